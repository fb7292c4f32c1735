"""Boxes that texts take on a drawing: how large one is, and whether it is free."""

from __future__ import annotations

import numpy as np

from graben.arrays import FloatArray

#: Width and height of a letter over the font's size.
_LETTER = (0.66, 1.3)


def half_box(text: str, size: float, padding: float) -> FloatArray:
    """Return half the width and half the height of a text, (2,), points.

    ``size`` of the font and ``padding`` around the text: points.
    """
    lines = text.split("\n")
    letters = np.array([max(len(line) for line in lines), len(lines)])
    return np.asarray(letters * np.array(_LETTER) * size / 2 + padding, dtype=np.float64)


def is_free(box: FloatArray, taken: FloatArray, frame: FloatArray) -> bool:
    """Return whether a box lies in a frame and over none of those that are taken.

    A box is west, south, east, north, all in one unit: ``box`` and ``frame`` (4,), ``taken`` (k, 4). Boxes
    that touch do not lie over each other.
    """
    if (box[:2] < frame[:2]).any() or (box[2:] > frame[2:]).any():
        return False
    over = (taken[:, :2] < box[2:]).all(axis=1) & (taken[:, 2:] > box[:2]).all(axis=1)
    return not over.any()
