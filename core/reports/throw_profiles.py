"""The throw of every horizon along the strike of a fault, in one picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from graben.modeling.results import HorizonResult
from graben.modeling.strike import Stretch, stretches_on
from graben.reports.along_strike import fitted_name, looks, strike_axis, title
from graben.reports.style import FAULT, PAPER, Frame, styled
from graben.surface import Surface

#: Names in the legend; further horizons are drawn without.
_MOST_NAMED = 14


@styled
def throw_profile_figure(results: Sequence[HorizonResult], fault: Surface, frame: Frame) -> Figure | None:
    """Return the throw of each horizon that a fault cuts against the distance along its strike.

    Lines end at tips, exits and junctions; a ring marks an end at which the throw is not zero. Positive throw
    is normal, negative reverse.

    Parameters
    ----------
    results : sequence of HorizonResult
        Rebuilt horizons, in the order of the legend.
    fault : Surface
        The fault as modeled.
    frame : Frame
        Unit.

    Returns
    -------
    Figure or None
        None where the fault cuts none of them.
    """
    lines = stretches_on(results, fault)
    names = list(dict.fromkeys(line.horizon for line in lines))
    if not names:
        return None
    figure = Figure(figsize=(7.6, 3.2), layout="constrained")
    axes = figure.add_subplot()
    axes.axhline(0.0, color=FAULT, lw=0.7)
    look = dict(zip(names, looks(len(names)), strict=True))
    for line in lines:
        colour, dash = look[line.horizon]
        axes.plot(line.along, line.throw, color=colour, ls=dash, lw=1.5, label=fitted_name(line.horizon))
        _open_ends(axes, line, colour)
    strike_axis(axes, fault, frame)
    axes.set_ylabel(frame.label("throw"))
    axes.set_title(f"{title(fault.name)}: throw along strike", pad=16)
    handles: list[Any] = [
        Line2D([], [], color=look[name][0], ls=look[name][1], lw=1.5, label=fitted_name(name))
        for name in names[:_MOST_NAMED]
    ]
    if len(names) > _MOST_NAMED:
        handles.append(Line2D([], [], ls="none", label=f"and {len(names) - _MOST_NAMED} more"))
    figure.legend(handles=handles, loc="outside right upper", handlelength=2.6)
    return figure


def _open_ends(axes: Any, line: Stretch, colour: Any) -> None:
    """Mark ends with throw: at an exit, at a junction."""
    for k in (0, -1):
        if np.abs(line.throw[k]) > 0:
            axes.plot(line.along[k], line.throw[k], "o", ms=4, mfc=PAPER, mec=colour, mew=1.0)
