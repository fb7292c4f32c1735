"""The course of an iteration as a curve the size of a word, for a row of a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graben.reports.style import Frame, rounded

#: Size of the drawing, its margin, and how far it reaches beyond the tolerance, in its own units and factors.
_WIDTH, _HEIGHT, _MARGIN, _BEYOND = 120.0, 30.0, 3.0, 3.0
#: A change of zero has no logarithm: it stands at this share of the tolerance.
_FLOOR = 1e-4
#: So many changes are told in words.
_MOST_TOLD = 12


@dataclass(frozen=True)
class Curve:
    """A curve in a box of ``width`` and ``height``: points of its line, level of the tolerance, and words."""

    points: str
    last: tuple[str, str]
    level: str
    words: str
    width: float = _WIDTH
    height: float = _HEIGHT


def curve(history: Sequence[float], tolerance: float, frame: Frame) -> Curve | None:
    """Return the largest change of each iteration against a logarithmic scale; None where there was none.

    Parameters
    ----------
    history : sequence of float
        eps_k of formula (7) of the paper, model units.
    tolerance : float
        eps_tol, model units; above zero.
    frame : Frame
        Unit.
    """
    if not history:
        return None
    heights = np.maximum(np.nan_to_num(np.asarray(history, dtype=np.float64), nan=0.0), _FLOOR * tolerance)
    low = min(float(heights.min()), tolerance / _BEYOND)
    high = max(float(heights.max()), tolerance * _BEYOND)

    def up(value: float) -> float:
        share = np.log(value / low) / np.log(high / low)
        return float(_HEIGHT - _MARGIN - share * (_HEIGHT - 2 * _MARGIN))

    x = np.linspace(_MARGIN, _WIDTH - _MARGIN, len(heights)) if len(heights) > 1 else [_WIDTH / 2]
    places = [(f"{at:.1f}", f"{up(value):.1f}") for at, value in zip(x, heights, strict=True)]
    told = [rounded(float(value)) for value in history]
    shown = told if len(told) <= _MOST_TOLD else [*told[: _MOST_TOLD - 2], "…", told[-1]]
    words = f"Largest change by iteration: {', '.join(shown)} {frame.unit}".rstrip()
    return Curve(" ".join(",".join(p) for p in places), places[-1], f"{up(tolerance):.1f}", f"{words}.")
