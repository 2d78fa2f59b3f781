"""Filterable shadow maps on arrays."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from . import _msm
from ._arrays import flat, floats, one_each, vectors


class Technique:
    """A basis, an encoding and a bound, by the keys of an experiment's ``method``.

    >>> Technique(bound="hamburger4", transform="GDC16 four moments", format="unorm16", alpha=6e-5)
    >>> Technique(basis="z, z^2, exp(4z), exp(-4z)")

    Arrays in float32 are computed as a shader would, in float64 with the error of storage alone.
    """

    def __init__(self, **keys: Any) -> None:
        self._technique = _msm.Technique(json.dumps(keys))
        self.keys = dict(keys)

    @property
    def name(self) -> str:
        """With its parameters."""
        return self._technique.name

    @property
    def channels(self) -> int:
        """Values of a texel."""
        return self._technique.channels

    @property
    def bits_per_texel(self) -> int:
        """With bits that the texture wastes."""
        return self._technique.bits_per_texel

    @property
    def is_lower_bound(self) -> bool:
        """Whether shades never exceed percentage-closer filtering."""
        return self._technique.is_lower_bound

    def encode(self, depths: ArrayLike) -> NDArray[Any]:
        """What texels of these depths hold: shape (..., channels), transformed and rounded to the format."""
        z = floats(depths, "depths")
        single = z.dtype == np.float32
        found = self._technique.encode_single(flat(z)) if single else self._technique.encode_double(flat(z))
        return found.reshape(z.shape + (self.channels,))

    def filter(
        self,
        depth_map: ArrayLike,
        *,
        size: int = 9,
        sigma: float = 2.4,
        dtype: DTypeLike = np.float32,
    ) -> NDArray[Any]:
        """A shadow map of shape (height, width), stored, filtered by a Gaussian of size x size texels and decoded.

        Returns the filtered functions of depth, shape (height, width, channels), for :meth:`shade`.
        """
        depths = np.asarray(depth_map)
        if depths.ndim != 2:
            raise ValueError(f"depth_map has shape {depths.shape}; (height, width) is needed")
        depths = floats(depths, "depth_map").astype(np.float32, copy=False)
        if np.dtype(dtype) not in (np.dtype(np.float32), np.dtype(np.float64)):
            raise TypeError(f"dtype {np.dtype(dtype)}: float32 or float64 is needed")
        single = np.dtype(dtype) == np.float32
        compute = self._technique.filter_single if single else self._technique.filter_double
        height, width = depths.shape
        return compute(flat(depths), (width, height), (size, float(sigma))).reshape(height, width, self.channels)

    def shade(self, filtered: ArrayLike, z_f: ArrayLike) -> NDArray[Any]:
        """The shadow intensity at depths z_f, broadcast to (...), from filtered functions of shape (..., channels)."""
        b = vectors(filtered, self.channels, "filtered")
        z = one_each(z_f, b, "z_f")
        single = b.dtype == np.float32
        compute = self._technique.shade_single if single else self._technique.shade_double
        return compute(flat(b), flat(z)).reshape(b.shape[:-1])

    def __repr__(self) -> str:
        return f"Technique({self.name}, {self.bits_per_texel} bits a texel)"
