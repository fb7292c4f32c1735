"""The cut polyhedron G = U ∩ (W_1 ∪ … ∪ W_N) of a horizon, from the exact complex (paper Sect. 3.3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from graben.arrays import FloatArray, IntArray
from graben.complexes import Complex
from graben.cutgraph import CutGraph, DroppedTrace, NodeKind
from graben.errors import ModelingError
from graben.model import Horizon, Model
from graben.modeling.bubbles import unbubbled
from graben.modeling.calming import calmed
from graben.modeling.resampling import Trace, node_kinds, resampled
from graben.modeling.snapping import NEAR, along_boundary, reaching, snapped, unlooped, without
from graben.refinement import component_labels, refined
from graben.surface import Surface, boundary_edges, mean_dip_direction, triangle_areas
from graben.words import plural

#: Pieces of a trace shorter than this many steps are dropped (check `trace`).
_PIECE = 2.0
#: Ends beyond a junction shorter than this many steps are dropped: the mesh could not open them.
_STUB = 1.0
_SKIRTS = "along the boundary of the horizon"
_LOOP = "around less than a step, drawn as a point"
_BUBBLE = "around a few cells that one fault closes off alone, in what is smeared"
#: Where a trace drawn with the step of the horizon crosses itself, it is drawn with these shares of it.
_FINER = (1.0, 0.5, 0.25)


def cut_graph(model: Model, horizon: Horizon, network: Complex) -> CutGraph:
    """Return the cut graph of a horizon, resampled to about its step.

    Parameters
    ----------
    model : Model
        The model of ``horizon`` and of the faults of ``network``, in its local frame.
    horizon : Horizon
        A horizon that is a function of x and y.
    network : Complex
        The common refinement of the model's faults; ``owner`` is the fault's index.
    """
    names = [f.name for f in model.faults]
    reach = NEAR * horizon.step
    surface = calmed(horizon.surface, [f.surface for f in model.faults])
    trace = snapped(exact_trace(surface, network, names, reach), horizon.step)
    whole, looped = trace, unlooped(trace, horizon.step)
    trace = looped[0]
    loops = _left_out(whole, looped[1], _LOOP)
    beside = along_boundary(trace, horizon.surface, reach)
    skirting = _left_out(trace, np.flatnonzero(beside), _SKIRTS)
    trace = reaching(without(trace, beside), horizon.surface, reach)
    trace, bubbles = unbubbled(trace, horizon.step)
    gone = [DroppedTrace(fault, length, middle, _BUBBLE) for fault, middle, length in bubbles]
    keep, dropped = _long_enough(trace, horizon.step)
    directions = [mean_dip_direction(f.surface.vertices, f.surface.triangles)[0] for f in model.faults]
    left_out = (*loops, *skirting, *gone, *dropped)
    for share in _FINER:
        graph = resampled(horizon.name, _kept(trace, keep), share * horizon.step, directions, left_out)
        pairs = _crossing(graph)
        if not len(pairs):
            return graph
    raise _crossing_error(graph, pairs[0], names, horizon)


def _left_out(trace: Trace, edges: IntArray, reason: str) -> list[DroppedTrace]:
    """Return what is left out of each fault with these edges."""
    ends = trace.points[trace.edges[edges]]
    lengths = np.hypot(*(ends[:, 1, :2] - ends[:, 0, :2]).T)
    dropped = []
    for fault in np.unique(trace.faults[edges]):
        mine = trace.faults[edges] == fault
        place = ends[mine].mean(axis=(0, 1))
        dropped.append(DroppedTrace(int(fault), float(lengths[mine].sum()), place, reason))
    return dropped


def _crossing(graph: CutGraph) -> IntArray:
    """Return the pairs of edges of a resampled graph that cross in plan, (k, 2)."""
    lines = shapely.linestrings(graph.nodes[graph.edges][:, :, :2])
    return np.asarray(shapely.STRtree(lines).query(lines, predicate="crosses").T, dtype=np.int64)


def _crossing_error(graph: CutGraph, pair: IntArray, names: Sequence[str], horizon: Horizon) -> ModelingError:
    """Return the error that says which traces cross in plan, where, and what helps with such an input."""
    a, b = (names[f] for f in graph.faults[pair])
    whose = f"the trace of {a} crosses itself" if a == b else f"the traces of {a} and {b} cross"
    x, y, z = (float(c) for c in graph.nodes[graph.edges[pair]].mean(axis=(0, 1)))
    helps = (
        "use a smaller step"
        if len(horizon.picks)
        else "smooth the grid beside the fault, or give the horizon as points with a step"
    )
    return ModelingError(f"{whose} in plan once drawn with the horizon's step; {helps}.", (x, y, z))


def exact_trace(horizon: Surface, network: Complex, names: Sequence[str] = (), reach: float = 0.0) -> Trace:
    """Return the edges that the horizon and the faults share in their exact common refinement.

    Raises
    ------
    ModelingError
        When a fault lies in the horizon over an area wider than ``reach`` (model units): says which by
        ``names``, else by its number.
    """
    faults = Surface("faults", network.vertices, network.triangles)
    whole = refined([faults, horizon])
    outer = np.zeros(len(whole.vertices), dtype=np.int64)
    outer[boundary_edges(whole.triangles[whole.owner == 1])] = 1
    both = _about_faults(whole)
    _require_no_area(both, network, names, reach)
    edges, sides = both.edges()
    of_horizon = both.owner == 1
    in_horizon = np.zeros(len(edges), dtype=bool)
    in_horizon[sides[of_horizon]] = True
    owner = network.owner[both.parent[~of_horizon]]
    side = sides[~of_horizon]
    count = int(network.owner.max(initial=0)) + 1
    keys = np.unique((side * count + owner[:, None])[in_horizon[side]])
    shared, fault = keys // count, keys % count
    rim = np.zeros((len(shared), 2), dtype=np.int64)
    for f in np.unique(fault):
        on_rim = np.zeros(len(both.vertices), dtype=np.int64)
        on_rim[boundary_edges(both.triangles[~of_horizon][owner == f])] = 1
        rim[fault == f] = on_rim[edges[shared[fault == f]]]
    nodes, local = np.unique(edges[shared], return_inverse=True)
    return Trace(both.vertices[nodes], local.reshape(-1, 2), fault, outer[nodes], rim)


def _about_faults(both: Complex) -> Complex:
    """Return the complex with those triangles of the horizon alone that share an edge with a fault."""
    of_fault = np.zeros(len(both.vertices), dtype=np.int8)
    of_fault[both.triangles[both.owner == 0]] = 1
    a, b, c = of_fault[both.triangles].T
    near = a + b + c >= 2
    return Complex(both.vertices, both.triangles[near], both.owner[near], both.parent[near])


def _require_no_area(both: Complex, network: Complex, names: Sequence[str], reach: float) -> None:
    """Raise ModelingError when a triangle of a fault, not a sliver, is a triangle of the horizon too."""
    rows = np.sort(both.triangles, axis=1)
    order = np.lexsort((both.owner, *rows.T))
    first, second = order[:-1], order[1:]
    # Of the two, the one of owner 0 is the fault's.
    same = first[(rows[first] == rows[second]).all(axis=1) & (both.owner[first] != both.owner[second])]
    longest = np.max([np.linalg.norm(e, axis=1) for e in _sides(both.vertices[rows[same]])], axis=0)
    wide = same[2 * triangle_areas(both.vertices, both.triangles[same]) > reach * longest]
    if len(wide):
        fault = int(network.owner[both.parent[wide[0]]])
        name = names[fault] if names else f"Fault {fault}"
        raise ModelingError(f"{name} lies in the horizon over an area, in {plural(len(wide), 'triangle')}.")


def _sides(corners: FloatArray) -> list[FloatArray]:
    return [corners[:, (k + 1) % 3] - corners[:, k] for k in range(3)]


def _long_enough(trace: Trace, step: float) -> tuple[IntArray, list[DroppedTrace]]:
    """Return the indices of the edges to keep, and what is dropped: short pieces and stubs."""
    keep = np.arange(len(trace.edges))
    dropped: list[DroppedTrace] = []
    while True:
        gone = _short_branches(trace, keep, step, dropped)
        if len(gone) == 0:
            return keep, dropped
        keep = np.setdiff1d(keep, gone)


def _short_branches(trace: Trace, keep: IntArray, step: float, dropped: list[DroppedTrace]) -> IntArray:
    """Return the edges of one round of dropping, noting each in ``dropped``.

    A branch is a chain of edges of one fault between nodes where faults meet or the trace ends. It is
    short when it joins nothing (at most one end on other faults) and is too short. Pieces of which nothing
    would be left go first: where they go, what they met ends no longer at them, and is no stub.
    """
    edges, faults = trace.edges[keep], trace.faults[keep]
    kinds = node_kinds(len(trace.points), edges, faults, trace.outer, trace.rim[keep])
    junction = kinds == NodeKind.JUNCTION
    ends = edges + faults[:, None] * len(trace.points)
    # Edges of a fault that meet in a node which is not a junction belong to one branch.
    branch, piece = _joined_edges(np.where(junction[edges], -1, ends)), _joined_edges(ends)
    plan = trace.points[edges]
    lengths = np.bincount(branch, np.hypot(*(plan[:, 1, :2] - plan[:, 0, :2]).T))
    held = np.unique(np.stack([np.repeat(branch, 2), edges.ravel()], axis=1)[junction[edges.ravel()]], axis=0)
    holds = np.bincount(held[:, 0], minlength=len(lengths))
    leaves = np.bincount(branch, (kinds[edges] == NodeKind.EXIT).any(axis=1)) > 0
    short = (holds == 0) & (lengths < _PIECE * step)
    # What leads from a junction to the boundary parts the two sides of its fault, however short.
    short |= (holds == 1) & ~leaves & (lengths < _STUB * step)
    whole = np.bincount(piece[~short[branch]], minlength=piece.max(initial=-1) + 1) == 0
    groups, chosen = (piece, whole) if whole.any() else (branch, short)
    reason = "piece shorter than two steps" if whole.any() else "stub beyond a junction"
    gone = np.flatnonzero(chosen[groups])
    for label in np.unique(groups[gone]):
        mine = np.flatnonzero(groups == label)
        length = float(np.hypot(*(plan[mine, 1, :2] - plan[mine, 0, :2]).T).sum())
        dropped.append(DroppedTrace(int(faults[mine[0]]), length, plan[mine].mean(axis=(0, 1)), reason))
    return keep[gone]


def _joined_edges(ends: IntArray) -> IntArray:
    """Return a label for each edge, (e,), the same where they have an end (e, 2) in common; -1 joins none."""
    m = len(ends)
    edge, column = np.nonzero(ends >= 0)
    nodes = np.unique(ends[edge, column], return_inverse=True)[1].reshape(-1)
    labels = component_labels(m + len(nodes), np.stack([edge, m + nodes], axis=1))[:m]
    return np.asarray(np.unique(labels, return_inverse=True)[1], dtype=np.int64)


def _kept(trace: Trace, keep: IntArray) -> Trace:
    return Trace(trace.points, trace.edges[keep], trace.faults[keep], trace.outer, trace.rim[keep])
