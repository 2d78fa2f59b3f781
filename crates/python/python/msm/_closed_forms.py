"""Closed-form bounds of many moment vectors at once."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _msm
from ._arrays import flat, one_each, vectors

Pair = tuple[NDArray[Any], NDArray[Any]]


def _closed_form(name: str, moments: ArrayLike, z_f: ArrayLike, alpha: float) -> Pair:
    b = vectors(moments, _msm.order(name), "moments")
    z = one_each(z_f, b, "z_f")
    compute = _msm.closed_form_single if b.dtype == np.float32 else _msm.closed_form_double
    lower, upper = compute(name, flat(b), flat(z), float(alpha))
    return lower.reshape(b.shape[:-1]), upper.reshape(b.shape[:-1])


def hamburger2(moments: ArrayLike, z_f: ArrayLike, alpha: float = 0.0) -> Pair:
    """Cantelli's inequality from mean and second moment.

    Parameters
    ----------
    moments : (..., 2) float32 or float64
        Means of z and z^2 over the kernel, in any affine map of depth.
    z_f : broadcast to (...)
        Depth of the fragment in the same variable.
    alpha : float
        Moment bias from 0 to 1 (MSM15 section 4.2): bounds are those of (1 - alpha) b + alpha b*, where b* belongs to
        depths from -1 to 1.

    Returns
    -------
    lower, upper : (...) of the moments' type
        Bounds of the mass strictly before z_f, and up to and including it. Never NaN.
    """
    return _closed_form("hamburger2", moments, z_f, alpha)


def hamburger4(moments: ArrayLike, z_f: ArrayLike, alpha: float = 0.0) -> Pair:
    """Hamburger 4MSM (MSM15 Algorithm 3): as :func:`hamburger2` for four power moments, shape (..., 4)."""
    return _closed_form("hamburger4", moments, z_f, alpha)


def hamburger6(moments: ArrayLike, z_f: ArrayLike, alpha: float = 0.0) -> Pair:
    """MSM15 Algorithm 2: as :func:`hamburger2` for six power moments, shape (..., 6)."""
    return _closed_form("hamburger6", moments, z_f, alpha)


def hamburger8(moments: ArrayLike, z_f: ArrayLike, alpha: float = 0.0) -> Pair:
    """MSM15 Algorithm 2: as :func:`hamburger2` for eight power moments, shape (..., 8)."""
    return _closed_form("hamburger8", moments, z_f, alpha)


def hausdorff4(moments: ArrayLike, z_f: ArrayLike, alpha: float = 0.0) -> Pair:
    """Hausdorff 4MSM (MSM15 section 4): means of z to z^4, shape (..., 4), with z and z_f in [0, 1]."""
    return _closed_form("hausdorff4", moments, z_f, alpha)


def trigonometric4(moments: ArrayLike, z_f: ArrayLike, alpha: float = 0.0) -> Pair:
    """Trigonometric 4MSM (MSM15 section 4): means of sine and cosine of 2 pi z, then of 4 pi z, shape (..., 4), z in [0, 1]."""
    return _closed_form("trigonometric4", moments, z_f, alpha)
