"""A horizon from points, fitted anew beside its faults once these are known.

The surface that points are fitted to on reading knows of no fault: it smooths the smeared jump and rings
beside it, further out than gamma. Fixed with those values, the nodes around the zone would hand the ringing
on to it, where it grows with the distance to the cut. So they are fitted once more, on the cut mesh, to the
picks outside the zone alone: nothing is smoothed across a fault, and nothing smeared takes part. What is
minimized is that of :mod:`graben.modeling.scattered`; c is the length with the least expected error of
prediction of those picks (:mod:`graben.modeling.noise`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, bools, ints
from graben.cutgraph import CutGraph
from graben.model import Horizon
from graben.modeling.algebra import Cholmod
from graben.modeling.cutting import CutMesh
from graben.modeling.noise import PROBES, SEED, expected_error, least, near_places, node_areas, rings
from graben.modeling.picks import NodeData
from graben.modeling.scattered import Places, Scattered, located
from graben.modeling.triangulation import PlanMesh

#: Rings around the zone on which c is estimated, and the least that are fitted.
_RINGS = 10
#: Rings that are fitted, for each step of the greater c: ringing and picks further away change the zone by
#: less than 1 %.
_REACH = 5.0
#: Shortest length c that is tried, in steps: it smooths less than linear interpolation does.
_FIRST = 0.25
#: With fewer picks outside the zone c stays as it was.
_LEAST_PICKS = 100
#: Picks that make a local plane. A part of the mesh with fewer outside the zone is fitted to all that it has,
#: which are smeared but lie on its side; one with fewer in all stays as it was.
_LEAST_IN_PART = 10
#: Steps from a node beyond which no pick can lie in one of its triangles.
_NEAR = 3.0
#: Weight of the surface as it was, beside that of picks: it settles what no pick says anything of.
_KEPT = 1e-6


@dataclass(frozen=True, eq=False)
class Refit:
    """``change`` (n,) in the elevation of each copy, and the length c and noise sigma; model units."""

    change: FloatArray
    length: float
    noise: float


def refitted(
    horizon: Horizon,
    mesh: PlanMesh,
    cut: CutMesh,
    unknown: BoolArray,
    graph: CutGraph,
    data: NodeData,
    unit: str,
) -> tuple[Horizon, PlanMesh]:
    """Return a horizon from points with a note, and its mesh with the nodes beside the zone fitted anew.

    Parameters
    ----------
    horizon : Horizon
        The input; one without picks is returned as it is.
    mesh, cut : PlanMesh, CutMesh
        Its triangulation and that opened along the cut.
    unknown : (n,) bool array
        Copies in the zone: they keep the elevation of the input, and picks in their triangles are left out.
    graph : CutGraph
        The cut graph.
    data : NodeData
        What trusted picks inside the zone say of its nodes.
    unit : str
        Of the model, for the note.
    """
    if len(horizon.picks) == 0 or not unknown.any():
        return horizon, mesh
    found = refit(horizon, mesh.points[cut.origin], cut.triangles, unknown, graph, data)
    # A node of the cut has the elevation of the trace, which all its copies share.
    lone = np.bincount(cut.origin, minlength=len(mesh.points))[cut.origin] == 1
    moved = lone & ~unknown
    points = mesh.points.copy()
    points[cut.origin[moved], 2] += found.change[moved]
    largest = float(np.abs(found.change[moved]).max(initial=0.0))
    note = (
        f"Around the faults the surface is fitted anew to the points outside the zone, smoothed over "
        f"{found.length:.3g} {unit} at a noise of {found.noise:.2g} {unit}; it moves by up to "
        f"{largest:.3g} {unit}."
    )
    told = replace(horizon, smoothing=found.length, notes=(*horizon.notes, note))
    return told, replace(mesh, points=points)


def refit(
    horizon: Horizon,
    points: FloatArray,
    triangles: IntArray,
    unknown: BoolArray,
    graph: CutGraph,
    data: NodeData,
) -> Refit:
    """Return what a fit to the picks outside the zone changes in the nodes around it.

    ``points`` (n, 3) and ``triangles`` (m, 3) are the cut mesh; the rest as of :func:`refitted`. The change
    is that of all nodes within reach and fades out over the further half of the way.
    """
    step = horizon.step
    before = (horizon.smoothing or step) / step
    reach = max(_RINGS, int(np.ceil(_REACH * before)))
    band = _Band.of(horizon, points, triangles, unknown, reach)
    length, noise = band.smoothing(points, unknown, graph, horizon.noise) or (before, horizon.noise or 0.0)
    if _REACH * length > reach:
        reach = int(np.ceil(_REACH * length))
        band = _Band.of(horizon, points, triangles, unknown, reach)
    change = np.zeros(len(points))
    fade = np.clip(2.0 * (1.0 - band.ring / (reach + 1)), 0.0, 1.0)
    change[band.nodes] = fade * band.change(length, data, len(points))
    return Refit(change, length * step, noise)


@dataclass(frozen=True, eq=False)
class _Band:
    """The mesh around the zone and in it, and the picks there; plan in steps, elevations in model units.

    ``nodes`` (k,) are copies, ``ring`` (k,) how far each is from the zone, ``plan`` (k, 2) and ``z`` (k,)
    where; ``triangles`` (t, 3) count in them. Picks lie in ``faces`` with ``weights`` and stand for the area
    ``shares``, their mean elevation is ``told``; (p,) and (p, 3). ``reliable`` (p,) marks those that are
    fitted: outside the zone, or in a part of the mesh that has hardly any there.
    """

    nodes: IntArray
    ring: IntArray
    plan: FloatArray
    z: FloatArray
    triangles: IntArray
    faces: IntArray
    weights: FloatArray
    shares: FloatArray
    told: FloatArray
    reliable: BoolArray

    @staticmethod
    def of(
        horizon: Horizon, points: FloatArray, triangles: IntArray, unknown: BoolArray, reach: int
    ) -> _Band:
        """Return the band that reaches so many rings from the zone."""
        ring = rings(triangles, unknown, reach)
        nodes, flat = np.unique(triangles[(ring[triangles] >= 0).all(axis=1)], return_inverse=True)
        flat = flat.reshape(-1, 3)
        middle = points[nodes, :2].mean(axis=0)
        plan = (points[nodes, :2] - middle) / horizon.step
        picks = horizon.picks[np.isfinite(horizon.picks).all(axis=1)]
        local = (picks[:, :2] - middle) / horizon.step
        near = np.isfinite(cKDTree(plan).query(local, distance_upper_bound=_NEAR)[0])
        places = Places.of(local[near], picks[near, 2])
        faces, weights, inside = located(plan, flat, places.points)
        faces, weights, told = faces[inside], weights[inside], places.means[inside]
        shares = _shares(node_areas(plan, flat), flat[faces], weights)
        part = _parts(flat, len(nodes))[flat[faces, 0]]
        outside = ~unknown[nodes[flat[faces]]].any(axis=1)
        reliable = bools(outside | (np.bincount(part[outside], minlength=len(nodes))[part] < _LEAST_IN_PART))
        return _Band(nodes, ring[nodes], plan, points[nodes, 2], flat, faces, weights, shares, told, reliable)

    def change(self, length: float, data: NodeData, count: int) -> FloatArray:
        """Return the change in elevation of its nodes by a fit with the length c, in steps, (k,).

        ``count`` is the number of copies that ``data`` counts in.
        """
        used = np.flatnonzero(self.reliable)
        problem = Scattered.of(
            self.plan, self.triangles, self.faces[used], self.weights[used], self.shares[used]
        )
        # Solved for the difference from the input, so that a plane is kept to rounding.
        misfit = self.told[used] - problem.at_places(self.z)
        load = problem.load(misfit) - length**4 * (problem.energy @ self.z)
        areas = node_areas(self.plan, self.triangles)
        held = _KEPT * areas
        index = np.full(count, -1)
        index[self.nodes] = np.arange(len(self.nodes))
        known = index[data.nodes] >= 0
        at = index[data.nodes[known]]
        held[at] += areas[at]
        load[at] += areas[at] * (data.z[known] - self.z[at])
        matrix = problem.matrix(length)
        matrix.setdiag(matrix.diagonal() + held)
        return np.where(self._known(), Cholmod().analyse(matrix).factor(matrix).solve(load), 0.0)

    def _known(self) -> BoolArray:
        """Return which nodes belong to a connected part of the mesh with enough reliable picks, (k,)."""
        part = _parts(self.triangles, len(self.nodes))
        picks = part[self.triangles[self.faces[self.reliable], 0]]
        return np.asarray(np.bincount(picks, minlength=len(part))[part] >= _LEAST_IN_PART)

    def smoothing(
        self, points: FloatArray, unknown: BoolArray, graph: CutGraph, noise: float | None
    ) -> tuple[float, float] | None:
        """Return the length c, in steps, with the least expected error, and the noise, model units.

        None with hardly a pick outside the zone.
        """
        chosen = near_places(points, ~unknown, graph)[self.nodes]
        whole = bools(chosen[self.triangles].all(axis=1))
        used = np.flatnonzero(self.reliable & whole[self.faces])
        if len(used) < _LEAST_PICKS:
            return None
        return least(_Estimate(self, whole, used, noise).at, _FIRST)


class _Estimate:
    """How well some picks ``used`` are predicted on the triangles ``whole`` of a band."""

    def __init__(self, band: _Band, whole: BoolArray, used: IntArray, noise: float | None) -> None:
        nodes, flat = np.unique(band.triangles[whole], return_inverse=True)
        flat = flat.reshape(-1, 3)
        faces = (np.cumsum(whole) - 1)[band.faces[used]]
        plan, z = band.plan[nodes], band.z[nodes]
        self._problem = Scattered.of(plan, flat, faces, band.weights[used], band.shares[used])
        self._rest = band.told[used] - self._problem.at_places(z)
        self._bent = self._problem.energy @ z
        self._held = _KEPT * node_areas(plan, flat)
        self._probes = np.random.default_rng(SEED).choice([-1.0, 1.0], (PROBES, len(used)))
        self._told = np.column_stack([self._problem.load(p) for p in (self._rest, *self._probes)])
        self._analysis = Cholmod().analyse(self._problem.energy)
        self._noise = noise

    def at(self, length: float) -> tuple[float, float]:
        """Return the expected square error for a length c, in steps, but for a constant, and the noise."""
        matrix = self._problem.matrix(length)
        matrix.setdiag(matrix.diagonal() + self._held)
        loads = self._told.copy()
        loads[:, 0] -= length**4 * self._bent
        solved = self._analysis.factor(matrix).solve(loads)
        fit, *answers = (self._problem.at_places(column) for column in solved.T)
        residual = float(((self._rest - fit) ** 2).sum())
        trace = float((self._probes * np.array(answers)).sum()) / PROBES
        return expected_error(residual, trace, len(self._rest), self._noise)


def _parts(triangles: IntArray, count: int) -> IntArray:
    """Return the connected part of each of so many nodes, (count,)."""
    a, b = triangles, np.roll(triangles, 1, axis=1)
    joined = coo_array((np.ones(a.size), (a.ravel(), b.ravel())), shape=(count, count))
    return ints(connected_components(joined, directed=False)[1])


def _shares(areas: FloatArray, corners: IntArray, weights: FloatArray) -> FloatArray:
    """Return the area that each pick stands for, (p,): that of each node shared out by weight among picks."""
    total = np.bincount(corners.ravel(), weights.ravel(), minlength=len(areas))
    per_weight = np.divide(areas, total, out=np.zeros(len(areas)), where=total > 0)
    return np.asarray((weights * per_weight[corners]).sum(axis=1))
