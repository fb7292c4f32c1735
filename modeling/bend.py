"""How a horizon is bent where the zone begins, carried on into it.

The energy of :mod:`graben.modeling.energy` carries a horizon on with its slope. A displacement that dies out
away from its fault is bent there, so that throws come out too large. With its second derivatives K known,
what is minimized is

    1/2 sum over edges with two triangles of c_e (d_e(u) - g_e)^2,  g_e = d_e(1/2 (P - X)^T K (P - X)),

which changes the load alone. K comes from cubic surfaces fitted to reliable nodes around places on the rim of
the zone (:mod:`graben.modeling.cubics`), and is harmonic inside it, free at the cut.

Three things are asked before it is used, for each fault. Does it foretell what is known: of surfaces fitted
to nodes beyond 2 gamma alone, by which share lambda of what K says do the nodes between gamma and 2 gamma
leave the tangent planes? Is the rim clear of the smear, which bends a horizon more than any displacement? And
is the zone not so wide that the bend changes inside it?
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.cutgraph import CutGraph
from graben.modeling.algebra import Backend
from graben.modeling.cubics import Nodes, quadratic, thinned
from graben.modeling.energy import EdgePattern, dirichlet
from graben.modeling.noise import rings

#: Radius of the fits, in gammas, and at most in standard widths of the smear, but never less than so many
#: gammas; and where the zone of the hold-out ends, in gammas.
_RADIUS, _MOST_RADIUS, _LEAST_RADIUS, _HELD_OUT = 2.0, 6.0, 1.25, 2.0
#: Distance between fits, in radii, of the rim and of the hold-out, which needs no more: those closer to each
#: other are made of the same nodes.
_APART, _HELD_APART = 0.125, 0.25
#: What is held out is foretold over this distance, in gammas: a little more than the way to the zone.
_BACK = 1.1
#: From the first to the second share lambda, less so many of its standard errors, the part of K that is used
#: grows from 0 to 1. Noise that is alike over two steps gave up to 0.5, horizons without noise 0.75 and more.
_LEAST_SHARE, _FULL_SHARE, _ERRORS = 0.5, 0.75, 2.0
#: Standard widths of the smear within which no node takes part in a fit.
_CLEAR = 3.0
#: K is used where the rim lies so many standard widths from the cut: it fades in from the first to the
#: second, and out from the third to the fourth.
_WIDTHS = (2.25, 2.75, 5.0, 6.0)
#: Shares of the places along a fault at which K is firm: from the first to the second the part of it that is
#: used grows from 0 to 1. A few places near the tips say nothing of the rest.
_FIRM = (0.3, 0.5)
#: A bend that lifts the cut by less than this share of the tolerance is none.
_LEAST_LIFT = 0.01
#: Fits whose K a node of the rim takes over, by inverse square distance, and what is added to that, in radii.
_NEAREST, _SOFT = 4, 0.01


@dataclass(frozen=True, eq=False)
class _Traces:
    """Where nodes lie to the faults: distance to the nearest trace, its gamma and width of smear, its fault.

    All (n,); lengths in model units, the width 0 where no smear is seen.
    """

    away: FloatArray
    gamma: FloatArray
    width: FloatArray
    fault: IntArray

    @staticmethod
    def of(points: FloatArray, graph: CutGraph, gammas: FloatArray, widths: FloatArray) -> _Traces:
        """Return this for nodes (n, 3); ``gammas`` and ``widths`` (f,) of ``np.unique(graph.faults)``."""
        index = np.unique(graph.faults, return_inverse=True)[1]
        ends = graph.nodes[graph.edges][:, :, :2]
        line = np.concatenate([ends[:, 0], ends.mean(axis=1), ends[:, 1]])
        furthest = (_RADIUS + _HELD_OUT) * gammas.max()
        away, at = cKDTree(line).query(points[:, :2], distance_upper_bound=furthest)
        own = np.append(np.tile(index, 3), 0)[at]
        return _Traces(away, gammas[own], widths[own], own)

    @property
    def radius(self) -> FloatArray:
        """Radius of a fit around a node."""
        most = np.maximum(_MOST_RADIUS * self.width, _LEAST_RADIUS * self.gamma)
        return np.minimum(_RADIUS * self.gamma, most)

    @property
    def clear(self) -> BoolArray:
        """Whether a node is beyond the smear."""
        return np.asarray(self.away >= _CLEAR * self.width, dtype=bool)

    def trusted(self, nodes: IntArray) -> FloatArray:
        """Return the part of K to use at some nodes (k,) as far as the smear goes; 0 where none is seen."""
        width = self.width[nodes]
        ratio = np.divide(self.away[nodes], width, out=np.zeros(len(nodes)), where=width > 0)
        return np.asarray(np.interp(ratio, _WIDTHS, [0.0, 1.0, 1.0, 0.0]), dtype=np.float64)


def bend_at_rim(
    graph: CutGraph,
    points: FloatArray,
    triangles: IntArray,
    labels: IntArray,
    unknown: BoolArray,
    gammas: FloatArray,
    widths: FloatArray,
    tolerance: float,
) -> FloatArray:
    """Return K_xx, K_xy, K_yy of the horizon at the fixed nodes beside the zone, (n, 3), 0 at all others.

    Parameters
    ----------
    graph : CutGraph
        The cut graph.
    points : (n, 3) array
        Nodes of the cut mesh on the input horizon, model units.
    triangles, labels : (m, 3), (n,) arrays
        Of the cut mesh, and the subdomain of each node, -1 for none.
    unknown : (n,) bool array
        Nodes of the zone.
    gammas, widths : (f,) arrays
        gamma of each fault in ``np.unique(graph.faults)``, and the standard width of the smear along it, 0
        where none is seen, model units.
    tolerance : float
        Of the elevations, model units.
    """
    bend = np.zeros((len(points), 3))
    if not unknown.any() or not widths.any():
        return bend
    traces = _Traces.of(points, graph, gammas, widths)
    rim = np.flatnonzero(_beside(triangles, unknown) & (labels >= 0))
    rim = rim[traces.trusted(rim) > 0]
    reach = _RADIUS * float(gammas.max())
    # The first ring around the zone is not the input's own.
    known = ~unknown & (labels >= 0)
    nodes = Nodes.of(points, labels, traces.away, known & traces.clear & ~_beside(triangles, unknown), reach)
    centres = rim[thinned(points[rim, :2], _APART * reach)]
    fits = nodes.fitted(centres, traces.radius[centres], np.zeros(len(centres)))
    lift = 0.5 * np.abs(fits.bend).max(axis=1, initial=0.0) * traces.gamma[fits.centres] ** 2
    if not (lift > _LEAST_LIFT * tolerance).any():
        return bend
    shares = _shares(nodes, traces, triangles, known) * _firm(traces.fault, centres, fits.centres[fits.firm])
    part = traces.trusted(rim) * shares[traces.fault[rim]]
    bend[rim] = part[:, None] * nodes.between(fits, rim, _NEAREST, _SOFT * reach)
    return bend


def carried(
    points: FloatArray, pattern: EdgePattern, unknown: BoolArray, bend: FloatArray, backend: Backend
) -> FloatArray:
    """Return K at all nodes, (n, 3): as given at the fixed ones, harmonic at the others, free at the cut.

    ``points``: (n, 2), model units; ``unknown``: (n,); ``bend``: (n, 3).
    """
    if not bend.any():
        return bend
    laplacian = dirichlet(points, pattern)
    inner, outer = np.flatnonzero(unknown), np.flatnonzero(~unknown)
    rows = laplacian[:, inner].T.tocsr()
    own = rows[:, inner].tocsc()
    result = bend.copy()
    result[inner] = backend.analyse(own).factor(own).solve(-(rows[:, outer] @ bend[outer]))
    return result


def _beside(triangles: IntArray, start: BoolArray) -> BoolArray:
    """Return which nodes lie one ring outside some others, (n,)."""
    return np.asarray(rings(triangles, start, 1) == 1)


def _firm(fault: IntArray, centres: IntArray, firm: IntArray) -> FloatArray:
    """Return for each fault the part of K to use as far as it is firm along its rim, (f,).

    ``fault``: (n,), of each node; ``centres``: nodes around which K was sought; ``firm``: those where it is.
    """
    asked, found = (np.bincount(fault[some], minlength=fault.max() + 1) for some in (centres, firm))
    return np.asarray(np.interp(found / np.maximum(asked, 1), _FIRM, (0.0, 1.0)), dtype=np.float64)


def _shares(nodes: Nodes, traces: _Traces, triangles: IntArray, known: BoolArray) -> FloatArray:
    """Return for each fault the part of K that is borne out by what is held out, (f,), from 0 to 1.

    ``triangles``: (m, 3); ``known``: (n,), the nodes outside the zone.
    """
    within = traces.away < _HELD_OUT * traces.gamma
    rim = np.flatnonzero(_beside(triangles, within & (nodes.labels >= 0)) & known)
    rim = rim[thinned(nodes.points[rim, :2], _HELD_APART * float(traces.radius.max()))]
    fits = nodes.fitted(rim, traces.radius[rim], _HELD_OUT * traces.gamma[rim])
    own = traces.fault[fits.centres]
    held = np.flatnonzero(known & within & traces.clear)
    owner, node, way = nodes.around(held, fits.centres, _BACK * traces.gamma[fits.centres])
    lifted = quadratic(fits.bend[owner], way)
    left = nodes.points[node, 2] - fits.height[owner] - (fits.slope[owner] * way).sum(axis=1)
    borne = np.bincount(owner, left * lifted, minlength=len(own))
    full = np.bincount(owner, lifted**2, minlength=len(own))
    shares = np.zeros(traces.fault.max() + 1)
    for f in np.unique(own[full > 0]):
        mine = own == f
        places = nodes.points[fits.centres[mine], :2]
        shares[f] = _share(places, borne[mine], full[mine], float(traces.radius[fits.centres[mine]].max()))
    return shares


def _share(places: FloatArray, borne: FloatArray, full: FloatArray, radius: float) -> float:
    """Return the part of K to use for a fault, from 0 to 1, by least squares over fits at places (k, 2).

    ``borne`` and ``full`` (k,): sums of r q and q^2, r what is left of the tangent plane and q what K says.
    """
    share = borne.sum() / full.sum()
    rest = borne - share * full
    # Fits within half a radius of each other are made of the same nodes, so that their errors are alike.
    squared = ((places[:, None] - places) ** 2).sum(axis=2) / radius**2
    error = np.sqrt(max(rest @ np.exp(-2.0 * squared) @ rest, 0.0)) / full.sum()
    return float(np.interp(share - _ERRORS * error, (_LEAST_SHARE, _FULL_SHARE), (0.0, 1.0)))
