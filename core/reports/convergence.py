"""The course of all iterations of a run in one picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MaxNLocator

from graben.modeling.results import HorizonResult, TerminationType
from graben.reports.along_strike import fitted_name, looks
from graben.reports.style import FAULT, Frame, rounded, styled

#: A change of zero has no logarithm: it stands at this share of the tolerance.
_FLOOR = 1e-4
#: Names in the legend; further horizons are drawn without.
_MOST_NAMED = 12


@styled
def run_convergence_figure(results: Sequence[HorizonResult], tolerance: float, frame: Frame) -> Figure | None:
    """Return eps_k of formula (7) of the paper against the iteration: a line for each subdomain of a run.

    Subdomains of a horizon share its colour. One that ended with type 0 ends in a dot, any other in a cross
    with its type.

    Parameters
    ----------
    results : sequence of HorizonResult
        Rebuilt horizons.
    tolerance : float
        eps_tol, model units.
    frame : Frame
        Unit.

    Returns
    -------
    Figure or None
        None where nothing was iterated.
    """
    iterated = [(result, s) for result in results for s in result.subdomains if s.history]
    if not iterated:
        return None
    names = list(dict.fromkeys(result.name for result, _ in iterated))
    look = dict(zip(names, looks(len(names)), strict=True))
    figure = Figure(figsize=(7.6, 3.0), layout="constrained")
    axes = figure.add_subplot()
    for result, subdomain in iterated:
        colour, dash = look[result.name]
        heights = np.maximum(np.nan_to_num(subdomain.history, nan=0.0), _FLOOR * tolerance)
        at, kind = np.arange(1, len(heights) + 1), subdomain.termination.type
        good = kind is TerminationType.CONVERGED
        axes.plot(at, heights, color=colour, ls=dash, lw=1.3)
        axes.plot(at[-1], heights[-1], "o" if good else "X", ms=4.5 if good else 7, color=colour)
        if not good:
            end: dict[str, Any] = {"xytext": (5, 3), "textcoords": "offset points", "fontsize": 7.5}
            axes.annotate(f"type {int(kind)}", (at[-1], heights[-1]), **end)
    _tolerance(axes, tolerance, frame)
    longest = max(len(s.history) for _, s in iterated)
    axes.set(yscale="log", xlim=(0.8, max(2, longest) + 0.4), xlabel="iteration")
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: rounded(value)))
    axes.yaxis.set_minor_formatter(FuncFormatter(lambda value, _: ""))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    axes.set_ylabel(frame.label("largest change ε"))
    axes.set_title("convergence")
    handles = [
        Line2D([], [], color=look[name][0], ls=look[name][1], lw=1.3, label=fitted_name(name))
        for name in names[:_MOST_NAMED]
    ]
    if len(names) > _MOST_NAMED:
        handles.append(Line2D([], [], ls="none", label=f"and {len(names) - _MOST_NAMED} more"))
    figure.legend(handles=handles, loc="outside right upper", handlelength=2.6)
    return figure


def _tolerance(axes: Any, tolerance: float, frame: Frame) -> None:
    axes.axhline(tolerance, color=FAULT, lw=0.9, ls=(0, (5, 2)))
    axes.annotate(
        f"tolerance {frame.length(tolerance)}",
        (0.995, tolerance),
        xycoords=("axes fraction", "data"),
        xytext=(0, 2),
        textcoords="offset points",
        ha="right",
        va="bottom",
        fontsize=7.5,
    )
