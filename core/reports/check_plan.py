"""A finding in plan: faults shaded, horizons contoured, traces, and what the finding marks."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.patches import PathPatch

from graben.arrays import FloatArray, IntArray
from graben.finding import Finding
from graben.reports.check_words import seen
from graben.reports.labels import Label, write_labels
from graben.reports.map_parts import HALO, Window, silhouette, strokes
from graben.reports.marks import Marks
from graben.reports.scenery import HORIZON_INK, OTHER_INK, Scenery
from graben.reports.shapes import Projection, Shape, crossings, level_lines, usable
from graben.reports.style import FAULT, INPUT, Frame, plain_numbers
from graben.surface import Surface

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Structure contours of a surface, about.
_CONTOURS = 9
#: Least distance between the elevations written on contours, inches.
_APART = 0.14
_LONGEST_NAME = 28
#: Other faults in a window have names where they are so few.
_MOST_OTHERS, _OTHER_NAME = 6, "#5A5A5A"
_CONTOUR_INK, _NUMBER_INK = "#5E6B73", "#3D4F58"


@dataclass(frozen=True)
class View:
    """What one panel draws: the scenery, the finding and its marks, and the size of the panel in inches."""

    scenery: Scenery
    finding: Finding
    marks: Marks
    extent: tuple[float, float]

    @property
    def frame(self) -> Frame:
        """Unit and sign of z."""
        return self.scenery.frame

    def inch(self, window: Window) -> float:
        """Return how many model units stand for an inch."""
        return (window[1] - window[0]) / self.extent[0]


def plan(points: FloatArray) -> FloatArray:
    """Return points (..., 3) in plan, shape (..., 2)."""
    return points[..., :2]


def plan_panel(axes: Axes, view: View, window: Window) -> None:
    """Draw the objects of a finding in plan; faults alone also as cut at the elevation of the worst place."""
    scenery, finding, marks = view.scenery, view.finding, view.marks
    axes.set(xlim=window[:2], ylim=window[2:])
    inks, labels = scenery.inks(finding), marks.labels(plan)
    others: list[Label] = []
    for name, shape in scenery.faults.items():
        near = shape.within(plan, window)
        if len(near):
            footprint(axes, shape, near, inks.get(name, OTHER_INK), strong=name in inks)
            names = labels if name in inks else others
            names += name_label(shape, inks.get(name, (_OTHER_NAME, ""))[0], window)
    labels += others if len(others) <= _MOST_OTHERS else []
    own = [name for name in finding.objects if name in scenery.horizons]
    for name in own:
        shape = scenery.horizons[name]
        draw_outline(axes, shape, "-")
        part = Surface(name, shape.surface.vertices, shape.within(plan, window))
        draw_contours(axes, part, plan, view, window)
    for name in scenery.graphs:
        if name in own or not own:
            draw_traces(axes, scenery, name, 1.5 if name in own else 0.7)
    if not own and marks.worst is not None:
        for name, (ink, _) in inks.items():
            surface = scenery.faults[name].surface
            z = surface.vertices[:, 2] - marks.worst[2]
            cut = crossings(surface.vertices[:, :2], surface.triangles, z)[0]
            axes.add_artist(PathPatch(strokes(cut), fill=False, ec=ink, lw=1.8, zorder=4))
    marks.draw(axes, plan, view.inch(window))
    marks.draw_worst(axes, plan)
    view.frame.plan_axes(axes, max(window[1] - window[0], window[3] - window[2]))
    plain(axes)
    ring = None if view.marks.worst is None else plan(view.marks.worst)
    write_labels(axes, labels, view.extent, ring=ring)


def footprint(
    axes: Axes, shape: Shape, triangles: IntArray, ink: tuple[str, str], *, strong: bool = True
) -> None:
    """Draw a fault in plan: some of its triangles shaded, and its rim, bold where it is the upper one."""
    line, fill = ink
    shade = silhouette(shape.surface.vertices[triangles][..., :2])
    axes.add_artist(PathPatch(shade, fc=fill, ec=fill, lw=0.2, alpha=0.8, zorder=2.0 if strong else 1.0))
    for lines, width in ((shape.rim, 0.4), (shape.upper_rim, 1.4 if strong else 0.9)):
        drawn = LineCollection([p[:, :2] for p in lines], colors=line, linewidths=width, zorder=2.5)
        axes.add_collection(drawn, autolim=False)


def name_label(shape: Shape, ink: str, window: Window, stem: str = "") -> list[Label]:
    """Return the name of a fault at the middle of that part of its upper rim which is in the window.

    Of the name its beginning, ``stem``, is left out.
    """
    lines = shape.upper_rim or shape.rim or (shape.surface.vertices,)
    places = np.concatenate([(p[1:, :2] + p[:-1, :2]) / 2 for p in lines])
    west, east, south, north = window
    inside = places[((places >= [west, south]) & (places <= [east, north])).all(axis=1)]
    if not len(inside):
        return []
    x, y = inside[np.argmin(np.linalg.norm(inside - np.median(inside, axis=0), axis=1))]
    return [Label(shortened(shape.surface.name.removeprefix(stem)), (float(x), float(y)), ink, boxed=False)]


def shortened(name: str) -> str:
    """Return a name as a drawing shows it: on one line, and not without end."""
    text = seen(name)
    return text if len(text) <= _LONGEST_NAME else f"{text[: _LONGEST_NAME - 1]}…"


def draw_outline(axes: Axes, shape: Shape, dashes: Any) -> None:
    """Draw the outline of a horizon in plan."""
    outline = LineCollection([p[:, :2] for p in shape.rim], colors=HORIZON_INK, linewidths=0.8, zorder=1.5)
    outline.set_linestyle(dashes)
    axes.add_collection(outline, autolim=False)


def draw_traces(axes: Axes, scenery: Scenery, horizon: str, width: float) -> None:
    """Draw the cut graph of a horizon in plan."""
    graph = scenery.graphs[horizon]
    lines = strokes(graph.nodes[graph.edges][..., :2])
    axes.add_artist(PathPatch(lines, fill=False, ec=FAULT, lw=width, zorder=4.5))


def draw_contours(axes: Axes, surface: Surface, project: Projection, view: View, window: Window) -> None:
    """Draw structure contours of a surface, their elevations at their left ends where there is room."""
    lines, levels = level_lines(usable(surface), _CONTOURS)
    if not len(lines):
        return
    segments = project(lines)
    drawn = PathPatch(strokes(segments), fill=False, ec=_CONTOUR_INK, lw=0.5, alpha=0.8, zorder=2.8)
    axes.add_artist(drawn)
    west, east, south, north = window
    inch, written = view.inch(window), plain_numbers(view.frame.z_factor)
    low, high = np.array([west + 0.04 * inch, south + 0.08 * inch]), np.array([east, north - 0.22 * inch])
    taken: list[FloatArray] = []
    for level in np.unique(levels):
        ends = segments[levels == level].reshape(-1, 2)
        ends = ends[((ends >= low) & (ends <= high)).all(axis=1)]
        if not len(ends):
            continue
        place = ends[np.argmin(ends[:, 0])]
        if all(np.abs(place - other).max() > _APART * inch for other in taken):
            taken.append(place)
            style: dict[str, Any] = {"fontsize": 6.5, "color": _NUMBER_INK, "ha": "left", "va": "center"}
            axes.text(
                float(place[0]),
                float(place[1]),
                written(float(level)),
                path_effects=[HALO],
                zorder=6.2,
                **style,
            )


def edge_words(axes: Axes, words: Iterable[str]) -> None:
    """Write what lies to the left and to the right of a panel, such as directions."""
    for x, side, word in zip((0.012, 0.988), ("left", "right"), words, strict=True):
        style: dict[str, Any] = {"weight": "bold", "ha": side, "va": "top", "fontsize": 8, "zorder": 8}
        axes.text(x, 0.97, word, transform=axes.transAxes, path_effects=[HALO], **style)


def plain(axes: Axes) -> None:
    """Take off what would only crowd a small panel."""
    axes.grid(False)
    axes.tick_params(labelsize=7, length=2.5, color=INPUT)
    axes.xaxis.label.set_fontsize(8)
    axes.yaxis.label.set_fontsize(8)
    axes.spines[["top", "right"]].set_visible(True)
    for spine in axes.spines.values():
        spine.set(linewidth=0.6, color=INPUT)
