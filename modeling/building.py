"""A horizon rebuilt near the faults: paper Algorithm 2 from the cut graph on."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.complexes import Complex
from graben.model import Model
from graben.modeling.advice import Deciding, termination
from graben.modeling.algebra import Backend, Cholmod
from graben.modeling.cutoffs import cutoffs
from graben.modeling.deformation import Deformation
from graben.modeling.energy import EdgePattern
from graben.modeling.guides import Guides
from graben.modeling.iteration import Outcome, Problem, iterated
from graben.modeling.movement import Lips, Role, guides_of, lips
from graben.modeling.noise import node_areas
from graben.modeling.outline import Run, runs
from graben.modeling.patching import CutArrays, Patch
from graben.modeling.picks import NodeData
from graben.modeling.preparation import CutHorizon
from graben.modeling.respacing import Arms
from graben.modeling.results import HorizonResult, Subdomain, Termination, TerminationType
from graben.surface import Surface, edge_table

#: The default length of the energy, in gammas of the widest zone of the subdomain.
_LENGTH = 10.0
_LOOSE = (
    "Nothing holds this part of the horizon, which is left as it is: lower gamma for the faults around it, "
    "or extend the horizon."
)
_THIN = (
    "Parts of the cut run so close to each other or to the outline that the mesh cannot be solved on; this "
    "part is left as it is: separate the faults there, or use a smaller step."
)
#: Corners of the outline nearer to an exit than this share of gamma slide with it.
_REACH = 0.5


def rebuilt(
    model: Model, prepared: CutHorizon, network: Complex, backend: Backend | None = None
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
    """
    stage = _Stage.of(model, prepared, network, backend or Cholmod())
    points = prepared.first.copy()
    patches: list[Patch] = []
    subdomains = [stage.solved(anchor.subdomain, points, patches) for anchor in prepared.anchors]
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
        graph=graph,
        cutoffs=cutoffs(graph, cut, points, surfaces),
        subdomains=tuple(subdomains),
        warnings=prepared.warnings,
        seconds={k: sum(s.seconds.get(k, 0.0) for s in subdomains) for k in ("solve", "move", "deform")},
    )


