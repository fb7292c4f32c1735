"""A repaired fault face-on: how far it moved, what was added and cut off, and a section across the change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch

from graben.arrays import BoolArray, FloatArray, floats
from graben.reports.check_faces import numbered
from graben.reports.check_layout import TALLEST, Panel, Row, composed, framed, paper
from graben.reports.check_plan import edge_words, shortened
from graben.reports.check_words import seen
from graben.reports.labels import Label, write_labels
from graben.reports.map_parts import SIGNS, Window, silhouette, strokes
from graben.reports.marks import fitted, reach_of, window_of
from graben.reports.page import Picture, picture
from graben.reports.repair_moves import FaultChange
from graben.reports.scenery import OTHER_INK
from graben.reports.section import Plane, cut_by
from graben.reports.shapes import FaceOn, Shape, compass
from graben.reports.style import FAULT, PAPER, Frame, styled
from graben.surface import Surface, mean_dip_direction

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Numbers of the changes in the ledger and their places.
Places = Sequence[tuple[int, FloatArray]]

_MOVES = LinearSegmentedColormap.from_list("moves", ["#F2F4F7", "#BCD0E6", "#6E9CCB", "#2C66A8", "#0B2F66"])
#: Added and cut off: told apart by hatching as well, for grey prints.
_ADDED, _ADDED_INK = "#BFE6CF", "#0B6B3A"
_CUT, _CUT_INK = "#FBE3DF", "#C0392B"
_PART, _PART_INK = "#DADADA", "#8A8A8A"
_SPOT_INK = "#D55E00"
_EDGE_INK = "#9AA3AA"
#: More triangles than these have no lines between them; meshes of more are too large as drawings.
_MOST_LINES, _DRAWN = 2_500, 6_000
#: Triangles that moved less than this share of the median edge are as they were: rounding.
_STILL = 1e-6
#: The spot reaches so many median edges, or largest moves, to each side; it is shown where the move takes a
#: share of that which can be seen.
_EDGES, _MOVES_AROUND, _SEEN = 2.0, 4.0, 0.03
#: Room for the legend below a fault, over the width of the panel.
_LEGEND = 0.05
_MARGIN = 0.06
#: Labels of changes on one picture.
_MOST_LABELS = 12


@dataclass(frozen=True, eq=False)
class _Sheet:
    """A fault before and after, ready to be drawn."""

    change: FaultChange
    parts: Sequence[Surface]
    others: Sequence[Surface]
    places: Places
    frame: Frame

    @cached_property
    def given(self) -> Shape:
        assert self.change.given is not None
        return Shape.of(self.change.given)

    @cached_property
    def made(self) -> Shape | None:
        made = self.change.made
        return Shape.of(made) if made is not None and len(made.triangles) else None

    @cached_property
    def face(self) -> FaceOn:
        shape = self.given if len(self.given.surface.triangles) or self.made is None else self.made
        return shape.face

    @cached_property
    def edge(self) -> float:
        return max(s.median_edge for s in (self.given, self.made) if s is not None) or 1.0

    @cached_property
    def corners(self) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Corners of the triangles made, seen face-on and the nearest last; moves; which ones were added."""
        made = self.made
        if made is None:
            return np.zeros((0, 3, 2)), np.zeros(0), np.zeros(0, dtype=np.bool_)
        t = made.surface.triangles
        corners = made.surface.vertices[t]
        moves = np.where(self.change.beyond, 0.0, self.change.moves)[t].max(axis=1)
        order = np.argsort(self.face.depth(corners.mean(axis=1)), kind="stable")
        return self.face(corners)[order], moves[order], self.change.added[order]

    @property
    def still(self) -> float:
        return _STILL * self.edge


def fault_picture(
    change: FaultChange,
    parts: Sequence[Surface],
    others: Sequence[Surface],
    places: Places,
    frame: Frame,
    budget: int,
) -> Picture | None:
    """Return the picture of a changed fault, or None where there is nothing to draw.

    The fault is shown face-on: along strike and up dip in its mean plane, with the moves as colours, the rim
    before and after, and what was added and cut off. Where the largest move would be seen in a section, the
    spot follows with one across it.

    Parameters
    ----------
    change : FaultChange
        The fault.
    parts : sequence of Surface
        What else was made of the same fault of the input; usable triangles alone.
    others : sequence of Surface
        The other faults of the result, for the section.
    places : sequence of (int, (3,) array)
        Numbers of its changes in the ledger, and where they are.
    frame : Frame
        Unit and sign of z.
    budget : int
        Bytes it may take.
    """
    sheet = _Sheet(change, parts, others, places, frame)
    if change.given is None or not (len(change.given.triangles) or sheet.made is not None):
        return None
    figure, caption = _figure(sheet)
    count = len(sheet.corners[0]) + len(sheet.given.surface.triangles)
    alt = f"{seen(change.name)} before and after repair: {seen(caption)}"
    return picture(figure, alt, seen(caption), budget, count <= _DRAWN)


