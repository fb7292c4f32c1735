"""What a finding marks in a drawing: triangles, lines, places and its parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from string import ascii_lowercase
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import PathPatch
from numpy.typing import NDArray

from graben.arrays import FloatArray, floats
from graben.finding import Element, Finding, Status
from graben.reports.labels import Label
from graben.reports.map_parts import SIGNS, Window, silhouette
from graben.reports.shapes import Projection, drawable
from graben.reports.style import PAPER
from graben.surface import Surface

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Red for failures and amber for warnings, on white.
COLOURS = {Status.FAIL: "#B3261E", Status.WARN: "#B26B00"}
_FILLS = {Status.FAIL: "#E5484D", Status.WARN: "#F5A524"}
#: Triangles of a finding that are drawn; of more, as many spread evenly.
_MOST_TRIANGLES = 4_000
_MOST_POINTS = 2_000
#: Least margin around places over their larger side.
_THINNEST = 1e-6
#: Parts that bear a letter.
LETTERS = ascii_lowercase
#: Marked triangles whose sides are shorter on paper, inches, also have dots.
_VISIBLE = 0.05
#: Sizes of dots, points, by their count.
_DOTS = ((30, 5.0), (300, 3.5), (np.inf, 2.0))

Number = TypeVar("Number", np.float64, np.int64)


@dataclass(frozen=True, eq=False)
class Marks:
    """The places of a finding that can be drawn.

    Parameters
    ----------
    status : Status
        Fails or warns.
    triangles : (k, 3, 3) array
        Corners of the triangles concerned.
    points : (p, 3) array
        Places.
    paths : tuple of (k, 3) arrays
        Lines; one whose ends are equal is closed.
    parts : tuple of (str, (3,) array)
        Letters and places of the parts.
    worst : (3,) array or None
        The worst place.
    """

    status: Status
    triangles: FloatArray
    points: FloatArray
    paths: tuple[FloatArray, ...]
    parts: tuple[tuple[str, FloatArray], ...]
    worst: FloatArray | None

    @classmethod
    def of(cls, finding: Finding, surface: Surface | None) -> Marks:
        """Return the marks of a finding; ``surface`` is its first object, of which triangles are numbered."""
        triangles = floats([], 0, 3, 3)
        if finding.element is Element.TRIANGLE and surface is not None:
            triangles = corners(surface, finding)
        points = finding.places[drawable(finding.places)]
        paths = tuple(p for p in finding.paths if len(p) and drawable(p).all())
        named = zip(LETTERS, finding.parts, strict=False)
        parts = tuple((letter, floats(p.place)) for letter, p in named if drawable(floats(p.place)))
        worst = None
        if finding.worst is not None:
            place = floats([finding.worst.x, finding.worst.y, finding.worst.z])
            worst = place if drawable(place) else None
        first = [points[:1], *(p[len(p) // 2][None] for p in paths[:1]), *(p[None] for _, p in parts[:1])]
        if worst is None:
            worst = next((f[0] for f in first if len(f)), None)
        return cls(finding.status, triangles, spread(points, _MOST_POINTS), paths, parts, worst)

    @property
    def everything(self) -> FloatArray:
        """All places, shape (n, 3)."""
        parts = [place[None] for _, place in self.parts]
        worst = [] if self.worst is None else [self.worst[None]]
        return np.concatenate([self.triangles.reshape(-1, 3), self.points, *self.paths, *parts, *worst])

    @property
    def at(self) -> FloatArray:
        """The worst place, or the first where none is the worst; there must be one."""
        return self.everything[0] if self.worst is None else self.worst

    def draw(self, axes: Axes, project: Projection, inch: float) -> None:
        """Draw triangles, lines and places; ``inch`` is how many model units stand for an inch."""
        colour, fill = COLOURS[self.status], _FILLS[self.status]
        if len(self.triangles):
            shapes = PathPatch(silhouette(project(self.triangles)), fc=fill, ec=colour, lw=0.5, alpha=0.85)
            shapes.set_zorder(SIGNS - 1)
            axes.add_artist(shapes)
        closed = [p for p in self.paths if len(p) > 3 and (p[0] == p[-1]).all()]
        rings = PolyCollection([project(p) for p in closed], facecolors=fill, edgecolors="none", alpha=0.3)
        rings.set_zorder(SIGNS - 1.5)
        axes.add_collection(rings, autolim=False)
        lines = [project(p) for p in self.paths]
        for width, ink, order in ((4.0, PAPER, 0.6), (2.2, colour, 0.5)):
            drawn = LineCollection(lines, colors=ink, linewidths=width, zorder=SIGNS - order)
            drawn.set_capstyle("round")
            axes.add_collection(drawn, autolim=False)
        if len(self.points) and self._median_side < _VISIBLE * inch:
            size = next(s for most, s in _DOTS if len(self.points) <= most)
            style: dict[str, Any] = {"ms": size, "mfc": colour, "mec": PAPER, "mew": 0.6 if size > 2 else 0.0}
            axes.plot(*project(self.points).T, "o", zorder=SIGNS - 0.3, **style)

    @cached_property
    def _median_side(self) -> float:
        """Median side of the marked triangles, model units; 0 without any."""
        if not len(self.triangles):
            return 0.0
        return float(np.median(np.linalg.norm(self.triangles - np.roll(self.triangles, 1, axis=1), axis=2)))

    def draw_worst(self, axes: Axes, project: Projection) -> None:
        """Draw a ring around the worst place."""
        if self.worst is not None:
            colour = COLOURS[self.status]
            style: dict[str, Any] = {"ms": 11, "mfc": "none", "mec": colour, "mew": 1.5}
            axes.plot(*project(self.worst[None]).T, "o", zorder=SIGNS, **style)

    def labels(self, project: Projection) -> list[Label]:
        """Return the letters of the parts, where there is more than one."""
        if len(self.parts) < 2:
            return []
        spots = [(letter, project(place[None])[0]) for letter, place in self.parts]
        return [Label(letter, (float(x), float(y)), COLOURS[self.status]) for letter, (x, y) in spots]


def corners(surface: Surface, finding: Finding) -> FloatArray:
    """Return the corners of the triangles that a finding names, those that can be drawn, shape (k, 3, 3)."""
    named = finding.elements[(finding.elements >= 0) & (finding.elements < len(surface.triangles))]
    t = surface.triangles[spread(named, _MOST_TRIANGLES)]
    t = t[((t >= 0) & (t < len(surface.vertices))).all(axis=1)]
    found = surface.vertices[t] if len(t) else floats([], 0, 3, 3)
    return floats(found[drawable(found).all(axis=1)], -1, 3, 3)


def spread(values: NDArray[Number], most: int) -> NDArray[Number]:
    """Return at most ``most`` rows, spread evenly."""
    if len(values) <= most:
        return values
    return values[np.linspace(0, len(values) - 1, most).astype(np.int64)]


def window_of(places: FloatArray, margin: float) -> Window:
    """Return the box around places (n, 2) with a margin, model units; it never has the width 0."""
    margin = max(margin, _THINNEST * float(np.ptp(places, axis=0).max())) or 1.0
    (west, south), (east, north) = places.min(axis=0) - margin, places.max(axis=0) + margin
    return float(west), float(east), float(south), float(north)


def fitted(window: Window, ratio: float) -> Window:
    """Return a window widened to the ratio of height to width of the paper it is drawn on."""
    west, east, south, north = window
    width, height = east - west, north - south
    more_x, more_y = max(height / ratio - width, 0.0) / 2, max(width * ratio - height, 0.0) / 2
    return west - more_x, east + more_x, south - more_y, north + more_y


def reach_of(places: Sequence[FloatArray] | FloatArray) -> float:
    """Return half the diagonal of the box around places (n, d), model units; 0 for none."""
    points = np.asarray(places)
    return float(np.linalg.norm(np.ptp(points, axis=0))) / 2 if len(points) else 0.0
