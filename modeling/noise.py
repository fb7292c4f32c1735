"""How noisy a horizon is, and over which length a least-squares fit should smooth it.

Fixed nodes with their values as they are hand the noise of these on to the zone, where it grows with the
distance to the cut. The fit takes the reliable nodes near the zone into the minimization instead,

    1/2 sum over reliable nodes p of a_p (u_p - z_p)^2 + c^4 E_H(u),

a_p the plan area of node p, E_H the Hessian-like energy of :mod:`graben.modeling.energy`. The length c is
that with the least expected error of prediction. Its estimate is made of the sum R of the squares of the
residuals and of the trace T of the matrix that takes z to u, for n nodes: with the noise sigma given,
R/n + 2 sigma^2 T/n (C. L. Mallows, Some comments on C_p, Technometrics 15, 1973); else (R/n) / (1 - T/n)^2,
generalized cross-validation (P. Craven and G. Wahba, Smoothing noisy data with spline functions, Numerische
Mathematik 31, 1979), which needs no sigma and gives one, sigma^2 = R / (n - T).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.cutgraph import CutGraph
from graben.modeling.algebra import Cholmod
from graben.modeling.energy import EdgePattern, assemble

#: Rings around the zone on which the noise is estimated; the nodes of the first are not the input's own.
_RINGS = (2, 10)
#: Lengths c that are tried, in steps, grow by this factor from the first to at most the last.
_FACTOR, _FIRST, _LAST = float(np.sqrt(2.0)), float(np.sqrt(0.5)), 16.0
#: The estimate takes the nodes beside so many stretches of the cut, of so many edges, about 300 nodes each.
_PLACES, _STRETCH = 40, 16
#: With fewer reliable nodes nothing is estimated.
_LEAST_NODES = 100
#: Random signs that the trace is estimated with (M. F. Hutchinson, 1989), and their seed.
PROBES, SEED = 4, 0
#: Rings of the fit around the zone, for each step of c: data further away change the zone by less than 1 %.
_REACH = 5.0


@dataclass(frozen=True)
class Smoothing:
    """What the noise of a horizon asks for: ``length`` c and ``noise`` sigma, model units.

    A length of 0 says that the horizon is smooth as it is, so that its nodes are fixed.
    """

    length: float = 0.0
    noise: float = 0.0


def smoothing(
    points: FloatArray,
    triangles: IntArray,
    unknown: BoolArray,
    graph: CutGraph,
    step: float,
    noise: float | None,
) -> Smoothing:
    """Return over which length the reliable nodes near the zone should be smoothed.

    Parameters
    ----------
    points : (n, 3) array
        Nodes of the cut mesh on the input horizon, model units.
    triangles : (m, 3) array
        Of the cut mesh.
    unknown : (n,) bool array
        Nodes of the zone.
    graph : CutGraph
        The cut graph.
    step : float
        Node spacing, model units.
    noise : float or None
        Standard deviation of the nodes' noise, model units, if it is known; 0 for none.
    """
    if noise == 0 or not unknown.any():
        return Smoothing()
    ring = rings(triangles, unknown, _RINGS[1])
    chosen = near_places(points, ring >= _RINGS[0], graph)
    faces = triangles[chosen[triangles].all(axis=1)]
    used, flat = np.unique(faces, return_inverse=True)
    if len(used) < _LEAST_NODES:
        return Smoothing()
    estimate = _Estimate(points[used], flat.reshape(-1, 3), step, noise)
    found, sigma = least(estimate.at, _FIRST)
    return Smoothing(found * step, sigma) if found > _FIRST else Smoothing()


def least(at: Callable[[float], tuple[float, float]], first: float) -> tuple[float, float]:
    """Return the length c, in steps, with the least expected error of prediction, and the noise there.

    ``at`` gives both for a length; ``first`` is the shortest that is tried, each further one is sqrt 2 times
    the one before.
    """
    best, found = at(first), first
    factor = first * _FACTOR
    while factor <= _LAST:
        tried = at(factor)
        if tried[0] >= best[0]:
            break
        best, found, factor = tried, factor, factor * _FACTOR
    return found, best[1]


def expected_error(residual: float, trace: float, count: int, noise: float | None) -> tuple[float, float]:
    """Return the expected square error of prediction, but for a constant, and the noise sigma.

    Mallows' C_p with the noise given, else generalized cross-validation: see the head of the module.

    Parameters
    ----------
    residual : float
        Sum R of the squares of the residuals, square model units.
    trace : float
        T of the matrix that takes data to their fit.
    count : int
        Number of data.
    noise : float or None
        sigma, model units, if it is known.
    """
    if noise is not None:
        return residual / count + 2.0 * noise**2 * trace / count, noise
    return residual / count / (1.0 - trace / count) ** 2, float(np.sqrt(residual / (count - trace)))


def rings(triangles: IntArray, start: BoolArray, count: int) -> IntArray:
    """Return how many rings of triangles each node is from the start nodes, (n,); -1 beyond ``count``."""
    ring = np.where(start, 0, -1)
    a, b, c = triangles.T
    for k in range(1, count + 1):
        near = ring >= 0
        touched = triangles[near[a] | near[b] | near[c]]
        ring[touched[ring[touched] < 0]] = k
    return ring


def fitted(triangles: IntArray, unknown: BoolArray, length: float, step: float) -> BoolArray:
    """Return the reliable nodes that take part in a fit with this length, (n,)."""
    if length == 0:
        return np.zeros(len(unknown), dtype=bool)
    return np.asarray(rings(triangles, unknown, int(np.ceil(_REACH * length / step))) > 0)


def node_areas(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Return a third of the plan area of the triangles around each node, (n,), square model units.

    ``points``: (n, 2) or (n, 3), model units; ``triangles``: (m, 3), counter-clockwise in plan.
    """
    a, b, c = (points[triangles[:, k], :2] for k in range(3))
    area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    share = np.bincount(triangles.ravel(), np.repeat(area / 3.0, 3), minlength=len(points))
    return np.asarray(share, dtype=np.float64)


