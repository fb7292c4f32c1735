"""The plan map of a rebuilt horizon, drawn as a structure map."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.cutgraph import NodeKind
from graben.modeling.products import cutoff_polygons
from graben.modeling.results import Cutoff, HorizonResult
from graben.reports.along_strike import title
from graben.reports.map_labels import (
    MARGIN,
    NAME,
    SMALL_THROW,
    THROW,
    Lettering,
    Way,
    distances,
    lettering,
    paper_size,
)
from graben.reports.map_parts import HALO, Window, bounds, mark_open, north_arrow, scale_bar
from graben.reports.style import (
    FAULT,
    FOOT,
    HANGING,
    INPUT,
    PAPER,
    Frame,
    elevation_colours,
    plain_numbers,
    styled,
)
from graben.reports.thinning import among, drawn

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Text

#: Lengths on the map as shares of its larger side.
_TICK_SPACING, _TICK_LENGTH, _NEAR = 0.028, 0.013, 0.012
_CONTOURS = 24
_WRITTEN: dict[str, Any] = {
    "path_effects": [HALO],
    "zorder": 7.0,
    "clip_on": True,
    "ha": "center",
    "va": "center",
}
_BELOW, _ABOVE, _LINES, _SIGNS = 1.0, 3.0, 5.0, 7.0  # what hides what


@styled
def map_figure(result: HorizonResult, frame: Frame, window: Window | None = None) -> Figure:
    """Return the structure map of a rebuilt horizon.

    Elevation is contoured on the cut triangulation, so that no contour crosses a fault. Gaps are hatched;
    in an overlap the hanging wall covers the foot wall, whose cutoff is dashed there.

    Parameters
    ----------
    result : HorizonResult
        The horizon.
    frame : Frame
        Unit and sign of z.
    window : (west, east, south, north), optional
        Part to show, model units; default the whole horizon.
    """
    points = result.surface.vertices
    window = window or bounds(points[:, :2])
    west, east, south, north = window
    extent = max(east - west, north - south)
    figure = Figure(figsize=paper_size(window), layout="constrained")
    axes = figure.add_subplot(aspect="equal")
    elevations = _elevation(figure, axes, result, frame, window)
    for cutoff in result.cutoffs:
        _draw_cutoff(axes, cutoff, extent, result.largest_throw)
    placed = lettering(result, window)
    _write(axes, placed)
    _clear(elevations, placed, extent)
    _graph(axes, result)
    margin = MARGIN * extent
    axes.set(xlim=(west - margin, east + margin), ylim=(south - margin, north + margin))
    axes.grid(False)
    frame.plan_axes(axes, extent)
    scale_bar(axes, window, extent, frame)
    north_arrow(axes)
    part = "" if window == bounds(points[:, :2]) else ", detail at the faults"
    axes.set_title(f"{title(result.name)}: {frame.z_name}{part}{mark_open(axes, result)}")
    _legend(figure, result, frame)
    return figure


def detail_window(result: HorizonResult, margin: float) -> Window | None:
    """Return the part of the map around the cutoffs, or None where it is most of the map.

    ``margin`` is kept around the cutoffs, model units.
    """
    if not result.cutoffs:
        return None
    lips = np.concatenate([line[:, :2] for c in result.cutoffs for line in (c.hanging, c.foot)])
    west, east, south, north = bounds(lips)
    whole = bounds(result.surface.vertices[:, :2])
    half = max(east - west, north - south) / 4.0 + margin  # no narrower than half as wide as long
    middle = (west + east) / 2, (south + north) / 2
    detail = (
        max(min(west - margin, middle[0] - half), whole[0]),
        min(max(east + margin, middle[0] + half), whole[1]),
        max(min(south - margin, middle[1] - half), whole[2]),
        min(max(north + margin, middle[1] + half), whole[3]),
    )
    share = (
        (detail[1] - detail[0]) * (detail[3] - detail[2]) / ((whole[1] - whole[0]) * (whole[3] - whole[2]))
    )
    return detail if share < 0.5 else None


def _elevation(
    figure: Figure, axes: Axes, result: HorizonResult, frame: Frame, window: Window
) -> Sequence[Text]:
    """Draw contours, the colour bar, the rim and the edge of the zone; return the elevations written."""
    points, triangles = result.surface.vertices, result.surface.triangles
    corners = points[triangles, :2]
    margin = 2 * MARGIN * max(window[1] - window[0], window[3] - window[2])
    low, high = np.array(window).reshape(2, 2).T + np.array([[-margin], [margin]])
    shown = ((corners.max(axis=1) >= low) & (corners.min(axis=1) <= high)).all(axis=1)
    near = triangles if shown.all() else triangles[shown]
    levels = _levels(points[among(near, len(points)), 2])
    filled = _contours(axes, drawn(result, near)[0], points, levels, _BELOW)
    written = _contour_labels(axes, filled[1], levels, frame)
    upper = _covering(result, near)
    if len(upper):
        _contours(axes, upper, points, levels, _ABOVE)
    if result.fixed[near].any() and not result.fixed[near].all():
        fixed = result.fixed[near]
        mesh = Triangulation(*points[:, :2].T, near[fixed.any(axis=1) & ~fixed.all(axis=1)])
        zone = {"colors": INPUT, "linewidths": 0.7, "linestyles": ":", "zorder": _LINES}
        axes.tricontour(mesh, result.fixed.astype(float), [0.5], **zone)
    rim = result.surface.rim
    rim = rim[(result.side[rim] == 0).any(axis=1)]
    axes.add_collection(LineCollection(list(points[rim, :2]), colors=INPUT, linewidths=0.6, zorder=_BELOW))
    bar = figure.colorbar(
        filled[0], ax=axes, shrink=0.75, aspect=28, pad=0.015, format=plain_numbers(frame.z_factor)
    )
    bar.set_label(frame.label(frame.z_name))
    bar.outline.set_linewidth(0.5)
    return written


def _covering(result: HorizonResult, triangles: IntArray) -> IntArray:
    """Return the triangles of the hanging wall that cover a foot wall, and one row around them."""
    import shapely

    overlaps = [p for c in result.cutoffs if (c.heave < 0).any() for p in cutoff_polygons(c)]
    if not overlaps:
        return triangles[:0]
    zone = shapely.union_all(overlaps).buffer(result.horizon.step)
    inside = shapely.contains_xy(zone, result.surface.vertices[:, :2])
    block = result.block[triangles]
    hanging = (block > 0).any(axis=(1, 2)) & ~(block < 0).any(axis=(1, 2))
    return ints(triangles[hanging & inside[triangles].any(axis=1)])


def _contours(
    axes: Axes, triangles: IntArray, points: FloatArray, levels: FloatArray, order: float
) -> tuple[Any, Any]:
    """Draw filled contours and lines of some triangles; levels are painted upwards."""
    mesh, z = Triangulation(*points[:, :2].T, triangles), points[:, 2]
    filled = axes.tricontourf(mesh, z, levels, cmap=elevation_colours(), antialiased=False, zorder=order)
    widths = np.where(_indexed(levels), 0.9, 0.4)
    lines = {"colors": "#3D4F58", "linewidths": widths, "linestyles": "-", "zorder": order + 0.5}
    return filled, axes.tricontour(mesh, z, levels, **lines)


def _indexed(levels: FloatArray) -> BoolArray:
    """Return which levels are index contours: round numbers, every fourth or fifth."""
    step = levels[1] - levels[0]
    every = 4 if f"{step:.1e}".startswith("2.5") else 5
    return np.asarray(np.isclose(np.round(levels / step) % every, 0))


def _contour_labels(axes: Axes, lines: Any, levels: FloatArray, frame: Frame) -> Sequence[Text]:
    indexed = levels[_indexed(levels)]
    named = indexed if len(indexed) > 1 else levels[::2]
    return axes.clabel(lines, named, fontsize=6.5, fmt=plain_numbers(frame.z_factor), inline_spacing=2)


def _levels(z: FloatArray) -> FloatArray:
    low, high = float(z.min()), float(z.max())
    if high - low <= 1e-9 * max(abs(low), abs(high)):  # a level horizon to rounding
        half = max(abs(low), 1.0) * 1e-3
        return np.array([low - half, low + half])
    return np.asarray(
        MaxNLocator(_CONTOURS, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high), dtype=np.float64
    )


def _draw_cutoff(axes: Axes, cutoff: Cutoff, extent: float, largest: float) -> None:
    """Draw the gap, both lips and ticks on the downthrown side."""
    gaps = [np.asarray(p.exterior.coords) for p in cutoff_polygons(cutoff)] if cutoff.heave.sum() > 0 else []
    axes.add_collection(
        PolyCollection(
            gaps, facecolors=PAPER, edgecolors="#B5B5B5", hatch="//////", linewidths=0, zorder=_LINES - 1
        )
    )
    overlapping = cutoff.heave < 0
    for part, hidden in _runs(overlapping):
        axes.plot(
            *cutoff.foot[part, :2].T, color=FOOT, lw=1.6, ls=(0, (3, 1.6)) if hidden else "-", zorder=_LINES
        )
    axes.plot(*cutoff.hanging[:, :2].T, color=HANGING, lw=1.8, zorder=_LINES + 0.5, solid_capstyle="round")
    if largest > 0:
        _ticks(axes, cutoff, extent, largest)


def _runs(mask: BoolArray) -> list[tuple[slice, bool]]:
    """Return the stretches of equal value; each reaches to the first point of the next."""
    breaks = np.flatnonzero(np.diff(mask)) + 1
    starts, stops = [0, *breaks.tolist()], [*breaks.tolist(), len(mask)]
    return [(slice(a, b + 1), bool(mask[a])) for a, b in zip(starts, stops, strict=True)]


def _ticks(axes: Axes, cutoff: Cutoff, extent: float, largest: float) -> None:
    """Draw ticks on the downthrown side of normal parts, teeth on the upthrown side of reverse parts.

    Both stand on the hanging cutoff: normal, its side is downthrown; reverse, upthrown.
    """
    line, spacing, length = cutoff.hanging[:, :2], _TICK_SPACING * extent, _TICK_LENGTH * extent
    total = distances(line)[-1]
    count = max(int(total / spacing), 1)
    way = Way.along(cutoff, line, (np.arange(count) + 0.5) / count * total, spacing)
    tips = way.places + length * way.right
    ticks = np.stack([way.places, tips], axis=1)[way.throw > SMALL_THROW * largest]
    axes.add_collection(LineCollection(list(ticks), colors=HANGING, linewidths=1.1, zorder=_LINES))
    half = 0.55 * length * way.right[:, ::-1] * [-1.0, 1.0]
    teeth = np.stack([way.places - half, tips, way.places + half], axis=1)[way.throw < -SMALL_THROW * largest]
    axes.add_collection(PolyCollection(list(teeth), facecolors=HANGING, edgecolors="none", zorder=_LINES))


def _write(axes: Axes, placed: Lettering) -> None:
    """Write names and throws; what they cover of the elevations on contours is not shown."""
    for w in placed.written:
        size, colour, weight = (NAME, FAULT, "bold") if w.name else (THROW, FOOT, "normal")
        axes.text(*w.place, w.text, fontsize=size, weight=weight, color=colour, **_WRITTEN)


def _clear(elevations: Sequence[Text], placed: Lettering, extent: float) -> None:
    """Hide the elevations on contours that stand where a name or throw does."""
    if not len(placed.boxes):
        return
    west, south, east, north = (placed.boxes + np.array([-1, -1, 1, 1]) * _NEAR * extent).T
    for text in elevations:
        x, y = text.get_position()
        text.set_visible(not ((west < x) & (x < east) & (south < y) & (y < north)).any())


def _graph(axes: Axes, result: HorizonResult) -> None:
    """Draw the trace on the input horizon and its special nodes."""
    graph = result.graph
    if len(graph.edges) == 0:
        return
    trace = LineCollection(
        list(graph.nodes[graph.edges, :2]), colors=FAULT, linewidths=0.6, zorder=_LINES - 0.5
    )
    axes.add_collection(trace)
    for kind, (marker, size, _) in _NODES.items():
        there = graph.nodes[graph.kinds == kind]
        axes.plot(*there[:, :2].T, marker, ms=size, mfc=PAPER, mec=FAULT, mew=0.9, zorder=_SIGNS - 0.5)


_NODES = {
    NodeKind.TIP: ("o", 4.0, "tip"),
    NodeKind.EXIT: ("s", 4.0, "exit"),
    NodeKind.JUNCTION: ("D", 4.5, "junction"),
    NodeKind.LOOSE: ("X", 6.0, "loose end"),
}


def _legend(figure: Figure, result: HorizonResult, frame: Frame) -> None:
    if not result.cutoffs:
        return
    unit = f" ({frame.unit})" if frame.unit else ""
    covered = ", dashed under an overlap" if any((c.heave < 0).any() for c in result.cutoffs) else ""
    reverse = any((c.throw < 0).any() for c in result.cutoffs)
    normal = any((c.throw > 0).any() for c in result.cutoffs)
    signs = [word for word, there in (("ticks: downthrown", normal), ("teeth: upthrown", reverse)) if there]
    handles: list[Any] = [
        Line2D(
            [],
            [],
            color=HANGING,
            lw=1.8,
            label=f"hanging wall cutoff ({', '.join(signs)} side)" if signs else "hanging wall cutoff",
        ),
        Line2D([], [], color=FOOT, lw=1.6, label=f"footwall cutoff, with throw{unit}{covered}"),
        Line2D([], [], color=FAULT, lw=0.6, label="trace on the input"),
        Line2D([], [], color=INPUT, lw=0.8, ls=":", label="edge of the rebuilt zone"),
    ]
    if any((c.heave > 0).any() for c in result.cutoffs):
        handles.append(Patch(facecolor=PAPER, edgecolor="#B5B5B5", hatch="//////", label="gap"))
    for kind, (marker, size, name) in _NODES.items():
        if (result.graph.kinds == kind).any():
            handles.append(
                Line2D([], [], marker=marker, ms=size, mfc=PAPER, mec=FAULT, ls="none", label=name)
            )
    figure.legend(handles=handles, loc="outside lower left", ncols=3, handlelength=2.2, columnspacing=1.4)
