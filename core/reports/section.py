"""A vertical section across a fault where its throw is largest: the first thing a geologist looks at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from graben.arrays import BoolArray, FloatArray, IntArray, bools
from graben.cutgraph import NodeKind
from graben.model import Fault
from graben.modeling.results import Cutoff, HorizonResult
from graben.reports.along_strike import title
from graben.reports.map_parts import HALO
from graben.reports.shapes import compass, crossings
from graben.reports.style import FAULT, FOOT, HANGING, INPUT, PAPER, Frame, placed, plain_numbers, styled
from graben.surface import Surface

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_EXAGGERATIONS = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0)
#: Height of the section over its width, and the share of the height the horizon may take.
_ASPECT, _FILLED = 0.42, 0.3
_ZONE = "#F1EDE2"


@dataclass(frozen=True, eq=False)
class Plane:
    """A vertical plane: a point and a unit vector in plan, shape (2,) each; the section looks across it."""

    origin: FloatArray
    along: FloatArray

    def coordinates(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the distances of points (..., >= 2) along the plane and to its left, model units."""
        way = points[..., :2] - self.origin
        return way @ self.along, way @ np.array([-self.along[1], self.along[0]])


def cut_by(plane: Plane, surface: Surface) -> tuple[FloatArray, IntArray]:
    """Return where a vertical plane cuts a surface.

    Returns
    -------
    segments : (k, 2, 2) array
        Ends of each segment: distance along the plane and elevation, model units.
    triangles : (k,) array
        The triangle of each.
    """
    along, off = plane.coordinates(surface.vertices)
    return crossings(np.stack([along, surface.vertices[:, 2]], axis=1), surface.triangles, off)


def section_place(result: HorizonResult, fault: str, margin: float) -> tuple[Cutoff, int] | None:
    """Return the cutoff of a fault and its row where a section shows most: large throw, no other fault.

    Parameters
    ----------
    result : HorizonResult
        The horizon.
    fault : str
        Name of the fault.
    margin : float
        How far to stay from junctions and from the outer boundary, which disturb a section, model units;
        where no row lies so far off, the one furthest from them is taken.

    Returns
    -------
    (Cutoff, int) or None
        None where the fault does not cut the horizon.
    """
    kinds = result.graph.kinds
    disturbing = result.graph.nodes[(kinds != NodeKind.INTERIOR) & (kinds != NodeKind.TIP), :2]
    best: tuple[bool, float, Cutoff, int] | None = None
    for cutoff in result.cutoffs:
        if cutoff.fault != fault or len(cutoff.throw) < 2:
            continue
        middle = (cutoff.hanging[:, :2] + cutoff.foot[:, :2]) / 2
        way = middle[:, None] - disturbing[None]
        away = np.hypot(way[..., 0], way[..., 1]).min(axis=1, initial=np.inf)
        clear = away >= margin
        size = np.where(clear, np.abs(cutoff.throw), -1.0) if clear.any() else away
        rank = bool(clear.any()), float(size.max())
        if best is None or rank > best[:2]:
            best = *rank, cutoff, int(np.argmax(size))
    return None if best is None else best[2:]


def plane_across(cutoff: Cutoff, row: int) -> Plane:
    """Return the vertical plane across a cutoff at one of its rows, running eastwards."""
    middle = (cutoff.hanging[:, :2] + cutoff.foot[:, :2]) / 2
    before, after = middle[max(row - 1, 0)], middle[min(row + 1, len(middle) - 1)]
    way = after - before
    size = float(np.hypot(*way))
    right = np.array([way[1], -way[0]]) / size if size > 0 else np.array([1.0, 0.0])
    eastwards = right[0] > 0 or (right[0] == 0 and right[1] > 0)
    return Plane(middle[row], right if eastwards else -right)


