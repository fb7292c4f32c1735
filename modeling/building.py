"""A horizon rebuilt near the faults: paper Algorithm 2 from the cut graph on."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from graben.arrays import FloatArray, IntArray
from graben.complexes import Complex
from graben.errors import ModelingError
from graben.model import Model
from graben.modeling.advice import Deciding, termination
from graben.modeling.algebra import Backend, Cholmod
from graben.modeling.cutoffs import cutoffs
from graben.modeling.guides import Guides
from graben.modeling.iteration import Outcome, Problem, iterated
from graben.modeling.movement import Role
from graben.modeling.patching import CutArrays, Patch
from graben.modeling.preparation import CutHorizon
from graben.modeling.problems import Stage
from graben.modeling.results import HorizonResult, Subdomain, Termination, TerminationType
from graben.modeling.side_by_side import usable_cores, worked
from graben.surface import Surface

_LOOSE = (
    "Nothing holds this part of the horizon, which is left as it is: lower gamma for the faults around it, "
    "or extend the horizon."
)
_THIN = (
    "Parts of the cut run so close to each other or to the outline that the mesh cannot be solved on; this "
    "part is left as it is: separate the faults there, or use a smaller step."
)
#: Unknowns whose solution takes longer than a process to start.
_WORTH_A_PROCESS = 20_000
_STAGES = ("solve", "move", "deform")


def rebuilt(
    model: Model,
    prepared: CutHorizon,
    network: Complex,
    backend: Backend | None = None,
    workers: int | None = None,
) -> HorizonResult:
    """Return the horizon rebuilt within gamma of the faults that cut it.

    Parameters
    ----------
    model : Model
        The model in its local frame.
    prepared : CutHorizon
        The horizon, cut open.
    network : Complex
        The common refinement of the model's faults.
    backend : Backend, optional
        Linear algebra; default CHOLMOD.
    workers : int, optional
        Most processes that solve independent parts side by side; default one for each processor. The result
        does not depend on it.
    """
    stage = Stage.of(model, prepared, network, backend or Cholmod())
    holding = [a.subdomain for a in prepared.anchors if a.holds]
    tasks = [int(part) for label in holding for part in stage.parts(label)]
    sizes = np.bincount(stage.part[stage.part >= 0], minlength=max(tasks, default=-1) + 1)
    ended = worked(
        lambda task: _ended(stage, tasks[task]),
        [float(sizes[part]) for part in tasks],
        usable_cores() if workers is None else workers,
        _WORTH_A_PROCESS,
    )
    points = prepared.first.copy()
    patches = [patch for end in ended if (patch := end.placed(stage, points)) is not None]
    by_part = dict(zip(tasks, ended, strict=True))
    subdomains = [_subdomain(stage, a.subdomain, by_part, points) for a in prepared.anchors]
    cut, graph = prepared.cut, prepared.graph
    side = np.zeros(len(cut.origin), dtype=np.int64)
    side[stage.lips.copies] = stage.lips.sides
    whole = CutArrays(
        cut.triangles, points, prepared.first, cut.node_labels, prepared.unknown, side, prepared.block
    )
    whole = whole.patched(patches) if patches else whole
    used = whole.labels >= 0
    renumbered = np.cumsum(used) - 1
    horizon = prepared.horizon
    surfaces = [f.surface for f in model.faults]
    return HorizonResult(
        horizon=horizon,
        surface=Surface(horizon.name, whole.points[used], renumbered[whole.triangles]),
        first=whole.first[used],
        subdomain=whole.labels[used],
        fixed=~whole.unknown[used],
        side=whole.side[used],
        block=whole.block[used],
        graph_faults=tuple(model.faults[f].name for f in prepared.faults),
        smears=prepared.smears,
        graph=graph,
        cutoffs=cutoffs(graph, cut, points, surfaces),
        subdomains=tuple(subdomains),
        warnings=prepared.warnings,
        seconds={k: sum(s.seconds.get(k, 0.0) for s in subdomains) for k in _STAGES},
    )


@dataclass(frozen=True, eq=False)
class _Ended:
    """How the iteration on one part ended.

    ``rows`` are its triangles and ``local`` their copies; ``outcome`` is None where the problem could not be
    solved at all, and ``sound`` says whether its result can be believed.
    """

    part: int
    rows: IntArray
    local: IntArray
    outcome: Outcome | None
    sound: bool
    setup: float

    def placed(self, stage: Stage, points: FloatArray) -> Patch | None:
        """Write the result into ``points`` (n, 3), positions of all copies; return the mesh if it is new."""
        if self.outcome is None or not self.sound:
            return None
        made = np.column_stack([self.outcome.points, self.outcome.values])
        mesh = self.outcome.remeshed
        if mesh is None:
            own = stage.part[self.local] == self.part
            points[self.local[own]] = made[own]
            return None
        kept = np.flatnonzero(stage.part[self.local[mesh.kept]] == self.part)
        points[self.local[mesh.kept[kept]]] = made[kept]
        label = int(stage.prepared.cut.node_labels[self.local[0]])
        return Patch(label, self.rows, self.local, mesh, made)


def _ended(stage: Stage, part: int) -> _Ended:
    """Solve one part."""
    start = time.perf_counter()
    parameters = stage.model.parameters
    rows = local = np.zeros(0, dtype=np.int64)
    try:
        rows, local, problem = stage.problem(part)
        outcome = iterated(problem, stage.backend, parameters.max_iterations, parameters.acceleration)
    except ModelingError:
        return _Ended(part, rows, local, None, False, time.perf_counter() - start)
    setup = time.perf_counter() - start - sum(outcome.seconds.values())
    return _Ended(part, rows, local, outcome, _credible(problem, outcome, stage.gamma), setup)


def _subdomain(stage: Stage, label: int, ended: dict[int, _Ended], points: FloatArray) -> Subdomain:
    """Return how the parts of a subdomain ended together; ``points`` (n, 3) are the copies in the end."""
    prepared = stage.prepared
    labels, anchor = prepared.cut.node_labels, prepared.anchors[label]
    nodes = int((labels == label).sum())
    unknowns = int((prepared.unknown & (labels == label)).sum())
    parts = [ended[int(part)] for part in stage.parts(label) if int(part) in ended]
    if not anchor.holds and (labels[stage.lips.copies] == label).any():
        loose = Termination(TerminationType.STAGNATION, "not anchored", _LOOSE)
        return Subdomain(label, anchor.faults, nodes, unknowns, 0, loose)
    if not parts:
        return Subdomain(label, anchor.faults, nodes, 0, 0, Termination(TerminationType.CONVERGED, "no cut"))
    outcomes = [end.outcome for end in parts if end.outcome is not None]
    sizes = [len(o.z) for o in outcomes]
    history = tuple(max(at) for at in zip_longest(*(o.history for o in outcomes), fillvalue=0.0))
    seconds = {k: sum(o.seconds.get(k, 0.0) for o in outcomes) for k in _STAGES}
    return Subdomain(
        id=label,
        faults=anchor.faults,
        nodes=nodes,
        unknowns=unknowns,
        iterations=len(history),
        termination=_worst([_part_termination(stage, end, points) for end in parts]),
        mean_displacement=_mean([o.displacement for o in outcomes], sizes),
        mean_deviation=_mean([o.deviation for o in outcomes], sizes),
        history=history,
        remeshings=sum(o.remeshings for o in outcomes),
        seconds=seconds | {"setup": sum(end.setup for end in parts)},
    )


def _mean(values: Sequence[float], sizes: Sequence[int]) -> float:
    return float(np.average(values, weights=sizes)) if values else 0.0


def _worst(terminations: Sequence[Termination]) -> Termination:
    """Return the termination of a subdomain: of parts that did not converge, the one that falls shortest."""
    failed = [t for t in terminations if t.type is not TerminationType.CONVERGED]
    return max(failed, key=lambda t: t.short_by or 0.0) if failed else terminations[0]


def _part_termination(stage: Stage, end: _Ended, points: FloatArray) -> Termination:
    if end.outcome is None or not end.sound:
        return Termination(TerminationType.STAGNATION, "unstable", _THIN)
    return _termination(stage, end.outcome, stage.cut_of(end.part), points)


def _termination(stage: Stage, outcome: Outcome, mine: IntArray, points: FloatArray) -> Termination:
    if outcome.worst < 0:
        return termination(outcome, stage.model, None)
    k = int(mine[outcome.worst])
    copy = stage.lips.copies[k]
    faults = tuple(dict.fromkeys(stage.lips.faults[k].tolist()))
    up = outcome.excess > 0
    guide = Guides(outcome.guides.lines[outcome.worst : outcome.worst + 1])
    deciding = Deciding(
        Role(int(stage.lips.roles[k])),
        tuple(stage.model.faults[f] for f in faults),
        tuple(_side(stage.prepared, copy, f) for f in faults),
        points[copy],
        guide.lines[0, -1 if up else 0],
        guide.tangents(upper=up)[0],
        tuple(stage.model.gamma(stage.model.faults[f], stage.prepared.horizon) for f in faults),
    )
    return termination(outcome, stage.model, deciding)


def _side(prepared: CutHorizon, copy: int, fault: int) -> int:
    """Return the lip of a fault that a copy lies on: 1 hanging, -1 foot, 0 both."""
    cut, mine = prepared.cut, prepared.graph.faults == fault
    return int((cut.right[mine] == copy).any()) - int((cut.left[mine] == copy).any())


def _credible(problem: Problem, outcome: Outcome, gamma: float) -> bool:
    """Return whether the result is finite and no further from the input than its relief and gamma allow."""
    before = problem.values if outcome.remeshed is None else outcome.remeshed.weights @ problem.values
    change = np.abs(outcome.values - before)
    most = 2.0 * (float(np.ptp(problem.values)) + gamma)
    return bool(np.isfinite(outcome.points).all() and (change <= most).all())
