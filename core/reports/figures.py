"""Throw profiles as figures."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from graben.arrays import FloatArray, floats
from graben.modeling.results import HorizonResult
from graben.reports.along_strike import end_words, title
from graben.reports.style import (
    FAULT,
    FOOT,
    HANGING,
    Frame,
    plain_numbers,
    styled,
)

#: Profiles beyond these are left out, and the figure says how many.
_MOST_PANELS = 12
_COLUMNS = 3
#: Points of the words at the ends of a panel, and of the room for them below its title.
_END_SIZE, _TITLE_PAD = 7.0, 13.0


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
        axes.set_title(_piece(result, k), fontsize=9, pad=_TITLE_PAD)
        way = (cutoff.hanging + cutoff.foot)[-1, :2] - (cutoff.hanging + cutoff.foot)[0, :2]
        if way.any():
            end_words(axes, floats(way / np.linalg.norm(way)), _END_SIZE)
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
