"""Allan diagrams: which layers of the two walls of a fault meet across it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from graben.modeling.results import HorizonResult
from graben.modeling.strike import Juxtaposed, juxtaposed
from graben.reports.along_strike import fitted_name, looks, strike_axis, title
from graben.reports.map_parts import HALO
from graben.reports.style import FAULT, FOOT, HANGING, Frame, styled
from graben.surface import Surface

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Juxtapositions of at least this share of the drawing, and on average of its height, have room for a number.
_NUMBERED, _HIGH = 0.004, 0.035
#: Names in the legend; further layers are drawn without.
_MOST_NAMED = 10
_FILLED = 0.35
_ROOM = 0.08  # above and below the cutoffs, of their range


@styled
def juxtaposition_figure(results: Sequence[HorizonResult], fault: Surface, frame: Frame) -> Figure | None:
    """Return the Allan diagram of a fault: its cutoffs on both walls, and the layers between neighbours.

    Layers of the foot wall are filled, those of the hanging wall hatched, each in its colour; where they
    overlap they meet across the fault, and a number says which: foot | hanging.

    Parameters
    ----------
    results : sequence of HorizonResult
        Rebuilt horizons.
    fault : Surface
        The fault as modeled.
    frame : Frame
        Unit and sign of z.

    Returns
    -------
    Figure or None
        None where the fault cuts fewer than two of them.
    """
    found = juxtaposed(results, fault)
    if not found.foot:
        return None
    figure = Figure(figsize=(7.6, 4.2), layout="constrained")
    axes = figure.add_subplot()
    colours = [colour for colour, _ in looks(len(found.foot))]
    for layer, colour in zip(found.foot, colours, strict=True):
        axes.add_patch(_patch(layer.shape, frame, fc=to_rgba(colour, _FILLED), ec="none", zorder=1))
    for layer, colour in zip(found.hanging, colours, strict=True):
        axes.add_patch(_patch(layer.shape, frame, fc="none", ec=colour, hatch="////", lw=0, zorder=2))
    _cutoffs(axes, found, frame)
    _limits(axes, found, frame)
    _numbers(axes, found, frame)
    strike_axis(axes, fault, frame)
    axes.set_ylabel(frame.label(frame.z_name))
    axes.set_title(f"{title(fault.name)}: juxtaposition (foot | hanging)", pad=16)
    axes.grid(False)
    figure.legend(handles=_legend(found, colours), loc="outside right upper", handlelength=2.2)
    return figure


def _patch(shape: shapely.Geometry, frame: Frame, **look: Any) -> PathPatch:
    """Return the polygons of a shape as one patch; holes stay holes."""
    rings = [
        np.asarray(ring.coords)[:, :2] * [1.0, frame.z_factor]
        for part in shapely.get_parts(shape)
        for ring in (part.exterior, *part.interiors)
    ]
    if not rings:
        return PathPatch(Path(np.zeros((1, 2))), **look)
    codes = [[Path.MOVETO, *[Path.LINETO] * (len(ring) - 2), Path.CLOSEPOLY] for ring in rings]
    return PathPatch(Path(np.concatenate(rings), np.concatenate(codes)), **look)


def _cutoffs(axes: Axes, found: Juxtaposed, frame: Frame) -> None:
    for line in found.stretches:
        for side, colour, dash in ((line.foot, FOOT, "-"), (line.hanging, HANGING, (0, (4, 1.6)))):
            axes.plot(side[:, 0], frame.z_factor * side[:, 1], color=colour, lw=1.4, ls=dash, zorder=4)


def _limits(axes: Axes, found: Juxtaposed, frame: Frame) -> None:
    """Set the limits, with depth growing downwards."""
    places = np.concatenate([side for line in found.stretches for side in (line.foot, line.hanging)])
    low, high = places.min(axis=0), places.max(axis=0)
    room = _ROOM * (high - low)
    axes.set_xlim(low[0] - 0.25 * room[0], high[0] + 0.25 * room[0])
    bottom, top = frame.z_factor * (low[1] - room[1]), frame.z_factor * (high[1] + room[1])
    axes.set_ylim(bottom, top if top != bottom else bottom + 1.0)


def _numbers(axes: Axes, found: Juxtaposed, frame: Frame) -> None:
    """Write at each juxtaposition of some size the numbers of its two layers."""
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    whole = abs((x1 - x0) * (y1 - y0))
    number = {(layer.upper, layer.lower): k for k, layer in enumerate(found.foot, start=1)}
    for meeting in found.meetings:
        for part in shapely.get_parts(meeting.shape):
            x_low, _, x_high, _ = part.bounds
            if part.area < max(_NUMBERED * whole, _HIGH * abs(y1 - y0) * (x_high - x_low)):
                continue
            place = shapely.point_on_surface(part)
            foot, hanging = (number[layer.upper, layer.lower] for layer in (meeting.foot, meeting.hanging))
            text = f"{foot}|{hanging}"
            bold = "bold" if foot == hanging else "normal"
            axes.text(
                *(place.x, frame.z_factor * place.y, text),
                ha="center",
                va="center",
                fontsize=7.5,
                weight=bold,
                color=FAULT,
                path_effects=[HALO],
                zorder=6,
            )


def _legend(found: Juxtaposed, colours: Sequence[Any]) -> list[Any]:
    handles: list[Any] = [
        Line2D([], [], color=FOOT, lw=1.4, label="footwall cutoffs"),
        Line2D([], [], color=HANGING, lw=1.4, ls=(0, (4, 1.6)), label="hanging wall cutoffs"),
        Patch(fc="#C9C9C9", ec="none", label="layer of the footwall"),
        Patch(fc="none", ec="#8A8A8A", hatch="////", lw=0, label="layer of the hanging wall"),
    ]
    for k, (layer, colour) in enumerate(zip(found.foot, colours, strict=True), start=1):
        if k > _MOST_NAMED:
            handles.append(Line2D([], [], ls="none", label=f"and {len(found.foot) - _MOST_NAMED} more"))
            break
        names = f"{k}  {fitted_name(layer.upper, 20)}\n    to {fitted_name(layer.lower, 20)}"
        handles.append(Patch(fc=to_rgba(colour, 0.6), ec="none", label=names))
    return handles
