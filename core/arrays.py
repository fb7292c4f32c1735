"""Array types and the read-only rule of graben's values."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def floats(values: ArrayLike, *shape: int) -> FloatArray:
    """Return a read-only float64 copy, reshaped to ``shape`` where one is given.

    >>> floats([[0, 1, 2]], -1, 3).flags.writeable
    False
    """
    return _frozen(np.array(values, dtype=np.float64), shape)


def ints(values: ArrayLike, *shape: int) -> IntArray:
    """Return a read-only int64 copy, reshaped to ``shape`` where one is given."""
    return _frozen(np.array(values, dtype=np.int64), shape)


def bools(values: ArrayLike, *shape: int) -> BoolArray:
    """Return a read-only boolean copy, reshaped to ``shape`` where one is given."""
    return _frozen(np.array(values, dtype=np.bool_), shape)


def _frozen(array: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    result = array.reshape(shape) if shape else array
    result.flags.writeable = False
    return result
