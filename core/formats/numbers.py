"""Many numbers as text at once: the shortest that reads back to the same bits, at most 17 digits (orjson)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import orjson
from numpy.typing import NDArray

#: Rows turned into text at once: enough for speed, few enough not to hold a file in memory.
BLOCK = 100_000


def rows_of_text(array: NDArray[Any]) -> list[bytes]:
    """Return each row of an array as its numbers with spaces between.

    Parameters
    ----------
    array : (n, k) array
        Whole numbers or floating-point numbers; what is not finite stands as nan, inf or -inf.

    >>> rows_of_text(np.array([[0.1, 2.0], [1e22, -0.0]]))
    [b'0.1 2.0', b'1e+22 -0.0']
    """
    if array.size == 0:
        return [b""] * len(array)
    whole = np.issubdtype(array.dtype, np.integer)
    values = np.ascontiguousarray(array, dtype=np.int64 if whole else np.float64)
    if not np.isfinite(values).all():
        # JSON has no word for these
        return [" ".join(map(repr, row)).encode() for row in values.tolist()]
    text = orjson.dumps(values, option=orjson.OPT_SERIALIZE_NUMPY)
    return text[2:-2].replace(b",", b" ").split(b"] [")


def blocks(count: int) -> Iterator[slice]:
    """Yield slices of at most BLOCK that together run from 0 to ``count``."""
    for start in range(0, count, BLOCK):
        yield slice(start, min(start + BLOCK, count))
