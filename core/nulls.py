"""Numbers that programs write where a surface is undefined, told from true values by how far off they lie."""

from __future__ import annotations

import numpy as np

from graben.arrays import BoolArray, FloatArray
from graben.model import UNDEFINED

#: What programs write for "undefined" where their format has no mark of its own, beside 1e30 and the like.
MARKS = (-999.25, -999.0, -9999.0, -99999.0, -999999.0, 999.0, 999.25, 9999.0, 99999.0, 999999.0)
#: A mark counts as one where it lies at least so many ranges of the other values beyond them.
_APART = 1.0


def null_marks(values: FloatArray) -> BoolArray:
    """Return which values, of any shape, are likely marks for "undefined"; NaN and infinite ones are not.

    >>> null_marks(np.array([-2100.0, -2050.0, -999.25, 1e30]))
    array([False, False,  True,  True])
    >>> null_marks(np.array([-1010.0, -980.0, -999.0]))
    array([False, False, False])
    """
    huge = np.isfinite(values) & (np.abs(values) >= UNDEFINED)
    marked = np.isin(values, MARKS)
    others = values[np.isfinite(values) & ~huge & ~marked]
    if len(others) == 0:
        return np.asarray(huge, dtype=np.bool_)
    low, high = float(others.min()), float(others.max())
    away = np.maximum(low - values, values - high)
    return np.asarray(huge | (marked & (away > _APART * (high - low))), dtype=np.bool_)
