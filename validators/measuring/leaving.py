"""Where a fault leaves the domain of a horizon: the line in which it meets the wall over the boundary."""

from __future__ import annotations

import numpy as np
import shapely

from graben.arrays import FloatArray, floats
from graben.surface import Surface, boundary_loops
from graben.validators.measuring.measures import welded_mesh_of
from graben.validators.measuring.openings import openings


def broken_by_holes(horizon: Surface, fault: Surface, reach: float, least: float) -> list[FloatArray]:
    """Return where holes of a fault break the line in which it meets the wall over a horizon's boundary.

    W_fict, the wall (paper Sect. 3.1), stands over the outer boundary of the horizon. Where the rim of a
    hole crosses that boundary in plan, W_i ∩ W_fict ends and begins again beyond the hole.

    Parameters
    ----------
    horizon, fault : Surface
        Model units.
    reach : float
        How far above or below the horizon's boundary a break matters, model units.
    least : float
        Length of a gap that counts, model units.

    Returns
    -------
    list of (k, 3) arrays
        The ends of the line at each hole, on the fault, those nearest to the horizon first.
    """
    holes = [hole.loop for hole in openings(fault)]
    wall = _outer_boundary(horizon) if holes else None
    if wall is None:
        return []
    found = []
    for hole in holes:
        points = _crossings(fault.vertices[hole], wall, reach)
        gap = np.linalg.norm(points[:, None] - points, axis=2).max(initial=0.0)
        if len(points) > 1 and gap > least:
            found.append(floats(points))
    return found


def _outer_boundary(horizon: Surface) -> FloatArray | None:
    """Return the longest boundary loop of a horizon, shape (k, 3); None where it has none."""
    loops = [horizon.vertices[loop] for loop in boundary_loops(welded_mesh_of(horizon).triangles)]
    return max(loops, key=_plan_length, default=None)


def _plan_length(points: FloatArray) -> float:
    return float(np.hypot(*np.diff(points[:, :2], axis=0).T).sum())


def _crossings(loop: FloatArray, wall: FloatArray, reach: float) -> FloatArray:
    """Return the points of a loop over a wall's foot within ``reach`` of its elevation, the nearest first."""
    sides = shapely.linestrings(np.stack([loop[:-1, :2], loop[1:, :2]], axis=1))
    foot = shapely.linestrings(np.stack([wall[:-1, :2], wall[1:, :2]], axis=1))
    i, j = shapely.STRtree(foot).query(sides, predicate="intersects")
    start, way = loop[i], loop[i + 1] - loop[i]
    origin, along = wall[j], wall[j + 1] - wall[j]
    across = _cross(way, along)
    crosses = across != 0
    i, start, way, origin, along = (a[crosses] for a in (i, start, way, origin, along))
    across = across[crosses]
    share = _cross(origin - start, along) / across
    points = start + share[:, None] * way
    level = origin[:, 2] + _cross(origin - start, way) / across * along[:, 2]
    off = np.abs(points[:, 2] - level)
    order = np.argsort(off, kind="stable")
    return np.asarray(points[order[off[order] <= reach]])


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
