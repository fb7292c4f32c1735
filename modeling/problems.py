"""The problems of a horizon: one for each part of it that is independent of the others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.beside import beside
from graben.complexes import Complex
from graben.model import Model
from graben.modeling.algebra import Backend
from graben.modeling.bend import carried
from graben.modeling.deformation import Deformation
from graben.modeling.energy import EdgePattern
from graben.modeling.guides import Guides
from graben.modeling.iteration import Problem
from graben.modeling.movement import Lips, Role, guides_of, lips
from graben.modeling.noise import node_areas
from graben.modeling.outline import Run, runs
from graben.modeling.picks import NodeData
from graben.modeling.preparation import CutHorizon
from graben.modeling.respacing import Arms
from graben.refinement import component_labels
from graben.surface import edge_table

#: The default length of the energy, in gammas of the widest zone of the subdomain.
_LENGTH = 10.0
#: Copies from which on a part is solved by itself: an iteration on 800 unknowns took 2 ms, of which the
#: arithmetic was a tenth.
_LEAST_PART = 10_000
#: Copies from which on a second core is worth its start.
_WORTH = 200_000
#: Corners of the outline nearer to an exit than this share of gamma slide with it.
_REACH = 0.5


@dataclass(frozen=True, eq=False)
class Stage:
    """What all parts of a horizon share.

    A subdomain consists of independent parts: no unknown of one has to do with an unknown of another, as
    where two faults end far from each other. Each is solved by itself, but that small ones are put together.

    Parameters
    ----------
    model, prepared, backend
        The model in its local frame, the horizon, cut open, and the linear algebra.
    lips, guides : Lips, Guides
        The copies on the cut, c, and the line of each.
    runs : list of Run
        Stretches of the outer boundary that slide with the exits.
    border : (n,) bool array
        Copies on the outer boundary.
    near : dict of arrays
        Triangles whose nodes take part in the problem of each part, ascending.
    gamma : float
        The largest gamma of a fault, model units.
    part : (n,) array
        Number of the part of each copy whose elevation is sought, -1 for all others.
    """

    model: Model
    prepared: CutHorizon
    backend: Backend
    lips: Lips
    guides: Guides
    runs: list[Run]
    border: BoolArray
    near: dict[int, IntArray]
    gamma: float
    part: IntArray

    @staticmethod
    def of(model: Model, prepared: CutHorizon, network: Complex, backend: Backend) -> Stage:
        """Return the lips of the horizon, their guides, and how its outline slides with its exits."""
        cut, graph = prepared.cut, prepared.graph
        lip = lips(graph, cut)
        surfaces = [f.surface for f in model.faults]

        def around() -> tuple[IntArray, IntArray, dict[int, IntArray]]:
            part = _independent(prepared, lip.copies)
            return prepared.border(), part, _near(cut.triangles, part, whole=prepared.smoothing > 0)

        later = beside(around) if len(cut.origin) > _WORTH else around
        gamma = max((model.gamma(model.faults[f], prepared.horizon) for f in prepared.faults), default=0.0)
        guides = guides_of(graph, cut, lip, surfaces, prepared.horizon.surface, network, gamma)
        outline, part, near = later()
        border = np.zeros(len(cut.origin), dtype=bool)
        border[outline] = True
        exits = lip.copies[lip.roles == Role.EXIT]
        runs_ = runs(prepared.first[:, :2], cut.origin, outline, prepared.unknown, exits, _REACH * gamma)
        return Stage(model, prepared, backend, lip, guides, runs_, border, near, gamma, part)

    def parts(self, label: int) -> IntArray:
        """Return the numbers of the parts of a subdomain, those without a cut left out."""
        copies = self.lips.copies
        return np.unique(self.part[copies[self.prepared.cut.node_labels[copies] == label]])

    def cut_of(self, part: int) -> IntArray:
        """Return the positions in ``lips.copies`` of the nodes of the cut in a part."""
        return np.flatnonzero(self.part[self.lips.copies] == part)

    def problem(self, part: int) -> tuple[IntArray, IntArray, Problem]:
        """Return the triangles near the unknowns of a part, their nodes, and the problem there.

        Raises
        ------
        ModelingError
            When the mesh there has triangles without area, or nothing holds it.
        """
        prepared, cut = self.prepared, self.prepared.cut
        parameters = self.model.parameters
        mine, near = self.cut_of(part), self.near[part]
        local, flat = np.unique(cut.triangles[near], return_inverse=True)
        index = np.full(len(cut.origin), -1)
        index[local] = np.arange(len(local))
        pattern = EdgePattern.of(flat.reshape(-1, 3), len(local))
        points = prepared.first[local]
        unknown = prepared.unknown[local] & (self.part[local] == part)
        nodes = index[self.lips.copies[mine]]
        runs_ = [
            Run(index[r.nodes], r.arcs, r.line, r.line_arcs)
            for r in self.runs
            if (index[r.nodes] >= 0).all() and (self.part[r.nodes[1:-1]] == part).all()
        ]
        deformation = Deformation.of(
            points[:, :2], pattern, unknown, self.border[local], nodes, runs_, self.backend
        )
        fitted = prepared.fitted[local] & (self.part[local] == part)
        length = parameters.length or _LENGTH * self._widest(cut.node_labels[self.lips.copies[mine[0]]])
        data, stiffness = self._data(part, index, points, fitted)
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
            bend=carried(points[:, :2], pattern, unknown, prepared.bend[local], self.backend),
            theta=parameters.theta,
            length=length,
            tolerance=self.model.tolerance,
        )
        return near, local, problem

    def _widest(self, label: int) -> float:
        """Return the largest gamma of the faults of a subdomain."""
        there = self.prepared.cut.node_labels[self.lips.copies] == label
        faults = [self.model.faults[f] for f in np.unique(self.lips.faults[there])]
        return max(self.model.gamma(fault, self.prepared.horizon) for fault in faults)

    def _data(
        self, part: int, index: IntArray, points: FloatArray, fitted: BoolArray
    ) -> tuple[NodeData, FloatArray]:
        """Return what picks and fitted nodes say of the nodes of a part, and c^-4 of each, (k,)."""
        prepared = self.prepared
        told = prepared.data
        known = prepared.unknown[told.nodes] & (self.part[told.nodes] == part)
        at = np.flatnonzero(fitted)
        data = NodeData(
            np.concatenate([index[told.nodes[known]], at]),
            np.concatenate([told.z[known], points[at, 2]]),
            np.concatenate([told.gradient[known], np.zeros((len(at), 2))]),
        )
        lengths = np.full(len(data.nodes), prepared.smoothing)
        lengths[: int(known.sum())] = prepared.horizon.smoothing or prepared.horizon.step
        return data, lengths**-4.0


def _independent(prepared: CutHorizon, copies: IntArray) -> IntArray:
    """Return the part of each copy whose elevation is sought, (n,), -1 for all others.

    Elevations that are sought have to do with each other only through triangles that hold such a copy and
    share an edge: so the copies of those triangles that are joined by their edges are together. A part
    without a node of the cut (``copies``) goes with one that has some, in its subdomain.
    """
    cut, sought = prepared.cut, prepared.unknown | prepared.fitted
    touched = cut.triangles[sought[cut.triangles].any(axis=1)]
    pairs = np.concatenate([touched[:, [0, 1]], touched[:, [1, 2]]])
    parts = np.where(sought, component_labels(len(sought), pairs), -1)
    bare = np.setdiff1d(parts[sought], parts[copies])
    for part in bare:
        there = parts == part
        label = cut.node_labels[np.argmax(there)]
        with_cut = parts[copies[(cut.node_labels[copies] == label) & (parts[copies] >= 0)]]
        parts[there] = with_cut.min() if len(with_cut) else -1
    return _together(parts, cut.node_labels)


def _near(triangles: IntArray, part: IntArray, *, whole: bool) -> dict[int, IntArray]:
    """Return for each part the triangles (m, 3) whose nodes take part in its problem, ascending.

    Without a fit they reach to the nodes whose fixed values the energy sees across an edge; with one
    (``whole``), to the last of the fitted nodes, where the surface is free. ``part``: (n,), -1 for none.
    """
    at = part[triangles]
    touched = np.asarray(at.max(axis=1))
    if whole:
        rows = np.flatnonzero((at.min(axis=1) == touched) & (touched >= 0))
        return _by_part(rows, touched[rows])
    reached = np.zeros(len(part), dtype=bool)
    reached[triangles[touched >= 0]] = True
    rows = np.flatnonzero(reached[triangles].sum(axis=1) > 1)
    edges, sides = edge_table(triangles[rows])
    # Triangles of two parts have no node in common, so that an edge belongs to one of them.
    owner = np.full(len(edges), -1)
    own = touched[rows] >= 0
    owner[sides[own]] = touched[rows][own][:, None]
    there = owner[sides]
    keys = np.unique((there * len(triangles) + rows[:, None])[there >= 0])
    return _by_part(keys % len(triangles), keys // len(triangles))


def _by_part(rows: IntArray, parts: IntArray) -> dict[int, IntArray]:
    """Return the rows of each part, in their order."""
    order = np.argsort(parts, kind="stable")
    numbers, first = np.unique(parts[order], return_index=True)
    ends = np.append(first, len(rows))[1:]
    return {int(k): rows[order[a:b]] for k, a, b in zip(numbers, first, ends, strict=True)}


def _together(parts: IntArray, labels: IntArray) -> IntArray:
    """Return the parts (n,) with small ones of a subdomain put together."""
    numbers, first, sizes = np.unique(parts, return_index=True, return_counts=True)
    merged = numbers.copy()
    for label in np.unique(labels[first[numbers >= 0]]):
        size, name = 0, -1
        for k in np.flatnonzero((labels[first] == label) & (numbers >= 0)):
            if size == 0:
                name = numbers[k]
            merged[k] = name
            size = 0 if size + sizes[k] >= _LEAST_PART else size + sizes[k]
    return ints(merged[np.searchsorted(numbers, parts)])
