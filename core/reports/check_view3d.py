"""The 3D view of an examined model: its surfaces, and the findings on them, check by check."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from textwrap import wrap
from typing import Any

import numpy as np

from graben.arrays import floats
from graben.finding import Finding, Status
from graben.reports.check_words import seen
from graben.reports.marks import COLOURS, Marks, spread
from graben.reports.scene import FAULT_COLOURS, MOST_TRIANGLES, Group, Scene, Space, thinned_surface
from graben.reports.scenery import Scenery
from graben.words import plural

#: Places, marked triangles and worst places that are drawn, all checks together.
_MOST_POINTS, _MOST_MARKED, _MOST_WORST = 10_000, 8_000, 1_000
#: Sizes of the worst places by their count.
_SIZES = ((50, 6), (200, 5), (np.inf, 4))
#: Letters in a line of a hover text.
_LINE = 60
#: The view is full with so many times the triangles it is thinned to.
_OVERFULL = 2.0
_SPOT = "#D500F9"
#: How opaque horizons are to begin with, percent: what is marked on faults lies behind them.
_VEIL = 30
_HORIZONS = ("#8FA37A", "#B7A46A", "#7FA3A3", "#A38F7A")


def check_scene(scenery: Scenery, numbered: Mapping[int, Finding]) -> Scene | None:
    """Return the 3D view of a model with its findings, or None where there is nothing to see.

    Parameters
    ----------
    scenery : Scenery
        The model.
    numbered : mapping of int to Finding
        The findings that warn or fail, by their numbers.
    """
    if not scenery.shapes:
        return None
    space = view_space(scenery)
    data: list[dict[str, Any]] = []
    groups: list[Group] = []
    note = _surfaces(scenery, space, data, groups)
    checks = dict.fromkeys(f.check for f in numbered.values())
    for check in checks:
        own = {n: f for n, f in numbered.items() if f.check == check}
        traces = _Budget(space, 1.0 / len(checks)).traces({n: (f, scenery.marks(f)) for n, f in own.items()})
        if traces:
            groups.append(Group("Findings", check, tuple(range(len(data), len(data) + len(traces)))))
            data += traces
    spot = {"size": 16, "symbol": "circle-open", "color": _SPOT, "line": {"width": 3}}
    data.append(space.points("the place", floats([], 0, 3), marker=spot, visible=False, hoverinfo="skip"))
    veiled = [k for g in groups if g.kind == "Horizons" for k in g.traces]
    return Scene(
        data,
        space.layout(),
        groups,
        space.exaggeration,
        veiled=veiled,
        veil=_VEIL,
        spot=len(data) - 1,
        note=note,
    )


def _surfaces(scenery: Scenery, space: Space, data: list[dict[str, Any]], groups: list[Group]) -> str:
    """Add the surfaces, horizons first, and return what was left out of them, in words."""
    whole = sum(len(s.surface.triangles) for s in scenery.shapes.values())
    share, shown, missing = min(MOST_TRIANGLES / whole, 1.0), 0, 0
    for kind, shapes in (("Horizons", scenery.horizons), ("Faults", scenery.faults)):
        colours, opacity = (_HORIZONS, _VEIL / 100.0) if kind == "Horizons" else (FAULT_COLOURS, 0.6)
        for number, (name, shape) in enumerate(shapes.items()):
            colour = colours[number % len(colours)]
            kept, triangles = thinned_surface(shape.surface, share)
            if shown + len(triangles) > _OVERFULL * MOST_TRIANGLES:
                missing += 1
                continue
            shown += len(triangles)
            style = {"color": colour, "opacity": opacity, "flatshading": True}
            groups.append(Group(kind, seen(name), (len(data),), colour))
            data.append(space.mesh(seen(name), shape.surface.vertices[kept], triangles, **style))
    left = f" {plural(missing, 'surface')} left out." if missing else ""
    thinned = f"Thinned for this view to {shown:,} of {whole:,} triangles; the rims are whole.{left}"
    return thinned if shown < whole else ""


def view_space(scenery: Scenery) -> Space:
    """Return the local coordinates of the view of a model with at least one surface."""
    return Space.around([scenery.places], scenery.frame)


@dataclass(frozen=True, eq=False)
class _Budget:
    """What the findings of one check may take of the view: a share of all that is drawn of findings."""

    space: Space
    share: float

    def of(self, most: int) -> int:
        """Return the share of a count, at least 1."""
        return max(int(self.share * most), 1)

    def traces(self, found: Mapping[int, tuple[Finding, Marks]]) -> list[dict[str, Any]]:
        """Return the traces of the findings of one check: triangles, lines, places and the worst of each."""
        made: list[dict[str, Any]] = []
        for status in (Status.WARN, Status.FAIL):
            made += self._marked(status, [(f, m) for f, m in found.values() if f.status is status])
        worst = [(n, f, m.worst) for n, (f, m) in found.items() if m.worst is not None]
        worst.sort(key=lambda item: item[1].status is not Status.FAIL)
        worst = worst[: self.of(_MOST_WORST)]
        if worst:
            style = {
                "size": next(size for most, size in _SIZES if len(worst) <= most),
                "symbol": "diamond",
                "color": [COLOURS[f.status] for _, f, _ in worst],
                "line": {"color": "#FFFFFF", "width": 1},
            }
            text = [_hover(n, f) for n, f, _ in worst]
            where = f"%{{text}}<br>%{{x}}, %{{y}}, {self.space.frame.z_name} %{{z}}<extra></extra>"
            points = np.stack([place for _, _, place in worst])
            made.append(
                self.space.points(worst[0][1].check, points, marker=style, text=text, hovertemplate=where)
            )
        return made

    def _marked(self, status: Status, found: Sequence[tuple[Finding, Marks]]) -> list[dict[str, Any]]:
        made, colour = [], COLOURS[status]
        check = found[0][0].check if found else ""
        triangles = [m.triangles for _, m in found if len(m.triangles)]
        if triangles:
            corners = spread(np.concatenate(triangles), self.of(_MOST_MARKED)).reshape(-1, 3)
            index = np.arange(len(corners)).reshape(-1, 3)
            made.append(self.space.mesh(check, corners, index, color=colour, opacity=0.9, hoverinfo="skip"))
        lines = [p for _, m in found for p in m.paths if len(p) > 1]
        lengths = np.cumsum([len(p) for p in lines])
        lines = lines[: int(np.searchsorted(lengths, self.of(_MOST_POINTS), side="right"))]
        if lines:
            style = {"color": colour, "width": 7}
            made.append(self.space.lines(check, lines, line=style, hoverinfo="skip"))
        dots = [m.points for _, m in found if len(m.points) > 1 and not len(m.triangles)]
        if dots:
            many = spread(np.concatenate(dots), self.of(_MOST_POINTS))
            made.append(
                self.space.points(check, many, marker={"size": 2.5, "color": colour}, hoverinfo="skip")
            )
        return made


def _hover(number: int, finding: Finding) -> str:
    """Return what stands at the worst place of a finding: text for plotly.js, which reads a little HTML."""
    words = seen(f"{number} {finding.check}: {finding.message or ', '.join(finding.objects)}")
    return "<br>".join(escape(line) for line in wrap(words, _LINE, max_lines=6, placeholder=" …"))
