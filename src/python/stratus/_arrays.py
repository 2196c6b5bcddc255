"""Arrays as the extension takes them: flat, contiguous, of equal lengths."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Shape = tuple[int, ...]


def broadcast(dtype: type, *values: ArrayLike) -> tuple[list[NDArray[Any]], Shape]:
    """Values broadcast against one another, flat, and the shape that they have together."""
    arrays = np.broadcast_arrays(*(np.asarray(value, dtype) for value in values))
    return [np.ascontiguousarray(array).reshape(-1) for array in arrays], arrays[0].shape


def broadcast_vectors(*values: ArrayLike) -> tuple[list[NDArray[np.float32]], Shape]:
    """Arrays of vectors, (..., 3), as rows of three components each, and the shape `...`."""
    arrays = [np.asarray(value, np.float32) for value in values]
    for array in arrays:
        if array.ndim == 0 or array.shape[-1] != 3:
            raise ValueError(f"vectors must have 3 components along the last axis, got the shape {array.shape}")
    arrays = list(np.broadcast_arrays(*arrays))
    shape = arrays[0].shape[:-1]
    return [np.ascontiguousarray(array).reshape(-1, 3) for array in arrays], shape


def values_of(rows: NDArray[Any], shape: Shape) -> Any:
    """A row for each channel as an array over `shape`, and the channel where there are three."""
    return rows.reshape(shape)[()] if len(rows) == 1 else np.ascontiguousarray(rows.T).reshape(*shape, 3)


def each(function: Callable[..., NDArray[Any]], dtype: type, *values: ArrayLike) -> Any:
    """function(*flat arrays), in the shape that they have together."""
    arrays, shape = broadcast(dtype, *values)
    return function(*arrays).reshape(shape)[()]
