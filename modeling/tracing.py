"""The cut polyhedron G = U ∩ (W_1 ∪ … ∪ W_N) of a horizon, from the exact complex (paper Sect. 3.3)."""

from __future__ import annotations

import numpy as np

from graben.arrays import IntArray
from graben.complexes import Complex
from graben.cutgraph import CutGraph, DroppedTrace, NodeKind
from graben.model import Horizon, Model
from graben.modeling.refinement import component_labels, refined
from graben.modeling.resampling import Trace, node_kinds, resampled
from graben.surface import Surface, boundary_edges, mean_dip_direction

#: Pieces of a trace shorter than this many steps are dropped (SPEC, check `trace`).
_PIECE = 2.0
#: Ends beyond a junction shorter than this many steps are dropped: the mesh could not open them.
_STUB = 1.0


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
    trace = exact_trace(horizon.surface, network)
    keep, dropped = _long_enough(trace, horizon.step)
    directions = [mean_dip_direction(f.surface.vertices, f.surface.triangles)[0] for f in model.faults]
    return resampled(horizon.name, _kept(trace, keep), horizon.step, directions, tuple(dropped))


def exact_trace(horizon: Surface, network: Complex) -> Trace:
    """Return the edges that the horizon and the faults share in their exact common refinement."""
    faults = Surface("faults", network.vertices, network.triangles)
    both = refined([faults, horizon])
    edges, sides = both.edges()
    of_horizon = both.owner == 1
    in_horizon = np.zeros(len(edges), dtype=bool)
    in_horizon[sides[of_horizon]] = True
    owner = network.owner[both.parent[~of_horizon]]
    side = sides[~of_horizon]
    count = int(network.owner.max(initial=0)) + 1
    keys = np.unique((side * count + owner[:, None])[in_horizon[side]])
    shared, fault = keys // count, keys % count
    outer = np.zeros(len(both.vertices), dtype=np.int64)
    outer[boundary_edges(both.triangles[of_horizon])] = 1
    rim = np.zeros((len(shared), 2), dtype=np.int64)
    for f in np.unique(fault):
        on_rim = np.zeros(len(both.vertices), dtype=np.int64)
        on_rim[boundary_edges(both.triangles[~of_horizon][owner == f])] = 1
        rim[fault == f] = on_rim[edges[shared[fault == f]]]
    nodes, local = np.unique(edges[shared], return_inverse=True)
    return Trace(both.vertices[nodes], local.reshape(-1, 2), fault, outer[nodes], rim)


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
    dropped when it joins nothing (at most one end on other faults) and is too short.
    """
    edges, faults = trace.edges[keep], trace.faults[keep]
    kinds = node_kinds(len(trace.points), edges, faults, trace.outer, trace.rim[keep])
    junction = kinds == NodeKind.JUNCTION
    # Edges that meet in a node which is not a junction belong to one branch.
    ends = np.where(junction[edges], -1, edges)
    m = len(edges)
    rows = np.concatenate([np.flatnonzero(ends[:, k] >= 0) for k in (0, 1)])
    cols = m + np.concatenate([ends[ends[:, k] >= 0, k] for k in (0, 1)])
    labels = component_labels(m + len(trace.points), np.stack([rows, cols], axis=1))[:m]
    plan = trace.points[edges]
    lengths = np.hypot(*(plan[:, 1, :2] - plan[:, 0, :2]).T)
    gone: list[IntArray] = []
    for label in np.unique(labels):
        mine = np.flatnonzero(labels == label)
        held = np.unique(edges[mine][junction[edges[mine]]])
        length = float(lengths[mine].sum())
        limit = (_PIECE if len(held) == 0 else _STUB) * step
        if len(held) > 1 or length >= limit:
            continue
        place = plan[mine].mean(axis=(0, 1))
        reason = "piece shorter than two steps" if len(held) == 0 else "stub beyond a junction"
        dropped.append(DroppedTrace(int(faults[mine[0]]), length, place, reason))
        gone.append(keep[mine])
    return np.concatenate(gone) if gone else np.zeros(0, dtype=np.int64)


def _kept(trace: Trace, keep: IntArray) -> Trace:
    return Trace(trace.points, trace.edges[keep], trace.faults[keep], trace.outer, trace.rim[keep])
