"""What drawings along the strike of a fault share: axes, colours of horizons, and names that fit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.ticker import MaxNLocator

from graben.arrays import FloatArray
from graben.modeling.strike import Strike
from graben.reports.shapes import compass
from graben.reports.style import CYCLE, DASHES, Frame, plain_numbers
from graben.surface import Surface

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Letters of a name in a legend, a title or a label.
_LEGEND, _TITLE = 28, 22
#: The palest and the darkest of a scale that still stand out from paper.
_SCALE = (0.0, 0.9)


def fitted_name(name: str, most: int = _LEGEND) -> str:
    """Return a name fit to be written: one line, no longer than ``most``, seen by a legend.

    >>> fitted_name("a\\nb", 9), fitted_name("abcdefghijkl", 9), fitted_name("_F1", 9)
    ('a b', 'abcdefgh…', ' _F1')
    """
    line = " ".join("".join(c if c.isprintable() else " " for c in name).split())
    line = line if len(line) <= most else line[: most - 1] + "…"
    # A legend leaves out what begins with an underscore.
    return f" {line}" if line.startswith("_") else line


def title(name: str) -> str:
    """Return a name fit to stand in a title."""
    return fitted_name(name, _TITLE).lstrip()


def looks(count: int) -> list[tuple[str | tuple[float, ...], str]]:
    """Return a colour and a line style for each of some horizons or layers, told apart in either."""
    if count <= len(CYCLE):
        return [(CYCLE[k], DASHES[k % len(DASHES)]) for k in range(count)]
    scale = matplotlib.colormaps["viridis"](np.linspace(*_SCALE, count))
    return [(tuple(scale[k].tolist()), DASHES[k % len(DASHES)]) for k in range(count)]


def strike_axis(axes: Axes, fault: Surface, frame: Frame) -> None:
    """Label the axis along the strike of a fault, and write at its ends where they lie."""
    way = Strike.of(fault).way
    axes.set_xlabel(frame.label("distance along strike"))
    axes.xaxis.set_major_formatter(plain_numbers())
    axes.yaxis.set_major_formatter(plain_numbers())
    axes.xaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 2.5, 5, 10]))
    end_words(axes, way)


def end_words(axes: Axes, way: FloatArray, size: float = 8.0) -> None:
    """Write above the ends of an axis where they lie; ``way`` (2,) is its direction in plan."""
    for x, end, side in ((0.0, -way, "left"), (1.0, way, "right")):
        axes.text(
            x,
            1.005,
            compass(end),
            transform=axes.transAxes,
            weight="bold",
            ha=side,
            va="bottom",
            fontsize=size,
        )
