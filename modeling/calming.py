"""The horizon on which the faults are traced: calm where it runs along a fault.

In the gap of a flat normal fault, seismic shows the fault itself. The horizon then lies in it to within
noise over the whole width of the gap, and where the two meet is chance: the trace wanders from lip to lip
and closes on itself, and a zone of gamma around it misses one of the lips. Any line through the gap serves
as a first trace; the best is its middle, from which both lips have an equal way to go. There f = u - w, the
height of the horizon above the fault, is replaced by the harmonic function with the values of f around the
gap: it grows from one side to the other and has neither peaks nor hollows, so its zero is one line, half way.
The same serves a step that a grid draws over a cell or two: there the horizon falls faster than the fault,
crosses it three times or as chance has it, and its gap lies around the step.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.modeling.algebra import Backend, Cholmod
from graben.modeling.energy import EdgePattern, dirichlet
from graben.proximity import nearest
from graben.refinement import component_labels
from graben.surface import Surface, edge_sharing, edge_table

#: A horizon runs along a fault where the slope between them is less than this share of the fault's.
ALONG = 0.05
#: What is calmed around such a place: the gap as a whole, at whose rims the slope is smeared already.
_GAP = 0.25
#: Rings of triangles added to those that run along the fault: f has left zero there, and holes are closed.
_RINGS = 1
#: A node further from the fault in plan than this share of its size is not on it.
_ON = 1e-9


def calmed(horizon: Surface, faults: list[Surface], backend: Backend | None = None) -> Surface:
    """Return the horizon with its height above each fault made harmonic where it runs along it.

    Parameters
    ----------
    horizon : Surface
        A function of x and y.
    faults : list of Surface
        Those that are no functions of x and y are passed: no horizon runs along them.
    backend : Backend, optional
        Linear algebra; default CHOLMOD.

    Returns
    -------
    Surface
        ``horizon`` itself where it runs along none.
    """
    z = horizon.vertices[:, 2].copy()
    steepest = _slopes(horizon.vertices[:, :2], horizon.triangles, z).max(initial=0.0)
    for fault in faults:
        if steepest > (1 - ALONG) * _least_slope(fault):
            _calm(z, horizon, fault, backend or Cholmod())
    if (z == horizon.vertices[:, 2]).all():
        return horizon
    return horizon.with_vertices(np.column_stack([horizon.vertices[:, :2], z]))


def _calm(z: FloatArray, horizon: Surface, fault: Surface, backend: Backend) -> None:
    """Change the elevations ``z`` (n,) of the horizon where it runs along one fault."""
    triangles = horizon.triangles
    plan = horizon.vertices[:, :2]
    low, high = fault.vertices.min(axis=0), fault.vertices.max(axis=0)
    place = np.column_stack([plan, z])
    near = np.flatnonzero(((place >= low) & (place <= high)).all(axis=1))
    above = np.full(len(z), np.nan)
    above[near] = z[near] - _elevation(fault, plan[near])
    rows = np.flatnonzero(np.isfinite(above[triangles]).all(axis=1))
    if len(rows) == 0:
        return
    faces = triangles[rows]
    between = _share(plan, faces, above, z - above)
    gap = between < _GAP
    band = rows[gap][_of_traces(faces[gap], above, (between < ALONG)[gap])]
    held = np.isin(rows, band)
    band = rows[_around_steps(plan, faces, above, z - above, held, held & (between < 0))]
    for _ in range(_RINGS):
        band = rows[np.isin(faces, triangles[band]).any(axis=1)]
    loose = np.zeros(len(z), dtype=bool)
    loose[triangles[band]] = True
    others = np.ones(len(triangles), dtype=bool)
    others[band] = False
    loose[triangles[others]] = False
    if not loose.any():
        return
    nodes, flat_faces = np.unique(triangles[band], return_inverse=True)
    inner = loose[nodes]
    pattern = EdgePattern.of(flat_faces.reshape(-1, 3), len(nodes))
    matrix = dirichlet(plan[nodes], pattern)[np.flatnonzero(inner)]
    own = matrix[:, np.flatnonzero(inner)].tocsc()
    load = -(matrix[:, np.flatnonzero(~inner)] @ above[nodes[~inner]])
    z[nodes[inner]] += backend.analyse(own).factor(own).solve(load) - above[nodes[inner]]


def _least_slope(fault: Surface) -> float:
    """Return the slope of a fault where it is flattest; infinite if it is no function of x and y."""
    normals = np.cross(*_sides(fault.vertices, fault.triangles))
    if not ((normals[:, 2] > 0).all() or (normals[:, 2] < 0).all()):
        return np.inf
    return float((np.hypot(normals[:, 0], normals[:, 1]) / np.abs(normals[:, 2])).min())


def _sides(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, FloatArray]:
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return b - a, c - a


def _slopes(plan: FloatArray, triangles: IntArray, values: FloatArray) -> FloatArray:
    """Return the length of the gradient of a function given at the nodes on each triangle, (m,)."""
    return np.asarray(np.hypot(*_gradients(plan, triangles, values)), dtype=np.float64)


def _gradients(plan: FloatArray, triangles: IntArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return both parts of the gradient of a function given at the nodes on each triangle, (m,) each."""
    (x1, y1), (x2, y2) = (side.T for side in _sides(plan, triangles))
    a, b, c = (values[triangles[:, k]] for k in range(3))
    det = x1 * y2 - x2 * y1
    det = np.where(det == 0, np.finfo(float).tiny, det)
    return ((b - a) * y2 - (c - a) * y1) / det, ((c - a) * x1 - (b - a) * x2) / det


