"""Labels beside places of a drawing, none over another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import TYPE_CHECKING

import numpy as np

from graben.arrays import FloatArray
from graben.reports.map_parts import SIGNS
from graben.reports.style import PAPER
from graben.reports.text_boxes import half_box, is_free

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_POINTS = 72.0  # to the inch
_PADDING = 1.5  # points around a text
#: Width and height of what stands in a corner, points.
_CORNER = (32.0, 16.0)
#: Half the size of a dot and of a ring, points.
_DOT, _RING = 3.0, 7.0
#: Texts further from their places than this have a line to them, points.
_FAR = 12.0
#: A beginning that all names share is left out from so many letters on, after one of these.
_LEAST_STEM, _SEPARATORS = 6, "-_. /"
#: Where a label is tried: distances from its place to its own middle, points, and directions.
_REACHES = (9.0, 14.0, 20.0, 28.0, 38.0, 50.0, 64.0)
_DIRECTIONS = np.stack([f(np.radians(np.arange(45, 405, 30))) for f in (np.cos, np.sin)], axis=1)


@dataclass(frozen=True)
class Label:
    """A text, the place it is about (x, y in the drawing), and its look.

    A box has a line to its place, and so has a text that stands far from it.
    """

    text: str
    place: tuple[float, float]
    colour: str
    size: float = 7.5
    boxed: bool = True


def write_labels(
    axes: Axes,
    labels: Sequence[Label],
    extent: tuple[float, float],
    *,
    corners: bool = False,
    ring: FloatArray | None = None,
) -> list[Label]:
    """Write labels where they cover neither each other nor a place that has one.

    Parameters
    ----------
    axes : Axes
        With its limits set.
    labels : sequence of Label
        The most important first: each takes the nearest free position.
    extent : (width, height)
        Of the axes on paper, inches.
    corners : bool
        Whether the two upper corners are taken.
    ring : (2,) array, optional
        A place around which a ring is drawn.

    Returns
    -------
    list of Label
        Those that found no room.
    """
    (west, east), (south, north) = sorted(axes.get_xlim()), sorted(axes.get_ylim())
    size = np.array(extent) * _POINTS
    scale = size / [east - west, north - south]
    flip = np.array([axes.get_xlim()[0] > axes.get_xlim()[1], axes.get_ylim()[0] > axes.get_ylim()[1]])

    def on_paper(places: FloatArray) -> FloatArray:
        return np.asarray(np.where(flip, [east, north] - places, places - [west, south]) * scale)

    dots = on_paper(np.array([label.place for label in labels]).reshape(-1, 2))
    taken = np.concatenate([dots - _DOT, dots + _DOT], axis=1)
    if ring is not None:
        middle_of_ring = on_paper(ring)
        taken = np.append(taken, [[*(middle_of_ring - _RING), *(middle_of_ring + _RING)]], axis=0)
    if corners:
        west_end, east_end = (0.0, size[1] - _CORNER[1]), (size[0] - _CORNER[0], size[1] - _CORNER[1])
        boxes = [[*end, end[0] + _CORNER[0], size[1]] for end in (west_end, east_end)]
        taken = np.append(taken, boxes, axis=0)
    missing = []
    for label, dot in zip(labels, dots, strict=True):
        half = half_box(label.text, label.size, _PADDING)
        middle = _free(dot, half, taken, size)
        if middle is None:
            missing.append(label)
            continue
        taken = np.append(taken, [[*(middle - half), *(middle + half)]], axis=0)
        apart = float(np.hypot(*np.maximum(np.abs(middle - dot) - half, 0.0)))
        _write(axes, label, middle / size, joined=label.boxed or apart > _FAR)
    return missing


def stem(names: Sequence[str]) -> str:
    """Return how all of some names begin, where that is so long that it hides what tells them apart.

    >>> stem(["SAFS-SGPR-Redlands", "SAFS-SGPR-Reservoir"]), stem(["F1", "F2"]), stem(["Northern fault"])
    ('SAFS-SGPR-', '', '')
    """
    if len(names) < 2:
        return ""
    # what the first and the last of them share, all between share
    ends = takewhile(lambda pair: pair[0] == pair[1], zip(min(names), max(names), strict=False))
    same = "".join(letter for letter, _ in ends)
    same = same[: max((same.rfind(c) for c in _SEPARATORS), default=-1) + 1]
    return same if len(same) >= _LEAST_STEM and all(len(n) > len(same) for n in names) else ""


def _free(dot: FloatArray, half: FloatArray, taken: FloatArray, size: FloatArray) -> FloatArray | None:
    """Return the middle of the nearest free position for a box of half size ``half``, in points."""
    inside = (dot >= 0).all() and (dot <= size).all()
    for reach in _REACHES if inside else ():
        for direction in _DIRECTIONS:
            middle = dot + direction * (reach + half)
            if is_free(np.concatenate([middle - half, middle + half]), taken, np.append([0.0, 0.0], size)):
                return np.asarray(middle)
    return None


def _write(axes: Axes, label: Label, middle: FloatArray, joined: bool) -> None:
    """Write a label at a middle, (2,) shares of the axes, with a line to its place where it is ``joined``."""
    box = {"boxstyle": "round,pad=0.18", "fc": PAPER, "ec": label.colour, "lw": 0.8, "alpha": 0.92}
    line = {
        "arrowstyle": "-",
        "color": label.colour,
        "lw": 0.7 if label.boxed else 0.4,
        "shrinkA": 0,
        "shrinkB": 2,
    }
    axes.annotate(
        label.text,
        label.place,
        xytext=(float(middle[0]), float(middle[1])),
        textcoords="axes fraction",
        ha="center",
        va="center",
        fontsize=label.size,
        weight="bold" if label.boxed else "normal",
        color=label.colour,
        bbox=box if label.boxed else {"boxstyle": "square,pad=0.1", "fc": PAPER, "ec": "none", "alpha": 0.75},
        arrowprops=line if joined else None,
        # the line of a text passes under boxes
        zorder=SIGNS + (2 if label.boxed else 1),
    )
