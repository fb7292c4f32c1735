"""A horizon made ready for the iteration: triangulated, cut, with its unknowns marked (paper Sect. 4)."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, SignArray, bools, floats, ints, signs
from graben.cutgraph import CutGraph
from graben.model import Horizon, Model
from graben.modeling.bend import bend_at_rim
from graben.modeling.close_smears import unsmeared
from graben.modeling.cutting import CutMesh, opened
from graben.modeling.distance import distances
from graben.modeling.narrows import narrows
from graben.modeling.noise import fitted, smoothing
from graben.modeling.picks import NodeData, node_data
from graben.modeling.refitting import refitted
from graben.modeling.smears import smear_widths
from graben.modeling.triangulation import PlanMesh, triangulated
from graben.proximity import Nearest, PlanIndex, boxes, nearest
from graben.surface import boundary_edges
from graben.validators.context import Anchoring
from graben.validators.measuring.measures import amount

#: Where a subdomain has no fixed node, gamma is not reduced below this many steps.
_LEAST_GAMMA = 2.0
#: Points that stray from a line by less than this share of their extent lie in it.
_IN_LINE = 1e-6


@dataclass(frozen=True, eq=False)
class CutHorizon:
    """A horizon cut open along its cut graph.

    Parameters
    ----------
    horizon, graph
        The input.
    mesh, cut
        The plan triangulation and its opened form.
    unknown : (n,) bool array
        Copies within gamma of the cut of a fault.
    block : (n, f) array
        Side of each copy with regard to each fault of ``faults``: see ``HorizonResult.block``.
    faults : (f,) array
        Indices of the faults that cut the horizon.
    data : NodeData
        What trusted picks inside the zone say of the copies.
    fitted : (n,) bool array
        Copies outside the zone whose values are noisy: they take part in a least-squares fit.
    smoothing : float
        Length over which that fit smooths, model units; 0 without one.
    bend : (n, 3) array
        Second derivatives K_xx, K_xy, K_yy at the copies beside the zone, to be carried on into it; else 0.
    smears : (f,) array
        Standard width of the smear along each of ``faults``, 0 where none is seen, model units.
    anchors : tuple of Anchoring
        How each subdomain is held.
    warnings : tuple of str
        What was changed to make it so.
    """

    horizon: Horizon
    graph: CutGraph
    mesh: PlanMesh
    cut: CutMesh
    unknown: BoolArray
    block: SignArray
    faults: IntArray
    data: NodeData
    fitted: BoolArray
    smoothing: float
    bend: FloatArray
    smears: FloatArray
    anchors: tuple[Anchoring, ...]
    warnings: tuple[str, ...]

    @cached_property
    def first(self) -> FloatArray:
        """Position of every copy on the input horizon, shape (n, 3)."""
        return floats(self.mesh.points[self.cut.origin])

    def border(self) -> IntArray:
        """Return the directed edges of the outer boundary, copies, shape (b, 2)."""
        edges = boundary_edges(self.cut.triangles)
        base = len(self.cut.origin)
        lips = np.concatenate([self.cut.left, self.cut.right[:, ::-1]])
        return ints(edges[~np.isin(edges[:, 0] * base + edges[:, 1], lips[:, 0] * base + lips[:, 1])])


def _few_steps(model: Model, horizon: Horizon, faults: IntArray, gammas: FloatArray) -> list[str]:
    """Return the warning that gamma of some faults (f,) is few steps of a horizon, and what to do."""
    unit = "" if model.unit == "none" else model.unit
    least = _LEAST_GAMMA * horizon.step
    small = {model.faults[f].name: float(g) for f, g in zip(faults, gammas, strict=True) if g < least}
    if not small:
        return []
    named = ", ".join(f"{name} ({amount(gamma, unit)})" for name, gamma in small.items())
    finest = amount(min(small.values()) / _LEAST_GAMMA, unit)
    mend = f"give it a step of {finest} or less" if len(horizon.picks) else "give a finer grid"
    return [
        f"gamma is less than {_LEAST_GAMMA:g} steps of {horizon.name}, {amount(least, unit)}, at {named}: "
        "the zone is a node or two wide; what is smeared further out stays in the throw. "
        "To do: nothing, where the horizon is sharp beside the fault; else set gamma to at least "
        f"{amount(least, unit)}, or {mend}."
    ]


def prepared(model: Model, horizon: Horizon, graph: CutGraph) -> CutHorizon:
    """Return a horizon triangulated with its cut graph, cut open, with its unknowns marked."""
    faults = np.unique(graph.faults)
    gammas = np.array([model.gamma(model.faults[f], horizon) for f in faults])
    mesh = triangulated(horizon.surface, graph, horizon.step, gammas)
    cut = opened(mesh)
    distance, unknown, block = _zones(graph, mesh, cut, faults, gammas)
    labels = cut.node_labels
    unknown &= labels >= 0
    # Smeared is what was given; a fit to picks beside the zone will change nothing of that.
    near = dict(zip(faults.tolist(), gammas.tolist(), strict=True))
    widths = smear_widths(horizon, graph, near)
    thin = narrows(graph, mesh.points[cut.origin], cut.triangles, gammas, widths, horizon.step)
    for part in thin:
        unknown[part.held] = False
    held = np.concatenate([ints([]), *(part.held for part in thin)])
    mesh = _freed(mesh, ints(cut.origin[held]), horizon, graph, near)
    anchors = []
    warnings = [part.warning([f.name for f in model.faults], model.unit) for part in thin]
    warnings += _few_steps(model, horizon, faults, gammas)
    for label in range(int(labels.max(initial=-1)) + 1):
        mine = labels == label
        names = tuple(model.faults[f].name for f in np.unique(graph.faults[_touching(cut, mine)]))
        anchor = _anchoring(label, names, mesh, cut, unknown)
        if not anchor.holds and names:
            away = distance[mine]
            gamma = max(away.max() / 2, _LEAST_GAMMA * horizon.step)
            unknown[np.flatnonzero(mine)[away > gamma]] = False
            anchor = _anchoring(label, names, mesh, cut, unknown)
            if not anchor.holds:
                anchor = replace(anchor, gamma=_holding_gamma(mesh.points[cut.origin[mine]], away))
            if anchor.holds:
                warnings.append(
                    f"Subdomain {label} lies within gamma of {', '.join(names)} everywhere: "
                    f"gamma reduced to {gamma:.4g} {model.unit} there."
                )
        anchors.append(anchor)
    surfaces = [model.faults[f].surface for f in faults]
    data = node_data(horizon.picks, graph, surfaces, gammas, mesh.points[cut.origin, :2], block)
    horizon, mesh = refitted(horizon, mesh, cut, unknown, graph, data, model.unit)
    horizon, length = _denoised(model, horizon, mesh, cut, unknown, graph)
    bend = np.zeros((len(cut.origin), 3))
    if model.parameters.theta > 0:
        bend = bend_at_rim(
            graph,
            mesh.points[cut.origin],
            cut.triangles,
            labels,
            unknown,
            gammas,
            widths,
            model.tolerance,
        )
    return CutHorizon(
        horizon,
        graph,
        mesh,
        cut,
        bools(unknown),
        signs(block),
        ints(faults),
        data,
        bools(fitted(cut.triangles, unknown, length, horizon.step) & (labels >= 0)),
        length,
        floats(bend),
        widths,
        tuple(anchors),
        tuple(warnings),
    )


def _freed(
    mesh: PlanMesh, held: IntArray, horizon: Horizon, graph: CutGraph, gammas: Mapping[int, float]
) -> PlanMesh:
    """Return the mesh with some nodes (k,) put where they would be without the smear of close faults."""
    if len(held) == 0:
        return mesh
    points = mesh.points.copy()
    points[held, 2] = unsmeared(points[held], horizon, graph, gammas)
    return replace(mesh, points=points)


def _denoised(
    model: Model, horizon: Horizon, mesh: PlanMesh, cut: CutMesh, unknown: BoolArray, graph: CutGraph
) -> tuple[Horizon, float]:
    """Return the horizon with a note on its noise, and the length over which a fit has to smooth it."""
    if model.parameters.theta == 0 or len(horizon.picks):
        # The Dirichlet energy alone has no length to smooth over; a fit to picks has smoothed them already.
        return horizon, 0.0
    noise = horizon.noise
    points = mesh.points[cut.origin]
    needed = smoothing(points, cut.triangles, unknown, graph, horizon.step, noise)
    if needed.length == 0:
        return horizon, 0.0
    said = "given" if noise is not None else "estimated from the nodes around the faults"
    note = (
        f"Noise of {needed.noise:.2g} {model.unit} ({said}): the zone is fitted to the nodes around it by "
        f"least squares, smoothed over {needed.length:.3g} {model.unit}, not tied to each of them."
    )
    return replace(horizon, notes=(*horizon.notes, note)), needed.length


def _touching(cut: CutMesh, mine: BoolArray) -> BoolArray:
    """Return which cut edges have a lip among the given copies, shape (e,)."""
    return np.asarray(mine[cut.left].all(axis=1) | mine[cut.right].all(axis=1), dtype=bool)


def _zones(
    graph: CutGraph, mesh: PlanMesh, cut: CutMesh, faults: IntArray, gammas: FloatArray
) -> tuple[FloatArray, BoolArray, SignArray]:
    """Return of each copy its distance to the cut, whether it lies in a zone, and its side of each fault.

    The distance (n,) is infinite outside the boxes around the zones; the sides (n, f) are 0 outside gamma.
    """
    plan = mesh.points[:, :2]
    index = PlanIndex(plan)
    distance, unknown = np.full(len(plan), np.inf), np.zeros(len(plan), dtype=bool)
    block = np.zeros((len(cut.origin), len(faults)), dtype=np.int8)
    for k, f in enumerate(faults):
        mine = graph.faults == f
        ends = graph.nodes[graph.edges[mine]][:, :, :2].reshape(-1, 2)
        near = index.within(ends.min(axis=0) - gammas[k], ends.max(axis=0) + gammas[k])
        away, edge = distances(plan[near], graph, mine)
        at = plan[near]
        a, b = graph.nodes[graph.edges[edge, 0], :2], graph.nodes[graph.edges[edge, 1], :2]
        right = (b[:, 0] - a[:, 0]) * (at[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (at[:, 0] - a[:, 0]) < 0
        distance[near] = np.minimum(distance[near], away)
        side = np.zeros(len(plan), dtype=np.int64)
        side[near] = np.where(away <= gammas[k], np.where(right, 1, -1), 0)
        unknown |= side != 0
        within = np.flatnonzero((side != 0)[cut.origin])
        block[within, k] = side[cut.origin[within]]
        block[cut.left[mine], k] = -1
        block[cut.right[mine], k] = 1
    return distance[cut.origin], unknown[cut.origin], block


def _anchoring(
    label: int, names: tuple[str, ...], mesh: PlanMesh, cut: CutMesh, unknown: BoolArray
) -> Anchoring:
    """Return how the subdomain ``label`` is held by its copies that are not unknown, (n,)."""
    points = mesh.points[cut.origin]
    held = points[(cut.node_labels == label) & ~unknown]
    faces = cut.triangles[cut.labels == label]
    a, b, c = (points[faces[:, k]] for k in range(3))
    areas = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    middles = (a + b + c) / 3.0
    place = (areas[:, None] * middles).sum(axis=0) / areas.sum()
    near = _nearest_one(place[:2], points, faces)
    if near.distance[0] > _IN_LINE * np.ptp(middles[:, :2]):
        # The middle of a part that bends round another lies in that other.
        place = middles[near.simplex[0]]
    return Anchoring(label, names, len(held), _spread(held), place)


def _nearest_one(place: FloatArray, points: FloatArray, faces: IntArray) -> Nearest:
    """Return the triangle nearest to one place (2,) in plan, without a tree over all of them."""
    low, high = boxes(points, faces)
    low, high = low[:, :2], high[:, :2]
    least = (np.maximum(np.maximum(low - place, place - high), 0.0) ** 2).sum(axis=1)
    most = (np.maximum(np.abs(low - place), np.abs(high - place)) ** 2).sum(axis=1)
    close = np.flatnonzero(least <= most.min())
    near = nearest(place[None], points, faces[close])
    return replace(near, simplex=close[near.simplex])


def _spread(points: FloatArray) -> bool:
    """Return whether three of the points (n, 3) are not in one line in plan."""
    if len(points) < 3:
        return False
    size = np.linalg.svd(points[:, :2] - points[:, :2].mean(axis=0), compute_uv=False)
    return bool(size[1] > _IN_LINE * size[0])


def _holding_gamma(points: FloatArray, away: FloatArray) -> float:
    """Return the gamma below which points (n, 3) so far ``away`` (n,) from the cut hold; 0 if none does."""
    order = np.argsort(-away)
    count = bisect_left(range(len(points) + 1), True, key=lambda k: _spread(points[order[:k]]))
    return float(away[order[count - 1]]) if count <= len(points) else 0.0
