"""Problem 1 of MSM15 for any basis, and how moments are best stored."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _msm
from ._arrays import flat, floats, one_each

Solver = Literal["lp", "fast", "closed"]
Interval = Literal["unit", "real"]


def bounds(
    basis: str,
    moments_or_atoms: ArrayLike,
    z_f: float,
    *,
    interval: Interval = "unit",
    solver: Solver | None = None,
) -> _msm.Bounds:
    """Sharp bounds of the shadow intensity, with proof, as ``msm bound`` gives them.

    Parameters
    ----------
    basis : str
        ``power:M``, ``trig:N``, or formulas in z separated by commas.
    moments_or_atoms : (m,) or (n, 2)
        The filtered means of b_1 to b_m; or depth and weight of each of n points, whose weights sum to 1.
    z_f : float
        Depth of the fragment.
    interval : str
        Admissible depths: ``unit`` is [0, 1], ``real`` the whole line.
    solver : str, optional
        ``lp``, ``fast`` or ``closed``; without it the closed form where there is one.

    Raises
    ------
    ValueError
        Moments that no distribution has, a basis that cannot be read, a depth outside the interval.
    RuntimeError
        No certified solution was found.
    """
    values = floats(moments_or_atoms, "moments_or_atoms").astype(np.float64)
    if values.ndim == 1:
        return _msm.bounds(basis, values.tolist(), None, float(z_f), interval, solver)
    if values.ndim == 2 and values.shape[1] == 2:
        return _msm.bounds(basis, values[:, 0].tolist(), values[:, 1].tolist(), float(z_f), interval, solver)
    shape = values.shape
    raise ValueError(f"moments_or_atoms has shape {shape}; (m,) for moments or (n, 2) for depths and weights is needed")


def certified(
    basis: str,
    moments: ArrayLike,
    z_f: ArrayLike,
    *,
    interval: Interval = "unit",
    solver: Solver | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Proved lower and upper bounds of many moment vectors, in double precision.

    ``moments`` has shape (..., m) and ``z_f`` broadcasts to (...), as do the results. The first vector that has no solution
    is named in the exception.
    """
    b = floats(moments, "moments").astype(np.float64, copy=False)
    if b.ndim == 0:
        raise ValueError("moments has shape (); the last axis must hold the moments")
    z = one_each(np.asarray(floats(z_f, "z_f"), dtype=np.float64), b, "z_f")
    if b.size == 0:
        return np.zeros(b.shape[:-1]), np.zeros(b.shape[:-1])
    if b.shape[-1] != len_of(basis):
        raise ValueError(f"{b.shape[-1]} moments given, the basis has {len_of(basis)} functions")
    lower, upper = _msm.certified(basis, flat(b), flat(z), interval, solver)
    return lower.reshape(b.shape[:-1]), upper.reshape(b.shape[:-1])


def len_of(basis: str) -> int:
    """Functions of a basis."""
    return _msm.basis_length(basis)


@dataclass(frozen=True)
class Quantization:
    """An affine transform of moments; ``stored = matrix @ b + offset``."""

    matrix: NDArray[np.float64]
    """(m, m)."""
    offset: NDArray[np.float64]
    """(m,)."""
    inverse: NDArray[np.float64]
    """(m, m)."""
    gain_bits: float
    """Bits that are gained over storing the functions as they are."""
    bound_bits: float
    """No transform gains more, proved."""
    range: tuple[float, float]
    """Least and largest stored value, proved."""
    depths: tuple[float, float]
    """Depths over which the transform's functions run; depths of another range are mapped there first."""


def quantize(
    order_or_basis: int | str,
    *,
    depth_range: Literal["unit", "signed"] = "unit",
    structure: Literal["dense", "parity"] = "dense",
    starts: int | None = None,
    seed: int = 1,
) -> Quantization:
    """The affine transform that makes moments fill the codes of a texel (MSM15 section 4.3), as ``msm quantize`` finds it."""
    basis = f"power:{order_or_basis}" if isinstance(order_or_basis, int) else order_or_basis
    for name, value, known in (
        ("depth_range", depth_range, ("unit", "signed")),
        ("structure", structure, ("dense", "parity")),
    ):
        if value not in known:
            raise ValueError(f"{name} = {value!r} is none of {', '.join(known)}")
    found: Any = _msm.quantize(basis, depth_range == "signed", structure == "parity", starts, seed)
    square = (found.order, found.order)
    return Quantization(
        matrix=np.array(found.matrix).reshape(square),
        offset=np.array(found.offset),
        inverse=np.array(found.inverse).reshape(square),
        gain_bits=found.gain_bits,
        bound_bits=found.bound_bits,
        range=(found.range_min, found.range_max),
        depths=found.depths,
    )
