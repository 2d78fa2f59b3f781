"""Shapes and types of arrays, checked in one place."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FLOATS = (np.dtype(np.float32), np.dtype(np.float64))


def floats(values: ArrayLike, name: str, dtype: np.dtype[Any] | None = None) -> NDArray[Any]:
    """An array of float32 or float64; of ``dtype`` where that is given. Python numbers and lists become what is needed."""
    array = np.asarray(values)
    if not isinstance(values, (np.ndarray, np.generic)) and array.dtype.kind in "iuf":
        return array.astype(dtype if dtype is not None else np.float64)
    if dtype is not None and array.dtype != dtype:
        raise TypeError(f"{name} has dtype {array.dtype}, {dtype} is needed as for the other array")
    if array.dtype not in FLOATS:
        raise TypeError(f"{name} has dtype {array.dtype}; float32 or float64 is needed")
    return array


def vectors(values: ArrayLike, count: int, name: str) -> NDArray[Any]:
    """An array of floats whose last axis holds ``count`` values."""
    array = floats(values, name)
    if array.ndim == 0 or array.shape[-1] != count:
        raise ValueError(f"{name} has shape {array.shape}; the last axis must hold {count} values")
    return array


def one_each(values: ArrayLike, of: NDArray[Any], name: str) -> NDArray[Any]:
    """Broadcast to one value a vector of ``of``."""
    array = floats(values, name, of.dtype)
    shape = of.shape[:-1]
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise ValueError(f"{name} has shape {array.shape}, which does not fit {shape}, one value a vector") from None


def flat(array: NDArray[Any]) -> NDArray[Any]:
    """Contiguous and one-dimensional; a view where the array is contiguous already."""
    return np.ascontiguousarray(array).reshape(-1)
