"""A finding in a vertical section through its worst place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patches import PathPatch

from graben.arrays import FloatArray, floats
from graben.proximity import nearest
from graben.reports.check_faces import numbered
from graben.reports.check_layout import paper
from graben.reports.check_plan import View, edge_words, shortened
from graben.reports.labels import Label, write_labels
from graben.reports.map_parts import Window, strokes
from graben.reports.marks import COLOURS, Marks, reach_of, window_of
from graben.reports.scenery import HORIZON_INK, OTHER_INK
from graben.reports.section import Plane, cut_by
from graben.reports.shapes import Shape, compass
from graben.reports.style import INPUT
from graben.surface import mean_dip_direction

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: A line steeper than this against its length has no direction in plan to look across.
_STEEP = 0.35
#: Sky above the model, and what is below it, in a section, over half its height.
_BEYOND = 0.15


@dataclass(frozen=True, eq=False)
class Section:
    """A section through the worst place of a finding: ``half`` model units to each side, or a whole shape."""

    plane: Plane
    at: FloatArray
    half: float | None
    first: Shape

    @classmethod
    def of(cls, marks: Marks, shapes: list[Shape], half: float | None) -> Section:
        """Return the section that shows most of a finding about some shapes."""
        return cls(_across(marks, shapes, half or 0.0), marks.at, half, shapes[0])

    def draw(self, axes: Axes, view: View) -> None:
        """Draw the section."""
        if self.half is None:
            cut = cut_by(self.plane, self.first.surface)[0].reshape(-1, 2)
            ends = np.append(cut, [[0.0, self.at[2]]], axis=0)
            window = paper(window_of(ends, 0.1 * reach_of(ends) or 1.0), view.extent)
        else:
            high = self.half * view.extent[1] / view.extent[0]
            z = view.scenery.places[:, 2]
            middle = min(float(self.at[2]), float(z.max()) - (1.0 - _BEYOND) * high)
            middle = max(middle, min(float(self.at[2]), float(z.min()) + (1.0 - _BEYOND) * high))
            window = -self.half, self.half, middle - high, middle + high
        section_panel(axes, view, self.plane, window)

    def draw_line(self, axes: Axes) -> None:
        """Draw on a map where the section runs."""
        reach = self.half if self.half is not None else reach_of(self.first.surface.vertices)
        ends = np.stack(
            [self.plane.origin - reach * self.plane.along, self.plane.origin + reach * self.plane.along]
        )
        axes.plot(*ends.T, color="#333333", lw=1.0, ls=(0, (1, 1.5)), zorder=5)


def section_panel(axes: Axes, view: View, plane: Plane, window: Window) -> None:
    """Draw a vertical section: the objects of a finding, the others, its picks nearby and the worst place.

    ``window`` holds distances along the plane and elevations.
    """
    scenery, factor = view.scenery, view.frame.z_factor
    inks, own = scenery.inks(view.finding), view.finding.objects
    low, high = sorted((factor * window[2], factor * window[3]))
    axes.set(xlim=window[:2], ylim=(low, high) if factor > 0 else (high, low))
    labels = []
    for name, shape in scenery.shapes.items():
        segments = cut_by(plane, shape.surface)[0] * [1.0, factor]
        near = (segments.max(axis=1) >= [window[0], low]) & (segments.min(axis=1) <= [window[1], high])
        segments = segments[near.all(axis=1)]
        horizon = name in scenery.horizons
        ink = HORIZON_INK if horizon else inks.get(name, OTHER_INK)[0]
        width = 2.2 if name in inks else 1.6 if name in own else 1.0
        lines = PathPatch(strokes(segments), fill=False, ec=ink, lw=width, zorder=3.5 if name in own else 3.0)
        lines.set_capstyle("round")
        axes.add_artist(lines)
        if len(segments) and name in own:
            middles = segments.mean(axis=1)
            at = middles[np.argmin(middles[:, 0]) if horizon else np.argmax(factor * middles[:, 1])]
            labels.append(Label(shortened(name), (float(at[0]), float(at[1])), ink, boxed=False))

    def project(points: FloatArray) -> FloatArray:
        return floats(np.stack([plane.coordinates(points)[0], factor * points[..., 2]], axis=-1))

    for pick in scenery.model.horizons:
        if pick.name in own and len(pick.picks):
            marked = COLOURS[view.marks.status]
            for points, ink in ((pick.picks, INPUT), (view.marks.points, marked)):
                near_by = points[np.abs(plane.coordinates(points)[1]) <= pick.step]
                axes.plot(*project(near_by).T, "o", ms=2.8, mfc="none", mec=ink, mew=0.8, zorder=4)
    view.marks.draw_worst(axes, project)
    edge_words(axes, (compass(-plane.along), compass(plane.along)))
    axes.set_xlabel(view.frame.label("distance from the place"))
    axes.set_ylabel(view.frame.label(view.frame.z_name))
    numbered(axes)
    ring = None if view.marks.worst is None else project(view.marks.worst)
    write_labels(axes, labels, view.extent, corners=True, ring=ring)


def _across(marks: Marks, shapes: list[Shape], half: float) -> Plane:
    """Return the vertical plane through the worst place that shows most.

    Across the line that the finding marks there, or across the first shape; where it misses another shape
    within ``half``, towards the nearest place of that.
    """
    at = marks.at
    direction = mean_dip_direction(shapes[0].surface.vertices, shapes[0].surface.triangles)[0]
    lines = [p for p in marks.paths if len(p) > 1]
    if lines:
        ways = np.concatenate([np.diff(p, axis=0) for p in lines])
        middles = np.concatenate([(p[1:] + p[:-1]) / 2 for p in lines])
        way = ways[np.argmin(np.linalg.norm(middles - at, axis=1))]
        flat = float(np.hypot(way[0], way[1]))
        if flat > _STEEP * float(np.linalg.norm(way)):
            direction = np.array([way[1], -way[0]]) / flat
    plane = _eastwards(at, direction)
    for shape in shapes[1:]:
        along = cut_by(plane, shape.surface)[0][..., 0]
        if not (np.abs(along) < half).any():
            towards = nearest(at[None], shape.surface.vertices, shape.surface.triangles).place[0] - at
            flat = float(np.hypot(towards[0], towards[1]))
            return _eastwards(at, towards[:2] / flat) if flat > 0 else plane
    return plane


def _eastwards(at: FloatArray, direction: FloatArray) -> Plane:
    east = direction[0] > 0 or (direction[0] == 0 and direction[1] > 0)
    return Plane(at[:2], direction if east else -direction)
