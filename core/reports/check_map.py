"""The plan map of an examined model: horizons, faults, traces, and every finding with its number."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from graben.arrays import FloatArray
from graben.finding import Finding, Status
from graben.reports.check_plan import draw_outline, draw_traces, footprint, name_label, plan
from graben.reports.check_words import seen
from graben.reports.labels import Label, stem, write_labels
from graben.reports.map_parts import SIGNS, bounds, north_arrow, scale_bar
from graben.reports.marks import COLOURS, Marks, fitted, window_of
from graben.reports.scenery import HORIZON_INK, Scenery
from graben.reports.shapes import Shape
from graben.reports.style import FAULT, PAPER, styled

# Inches on paper.
_WIDTH, _LEFT, _RIGHT, _BOTTOM, _TOP = 7.6, 0.65, 0.1, 0.85, 0.15
_LOWEST, _HIGHEST = 1.5, 8.2
_DASHES = (0, (5, 2))
_MARGIN = 0.05  # of the larger side
_FAULT_INK = ("#4A4A4A", "#DDE3EA")
#: Of more faults than these none is named.
_MOST_NAMES = 40
#: Of more findings than these only the worst places are drawn, each a dot of so many points.
_MOST_DRAWN, _DOT = 40, 3.5
#: Findings whose places lie within this share of the larger side have one label, of so many numbers.
_TOGETHER = 0.022
_MOST_NUMBERS = 3


@dataclass(frozen=True, eq=False)
class Overview:
    """The map, how many numbers and names found no room on it, and the beginning of all names, left out."""

    figure: Figure
    numbers: int
    names: int
    stem: str

    def words(self) -> str:
        """Return what a caption says of what is left out; empty where nothing is."""
        said = f" All names begin with {self.stem}, which is left out." if self.stem else ""
        counts = ((self.numbers, "label of findings", "labels of findings"), (self.names, "name", "names"))
        left = [f"{count} {one if count == 1 else many}" for count, one, many in counts if count]
        if left:
            said += f" Left out for want of room: {', '.join(left)}."
        if self.names:
            said += " In the 3D view a fault is named where the pointer rests on it."
        return said


@styled
def overview(scenery: Scenery, numbered: Mapping[int, Finding], named: Collection[int]) -> Overview | None:
    """Return the plan map of a model with its findings.

    Parameters
    ----------
    scenery : Scenery
        The model.
    numbered : mapping of int to Finding
        The findings that warn or fail, by their numbers.
    named : collection of int
        The numbers that are written.

    Returns
    -------
    Overview or None
        None where no surface can be drawn.
    """
    if not scenery.shapes:
        return None
    west, east, south, north = bounds(plan(scenery.places))
    extent = max(east - west, north - south) or 1.0
    window = window_of(plan(scenery.places), _MARGIN * extent)
    width = _WIDTH - _LEFT - _RIGHT
    ratio = (window[3] - window[2]) / (window[1] - window[0])
    height = float(np.clip(width * ratio, _LOWEST, _HIGHEST))
    window = fitted(window, height / width)
    total = height + _BOTTOM + _TOP
    figure = Figure(figsize=(_WIDTH, total))
    axes = figure.add_axes((_LEFT / _WIDTH, _BOTTOM / total, width / _WIDTH, height / total))
    axes.set(xlim=window[:2], ylim=window[2:])
    axes.grid(False)
    for shape in scenery.horizons.values():
        draw_outline(axes, shape, _DASHES)
    for shape in scenery.faults.values():
        footprint(axes, shape, shape.surface.triangles, _FAULT_INK)
    for horizon in scenery.graphs:
        draw_traces(axes, scenery, horizon, 0.9)
    marks = {number: scenery.marks(f) for number, f in numbered.items()}
    inch = (window[1] - window[0]) / width
    for status in (Status.WARN, Status.FAIL):
        own = [m for m in marks.values() if m.status is status]
        if len(marks) <= _MOST_DRAWN:
            for mark in own:
                mark.draw(axes, plan, inch)
        else:
            places = np.array([plan(m.worst) for m in own if m.worst is not None]).reshape(-1, 2)
            axes.plot(*places.T, "o", ms=_DOT, mfc=COLOURS[status], mec=PAPER, mew=0.4, zorder=SIGNS - 0.5)
    labels = _numbers({n: m for n, m in marks.items() if n in named}, extent)
    shapes = sorted(scenery.faults.values(), key=_length, reverse=True)
    start = stem([seen(s.surface.name) for s in shapes])
    names = [label for s in shapes for label in name_label(s, FAULT, window, start)]
    written = names if len(shapes) <= _MOST_NAMES else []
    missing = write_labels(axes, [*labels, *written], (width, height))
    unnamed = len(names) - len(written) + sum(not label.boxed for label in missing)
    scenery.frame.plan_axes(axes, extent)
    scale_bar(axes, bounds(plan(_corners(window))), extent, scenery.frame)
    north_arrow(axes)
    _legend(figure, scenery, numbered)
    return Overview(figure, sum(label.boxed for label in missing), unnamed, start if written else "")


def _length(shape: Shape) -> float:
    """Return the length in plan of the upper rim of a fault, which its name stands for on the map."""
    return float(sum(np.hypot(*np.diff(line[:, :2], axis=0).T).sum() for line in shape.upper_rim))


def _corners(window: tuple[float, float, float, float]) -> FloatArray:
    west, east, south, north = window
    return np.array([[west, south, 0.0], [east, north, 0.0]])


def _numbers(marks: Mapping[int, Marks], extent: float) -> list[Label]:
    """Return the labels of findings, those of one place together, failures first."""
    placed = [(n, m) for n, m in marks.items() if m.worst is not None]
    placed.sort(key=lambda item: (item[1].status is not Status.FAIL, item[0]))
    groups: list[tuple[FloatArray, list[int], Status]] = []
    for number, mark in placed:
        assert mark.worst is not None
        here = plan(mark.worst)
        for place, numbers, _ in groups:
            if np.abs(here - place).max() <= _TOGETHER * extent:
                numbers.append(number)
                break
        else:
            groups.append((here, [number], mark.status))
    return [
        Label(_listed(numbers), (float(place[0]), float(place[1])), COLOURS[status], 7.5)
        for place, numbers, status in groups
    ]


def _listed(numbers: Sequence[int]) -> str:
    """Return numbers as one label, as in "3, 8 +2"."""
    first = sorted(numbers)[:_MOST_NUMBERS]
    more = len(numbers) - len(first)
    return ", ".join(map(str, first)) + (f" +{more}" if more else "")


def _legend(figure: Figure, scenery: Scenery, numbered: Mapping[int, Finding]) -> None:
    handles: list[Line2D | Patch] = []
    if scenery.faults:
        handles.append(Patch(fc=_FAULT_INK[1], ec=_FAULT_INK[0], lw=0.5, label="fault in plan"))
        handles.append(Line2D([], [], color=_FAULT_INK[0], lw=1.4, label="its upper rim"))
    if scenery.horizons:
        handles.append(Line2D([], [], color=HORIZON_INK, lw=0.8, ls=_DASHES, label="outline of a horizon"))
    if scenery.graphs:
        handles.append(Line2D([], [], color=FAULT, lw=0.9, label="trace of a fault"))
    for status, words in ((Status.FAIL, "fails"), (Status.WARN, "warns")):
        if any(f.status is status for f in numbered.values()):
            handles.append(
                Line2D(
                    [],
                    [],
                    color=COLOURS[status],
                    lw=2.2,
                    marker="o",
                    ms=5,
                    mec="w",
                    label=f"{words}, number of the finding",
                )
            )
    figure.legend(handles=handles, loc="lower left", ncols=3, handlelength=2.2, columnspacing=1.4)