@dataclass(frozen=True, eq=False)
class _Stage:
    """What all subdomains of a horizon share."""

    model: Model
    prepared: CutHorizon
    backend: Backend
    lips: Lips
    guides: Guides
    runs: list[Run]
    border: BoolArray
    sides: IntArray
    edge_count: int
    gamma: float

    @staticmethod
    def of(model: Model, prepared: CutHorizon, network: Complex, backend: Backend) -> _Stage:
        """Return the lips of the horizon, their guides, and how its outline slides with its exits."""
        cut, graph = prepared.cut, prepared.graph
        lip = lips(graph, cut)
        surfaces = [f.surface for f in model.faults]
        gamma = max((model.gamma(model.faults[f], prepared.horizon) for f in prepared.faults), default=0.0)
        guides = guides_of(graph, cut, lip, surfaces, prepared.horizon.surface, network, gamma)
        outline = prepared.border()
        border = np.zeros(len(cut.origin), dtype=bool)
        border[outline] = True
        exits = lip.copies[lip.roles == Role.EXIT]
        runs_ = runs(prepared.first[:, :2], cut.origin, outline, prepared.unknown, exits, _REACH * gamma)
        edges, sides = edge_table(cut.triangles)
        return _Stage(model, prepared, backend, lip, guides, runs_, border, sides, len(edges), gamma)

    def solved(self, label: int, points: FloatArray, patches: list[Patch]) -> Subdomain:
        """Solve one subdomain and write its result into ``points`` (n, 3), positions of all copies.

        A mesh that was made anew is added to ``patches``.
        """
        prepared = self.prepared
        labels = prepared.cut.node_labels
        names = prepared.anchors[label].faults
        nodes = int((labels == label).sum())
        unknowns = int((prepared.unknown & (labels == label)).sum())
        mine = np.flatnonzero(labels[self.lips.copies] == label)
        if not prepared.anchors[label].holds and len(mine):
            loose = Termination(TerminationType.STAGNATION, "not anchored", _LOOSE)
            return Subdomain(label, names, nodes, unknowns, 0, loose)
        if len(mine) == 0:
            return Subdomain(label, names, nodes, 0, 0, Termination(TerminationType.CONVERGED, "no cut"))
        start = time.perf_counter()
        near, local, problem = self._problem(label, mine)
        parameters = self.model.parameters
        outcome = iterated(problem, self.backend, parameters.max_iterations, parameters.acceleration)
        if not _credible(problem, outcome, self.gamma):
            thin = Termination(TerminationType.STAGNATION, "unstable", _THIN)
            steps = len(outcome.history)
            return Subdomain(label, names, nodes, unknowns, steps, thin, history=outcome.history)
        placed = np.column_stack([outcome.points, outcome.values])
        if outcome.remeshed is None:
            points[local] = placed
        else:
            kept = outcome.remeshed.kept
            points[local[kept]] = placed[: len(kept)]
            patches.append(Patch(label, near, local, outcome.remeshed, placed))
        seconds = dict(outcome.seconds)
        seconds["solve"] = seconds.get("solve", 0.0)
        seconds["setup"] = time.perf_counter() - start - sum(outcome.seconds.values())
        return Subdomain(
            id=label,
            faults=names,
            nodes=nodes,
            unknowns=unknowns,
            iterations=len(outcome.history),
            termination=self._termination(outcome, mine, points),
            mean_displacement=outcome.displacement,
            mean_deviation=outcome.deviation,
            history=outcome.history,
            remeshings=outcome.remeshings,
            seconds=seconds,
        )

    def _problem(self, label: int, mine: IntArray) -> tuple[IntArray, IntArray, Problem]:
        """Return the triangles of the subdomain near the unknowns, their nodes, and the problem there."""
        prepared, cut = self.prepared, self.prepared.cut
        parameters = self.model.parameters
        near = self._near(label)
        local, flat = np.unique(cut.triangles[near], return_inverse=True)
        index = np.full(len(cut.origin), -1)
        index[local] = np.arange(len(local))
        pattern = EdgePattern.of(flat.reshape(-1, 3), len(local))
        points = prepared.first[local]
        unknown = prepared.unknown[local]
        nodes = index[self.lips.copies[mine]]
        runs_ = [
            Run(index[r.nodes], r.arcs, r.line, r.line_arcs) for r in self.runs if (index[r.nodes] >= 0).all()
        ]
        deformation = Deformation.of(
            points[:, :2], pattern, unknown, self.border[local], nodes, runs_, self.backend
        )
        fitted = prepared.fitted[local]
        gammas = [
            self.model.gamma(self.model.faults[f], prepared.horizon)
            for f in np.unique(self.lips.faults[mine])
        ]
        length = parameters.length or _LENGTH * max(gammas)
        data, stiffness = self._data(label, index, points, fitted)
        stiffness *= parameters.theta * length**2 * node_areas(points, pattern.triangles)[data.nodes]
        problem = Problem(
            points=points[:, :2],
            pattern=pattern,
            values=points[:, 2],
            unknown=unknown,
            fitted=fitted,
            cut=nodes,
            guides=Guides(self.guides.lines[mine]),
            deformation=deformation,
            arms=Arms.of(self.lips, mine, [f.surface for f in self.model.faults], self.gamma),
            data=data,
            stiffness=stiffness,
            theta=parameters.theta,
            length=length,
            tolerance=self.model.tolerance,
        )
        return np.flatnonzero(near), local, problem

    def _near(self, label: int) -> BoolArray:
        """Return the triangles of a subdomain whose nodes take part in its problem, (m,).

        Without a fit they reach to the nodes whose fixed values the energy sees across an edge; with one, to
        the last of the fitted nodes, where the surface is free.
        """
        prepared, cut = self.prepared, self.prepared.cut
        inside, mine = prepared.unknown | prepared.fitted, cut.labels == label
        if prepared.smoothing > 0:
            return np.asarray(inside[cut.triangles].all(axis=1) & mine)
        on_edge = np.zeros(self.edge_count, dtype=bool)
        on_edge[self.sides[inside[cut.triangles].any(axis=1) & mine]] = True
        return np.asarray(on_edge[self.sides].any(axis=1) & mine)

    def _data(
        self, label: int, index: IntArray, points: FloatArray, fitted: BoolArray
    ) -> tuple[NodeData, FloatArray]:
        """Return what picks and fitted nodes say of the nodes of a subdomain, and c^-4 of each, (k,)."""
        prepared, cut = self.prepared, self.prepared.cut
        told = prepared.data
        known = (index[told.nodes] >= 0) & prepared.unknown[told.nodes]
        known &= cut.node_labels[told.nodes] == label
        at = np.flatnonzero(fitted)
        data = NodeData(
            np.concatenate([index[told.nodes[known]], at]),
            np.concatenate([told.z[known], points[at, 2]]),
            np.concatenate([told.gradient[known], np.zeros((len(at), 2))]),
        )
        lengths = np.full(len(data.nodes), prepared.smoothing)
        lengths[: int(known.sum())] = prepared.horizon.smoothing or prepared.horizon.step
        return data, lengths**-4.0

    def _termination(self, outcome: Outcome, mine: IntArray, points: FloatArray) -> Termination:
        if outcome.worst < 0:
            return termination(outcome, self.model, None)
        k = int(mine[outcome.worst])
        copy = self.lips.copies[k]
        faults = tuple(dict.fromkeys(self.lips.faults[k].tolist()))
        up = outcome.excess > 0
        guide = Guides(outcome.guides.lines[outcome.worst : outcome.worst + 1])
        deciding = Deciding(
            Role(int(self.lips.roles[k])),
            tuple(self.model.faults[f] for f in faults),
            tuple(self._side(copy, f) for f in faults),
            points[copy],
            guide.lines[0, -1 if up else 0],
            guide.tangents(upper=up)[0],
            tuple(self.model.gamma(self.model.faults[f], self.prepared.horizon) for f in faults),
        )
        return termination(outcome, self.model, deciding)

    def _side(self, copy: int, fault: int) -> int:
        """Return the lip of a fault that a copy lies on: 1 hanging, -1 foot, 0 both."""
        cut, mine = self.prepared.cut, self.prepared.graph.faults == fault
        return int((cut.right[mine] == copy).any()) - int((cut.left[mine] == copy).any())


def _credible(problem: Problem, outcome: Outcome, gamma: float) -> bool:
    """Return whether the result is finite and no further from the input than its relief and gamma allow."""
    before = problem.values if outcome.remeshed is None else outcome.remeshed.weights @ problem.values
    change = np.abs(outcome.values - before)
    most = 2.0 * (float(np.ptp(problem.values)) + gamma)
    return bool(np.isfinite(outcome.points).all() and (change <= most).all())
