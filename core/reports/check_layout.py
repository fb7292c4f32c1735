"""How the panels of a figure stand on paper."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from graben.reports.map_parts import Window
from graben.reports.marks import fitted
from graben.reports.shapes import Shape
from graben.surface import triangle_areas, triangle_dips

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Inches on paper.
_WIDTH, _LEFT, _BOTTOM, _TOP, _GAP, _RIGHT, _BAR = 7.6, 0.68, 0.5, 0.1, 0.8, 0.12, 0.62
#: Least and greatest height over width of a panel that has a row to itself.
FLATTEST, TALLEST = 0.16, 0.42
#: Share of a fault's area whose dips the colours tell apart.
_TAILS = (0.02, 0.98)
_LEAST_DIPS = 5.0  # degrees that the colours span at least
_DIPS = LinearSegmentedColormap.from_list("dips", ["#F4F6F8", "#C9D6E2", "#8FA9C2", "#54708F"])

#: Draws a panel of a size in inches.
Panel = Callable[["Axes", tuple[float, float]], None]
#: Panels beside each other, and their height over their width where there is but one.
Row = tuple[Sequence[Panel], float]
#: Colours and the values they stand for.
Scale = tuple[LinearSegmentedColormap, Normalize]


def composed(rows: Sequence[Row], scale: Scale | None = None, label: str = "dip [degrees]") -> Figure:
    """Return a figure of rows of panels; with a scale, the first row has a bar of its colours beside it."""
    bar = 0.0 if scale is None else _BAR
    room = _WIDTH - _LEFT - _RIGHT - bar
    widths = [(room - _GAP * (len(panels) - 1)) / len(panels) for panels, _ in rows]
    ratios = [1.0 if len(panels) > 1 else float(np.clip(r, FLATTEST, TALLEST)) for panels, r in rows]
    heights = [w * r for w, r in zip(widths, ratios, strict=True)]
    total = sum(heights) + len(rows) * (_BOTTOM + _TOP)
    figure = Figure(figsize=(_WIDTH, total))
    bottom = total
    for k, (panels, _) in enumerate(rows):
        bottom -= heights[k] + _TOP
        for n, draw in enumerate(panels):
            left = _LEFT + n * (widths[k] + _GAP)
            box = (left / _WIDTH, bottom / total, widths[k] / _WIDTH, heights[k] / total)
            draw(figure.add_axes(box), (widths[k], heights[k]))
        if k == 0 and scale is not None:
            left = (_WIDTH - bar - _RIGHT + 0.12) / _WIDTH
            side = figure.add_axes((left, bottom / total, 0.1 / _WIDTH, heights[k] / total))
            drawn = figure.colorbar(
                ScalarMappable(scale[1], scale[0]), cax=side, ticks=MaxNLocator(5, steps=[1, 2, 5, 10])
            )
            drawn.set_label(label, fontsize=7.5)
            drawn.outline.set_linewidth(0.4)
            side.tick_params(labelsize=7)
        bottom -= _BOTTOM
    return figure


def framed(axes: Axes, window: Window) -> None:
    """Draw the frame of a spot."""
    west, east, south, north = window
    ring = [west, east, east, west, west], [south, south, north, north, south]
    axes.plot(*ring, color="#222222", lw=0.9, zorder=8)


def paper(window: Window, extent: tuple[float, float]) -> Window:
    """Return a window widened to the proportions of a panel."""
    return fitted(window, extent[1] / extent[0])


def dip_scale(shape: Shape) -> Scale:
    """Return the colours of the dips of a fault, degrees."""
    dips = triangle_dips(shape.surface.vertices, shape.surface.triangles)
    order = np.argsort(dips)
    shares = np.cumsum(triangle_areas(shape.surface.vertices, shape.surface.triangles)[order])
    if shares[-1] <= 0:
        return _DIPS, Normalize(0.0, 90.0)
    low, high = (dips[order][min(np.searchsorted(shares, t * shares[-1]), len(dips) - 1)] for t in _TAILS)
    more = max(_LEAST_DIPS - (high - low), 0.0) / 2
    return _DIPS, Normalize(max(float(low) - more, 0.0), min(float(high) + more, 90.0))
