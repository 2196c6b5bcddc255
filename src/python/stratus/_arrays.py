"""Arrays as the extension takes them: flat, contiguous, of equal lengths."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Shape = tuple[int, ...]


def shown(value: object) -> str:
    """A value as refusals repeat it."""
    text = repr(value)
    return text if len(text) <= 80 else text[:77] + "..."


def as_array(function: str, name: str, dtype: type, value: ArrayLike) -> NDArray[Any]:
    """An array of numbers.

    Errors   ValueError naming `function` and the argument, for a masked array with masked values, too.
    """
    if np.ma.is_masked(value):
        raise ValueError(f"{function}: {name} must have no masked values, got {np.ma.count_masked(value)} of them")
    try:
        return np.asarray(value, dtype)
    except (TypeError, ValueError):
        raise ValueError(f"{function}: {name} must be a number or an array of numbers, got {shown(value)}") from None


def number(function: str, name: str, value: Any) -> float:
    """One number."""
    array = as_array(function, name, np.float64, value)
    if array.ndim > 0:
        raise ValueError(f"{function}: {name} must be one number, got {shown(value)}")
    return float(array)


def whole(function: str, name: str, value: Any) -> int:
    """One whole number."""
    found = number(function, name, value)
    if found != found // 1:
        raise ValueError(f"{function}: {name} must be a whole number, got {shown(value)}")
    return int(found)


def broadcast(function: str, dtype: type, **values: ArrayLike) -> tuple[list[NDArray[Any]], Shape]:
    """Values broadcast against one another, flat, and the shape that they have together.

    Errors   ValueError naming `function` and the argument.
    """
    given = [as_array(function, name, dtype, value) for name, value in values.items()]
    try:
        arrays = np.broadcast_arrays(*given)
    except ValueError:
        shapes = ", ".join(f"{name} of {array.shape}" for name, array in zip(values, given))
        raise ValueError(f"{function}: arguments must have shapes that broadcast, got {shapes}") from None
    return [np.ascontiguousarray(array).reshape(-1) for array in arrays], arrays[0].shape


def broadcast_vectors(function: str, **values: ArrayLike) -> tuple[list[NDArray[np.float32]], Shape]:
    """Arrays of vectors, (..., 3), as rows of three components each, and the shape `...`."""
    arrays = [as_array(function, name, np.float32, value) for name, value in values.items()]
    for array in arrays:
        if array.ndim == 0 or array.shape[-1] != 3:
            raise ValueError(f"vectors must have 3 components along the last axis, got the shape {array.shape}")
    arrays = list(np.broadcast_arrays(*arrays))
    shape = arrays[0].shape[:-1]
    return [np.ascontiguousarray(array).reshape(-1, 3) for array in arrays], shape


def in_shape(rows: NDArray[Any], shape: Shape) -> Any:
    """A row for each channel as an array over `shape`, and the channel where there are three."""
    return rows.reshape(shape)[()] if len(rows) == 1 else np.ascontiguousarray(rows.T).reshape(*shape, 3)


def each(name: str, function: Callable[..., NDArray[Any]], dtype: type, **values: ArrayLike) -> Any:
    """function(*flat arrays), in the shape that they have together; refusals call it `name`."""
    arrays, shape = broadcast(name, dtype, **values)
    return function(*arrays).reshape(shape)[()]
