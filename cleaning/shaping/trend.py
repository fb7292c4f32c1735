"""How a fault curves near its rim, and the curve on which it would go on beyond it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import FloatArray, IntArray, floats
from graben.cleaning.shaping.rim_chains import SHEET, Ways
from graben.surface import Surface, triangle_normals
from graben.validators.measuring.rim_lines import unit

#: The most that an extension turns from the tangent at the rim, degrees: it straightens and does not curl.
_MOST_TURN = 30.0
#: Weight of no curvature against the points of a fit, as a share: enough where they do not tell.
_STIFF = 1e-6
#: A fit of fewer points than this is a plane's.
_ENOUGH = 8
#: Nodes of the quadrature along a curve.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


@dataclass(frozen=True, eq=False)
class Trend:
    """Curves that go on from vertices of a rim, one row a vertex.

    Parameters
    ----------
    start : (k, 3) array
        The vertices, model units.
    tangent, side : (k, 3) arrays
        Unit vectors: the way on, and square to it the side to which it turns.
    stretch : (k,) array
        Length of the curve for a length of 1 square to the rim.
    curvature : (k,) array
        At the rim, towards ``side``, over model units.
    """

    start: FloatArray
    tangent: FloatArray
    side: FloatArray
    stretch: FloatArray
    curvature: FloatArray

    def at(self, row: IntArray, far: FloatArray) -> FloatArray:
        """Return the places ``far`` beyond the rim, square to it, on the curves of some rows, (n, 3)."""
        length = far * self.stretch[row]
        most = np.radians(_MOST_TURN)
        steps = length[:, None] * (_NODES + 1) / 2
        turn = most * np.tanh(self.curvature[row][:, None] * steps / most)
        ahead = 0.5 * length * (np.cos(turn) @ _WEIGHTS)
        aside = 0.5 * length * (np.sin(turn) @ _WEIGHTS)
        return floats(self.start[row] + ahead[:, None] * self.tangent[row] + aside[:, None] * self.side[row])


def trend(
    surface: Surface, chain: IntArray, ways: Ways, window: FloatArray, width: float, bend: float
) -> Trend:
    """Return how a surface goes on from vertices of its rim.

    A quadratic height over the tangent plane is fitted, by weighted least squares through the rim's vertex,
    to the vertices of the surface within a window. Its slope turns the way on, its curvature bends the curve;
    it counts by how sure the fit is of it.

    Parameters
    ----------
    surface : Surface
        The fault.
    chain : (k,) array
        Rim vertices.
    ways : Ways
        The ways on from them.
    window : (k,) array
        Reach of each fit along the way on, model units.
    width : float
        Its reach along the rim, at most the window: what lies beside tells less of the way on.
    bend : float
        Share of the curvature to go on with, 0 to 1; with 0 a plane is fitted, whose slope few points or
        rough ones tell far better.
    """
    size = np.linalg.norm(ways.way, axis=1)
    ahead = ways.way / size[:, None]
    aside = np.cross(ways.normal, ahead)
    start = surface.vertices[chain]
    row, offset = _near(surface, start, ways.normal, window)
    reach = window[row]
    a, b, z = (np.einsum("ij,ij->i", offset, axis[row]) / reach for axis in (ahead, aside, ways.normal))
    weight = np.maximum(1.0 - a * a - (b * reach / width) ** 2, 0.0) ** 2
    terms = np.stack([a, b, a * a, a * b, b * b], axis=1)
    slope, quadratic = _fitted(terms, z, weight, row, len(chain), plane=bend == 0.0)
    steep = np.sqrt(1.0 + slope**2)
    tangent = (ahead + slope[:, None] * ways.normal) / steep[:, None]
    side = (ways.normal - slope[:, None] * ahead) / steep[:, None]
    curvature = bend * 2.0 * quadratic / window / steep**3
    return Trend(floats(start), floats(tangent), floats(side), floats(size), floats(curvature))


def _near(
    surface: Surface, start: FloatArray, normal: FloatArray, window: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return the vertices of the same sheet within the windows of places: row and offset of each."""
    total = np.zeros((len(surface.vertices), 3))
    normals = triangle_normals(surface.vertices, surface.triangles)
    np.add.at(total, surface.triangles.ravel(), np.repeat(normals, 3, axis=0))
    found = cKDTree(surface.vertices).query_ball_point(start, window)
    row = np.repeat(np.arange(len(start)), [len(f) for f in found])
    vertex = np.concatenate([np.asarray(sorted(f), dtype=np.int64) for f in found])
    alike = np.einsum("ij,ij->i", unit(total)[vertex], normal[row]) > SHEET
    row, vertex = row[alike], vertex[alike]
    return row, floats(surface.vertices[vertex] - start[row])


def _fitted(
    terms: FloatArray, z: FloatArray, weight: FloatArray, row: IntArray, count: int, *, plane: bool
) -> tuple[FloatArray, FloatArray]:
    """Return the slope ahead and the quadratic term ahead of each fit, shape (count,) each."""
    normal, right = np.zeros((count, 5, 5)), np.zeros((count, 5))
    np.add.at(normal, row, weight[:, None, None] * terms[:, :, None] * terms[:, None, :])
    np.add.at(right, row, (weight * z)[:, None] * terms)
    total = np.bincount(row, weight, minlength=count)
    points = np.bincount(row, weight > 0, minlength=count)
    stiff = np.where((points >= _ENOUGH) & (not plane), _STIFF, 1.0 / _STIFF)[:, None] * np.array(
        [0, 0, 1.0, 1.0, 1.0]
    )
    normal += (np.maximum(total, 1.0)[:, None] * (stiff + 1e-12))[:, :, None] * np.eye(5)
    inverse = np.linalg.inv(normal)
    found = np.einsum("kij,kj->ki", inverse, right)
    rest = z - np.einsum("ij,ij->i", terms, found[row])
    freedom = np.maximum(points - 5, 1) / np.maximum(points, 1)
    variance = np.bincount(row, weight * rest**2, minlength=count) / (np.maximum(total, 1e-300) * freedom)
    unsure = variance * inverse[:, 2, 2]
    quadratic = found[:, 2]
    sure = quadratic**2 / np.maximum(quadratic**2 + unsure, 1e-300)
    return floats(found[:, 0]), floats(quadratic * sure)
