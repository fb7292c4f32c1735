"""Narrows: parts of a horizon between faults that are too thin for gamma, where it is reduced.

Between two faults less than 2 gamma apart no node is reliable, and the extrapolation from the nearest that
are may go over kilometres: the strip then hangs on its ends alone, while seismic shows its middle. A strip
that is a subdomain of its own has the same need, and the same answer serves both: gamma is reduced to what
there is room for: to the reach of the smear where one is seen, else to half.

Wedges between faults that reliable nodes are nearer to are left alone. To hold what lies beyond the smear of
each of their faults was tried: on two faults that cross at 30 degrees it took the cutoff error from 6.5 to
3.0 % of the throw, but at junctions, where smears add up, from below 4 to 5 to 10 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, bools
from graben.cutgraph import CutGraph
from graben.modeling.distance import distances, outside
from graben.refinement import component_labels
from graben.surface import edge_table

#: Reliable nodes further than so many gammas do not serve: an extrapolation errs with the square of its
#: length, here sixteen times as much as over gamma.
_FAR = 4.0
#: Standard widths up to which the smear reaches: beyond, less than 1 % of a step is left.
_CLEAR = 2.5
#: Gamma is not reduced below this many steps: a lip needs a node of the mesh between it and the nodes held.
_LEAST = 1.0
#: The part of the room between faults that gamma becomes: half where no smear is seen, and what is beyond the
#: smear where one is, but not less and not more than so much.
_SHARES = (0.5, 0.85)


@dataclass(frozen=True, eq=False)
class Narrow:
    """A thin part of a horizon that reliable nodes are far from.

    Parameters
    ----------
    held : (k,) array
        Copies within gamma of a fault that are held for all that; none where there is no room for any.
    width : float
        Of the part at its widest, model units; 0 where the mesh has no node between the cuts.
    faults : (f,) array
        The faults around it, by their index in the model.
    """

    held: IntArray
    width: float
    faults: IntArray

    def warning(self, names: Sequence[str], unit: str) -> str:
        """Return what was done, in a sentence; ``names`` are those of the model's faults."""
        between = " and ".join(names[f] for f in self.faults)
        length = "" if unit == "none" else f" {unit}"
        wide = f"at most {self.width:.3g}{length} wide" if self.width else "hardly there at all"
        told = f"Between the cuts of {between} the horizon is {wide}, and within gamma of them all along: "
        if len(self.held) == 0:
            return told + "nothing tells its elevation there, and the throws are a guess. Use a smaller step."
        return told + "gamma is reduced to what there is room for there."


def narrows(
    graph: CutGraph,
    points: FloatArray,
    triangles: IntArray,
    gammas: FloatArray,
    widths: FloatArray,
    step: float,
) -> list[Narrow]:
    """Return the thin parts of a cut horizon that reliable nodes are far from, with what to hold in them.

    A node is in a thin part where no disc free of cuts that contains it has room for nodes beyond gamma and
    one step. There gamma becomes a part of what there is room for at each node: the distance from the cuts of
    the furthest node in whose disc free of cuts it lies. A strip that tapers is so held all along.

    Parameters
    ----------
    graph : CutGraph
        The cut graph.
    points : (n, 3) array
        The copies of the nodes.
    triangles : (m, 3) array
        Of copies.
    gammas, widths : (f,) arrays
        gamma of each fault in ``np.unique(graph.faults)``, and the standard width of the smear along it, 0
        where none is seen, model units.
    step : float
        Model units.
    """
    if len(graph.edges) == 0:
        return []
    plan, widest = points[:, :2], float(gammas.max())
    away, nearest = distances(plan, graph, within=widest + step)
    beyond = outside(plan, graph, gammas, within=step)
    used = np.zeros(len(points), dtype=bool)
    used[triangles] = True
    roomy = _roomy(plan, away, beyond, gammas, step)
    on_cut, reliable = bools(used & (away == 0)), bools(beyond > 0)
    # Between nodes that are reliable and have room no way need be sought, and no part is.
    a, b, c = (roomy & reliable)[triangles].T
    edges = edge_table(triangles[~(a & b & c)])[0]
    way = _reach(plan, edges[~reliable[edges].all(axis=1)], used & roomy & reliable)
    far = used & np.isfinite(way) & (way > _FAR * widest)
    thin = _parts_with(used & ~roomy & ~on_cut, far, edges)
    bare = _parts_with(far & on_cut, far, edges)
    # Lips beside a thin part are spoken of with it.
    beside = edges[(thin[edges] >= 0).any(axis=1)]
    found = []
    for parts in (thin, np.where(np.isin(bare, bare[beside]), -1, bare)):
        for part in np.unique(parts[parts >= 0]):
            mine = np.flatnonzero(parts == part)
            # The point of a wedge has no room either, but ends before it matters.
            if parts is not thin and np.hypot(*np.ptp(plan[mine], axis=0)) < 2.0 * widest:
                continue
            near = np.unique(graph.faults[nearest[mine]])
            room = float(min(away[mine].max(), widest))
            smeared = away[mine] - _beyond_smear(plan[mine], graph, widths)
            low, high = (share * _room(plan[mine], away[mine], step) for share in _SHARES)
            least = np.maximum(np.clip(smeared, low, high), _LEAST * step)
            held = mine[reliable[mine] | (away[mine] > least)]
            found.append(Narrow(held, 2.0 * room, near))
    return found