@styled
def section_figure(
    result: HorizonResult, cutoff: Cutoff, row: int, faults: Sequence[Fault], frame: Frame, half_width: float
) -> Figure:
    """Return the vertical section across a fault at one pair of its cutoff.

    Parameters
    ----------
    result : HorizonResult
        The horizon.
    cutoff : Cutoff
        One of its cutoffs.
    row : int
        Row of the cutoff at which the section stands.
    faults : sequence of Fault
        The faults of the model as used.
    frame : Frame
        Unit and sign of z.
    half_width : float
        How far the section reaches to each side, model units.
    """
    plane = plane_across(cutoff, row)
    figure = Figure(figsize=(7.6, 3.9), layout="constrained")
    axes = figure.add_subplot()
    rebuilt, triangles = cut_by(plane, result.surface)
    before, _ = cut_by(plane, result.horizon.surface)
    near = np.abs(rebuilt[..., 0]).max(axis=1) <= half_width
    shown = [s[np.abs(s[..., 0]).max(axis=1) <= half_width] for s in (rebuilt, before)]
    zone = ~result.fixed[result.surface.triangles[triangles]].all(axis=1)
    _trusted(axes, rebuilt[near & zone])
    _faults(axes, plane, faults, cutoff.fault, frame)
    _picks(axes, plane, result, frame)
    line = before.reshape(-1, 2)[
        np.argsort(before[..., 0].ravel(), kind="stable")
    ]  # a function of the distance
    axes.plot(line[:, 0], frame.z_factor * line[:, 1], color=INPUT, lw=1.3, ls=(0, (4, 2)), zorder=4)
    _rebuilt(axes, rebuilt, _hanging(result, cutoff, plane, triangles, rebuilt), frame)
    exaggeration = _frame(axes, np.concatenate(shown), cutoff, row, half_width, frame)
    _throw_and_heave(axes, plane, cutoff, row, frame)
    _labels(axes, result, cutoff, row, plane, exaggeration, frame)
    figure.legend(handles=_legend(result), loc="outside lower left", ncols=5, columnspacing=1.4)
    return figure


def _trusted(axes: Axes, zone: FloatArray) -> None:
    """Shade the zone in which the horizon was rebuilt."""
    if len(zone):
        axes.axvspan(float(zone[..., 0].min()), float(zone[..., 0].max()), color=_ZONE, lw=0, zorder=0)


def _faults(axes: Axes, plane: Plane, faults: Sequence[Fault], main: str, frame: Frame) -> None:
    for fault in faults:
        segments, _ = cut_by(plane, fault.surface)
        lines = LineCollection(list(segments * [1.0, frame.z_factor]), zorder=3, capstyle="round")
        lines.set(color=FAULT, linewidth=1.8 if fault.name == main else 0.9)
        axes.add_collection(lines, autolim=False)


def _picks(axes: Axes, plane: Plane, result: HorizonResult, frame: Frame) -> None:
    """Draw input points within one step of the section."""
    if len(result.horizon.picks):
        along, off = plane.coordinates(result.horizon.picks)
        near = np.abs(off) <= result.horizon.step
        z = frame.z_factor * result.horizon.picks[near, 2]
        axes.plot(along[near], z, "o", ms=2.6, mfc="none", mec=INPUT, mew=0.7, zorder=3.5)


def _hanging(
    result: HorizonResult, cutoff: Cutoff, plane: Plane, triangles: IntArray, segments: FloatArray
) -> BoolArray:
    """Return which segments lie on the hanging side: by their block, and beyond its zone by their place."""
    block = result.block[:, result.graph_faults.index(cutoff.fault)][result.surface.triangles[triangles]].sum(
        axis=1
    )
    toward = 1.0 if _dip_sign(cutoff, plane) > 0 else -1.0
    return bools(np.where(block != 0, block > 0, toward * segments[..., 0].mean(axis=1) > 0))


def _dip_sign(cutoff: Cutoff, plane: Plane) -> float:
    """Return 1 where the fault dips along the plane's direction, else -1: the cutoff dips to its right."""
    way = cutoff.hanging[-1, :2] + cutoff.foot[-1, :2] - cutoff.hanging[0, :2] - cutoff.foot[0, :2]
    return float(np.sign(np.array([way[1], -way[0]]) @ plane.along)) or 1.0


def _rebuilt(axes: Axes, segments: FloatArray, hanging: BoolArray, frame: Frame) -> None:
    for side, colour in ((~hanging, FOOT), (hanging, HANGING)):
        lines = LineCollection(
            list(segments[side] * [1.0, frame.z_factor]), colors=colour, linewidths=2.4, zorder=5
        )
        lines.set_capstyle("round")
        axes.add_collection(lines, autolim=False)


