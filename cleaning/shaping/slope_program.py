"""The nearest surface whose normals obey linear constraints: the quadratic program of two repairs.

Every vertex moves by a length t along one direction u common to a patch. The normal n of a triangle, as long
as twice its area, is then linear in the moves of its corners, without a term of second order, since
u x u = 0: moving corner a of the triangle a, b, c changes n by t u x (b - c). So a bound on n . g is a linear
constraint: with g = z a plan area, with g = d - tan(dip) z a least dip towards d (THEORY 6).
"""

from __future__ import annotations

from dataclasses import dataclass

import clarabel
import numpy as np
from scipy.sparse import coo_array, csc_array, csc_matrix, diags_array, eye_array, triu, vstack

from graben.arrays import FloatArray, IntArray
from graben.surface import triangle_normals

#: Accuracy of the solution in moves over the median edge and in sines of angles: 6e-8 degrees, far within the
#: margin that the repairs keep.
ACCURACY = 1e-9
#: Moves below this share of the largest one are none: what an interior point leaves of a zero.
NOTHING = 1e-6


@dataclass(frozen=True, eq=False)
class Bounds:
    """Constraints n . g >= least |n0| on normals, n0 the normal before.

    Parameters
    ----------
    triangles : (c,) array
        The triangle of each, with an area; a triangle may have several.
    ways : (c, 3) array
        The vectors g.
    least : (c,) array
        The bounds, as parts of the length of n0.
    """

    triangles: IntArray
    ways: FloatArray
    least: FloatArray

    def joined(self, other: Bounds) -> Bounds:
        """Return these and others."""
        return Bounds(
            np.concatenate([self.triangles, other.triangles]),
            np.concatenate([self.ways, other.ways]),
            np.concatenate([self.least, other.least]),
        )


@dataclass(frozen=True, eq=False)
class Smooth:
    """What the moved surface is drawn to besides its place: values of ``rows @ heights`` near 0.

    Parameters
    ----------
    rows : (r, n) sparse array
        Of the positions along u.
    weight : float
        Their weight over that of the moves.
    """

    rows: csc_array
    weight: float


def slopes(
    points: FloatArray, triangles: IntArray, way: FloatArray, bounds: Bounds
) -> tuple[csc_array, FloatArray]:
    """Return the matrix and the right side of some bounds as ``matrix @ moves >= right``.

    Parameters
    ----------
    points : (n, 3) array
        Vertices, model units.
    triangles : (m, 3) array
        Vertex indices, each triangle seen from the top of its fault.
    way : (3,) array
        The unit vector u.
    bounds : Bounds
        What is asked.

    Returns
    -------
    matrix : (c, n) sparse array
        Per model unit of move.
    right : (c,) array
        Sines.
    """
    corners = triangles[bounds.triangles]
    normals = triangle_normals(points, corners)
    size = np.linalg.norm(normals, axis=1)
    a, b, c = (points[corners[:, k]] for k in range(3))
    change = np.cross(way, np.stack([b - c, c - a, a - b], axis=1))
    entries = (change * bounds.ways[:, None]).sum(axis=2) / size[:, None]
    right = bounds.least - (normals * bounds.ways).sum(axis=1) / size
    rows = np.repeat(np.arange(len(corners)), 3)
    matrix = coo_array((entries.ravel(), (rows, corners.ravel())), shape=(len(corners), len(points)))
    return csc_array(matrix), right


