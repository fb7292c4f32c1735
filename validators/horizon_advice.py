"""What a person wants to know of a horizon at a fault before modeling; none of it forbids the modeling."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from graben.arrays import FloatArray, floats
from graben.cutgraph import CutGraph
from graben.finding import Element, Part
from graben.model import Horizon
from graben.surface import Surface
from graben.validators.context import CheckContext, Defect, Severity
from graben.validators.measuring.holes import Hole, distances, traced
from graben.validators.measuring.measures import amount
from graben.validators.measuring.parallel import Stretch, slope_ratios
from graben.validators.measuring.smear import smear_width
from graben.validators.measuring.strays import strays
from graben.words import plural

#: Two stretches of a trace with less than this share of their length between them follow each other.
_SAME = 1e-6
#: Standard widths of the smear up to which a horizon counts as smeared, and which gamma should have at least.
#: gamma of 2 of them left cutoff errors of 4 to 6 % of the throw, of 2.3 some 2 %, of 2.75 less than 1 %.
_SMEARED, _CLEAR = 2.25, 2.75


@dataclass(frozen=True, eq=False)
class Pair:
    """A horizon and one of the faults whose traces it has.

    Parameters
    ----------
    horizon, fault : Horizon, Surface
        As given.
    graph : CutGraph
        Of the horizon.
    number : int
        Index of the fault in the model.
    gammas : mapping
        gamma of each fault of the graph, model units.
    holes : tuple of Hole
        Those within gamma of the trace, the widest first.
    unit : str
        Of lengths, empty without one.
    """

    horizon: Horizon
    fault: Surface
    graph: CutGraph
    number: int
    gammas: Mapping[int, float]
    holes: tuple[Hole, ...]
    unit: str

    @property
    def objects(self) -> tuple[str, str]:
        """Names of the two."""
        return self.horizon.name, self.fault.name

    @property
    def gamma(self) -> float:
        """Half-width of the modeling zone of the fault, model units."""
        return self.gammas[self.number]

    @property
    def trace(self) -> shapely.MultiLineString:
        """The trace of the fault in plan."""
        return traced(self.graph, [self.number])

    def length(self, value: float) -> str:
        """Return a length to three digits with its unit."""
        return amount(value, self.unit)


def pairs_of(context: CheckContext, horizon: Horizon, graph: CutGraph, holes: Sequence[Hole]) -> list[Pair]:
    """Return a horizon with each fault that cuts it, in the order of the model; ``holes`` are its own."""
    faults = context.model.faults
    gammas = {k: context.model.gamma(faults[k], horizon) for k in np.unique(graph.faults).tolist()}
    widest = sorted(holes, key=lambda hole: hole.width, reverse=True)
    pairs = []
    for k, gamma in gammas.items():
        close = distances(widest, traced(graph, [k])) <= gamma
        near = tuple(hole for hole, is_close in zip(widest, close, strict=True) if is_close)
        pairs.append(Pair(horizon, faults[k].surface, graph, k, gammas, near, context.unit))
    return pairs


def nearly_parallel(pair: Pair, limit: float) -> list[Defect]:
    """Return where the horizon dips with the fault at ``limit`` times its slope or more, as one defect."""
    stretches = slope_ratios(pair.horizon, pair.fault, pair.graph, pair.number, pair.gammas)
    close = [s for s in stretches if s.ratio >= limit]
    if not close:
        return []
    horizon, fault = pair.objects
    runs = _runs(close)
    along = sum(run.length for run in runs)
    places = floats([run.place for run in runs], -1, 3)
    defect = Defect(
        pair.objects,
        f"{horizon} dips with {fault} at {runs[0].ratio:.2f} of its slope along {pair.length(along)} of the "
        "trace: where they meet is hardly determined.",
        f"See whether {fault} cuts {horizon} there at all; if not, let it end where the two begin to run "
        "along each other.",
        count=len(runs),
        value=runs[0].ratio,
        place=places[0],
        places=places,
        paths=tuple(floats(run.line) for run in runs),
        parts=tuple(_part("near-parallel stretch", 1, run.place, run.ratio) for run in runs),
        severity=Severity.WARN,
    )
    return [defect]


def _runs(stretches: Sequence[Stretch]) -> list[Stretch]:
    """Return the stretches with those that follow each other joined, the one of the largest ratio first."""
    joined: list[Stretch] = []
    for stretch in stretches:
        gap = np.linalg.norm(joined[-1].line[-1] - stretch.line[0]) if joined else np.inf
        if gap > _SAME * stretch.length:
            joined.append(stretch)
            continue
        last = joined.pop()
        line = np.concatenate([last.line, stretch.line[1:]])
        joined.append(Stretch(max(last.ratio, stretch.ratio), line))
    return sorted(joined, key=lambda s: s.ratio, reverse=True)


def stray_picks(pair: Pair) -> list[Defect]:
    """Return the picks that lie on one side of the fault and belong to the lip on the other, as one."""
    found = strays(pair.horizon, pair.fault, pair.graph, pair.number, pair.gammas)
    if not len(found.picks):
        return []
    horizon, fault = pair.objects
    places = pair.horizon.picks[found.picks]
    worst = int(np.argmax(found.misfit))
    off = float(found.misfit[worst])
    count = len(found.picks)
    lie, whose = ("lies", "its") if count == 1 else ("lie", "their")
    defect = Defect(
        pair.objects,
        f"{plural(count, 'pick')} of {horizon} {lie} on the wrong side of {fault}, up to "
        f"{pair.length(float(found.beyond.max()))} beyond it: {whose} elevation is that of the other lip, "
        f"off {whose} own by up to {pair.length(off)}.",
        "Move the picks to the side whose lip they belong to, or the fault to between the lips.",
        count=count,
        value=off,
        unit=pair.unit,
        place=places[worst],
        elements=found.picks,
        element=Element.PICK,
        places=floats(places, -1, 3),
        parts=(_part("picks on the wrong side", count, places[worst], off, pair.unit),),
        severity=Severity.WARN,
    )
    return [defect]


def wide_smear(pair: Pair) -> list[Defect]:
    """Return that the horizon is smeared further from the trace than gamma reaches."""
    found = smear_width(pair.horizon, pair.graph, pair.number, pair.gammas)
    if found is None or _SMEARED * found.standard <= pair.gamma:
        return []
    horizon, fault = pair.objects
    reach, wanted = _SMEARED * found.standard, _CLEAR * found.standard
    digit = 10.0 ** (np.floor(np.log10(wanted)) - 1)
    enough = float(np.ceil(wanted / digit) * digit)
    defect = Defect(
        pair.objects,
        f"{horizon} is smeared over {pair.length(reach)} on either side of {fault}, beyond gamma "
        f"({pair.length(pair.gamma)}): what is taken for reliable there is not.",
        f"Set gamma of {fault} to at least {pair.length(enough)}.",
        value=reach,
        unit=pair.unit,
        place=found.place,
        places=floats(found.place, 1, 3),
        paths=found.lines,
        parts=(_part("smear", 1, found.place, reach, pair.unit),),
        severity=Severity.WARN,
    )
    return [defect]


def filled_holes(pair: Pair) -> list[Defect]:
    """Return the holes near the trace that are filled before the horizon is traced, as one defect."""
    near = [hole for hole in pair.holes if hole.filled]
    if not near:
        return []
    places = floats([hole.place(pair.trace, pair.horizon.step) for hole in near], -1, 3)
    return [
        _filled(pair.objects, near, places, f"within gamma of the trace of {pair.fault.name} ", pair.unit)
    ]


def filled_elsewhere(horizon: Horizon, holes: Sequence[Hole], unit: str) -> list[Defect]:
    """Return which of the given holes, none of them near a trace, are filled, as one defect."""
    filled = sorted((h for h in holes if h.filled), key=lambda hole: hole.width, reverse=True)
    if not filled:
        return []
    places = floats([hole.place(hole.area, horizon.step) for hole in filled], -1, 3)
    return [_filled((horizon.name,), filled, places, "", unit)]


def _filled(
    objects: tuple[str, ...], holes: Sequence[Hole], places: FloatArray, where: str, unit: str
) -> Defect:
    """Return that holes, the widest first, are filled; ``places`` (h, 3), ``where`` they are in words."""
    nodes = sum(hole.nodes for hole in holes)
    many = "a hole" if len(holes) == 1 else f"{len(holes)} holes"
    return Defect(
        objects,
        f"{plural(nodes, 'undefined node')} of {objects[0]} in {many} {where}{'is' if nodes == 1 else 'are'} "
        "filled by interpolation.",
        "Nothing, where that serves; else give the horizon values there.",
        count=nodes,
        value=holes[0].width,
        unit=unit,
        place=places[0],
        places=places,
        parts=hole_parts("filled hole", holes, places, unit),
        severity=Severity.WARN,
    )


def hole_parts(kind: str, holes: Sequence[Hole], places: FloatArray, unit: str) -> tuple[Part, ...]:
    """Return a part for each hole: its undefined nodes, if it is a grid's, its place (h, 3) and its width."""
    return tuple(
        _part(kind, max(hole.nodes, 1), place, hole.width, unit)
        for hole, place in zip(holes, places, strict=True)
    )


def _part(kind: str, count: int, place: FloatArray, value: float, unit: str = "") -> Part:
    x, y, z = (float(c) for c in place)
    return Part(kind, count, (x, y, z), value, unit)