@styled
def _figure(sheet: _Sheet) -> tuple[Figure, str]:
    """Return the figure and what its caption says."""
    face, change = sheet.face, sheet.change
    surfaces = [s.surface.vertices for s in (sheet.given, sheet.made) if s is not None]
    seen_at = face(np.concatenate(surfaces))
    west, east, south, north = window_of(seen_at, _MARGIN * reach_of(seen_at))
    south -= _LEGEND * max(east - west, (north - south) / TALLEST)
    whole = (west, east, south, north)
    moved = change.largest_move > sheet.still
    scale = (_MOVES, Normalize(0.0, change.largest_move)) if moved else None
    said = f"Seen towards {compass(-face.towards[:2])}, square to its mean plane"
    given = "the surface that was given."
    said += (
        f"; colours: how far each triangle lies from {given}" if moved else f"; no vertex lies off {given}"
    )

    def panel(window: Window, legend: bool) -> Panel:
        return lambda axes, extent: _face(axes, sheet, paper(window, extent), extent, legend)

    rows: list[Row] = [([panel(whole, True)], (north - south) / (east - west))]
    at = change.largest_at if moved else None
    reach = max(_EDGES * sheet.edge, _MOVES_AROUND * change.largest_move)
    if at is None or change.largest_move < _SEEN * reach:
        return composed(rows, scale, sheet.frame.label("move")), said
    spot = window_of(face(at[None]), reach)
    half = (spot[1] - spot[0]) / 2

    def cross(axes: Axes, extent: tuple[float, float]) -> None:
        _section(axes, sheet, at, half, extent)

    figure = composed([*rows, ([panel(spot, False), cross], 1.0)], scale, sheet.frame.label("move"))
    framed(figure.axes[0], fitted(spot, 1.0))
    return figure, f"{said} Below: the largest move, in the frame, and a section across it along the dip."


def _face(axes: Axes, sheet: _Sheet, window: Window, extent: tuple[float, float], legend: bool) -> None:
    """Draw the fault face-on: before pale and dashed, after coloured and with a solid rim."""
    axes.set(xlim=window[:2], ylim=window[2:])
    face, given = sheet.face, sheet.given
    corners, moves, added = sheet.corners
    if len(given.surface.triangles):
        before = silhouette(face(given.surface.vertices[given.surface.triangles]))
        axes.add_artist(PathPatch(before, fc=_CUT, ec="none", zorder=1))
        axes.add_artist(PathPatch(before, fill=False, ec=_CUT_INK, lw=0.0, hatch="////", zorder=1.1))
    for part in sheet.parts:
        rest = silhouette(face(part.vertices[part.triangles]))
        axes.add_artist(PathPatch(rest, fc=_PART, ec="none", zorder=1.2))
    colours = _MOVES(np.where(moves > sheet.still, moves / (sheet.change.largest_move or 1.0), 0.0))
    lines = _EDGE_INK if len(corners) <= _MOST_LINES else colours
    axes.add_collection(
        PolyCollection(list(corners), facecolors=colours, edgecolors=lines, linewidths=0.25, zorder=2)
    )
    if added.any():
        more = PathPatch(
            silhouette(corners[added]), fc=_ADDED, ec=_ADDED_INK, lw=0.2, hatch="....", zorder=2.1
        )
        axes.add_artist(more)
    _rims(axes, sheet)
    ring = sheet.change.largest_at if sheet.change.largest_move > sheet.still else None
    if ring is not None:
        axes.plot(*face(ring[None]).T, "o", ms=11, mfc="none", mec=_SPOT_INK, mew=1.5, zorder=SIGNS)
    edge_words(axes, (compass(-face.along), compass(face.along)))
    axes.set_xlabel(sheet.frame.label("along strike"))
    axes.set_ylabel(sheet.frame.label("up dip"))
    numbered(axes)
    labels = _numbers(sheet, window)
    axes.plot(
        *np.array([label.place for label in labels]).reshape(-1, 2).T,
        "o",
        ms=3,
        color=_SPOT_INK,
        zorder=SIGNS,
    )
    write_labels(axes, labels, extent, corners=True, ring=None if ring is None else face(ring))
    if legend:
        _legend(axes, sheet, bool(added.any()))