def moves(
    points: FloatArray,
    triangles: IntArray,
    way: FloatArray,
    bounds: Bounds,
    weights: FloatArray,
    reach: FloatArray,
    smooth: Smooth | None = None,
) -> FloatArray | None:
    """Return the smallest moves along one direction that meet the bounds, shape (n,), or None without any.

    Minimizes sum(weights * moves^2), and the square of what ``smooth`` asks for, by an interior point.

    Parameters
    ----------
    points, triangles, way, bounds
        See :func:`slopes`.
    weights : (n,) array
        Of the squares of the moves, positive.
    reach : (n,) array
        The largest move of each vertex, model units: 0 holds it, infinity leaves it free.
    smooth : Smooth, optional
        What the surface is drawn to.
    """
    free = np.flatnonzero(reach > 0)
    matrix, right = slopes(points, triangles, way, bounds)
    matrix = matrix[:, free]
    touched = np.bincount(matrix.indices, minlength=matrix.shape[0]) > 0
    if (right[~touched] > ACCURACY).any():
        return None
    unit = _unit(points, triangles)
    matrix, right = csc_array(matrix.tocsr()[touched]) * unit, right[touched]
    weight = weights[free] / weights[free].mean()
    square, linear = csc_array(diags_array(weight)), np.zeros(len(free))
    if smooth is not None:
        rows = smooth.rows[:, free]
        square = csc_array(square + smooth.weight * (rows.T @ rows))
        linear = smooth.weight * (rows.T @ (smooth.rows @ (points @ way))) / unit
    limited = np.flatnonzero(np.isfinite(reach[free]))
    box = csc_array(eye_array(len(free), format="csr")[limited])
    far = reach[free][limited] / unit
    sides = csc_array(vstack([-matrix, box, -box]))
    found = _solved(square, linear, sides, np.concatenate([-right, far, far]))
    if found is None:
        return None
    found[np.abs(found) < NOTHING * np.abs(found).max(initial=0.0)] = 0.0
    result = np.zeros(len(points))
    result[free] = np.clip(found * unit, -reach[free], reach[free])
    return result


def hinges(points: FloatArray, triangles: IntArray, joints: IntArray, way: FloatArray) -> csc_array:
    """Return the rows that vanish where the surface is flat, one for each inner edge, shape (e, n).

    Over the plane normal to u the positions along u are a function, linear across an edge exactly when the
    four corners of its two triangles lie in a plane. The coefficients are the affine dependency of these
    four in that plane, which does not change when vertices move along u; their largest part is 1.

    Parameters
    ----------
    points, triangles, way
        See :func:`slopes`.
    joints : (e, 2) array
        The two sides of each inner edge, as 3 times the triangle and the corner opposite to it.
    """
    first, second = joints.T
    t, k = first // 3, first % 3
    four = np.stack(
        [
            triangles[t, (k + 1) % 3],
            triangles[t, (k + 2) % 3],
            triangles[t, k],
            triangles.ravel()[second],
        ],
        axis=1,
    )
    flat = points - (points @ way)[:, None] * way
    parts = []
    for left in range(4):
        a, b, c = (flat[four[:, j]] for j in range(4) if j != left)
        parts.append((-1.0) ** left * (np.cross(b - a, c - a) @ way))
    values = np.stack(parts, axis=1)
    most = np.abs(values).max(axis=1)
    values = values / np.where(most > 0, most, 1.0)[:, None]
    rows = np.repeat(np.arange(len(joints)), 4)
    return csc_array(coo_array((values.ravel(), (rows, four.ravel())), shape=(len(joints), len(points))))


def _unit(points: FloatArray, triangles: IntArray) -> float:
    """Return the median edge: the unit in which the program is solved."""
    corners = points[triangles]
    return float(np.median(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)))


def _solved(square: csc_array, linear: FloatArray, sides: csc_array, right: FloatArray) -> FloatArray | None:
    """Return the least of 1/2 x.P x + q.x with A x <= b, or None where there is no such x."""
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_feas = settings.tol_gap_abs = settings.tol_gap_rel = ACCURACY
    upper, sides = csc_array(triu(square)), csc_array(sides)
    for matrix in (upper, sides):
        matrix.sort_indices()
    cones = [clarabel.NonnegativeConeT(len(right))]
    answer = clarabel.DefaultSolver(
        csc_matrix(upper), linear, csc_matrix(sides), right, cones, settings
    ).solve()
    if str(answer.status) not in ("Solved", "AlmostSolved"):
        return None
    return np.array(answer.x, dtype=np.float64)
