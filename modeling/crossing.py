"""Rebuilt horizons that cross each other: where, and by how much."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import shapely
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, floats
from graben.modeling.results import HorizonResult
from graben.refinement import component_labels
from graben.surface import Surface
from graben.words import plural

#: Nodes nearer to each other than this many steps belong to one place.
_TOGETHER = 2.0
#: About so many nodes of a horizon tell whether it lies above another.
_SAMPLE = 2000
#: Barycentric coordinates down to minus this count as inside: nodes on an edge belong to its triangles.
_ON_EDGE = 1e-9


@dataclass(frozen=True, eq=False)
class Crossing:
    """Two horizons that cross each other within the same block.

    Parameters
    ----------
    upper, lower : str
        Names of the horizons, as they lie outside the rebuilt zones.
    places : (k, 3) array
        Where the upper lies furthest below the lower, one point on the upper or the lower for each place, the
        worst first; model units.
    depths : (k,) array
        By how much, model units.
    """

    upper: str
    lower: str
    places: FloatArray
    depths: FloatArray

    def warning(self, unit: str) -> str:
        """Return what crosses and what to do, in a sentence; ``unit`` is the model's."""
        x, y, _ = self.places[0]
        places = plural(len(self.depths), "place")
        depth = f"{self.depths[0]:.3g}" if unit == "none" else f"{self.depths[0]:.3g} {unit}"
        return (
            f"{self.upper} lies below {self.lower} in {places} once rebuilt, by up to {depth} "
            f"at x {x:.7g}, y {y:.7g}: lower gamma there, or look at the fault between them."
        )


def crossings(
    horizons: Sequence[HorizonResult], faults: Sequence[Surface], tolerance: float
) -> tuple[Crossing, ...]:
    """Return the pairs of rebuilt horizons that cross each other, with each place.

    The upper of two is that which lies above the other where the rebuilding left it alone. They cross where
    a rebuilt node of the upper lies below the lower, or one of the lower above the upper, and no fault lies
    between: on the two sides of a fault any order is possible.

    Parameters
    ----------
    horizons : sequence of HorizonResult
        In one frame.
    faults : sequence of Surface
        The faults of the model, in the same frame.
    tolerance : float
        Depths up to this are none, model units.
    """
    found = (_crossing(a, b, faults, tolerance) for a, b in combinations(horizons, 2))
    return tuple(c for c in found if c is not None)


def _crossing(
    a: HorizonResult, b: HorizonResult, faults: Sequence[Surface], tolerance: float
) -> Crossing | None:
    """Return how two horizons cross; None where they do not, or never lie over each other."""
    order = _order(a, b)
    if order == 0:
        return None
    places, depths = [], []
    for one, two, sign in ((a, b, order), (b, a, -order)):
        rebuilt = one.surface.vertices[~one.fixed]
        node, z = _sheets(rebuilt, two.surface)
        points, below = rebuilt[node], -sign * (rebuilt[node, 2] - z)
        wrong = np.flatnonzero(below > tolerance)
        wrong = wrong[~_parted(points[wrong], z[wrong], faults)]
        places.append(points[wrong])
        depths.append(below[wrong])
    points, depth = np.concatenate(places), np.concatenate(depths)
    if len(points) == 0:
        return None
    worst = _worst(points, depth, _TOGETHER * max(a.horizon.step, b.horizon.step))
    upper, lower = (a, b) if order > 0 else (b, a)
    return Crossing(upper.name, lower.name, floats(points[worst]), floats(depth[worst]))


def _order(a: HorizonResult, b: HorizonResult) -> int:
    """Return 1 where most nodes of ``a`` that were left alone lie above ``b``, -1 below, 0 for neither."""
    nodes = a.surface.vertices[a.fixed if a.fixed.any() else slice(None)]
    nodes = nodes[:: max(1, len(nodes) // _SAMPLE)]
    node, z = _sheets(nodes, b.surface)
    return int(np.sign(np.median(nodes[node, 2] - z))) if len(node) else 0


def _sheets(points: FloatArray, surface: Surface) -> tuple[IntArray, FloatArray]:
    """Return which points (n, 3) lie over or under a surface, once for each sheet, and its level there."""
    corners = surface.vertices[surface.triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    tree = shapely.STRtree(shapely.points(points[:, :2]))
    triangle, node = tree.query(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))
    a, b, c = (corners[triangle, k] for k in range(3))
    p = points[node]
    area = _cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):  # a triangle without area in plan is over nothing
        weights = np.stack([_cross(b - p, c - p), _cross(c - p, a - p), _cross(a - p, b - p)], axis=1)
        weights = weights / area[:, None]
    inside = (weights >= -_ON_EDGE).all(axis=1)
    z = (weights[inside] * corners[triangle[inside], :, 2]).sum(axis=1)
    return node[inside].astype(np.int64), np.asarray(z)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], dtype=np.float64)


def _parted(points: FloatArray, other: FloatArray, faults: Sequence[Surface]) -> BoolArray:
    """Return at which points (k, 3) a fault lies between them and the elevation ``other`` (k,)."""
    between = np.zeros(len(points), dtype=bool)
    low, high = np.minimum(points[:, 2], other), np.maximum(points[:, 2], other)
    # A lip lies on its fault: to rounding, at the end of the way between the two.
    slack = _ON_EDGE * float(np.abs(np.append(points, 1.0)).max())
    for fault in faults:
        node, z = _sheets(points, fault)
        between[node[(z >= low[node] - slack) & (z <= high[node] + slack)]] = True
    return between


def _worst(points: FloatArray, depth: FloatArray, reach: float) -> IntArray:
    """Return the index of the deepest point of each place, the worst place first."""
    pairs = cKDTree(points[:, :2]).query_pairs(reach, output_type="ndarray")
    labels = component_labels(len(points), pairs.reshape(-1, 2))
    order = np.argsort(-depth, kind="stable")
    return order[np.sort(np.unique(labels[order], return_index=True)[1])]