def _share(plan: FloatArray, triangles: IntArray, above: FloatArray, fault: FloatArray) -> FloatArray:
    """Return how fast a horizon rises above a fault against its dip, as a share of the fault's slope, (m,).

    1 where the horizon is level, 0 where it runs along the fault, negative where it is steeper, as in a step
    that a grid draws over one cell. A horizon that is steeper over more than half of the area crosses the
    fault the other way, and is no step: there the share is that of the slopes alone.
    """
    (f_x, f_y), (w_x, w_y) = (_gradients(plan, triangles, values) for values in (above, fault))
    square = np.maximum(w_x**2 + w_y**2, np.finfo(float).tiny)
    share = -(f_x * w_x + f_y * w_y) / square
    first, second = _sides(plan, triangles)
    area = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    if area[share < 0].sum() > 0.5 * area.sum():
        return np.asarray(np.sqrt((f_x**2 + f_y**2) / square))
    return np.asarray(share)


def _around_steps(
    plan: FloatArray,
    triangles: IntArray,
    above: FloatArray,
    fault: FloatArray,
    band: BoolArray,
    step: BoolArray,
) -> BoolArray:
    """Return the band (m,) with what lies around a step of the horizon as far as the gap reaches.

    Beside a step through the middle of the gap the horizon lies above the fault on its foot wall and below
    it on its hanging wall: from the step it is as far to a lip as that height over the slope of the fault.
    """
    rows = np.flatnonzero(step)
    if len(rows) == 0:
        return band
    slope = np.maximum(_slopes(plan, triangles[rows], fault), np.finfo(float).tiny)
    reach = np.abs(above[triangles[rows]]).max(axis=1) / slope
    middles = plan[triangles].mean(axis=1)
    within = cKDTree(middles).query_ball_point(middles[rows], reach)
    wide = band.copy()
    wide[np.concatenate([np.asarray(found, dtype=np.int64) for found in within])] = True
    return wide


def _elevation(fault: Surface, points: FloatArray) -> FloatArray:
    """Return the elevation of a fault at plan points, (k,); NaN beside it."""
    found = nearest(points, fault.vertices, fault.triangles)
    corners = fault.triangles[found.simplex]
    first, second = _sides(fault.vertices, corners)
    rel = points - fault.vertices[corners[:, 0], :2]
    det = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    s = (rel[:, 0] * second[:, 1] - rel[:, 1] * second[:, 0]) / det
    t = (first[:, 0] * rel[:, 1] - first[:, 1] * rel[:, 0]) / det
    z = fault.vertices[corners[:, 0], 2] + s * first[:, 2] + t * second[:, 2]
    reach = _ON * float(np.ptp(fault.vertices[:, :2], axis=0).max())
    return np.where(found.distance <= reach, z, np.nan)


def _of_traces(triangles: IntArray, values: FloatArray, along: BoolArray) -> BoolArray:
    """Return which triangles are joined across edges to one ``along`` the fault where the values change sign.

    ``triangles`` (m, 3), ``values`` (n,), ``along`` (m,); the result is (m,).
    """
    if len(triangles) == 0:
        return np.zeros(0, dtype=bool)
    edges, sides = edge_table(triangles)
    order = np.argsort(sides.ravel(), kind="stable")
    sharing = edge_sharing(sides, len(edges))
    first = np.concatenate([[0], np.cumsum(sharing)])[:-1][sharing == 2]
    labels = component_labels(len(triangles), np.stack([order[first], order[first + 1]], axis=1) // 3)
    corner = values[triangles]
    crossed = along & (corner.min(axis=1) <= 0) & (corner.max(axis=1) >= 0)
    return np.isin(labels, labels[crossed])