def _beyond_smear(plan: FloatArray, graph: CutGraph, widths: FloatArray) -> FloatArray:
    """Return how far nodes (n, 2) lie beyond the smear of every fault, (n,); inf where none is seen.

    A fault whose smear is not seen is taken for smeared as wide as the widest.
    """
    if not widths.any():
        return np.full(len(plan), np.inf)
    return outside(plan, graph, _CLEAR * np.where(widths > 0, widths, widths.max()))


def _room(plan: FloatArray, away: FloatArray, step: float) -> FloatArray:
    """Return the radius of the widest disc free of cuts that each node (n, 2) of a part lies in, (n,).

    Discs stand on nodes of the part, whose distances to the cuts are ``away`` (n,).
    """
    room = away.copy()
    # Where the disc should stand is up to half a step from a node.
    pairs = cKDTree(plan).query_pairs(float(away.max()) + 0.5 * step, output_type="ndarray")
    apart = np.hypot(*(plan[pairs[:, 0]] - plan[pairs[:, 1]]).T)
    for node, centre in (pairs.T, pairs.T[::-1]):
        inside = apart <= away[centre] + 0.5 * step
        np.maximum.at(room, node[inside], away[centre[inside]])
    return room


def _parts_with(chosen: BoolArray, wanted: BoolArray, edges: IntArray) -> IntArray:
    """Return the number of the part of chosen nodes, (n,), for parts with a wanted one; -1 for all others."""
    parts = component_labels(len(chosen), edges[chosen[edges].all(axis=1)])
    return np.where(chosen & np.isin(parts, parts[chosen & wanted]), parts, -1)


def _roomy(
    plan: FloatArray, away: FloatArray, beyond: FloatArray, gammas: FloatArray, step: float
) -> BoolArray:
    """Return which nodes lie in a disc free of cuts that has room for nodes beyond gamma and a step, (n,)."""
    clear = bools(beyond >= step)
    roomy: BoolArray = clear.copy()
    for gamma in np.unique(gammas):
        centres = np.flatnonzero(clear & (away >= gamma + step))
        rest = np.flatnonzero(~roomy)
        if len(centres) and len(rest):
            # Centres stand on nodes, so up to a step from where they should.
            near = cKDTree(plan[centres]).query(plan[rest], distance_upper_bound=gamma + 2 * step)[0]
            roomy[rest[np.isfinite(near)]] = True
    return roomy


def _reach(plan: FloatArray, edges: IntArray, sources: BoolArray) -> FloatArray:
    """Return the way along edges (e, 2) from each node to the nearest source, (n,); infinite without any."""
    far = np.full(len(plan), np.inf)
    at = np.flatnonzero(sources)
    if len(at) == 0:
        return far
    length = np.hypot(*(plan[edges[:, 1]] - plan[edges[:, 0]]).T)
    graph = coo_array((length, (edges[:, 0], edges[:, 1])), shape=(len(plan), len(plan))).tocsr()
    return np.asarray(dijkstra(graph, directed=False, indices=at, min_only=True))
