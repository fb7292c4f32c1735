"""What all figures share: colours, units on axes, and drawing that gives the same bytes each time."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import matplotlib
import numpy as np
from matplotlib.ticker import FuncFormatter, MaxNLocator

from graben.arrays import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.ticker import Formatter

    from graben.model import Model

P = ParamSpec("P")
R = TypeVar("R")

# Distinct in hue and in lightness, so that they hold for colour-blind eyes and on a grey print.
HANGING = "#D55E00"
FOOT = "#0B3C78"
FAULT = "#1A1A1A"
INPUT = "#7A7A7A"
PAPER = "#FFFFFF"
#: Okabe and Ito's colours, for lines told apart by style as well.
CYCLE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#1A1A1A")
DASHES = ("-", "--", "-.", ":")

#: Plan extents above this many units are labelled in thousands (kilometres).
_THOUSANDS = 5000.0

_RC: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 11.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.6,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "hatch.linewidth": 0.5,
    "svg.hashsalt": "graben",
    "svg.fonttype": "path",
    # Names are text as they stand: a $ in one is no formula.
    "text.parse_math": False,
    "axes.formatter.use_mathtext": False,
}


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Return ``draw`` running under the house style, whatever the user's own matplotlib settings."""

    @functools.wraps(draw)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> R:
        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            matplotlib.rcParams.update(_RC)
            return draw(*args, **kwargs)

    return wrapped


@dataclass(frozen=True)
class Frame:
    """How coordinates are told: unit, sign of z, and the unit of plan axes.

    ``z_factor`` is 1 for elevations and -1 for depths; ``unit`` is "" where the model has none.
    """

    unit: str
    z_factor: float

    @classmethod
    def of(cls, model: Model) -> Frame:
        """Return the frame of a model."""
        return cls("" if model.unit == "none" else model.unit, model.z_factor)

    @property
    def z_name(self) -> str:
        """elevation or depth."""
        return "elevation" if self.z_factor > 0 else "depth"

    def label(self, name: str, unit: str | None = None) -> str:
        """Return an axis label such as ``depth [m]``."""
        unit = self.unit if unit is None else unit
        return f"{name} [{unit}]" if unit else name

    def length(self, value: float) -> str:
        """Return a length with three digits and its unit.

        >>> Frame("m", 1.0).length(137.91)
        '138 m'
        """
        return f"{rounded(value)} {self.unit}".rstrip()

    def place(self, place: Sequence[float] | FloatArray, step: float) -> str:
        """Return a place (x, y, elevation) in the model's own convention of z; ``step`` as of :func:`placed`.

        >>> Frame("m", -1.0).place((1.0, 2.0, -3.0), 100.0)
        'x 1, y 2, depth 3'
        """
        x, y, z = (placed(float(c) + 0.0, step) for c in (place[0], place[1], self.z_factor * place[2]))
        return f"x {x}, y {y}, {self.z_name} {z}"

    def plan_axes(self, axes: Axes, extent: float) -> None:
        """Label x and y of a map whose larger side is ``extent`` units."""
        if self.unit and extent > _THOUSANDS:
            unit, scale = {"m": "km"}.get(self.unit, f"1000 {self.unit}"), 1000.0
        else:
            unit, scale = self.unit, 1.0
        for axis, name in ((axes.xaxis, "x"), (axes.yaxis, "y")):
            axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
            axis.set_major_formatter(plain_numbers(scale))
            axis.set_label_text(self.label(name, unit))


def rounded(value: float) -> str:
    """Return a number with three digits, without an exponent where it has up to seven before the point.

    >>> rounded(1234.6), rounded(0.01234), rounded(-0.0)
    ('1235', '0.0123', '0')
    """
    if value == 0:
        return "0"
    if not np.isfinite(value):
        return "-"
    digits = max(2 - int(np.floor(np.log10(abs(value)))), 0)
    text = f"{value:.{digits}f}" if digits < 8 else f"{value:.2e}"
    return text.rstrip("0").rstrip(".") if "." in text and "e" not in text else text


def placed(value: float, step: float) -> str:
    """Return a coordinate with the digits that matter where things are ``step`` units apart.

    >>> placed(435048.308, 100.0), placed(3.14159, 0.25), placed(-0.001, 1.0)
    ('435048', '3.142', '0.00')
    """
    return f"{value:z.{max(2 - int(np.floor(np.log10(step))), 0)}f}"


def plain_numbers(scale: float = 1.0) -> Formatter:
    """Return a formatter of ticks divided by ``scale``, with no offset and no exponent."""
    return FuncFormatter(lambda value, _: f"{round(value / scale, 9):.12g}")


def elevation_colours() -> Colormap:
    """Return the colours of elevation: light where shallow, blue-green where deep, never dark as a line."""
    from matplotlib.colors import LinearSegmentedColormap

    full = matplotlib.colormaps["YlGnBu"]
    return LinearSegmentedColormap.from_list("elevation", full(np.linspace(0.68, 0.04, 256)))


def nice(value: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is no greater than ``value`` > 0.

    >>> nice(437.0), nice(0.3)
    (200.0, 0.2)
    """
    power = 10.0 ** np.floor(np.log10(value))
    factors = [f for f in (1.0, 2.0, 5.0) if f * power <= value * (1 + 1e-9)]
    return float(max(factors) * power)