def near_places(points: FloatArray, candidates: BoolArray, graph: CutGraph) -> BoolArray:
    """Return the candidates, (n,), that lie beside some stretches of the cut, spread evenly over it."""
    middles = graph.nodes[graph.edges][:, :, :2].mean(axis=1)
    period = max(_STRETCH, len(middles) // _PLACES)
    _, beside = cKDTree(middles).query(points[candidates, :2])
    chosen = candidates.copy()
    chosen[candidates] = beside % period < _STRETCH
    return chosen


class _Estimate:
    """The least-squares problem of some reliable nodes alone; lengths in steps, elevations in model units."""

    def __init__(self, points: FloatArray, triangles: IntArray, step: float, noise: float | None) -> None:
        plan = (points[:, :2] - points[:, :2].mean(axis=0)) / step
        pattern = EdgePattern.of(triangles, len(points))
        self._energy = assemble(plan, pattern, theta=1.0, length=1.0)
        self._areas = node_areas(plan, triangles)
        self._bent = self._energy @ (points[:, 2] - points[:, 2].mean())
        self._probes = np.random.default_rng(SEED).choice([-1.0, 1.0], (len(points), PROBES))
        self._analysis = Cholmod().analyse(self._energy)
        self._noise = noise

    def at(self, length: float) -> tuple[float, float]:
        """Return the expected square error for a length c, in steps, but for a constant, and the noise."""
        matrix = length**4 * self._energy
        matrix.setdiag(matrix.diagonal() + self._areas)
        loads = np.column_stack([length**4 * self._bent, self._areas[:, None] * self._probes])
        solved = self._analysis.factor(matrix).solve(loads)
        residual = float((solved[:, 0] ** 2).sum())
        trace = float((self._probes * solved[:, 1:]).sum()) / PROBES
        return expected_error(residual, trace, len(loads), self._noise)
