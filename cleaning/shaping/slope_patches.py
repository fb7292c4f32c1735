"""The patches of a fault that are bent back into shape: which vertices take part, and how far they may go."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.cleaning.shaping.limits import reaches
from graben.cleaning.shaping.pushing import rings
from graben.cleaning.shaping.slope_program import Bounds, Smooth, moves
from graben.surface import Surface, triangle_normals
from graben.validators.measuring.measures import components, meshed, smallest_angles
from graben.validators.measuring.plan import orientation, projected
from graben.validators.z_monotone import SLIVER

#: Solves until the moves, measured as distances, stay within their limit.
_MOST_SOLVES = 8
#: Share of a limit that is aimed at where a vertex went beyond it.
_WITHIN = 0.999
#: Least cosine between the way and the normal at a vertex that its weight is made of, so that none is free.
_LEAST_COSINE = 0.05


@dataclass(frozen=True, eq=False)
class Turned:
    """A fault with its triangles seen from its top.

    Parameters
    ----------
    kept : (k,) array
        The triangles that have an area.
    triangles : (k, 3) array
        Those, turned so that most of the plan area of each component faces upwards.
    part : (k,) array
        Their component.
    normals : (k, 3) array
        As long as twice the area.
    joints : (e, 2) array
        The two sides of each inner edge, as 3 times the triangle (of those kept) and the corner.
    """

    kept: IntArray
    triangles: IntArray
    part: IntArray
    normals: FloatArray
    joints: IntArray

    @classmethod
    def of(cls, surface: Surface) -> Turned:
        """Return the triangles of a surface seen from its top."""
        solid = np.flatnonzero(smallest_angles(surface.vertices, surface.triangles) > 0)
        mesh = meshed(surface.triangles, solid)
        signs, part = orientation(mesh)
        up = signs * triangle_normals(surface.vertices, mesh.triangles)[:, 2]
        over = projected(surface).dips[mesh.kept] > 90.0
        sense = np.where(np.bincount(part, np.where(over, -up, up)) < 0, -1.0, 1.0)
        flip = signs * sense[part] < 0
        triangles = np.where(flip[:, None], mesh.triangles[:, [1, 0, 2]], mesh.triangles)
        # the corners of a joint follow the triangle that is turned
        corner = np.where(flip[:, None], np.array([[1, 0, 2]]), np.array([[0, 1, 2]])).ravel()
        joints = mesh.joints - mesh.joints % 3 + corner[mesh.joints]
        normals = triangle_normals(surface.vertices, triangles)
        return cls(mesh.kept, ints(triangles, -1, 3), part, floats(normals), ints(joints, -1, 2))

    def mean(self, chosen: BoolArray) -> FloatArray:
        """Return the sum of the normals of some triangles (k,), shape (3,)."""
        return np.asarray(self.normals[chosen].sum(axis=0), dtype=np.float64)

    def at_vertices(self, count: int, rounds: int) -> FloatArray:
        """Return normals at vertices, averaged so many times over neighbours, shape (count, 3)."""
        flat = self.triangles.ravel()
        rows = csr_array(
            coo_array(
                (np.ones(len(flat)), (flat, np.repeat(np.arange(len(self.triangles)), 3))),
                shape=(count, len(self.triangles)),
            )
        )
        normals = rows @ self.normals
        for _ in range(rounds):
            normals = rows @ (rows.T @ normals) / 3.0
        return np.asarray(normals, dtype=np.float64)


def patches(triangles: IntArray, free: BoolArray) -> Iterator[BoolArray]:
    """Yield the connected parts of some vertices (n,), in the order of their first vertices."""
    chosen = np.flatnonzero(free)
    index = np.full(len(free), -1)
    index[chosen] = np.arange(len(chosen))
    pairs = index[np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])]
    label = components(len(chosen), pairs[(pairs >= 0).all(axis=1)])
    for k in range(int(label.max(initial=-1)) + 1):
        mine = np.zeros(len(free), dtype=np.bool_)
        mine[chosen[label == k]] = True
        yield mine


def within(
    surface: Surface,
    turned: Turned,
    way: FloatArray,
    bounds: Bounds,
    movable: BoolArray,
    limit: float,
    reference: Surface,
    smooth: Smooth | None = None,
) -> FloatArray | None:
    """Return the smallest moves (n,) of some vertices that meet constraints and stay within a distance.

    None where there are none. The moves are shortened where they go too far, and solved for again.

    Parameters
    ----------
    surface, turned : Surface, Turned
        The fault.
    way : (3,) array
        Unit vector along which vertices move.
    bounds : Bounds
        On the normals of the triangles kept.
    movable : (n,) array
        The vertices that may move.
    limit : float
        How far a vertex or the middle of a side may lie from ``reference``, model units; infinity for no
        limit.
    reference : Surface
        What the limit is measured from.
    smooth : Smooth, optional
        What the surface is drawn to.
    """
    weights = _weights(surface, turned, way)
    reach = np.where(movable, np.inf, 0.0)
    for _ in range(_MOST_SOLVES):
        found = moves(surface.vertices, turned.triangles, way, bounds, weights, reach, smooth)
        if found is None:
            return None
        away = reaches(surface.with_vertices(surface.vertices + found[:, None] * way), [reference])
        far = (away > limit) & (found != 0)
        if not far.any():
            return found
        reach = np.where(far, np.abs(found) * _WITHIN * limit / np.where(far, away, 1.0), reach)
    return None


def slivers(points: FloatArray, triangles: IntArray) -> int:
    """Return how many triangles are too thin for their dip to be trusted."""
    return int((smallest_angles(points, triangles) < SLIVER).sum())


def around(triangles: IntArray, core: BoolArray, count: int) -> BoolArray:
    """Return the vertices within ``count`` rings of some (n,)."""
    return bools(rings(triangles, core, count))


def _weights(surface: Surface, turned: Turned, way: FloatArray) -> FloatArray:
    """Return the weights of squared moves, shape (n,): area times the squared part that leaves the surface.

    Moves along a surface do not leave it, and count little.
    """
    normals = turned.at_vertices(len(surface.vertices), 0)
    size = np.linalg.norm(normals, axis=1)
    cosine = np.abs(normals @ way) / np.where(size > 0, size, 1.0)
    cosine = np.maximum(np.where(size > 0, cosine, 1.0), _LEAST_COSINE)
    area = np.bincount(
        turned.triangles.ravel(),
        np.repeat(np.linalg.norm(turned.normals, axis=1), 3),
        minlength=len(surface.vertices),
    )
    positive = area[area > 0]
    area = np.where(area > 0, area, positive.mean() if len(positive) else 1.0)
    return floats(area * cosine**2)
