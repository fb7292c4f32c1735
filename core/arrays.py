"""Array types and the read-only rule of graben's values."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
#: Signs for each node and fault: an eighth of what whole numbers of 64 bits take.
SignArray = NDArray[np.int8]


def floats(values: ArrayLike, *shape: int) -> FloatArray:
    """Return a read-only float64 array, reshaped to ``shape`` where one is given.

    A copy, but for an array that is one already and was frozen here: a value made from the arrays of
    another, such as a moved surface, shares them.

    >>> floats([[0, 1, 2]], -1, 3).flags.writeable
    False
    """
    return _frozen(values, np.dtype(np.float64), shape)


def ints(values: ArrayLike, *shape: int) -> IntArray:
    """Return a read-only int64 array, reshaped to ``shape`` where one is given, as :func:`floats` does."""
    return _frozen(values, np.dtype(np.int64), shape)


def bools(values: ArrayLike, *shape: int) -> BoolArray:
    """Return a read-only boolean array, reshaped to ``shape`` where one is given, as :func:`floats` does."""
    return _frozen(values, np.dtype(np.bool_), shape)


def signs(values: ArrayLike, *shape: int) -> SignArray:
    """Return a read-only int8 array, reshaped to ``shape`` where one is given, as :func:`floats` does."""
    return _frozen(values, np.dtype(np.int8), shape)


def _frozen(values: ArrayLike, kind: np.dtype[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    if type(values) is np.ndarray and values.dtype == kind and _is_frozen(values):
        return values.reshape(shape) if shape else values
    array = np.array(values, dtype=kind)
    array.flags.writeable = False
    # a reshaped view of a read-only array is read-only too
    return array.reshape(shape) if shape else array


def _is_frozen(array: NDArray[Any]) -> bool:
    """Return whether an array is one block that nobody can write to: nor can what it is a view of."""
    if not array.flags.c_contiguous:
        return False
    seen: Any = array
    while isinstance(seen, np.ndarray):
        if seen.flags.writeable:
            return False
        seen = seen.base
    return seen is None