def _frame(axes: Axes, shown: FloatArray, cutoff: Cutoff, row: int, half_width: float, frame: Frame) -> float:
    """Set the limits and return the vertical exaggeration: true scale where the throw is then seen well."""
    z = np.concatenate([shown[..., 1].ravel(), [cutoff.hanging[row, 2], cutoff.foot[row, 2]]])
    low, high = float(z.min()), float(z.max())
    height = 2 * half_width * _ASPECT
    fitting = [e for e in _EXAGGERATIONS if (high - low) * e <= _FILLED * height]
    exaggeration = fitting[-1] if fitting else 1.0
    half = max(height / exaggeration, (high - low) * 1.25) / 2
    middle = (low + high) / 2
    limits = sorted((frame.z_factor * (middle - half), frame.z_factor * (middle + half)))
    axes.set(xlim=(-half_width, half_width), ylim=limits if frame.z_factor > 0 else limits[::-1])
    axes.set_aspect(exaggeration)
    axes.xaxis.set_major_formatter(plain_numbers())
    axes.yaxis.set_major_formatter(plain_numbers())
    return exaggeration


def _throw_and_heave(axes: Axes, plane: Plane, cutoff: Cutoff, row: int, frame: Frame) -> None:
    """Draw throw and heave as the legs of a right triangle between the two cutoff points."""
    lips = np.stack([cutoff.hanging[row], cutoff.foot[row]])
    along, z = plane.coordinates(lips)[0], frame.z_factor * lips[:, 2]
    axes.plot([along[1], along[1], along[0]], [z[1], z[0], z[0]], color=FAULT, lw=0.8, ls=":", zorder=6)
    axes.plot(along[:1], z[:1], "o", ms=5, color=HANGING, mec=PAPER, mew=0.8, zorder=7)
    axes.plot(along[1:], z[1:], "o", ms=5, color=FOOT, mec=PAPER, mew=0.8, zorder=7)
    text = f"throw {frame.length(cutoff.throw[row])}\nheave {frame.length(cutoff.heave[row])}"
    beside = 1.0 if along[1] < along[0] else -1.0
    axes.annotate(
        text,
        (along[1], (z[0] + z[1]) / 2),
        xytext=(-beside * 10, 0),
        textcoords="offset points",
        ha="right" if beside > 0 else "left",
        va="center",
        fontsize=8,
        path_effects=[HALO],
        zorder=8,
    )


def _labels(
    axes: Axes,
    result: HorizonResult,
    cutoff: Cutoff,
    row: int,
    plane: Plane,
    exaggeration: float,
    frame: Frame,
) -> None:
    names = [compass(-plane.along), compass(plane.along)]
    for x, name in zip((0.012, 0.988), names, strict=True):
        side = "left" if x < 0.5 else "right"
        axes.text(
            x,
            0.965,
            name,
            transform=axes.transAxes,
            weight="bold",
            ha=side,
            va="top",
            path_effects=[HALO],
            zorder=8,
        )
    scale = "true scale" if exaggeration == 1.0 else f"vertical exaggeration {exaggeration:g}"
    axes.set_title(
        f"{title(result.name)}: section across {title(cutoff.fault)} "
        f"where its throw is {frame.length(cutoff.throw[row])}"
    )
    at_x, at_y = (placed(value, result.horizon.step) for value in plane.origin)
    axes.set_xlabel(frame.label(f"distance from the fault at x {at_x}, y {at_y}"))
    axes.set_ylabel(frame.label(frame.z_name))
    axes.text(
        0.988,
        0.03,
        scale,
        transform=axes.transAxes,
        ha="right",
        va="bottom",
        fontsize=8,
        path_effects=[HALO],
        zorder=8,
    )


def _legend(result: HorizonResult) -> list[Any]:
    handles: list[Any] = [
        Line2D([], [], color=HANGING, lw=2.4, label="rebuilt, hanging wall"),
        Line2D([], [], color=FOOT, lw=2.4, label="rebuilt, footwall"),
        Line2D([], [], color=INPUT, lw=1.3, ls=(0, (4, 2)), label="input"),
        Line2D([], [], color=FAULT, lw=1.8, label="fault"),
    ]
    handles.append(Patch(color=_ZONE, label="zone rebuilt"))
    if len(result.horizon.picks):
        handles.append(
            Line2D([], [], marker="o", ms=2.6, mfc="none", mec=INPUT, ls="none", label="input points")
        )
    return handles
