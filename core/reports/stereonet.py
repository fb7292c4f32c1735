"""How the faults of a model lie: poles on an equal-area net, and a rose of their strikes.

The projection is a few lines; mplstereonet, which has it, had its last release in 2023, and apsg brings a
package of its own for what is asked here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from graben.arrays import FloatArray, floats
from graben.reports.along_strike import fitted_name, looks
from graben.reports.style import FAULT, HANGING, INPUT, styled
from graben.surface import Surface, mean_dip_direction, triangle_normals

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Poles drawn of one fault; of more, every so manieth of those sorted by their place.
_MOST_POLES = 400
#: Names in the legend; further faults are drawn without.
_MOST_NAMED = 14
#: Width of a petal of the rose, degrees.
_PETAL = 10
#: Dips with a circle on the net, degrees.
_CIRCLES = (30, 60)
_GREY = "#D0D0D0"


def equal_area(vectors: FloatArray) -> FloatArray:
    """Return directions (n, 3), z up, on the equal-area net of the lower half sphere, (n, 2), north up.

    The distance from the middle is sqrt(2) sin(t / 2), t the angle from straight down, so that the rim has
    radius 1 and equal areas of the sphere have equal areas on the net (W. Schmidt, 1925). Directions upwards
    are turned round.

    >>> (equal_area(floats([[0, 0, 5], [1, 0, 0], [0, 1, -1]])).round(6) + 0.0).tolist()
    [[0.0, 0.0], [1.0, 0.0], [0.0, 0.541196]]
    """
    v = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    v = v * np.where(v[:, 2:] > 0, -1.0, 1.0)
    # sqrt(2) sin(t / 2) = sqrt(1 - cos t), and sin t = sqrt((1 - cos t)(1 + cos t))
    return floats(v[:, :2] / np.sqrt(1.0 - v[:, 2:]))


def poles(surface: Surface) -> tuple[FloatArray, FloatArray]:
    """Return the normals of a surface, unit vectors down (m, 3), and the area of each triangle, (m,)."""
    normals = triangle_normals(surface.vertices, surface.triangles)
    size = np.linalg.norm(normals, axis=1)
    good = np.isfinite(size) & (size > 0)
    unit = normals[good] / size[good, None]
    return floats(unit * np.where(unit[:, 2:] > 0, -1.0, 1.0)), floats(size[good] / 2.0)


def strike_shares(surfaces: Sequence[Surface], petal: int = _PETAL) -> FloatArray:
    """Return the share of the area of surfaces in each petal of strike from north to south, (180 / petal,).

    Level triangles have no strike and count nowhere.
    """
    total = np.zeros(180 // petal)
    for surface in surfaces:
        pole, area = poles(surface)
        level = np.hypot(pole[:, 0], pole[:, 1])
        # Weighted by what is not level: a flat fault has hardly a strike.
        strike = (np.degrees(np.arctan2(pole[:, 0], pole[:, 1])) + 90.0) % 180.0
        total += np.bincount((strike // petal).astype(int) % len(total), area * level, len(total))
    whole = float(total.sum())
    return floats(total / whole if whole > 0 else total)


@styled
def stereonet_figure(faults: Sequence[Surface]) -> Figure | None:
    """Return a net of the poles of the faults' triangles with their mean planes, and a rose of their strikes.

    Parameters
    ----------
    faults : sequence of Surface
        Faults; those without a triangle that has an area are passed over.

    Returns
    -------
    Figure or None
        None where there is nothing to draw.
    """
    known = [fault for fault in faults if len(poles(fault)[1])]
    if not known:
        return None
    figure = Figure(figsize=(7.6, 3.9), layout="constrained")
    grid = figure.add_gridspec(1, 2, width_ratios=(1.15, 1.0))
    net = figure.add_subplot(grid[0])
    _net(net)
    handles: list[Any] = []
    for fault, (colour, _) in zip(known, looks(len(known)), strict=True):
        _fault(net, fault, colour)
        handles.append(Line2D([], [], color=colour, marker="o", ms=4, lw=1.2, label=fitted_name(fault.name)))
    net.set_title("poles and mean planes")
    _rose(figure.add_subplot(grid[1], projection="polar"), known)
    if len(handles) > _MOST_NAMED:
        more = Line2D([], [], ls="none", label=f"and {len(handles) - _MOST_NAMED} more")
        handles = [*handles[:_MOST_NAMED], more]
    figure.legend(handles=handles, loc="outside lower center", ncols=5, columnspacing=1.2)
    return figure


def _net(axes: Axes) -> None:
    """Draw the rim, circles of equal dip, and the points of the compass."""
    axes.set_axis_off()
    axes.set_aspect("equal")
    axes.set(xlim=(-1.15, 1.15), ylim=(-1.15, 1.15))
    axes.add_patch(Circle((0, 0), 1.0, fc="none", ec=FAULT, lw=1.0, zorder=2))
    for dip in _CIRCLES:
        radius = float(np.sqrt(2.0) * np.sin(np.radians(dip) / 2.0))
        axes.add_patch(Circle((0, 0), radius, fc="none", ec=_GREY, lw=0.7, zorder=1))
        axes.text(0.0, -radius, f"{dip}°", fontsize=6.5, color=INPUT, ha="center", va="bottom", zorder=1)
    axes.plot([-1, 1, np.nan, 0, 0], [0, 0, np.nan, -1, 1], color=_GREY, lw=0.7, zorder=1)
    for name, (x, y) in {"N": (0, 1.08), "E": (1.08, 0), "S": (0, -1.08), "W": (-1.08, 0)}.items():
        axes.text(x, y, name, ha="center", va="center", fontsize=8.5, weight="bold")


def _fault(axes: Axes, fault: Surface, colour: Any) -> None:
    pole = poles(fault)[0]
    places = equal_area(pole)
    every = -(-len(places) // _MOST_POLES)
    shown = places[np.lexsort(places.T)][::every]
    axes.plot(*shown.T, "o", ms=2.2, mec="none", mfc=colour, alpha=0.5, zorder=3)
    plane = mean_plane(fault)
    if len(plane):
        axes.plot(*plane.T, color=colour, lw=1.4, zorder=4)


def mean_plane(fault: Surface) -> FloatArray:
    """Return the great circle of the mean plane of a fault on the net, (k, 2)."""
    (dx, dy), dip = mean_dip_direction(fault.vertices, fault.triangles)
    c, s = np.cos(np.radians(dip)), np.sin(np.radians(dip))
    turn = np.linspace(0.0, np.pi, 91)[:, None]
    return equal_area(np.cos(turn) * [-dy, dx, 0.0] + np.sin(turn) * [dx * c, dy * c, -s])


def _rose(axes: Any, faults: Sequence[Surface]) -> None:
    """Draw the strikes, each petal with its opposite."""
    shares = 100.0 * strike_shares(faults)
    middles = np.radians(_PETAL * (np.arange(len(shares)) + 0.5))
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    both = np.concatenate([middles, middles + np.pi])
    width = np.radians(_PETAL)
    axes.bar(both, np.tile(shares, 2), width=width, color=HANGING, alpha=0.75, ec=FAULT, lw=0.5, zorder=2)
    axes.set_xticks(np.radians([0, 90, 180, 270]), ["N", "E", "S", "W"])
    axes.tick_params(axis="y", labelsize=6.5, labelcolor=INPUT)
    axes.spines["polar"].set_visible(True)
    axes.set_title("strikes, % of fault area")
