"""Throw profiles and the course of the iteration as figures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from graben.arrays import FloatArray
from graben.modeling.results import HorizonResult, TerminationType
from graben.reports.along_strike import fitted_name, title
from graben.reports.style import (
    CYCLE,
    DASHES,
    FAULT,
    FOOT,
    HANGING,
    INPUT,
    Frame,
    plain_numbers,
    rounded,
    styled,
)

#: Profiles beyond these are left out, and the figure says how many.
_MOST_PANELS = 12
_COLUMNS = 3
#: Subdomains beyond these share one colour; they are told apart in the table.
_MOST_NAMED = 7
#: Faults that a subdomain is called by: more names would leave the figure no room.
_MOST_FAULTS = 4
#: An eps_k of zero has no logarithm: it stands at this share of the tolerance.
_FLOOR = 1e-4


@styled
def throw_figure(result: HorizonResult, frame: Frame, truth: Sequence[FloatArray] = ()) -> Figure:
    """Return throw and heave along each cutoff.

    Parameters
    ----------
    result : HorizonResult
        A horizon with at least one cutoff.
    frame : Frame
        Unit.
    truth : sequence of (k,) arrays, optional
        The true throw at each row of each cutoff, model units, NaN where unknown.
    """
    shown = sorted(range(len(result.cutoffs)), key=lambda k: -float(np.abs(result.cutoffs[k].throw).max()))
    shown = sorted(shown[:_MOST_PANELS])
    columns = min(_COLUMNS, len(shown))
    rows = math.ceil(len(shown) / columns)
    figure = Figure(figsize=(7.6, 0.7 + (2.3 if columns == 1 else 1.8) * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True)
    for k, axes in zip(shown, panels.flat, strict=False):
        cutoff = result.cutoffs[k]
        axes.axhline(0.0, color=FAULT, lw=0.7)
        axes.fill_between(cutoff.s, cutoff.throw, color=HANGING, alpha=0.12, lw=0)
        (throw,) = axes.plot(cutoff.s, cutoff.throw, color=HANGING, lw=1.8, label="throw")
        (heave,) = axes.plot(cutoff.s, cutoff.heave, color=FOOT, lw=1.1, ls="--", label="heave")
        handles = [throw, heave]
        if len(truth) > k:
            handles += axes.plot(cutoff.s, truth[k], color=FAULT, lw=1.2, ls=":", label="true throw")
        axes.set_title(_piece(result, k), fontsize=9)
        axes.xaxis.set_major_formatter(plain_numbers())
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.yaxis.set_major_formatter(plain_numbers())
    for axes in list(panels.flat)[len(shown) :]:
        axes.set_visible(False)
    omitted = len(result.cutoffs) - len(shown)
    more = f" ({omitted} cutoffs of smaller throw not shown)" if omitted else ""
    figure.suptitle(f"{title(result.name)}: throw{more}", x=0.01, ha="left", weight="bold", fontsize=11)
    figure.supxlabel(frame.label("distance along the trace"), fontsize=9)
    figure.supylabel(frame.label("throw, heave"), fontsize=9)
    figure.legend(handles=handles, loc="outside upper right", ncols=3)
    return figure


def _piece(result: HorizonResult, k: int) -> str:
    """Return the fault's name, with the number of the piece where it has several, and its largest throw."""
    name = result.cutoffs[k].fault
    pieces = [i for i, c in enumerate(result.cutoffs) if c.fault == name]
    number = f", piece {pieces.index(k) + 1} of {len(pieces)}" if len(pieces) > 1 else ""
    return f"{title(name)}{number}"


def _some(faults: Sequence[str]) -> str:
    """Return the names of faults, of many the first.

    >>> _some([]), _some(["F1", "F2"]), _some([f"F{k}" for k in range(1, 46)])
    ('no fault', 'F1, F2', 'F1, F2, F3, F4 and 41 more')
    """
    named, rest = ", ".join(faults[:_MOST_FAULTS]), len(faults) - _MOST_FAULTS
    return (f"{named} and {rest} more" if rest > 0 else named) or "no fault"


@styled
def convergence_figure(result: HorizonResult, tolerance: float, frame: Frame) -> Figure:
    """Return eps_k of formula (7) of the paper against the iteration, for each subdomain that was iterated.

    Parameters
    ----------
    result : HorizonResult
        A horizon with at least one iteration.
    tolerance : float
        eps_tol, model units.
    frame : Frame
        Unit.
    """
    figure = Figure(figsize=(7.6, 2.7), layout="constrained")
    axes = figure.add_subplot()
    iterated = [s for s in result.subdomains if s.history]
    named = 0
    for subdomain in iterated:
        good = subdomain.termination.type is TerminationType.CONVERGED
        heights = np.maximum(np.nan_to_num(subdomain.history, nan=0.0), _FLOOR * tolerance)
        style: dict[str, Any] = {"color": INPUT, "lw": 0.8, "ls": "-"}
        if named < _MOST_NAMED:
            style = {"color": CYCLE[named % len(CYCLE)], "lw": 1.5, "ls": DASHES[named % len(DASHES)]}
            kind = f"type {int(subdomain.termination.type)}"
            style["label"] = f"{subdomain.id}: {fitted_name(_some(subdomain.faults))} ({kind})"
            named += 1
        axes.plot(np.arange(1, len(heights) + 1), heights, marker="o" if good else "X", ms=4, **style)
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
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: rounded(value)))
    axes.yaxis.set_minor_formatter(FuncFormatter(lambda value, _: ""))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    axes.set_xlim(left=0.8, right=max(2, *(len(s.history) for s in iterated)) + 0.2)
    axes.set_xlabel("iteration")
    axes.set_ylabel(frame.label("largest change ε"))
    axes.set_title(f"{title(result.name)}: convergence")
    axes.legend(title="subdomain: faults", loc="center left", bbox_to_anchor=(1.01, 0.5), title_fontsize=8)
    return figure