def _rims(axes: Axes, sheet: _Sheet) -> None:
    for shape, ink, width, dashes, order in (
        (sheet.made, FAULT, 1.1, "-", 3.0),
        (sheet.given, _CUT_INK, 0.9, (0, (4, 2)), 3.1),
    ):
        if shape is not None and len(shape.surface.triangles):
            rim = LineCollection(
                [sheet.face(p) for p in shape.rim], colors=ink, linewidths=width, zorder=order
            )
            rim.set_linestyle(dashes)
            axes.add_collection(rim, autolim=False)


def _numbers(sheet: _Sheet, window: Window) -> list[Label]:
    """Return the numbers of the changes in a window; those at one place together."""
    spots: dict[tuple[float, float], list[int]] = {}
    for number, place in sheet.places:
        x, y = (float(c) for c in sheet.face(place[None])[0])
        if window[0] <= x <= window[1] and window[2] <= y <= window[3]:
            spots.setdefault((x, y), []).append(number)
    named = [(", ".join(map(str, numbers[:4])), at) for at, numbers in spots.items()]
    return [Label(text, at, _SPOT_INK) for text, at in named[:_MOST_LABELS]]


def _legend(axes: Axes, sheet: _Sheet, added: bool) -> None:
    entries: list[Line2D | Patch] = [
        Line2D([], [], color=_CUT_INK, lw=0.9, ls=(0, (4, 2)), label="rim before"),
        Line2D([], [], color=FAULT, lw=1.1, label="rim after"),
    ]
    if added:
        entries.append(Patch(fc=_ADDED, ec=_ADDED_INK, lw=0.2, hatch="....", label="added"))
    if sheet.parts:
        entries.append(Patch(fc=_PART, ec=_PART_INK, lw=0.4, label="now another fault"))
    if sheet.change.cut_back > sheet.still or sheet.made is None:
        entries.append(Patch(fc=_CUT, ec=_CUT_INK, lw=0.2, hatch="////", label="cut off"))
    axes.legend(
        handles=entries,
        loc="lower left",
        ncols=len(entries),
        fontsize=7,
        frameon=True,
        facecolor=PAPER,
        edgecolor="none",
        framealpha=0.85,
        borderaxespad=0.2,
        handlelength=2.2,
    ).set_zorder(SIGNS + 1)


def _section(axes: Axes, sheet: _Sheet, at: FloatArray, half: float, extent: tuple[float, float]) -> None:
    """Draw a vertical section along the fault's dip through a place: before dashed, after solid."""
    direction = mean_dip_direction(sheet.given.surface.vertices, sheet.given.surface.triangles)[0]
    east = direction[0] > 0 or (direction[0] == 0 and direction[1] > 0)
    plane = Plane(at[:2], direction if east else -direction)
    factor, high = sheet.frame.z_factor, half * extent[1] / extent[0]
    low, top = sorted(factor * (at[2] + s * high) for s in (-1.0, 1.0))
    axes.set(xlim=(-half, half), ylim=(low, top) if factor > 0 else (top, low))
    labels = []
    drawn: list[tuple[Surface, str, float, Any, float]] = [
        (s, OTHER_INK[0], 1.0, "-", 2.0) for s in sheet.others
    ]
    drawn += [(sheet.made.surface, FAULT, 1.8, "-", 3.0)] if sheet.made is not None else []
    drawn += [(sheet.given.surface, _CUT_INK, 1.0, (0, (4, 2)), 3.1)]
    for surface, ink, width, dashes, order in drawn:
        segments = cut_by(plane, surface)[0] * [1.0, factor]
        near = (segments.max(axis=1) >= [-half, low]) & (segments.min(axis=1) <= [half, top])
        segments = segments[near.all(axis=1)]
        lines = PathPatch(strokes(segments), fill=False, ec=ink, lw=width, ls=dashes, zorder=order)
        axes.add_artist(lines)
        middles = segments.mean(axis=1)
        middles = middles[((middles > [-half, low]) & (middles < [half, top])).all(axis=1)]
        if len(middles) and surface is not sheet.given.surface:
            x, y = (float(c) for c in middles[np.argmax(factor * middles[:, 1])])
            labels.append(Label(shortened(surface.name), (x, y), ink, boxed=False))
    axes.plot([0.0], [factor * at[2]], "o", ms=11, mfc="none", mec=_SPOT_INK, mew=1.5, zorder=SIGNS)
    edge_words(axes, (compass(-plane.along), compass(plane.along)))
    axes.set_xlabel(sheet.frame.label("distance from the place"))
    axes.set_ylabel(sheet.frame.label(sheet.frame.z_name))
    numbered(axes)
    write_labels(axes, labels, extent, corners=True, ring=floats([0.0, factor * at[2]]))
