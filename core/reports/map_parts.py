"""What every map bears: bounds, a bar of scale and the arrow of north."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.path import Path
from matplotlib.patheffects import withStroke

from graben.arrays import FloatArray
from graben.modeling.results import HorizonResult, TerminationType
from graben.reports.style import FAULT, PAPER, Frame, nice

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: West, east, south and north, model units.
Window = tuple[float, float, float, float]

#: Behind letters that stand on lines.
HALO = withStroke(linewidth=2.5, foreground=PAPER)
#: Hides lines and surfaces of a map.
SIGNS = 7.0
#: Colour of what did not converge.
_OPEN = "#C00000"
_SCALE_BAR = 0.22  # of the map's larger side


def bounds(xy: FloatArray) -> Window:
    """Return west, east, south and north of points (n, 2)."""
    low, high = xy.min(axis=0), xy.max(axis=0)
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def silhouette(corners: FloatArray) -> Path:
    """Return triangles, corners (m, 3, 2), as one path: filled, it shows no seam between them.

    All are turned to one sense, so that the rule of winding numbers fills their union.
    """
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    clockwise = a[:, 0] * b[:, 1] < a[:, 1] * b[:, 0]
    turned = np.where(clockwise[:, None, None], corners[:, ::-1], corners)
    closed = np.concatenate([turned, turned[:, :1]], axis=1).reshape(-1, 2)
    return Path(closed, np.tile([Path.MOVETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY], len(corners)))


def strokes(segments: FloatArray) -> Path:
    """Return segments, ends (k, 2, 2), as one path."""
    return Path(segments.reshape(-1, 2), np.tile([Path.MOVETO, Path.LINETO], len(segments)))


def scale_bar_box(window: Window, extent: float) -> tuple[float, float, float, float]:
    """Return west, south, east and north of what the bar of scale covers of a map."""
    x, y, pad = window[0] + 0.02 * extent, window[2] + 0.03 * extent, 0.015 * extent
    return x - pad, y - 0.02 * extent, x + nice(_SCALE_BAR * extent) + pad, y + 0.03 * extent


def scale_bar(axes: Axes, window: Window, extent: float, frame: Frame) -> None:
    """Draw a bar of round length in the lower left corner."""
    length = nice(_SCALE_BAR * extent)
    x, y, h = window[0] + 0.02 * extent, window[2] + 0.03 * extent, 0.008 * extent
    halves = [
        [(x + a, y), (x + b, y), (x + b, y + h), (x + a, y + h)]
        for a, b in ((0, length / 2), (length / 2, length))
    ]
    west, south, east, north = scale_bar_box(window, extent)
    box = [(west, south), (east, south), (east, north), (west, north)]
    axes.add_collection(PolyCollection([box], facecolors=PAPER, edgecolors="none", alpha=0.8, zorder=SIGNS))
    axes.add_collection(
        PolyCollection(halves, facecolors=[FAULT, PAPER], edgecolors=FAULT, linewidths=0.7, zorder=SIGNS + 1)
    )
    whole = frame.unit == "m" and length >= 1000
    text = f"{length / 1000:g} km" if whole else f"{length:g} {frame.unit}".rstrip()
    axes.text(x + length / 2, y + 1.6 * h, text, ha="center", va="bottom", fontsize=7.5, zorder=SIGNS + 1)


def north_arrow(axes: Axes) -> None:
    """Draw the arrow of north, which is up: y grows that way."""
    axes.annotate(
        "N",
        xy=(0.95, 0.96),
        xytext=(0.95, 0.89),
        xycoords="axes fraction",
        ha="center",
        va="top",
        fontsize=9,
        weight="bold",
        path_effects=[HALO],
        arrowprops={"arrowstyle": "-|>", "color": FAULT, "lw": 1.4, "shrinkA": 0, "shrinkB": 0},
        zorder=SIGNS + 1,
    )


def mark_open(axes: Axes, result: HorizonResult) -> str:
    """Mark where subdomains did not converge by crosses; return what to add to the title, if any did not."""
    open_ = [s.termination for s in result.subdomains if s.termination.type is not TerminationType.CONVERGED]
    if not open_:
        return ""
    places = [(t.x, t.y) for t in open_ if t.x is not None and t.y is not None]
    if not places:
        return ", not converged"
    x, y = zip(*places, strict=True)
    axes.plot(x, y, "P", ms=9, mfc=_OPEN, mec=PAPER, mew=0.8, ls="none", zorder=SIGNS + 2)
    return f", not converged (at the red {'cross' if len(places) == 1 else 'crosses'})"
