"""The topological cut of a plan triangulation along the cut graph, by sectors (paper Sect. 4.1).

The paper's Algorithm 1 makes one copy of a node for each subdomain around it; a fault that ends inside
has the same subdomain on both sides and would stay closed. Here a node gets one copy for each sector: a
fan of triangles around it that no cut edge separates.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from graben.arrays import BoolArray, IntArray, ints
from graben.errors import ModelingError
from graben.modeling.triangulation import PlanMesh
from graben.refinement import component_labels
from graben.surface import edge_sharing, edge_table


@dataclass(frozen=True, eq=False)
class CutMesh:
    """A triangulation opened along its cut.

    Parameters
    ----------
    triangles : (m, 3) array
        Indices of copies.
    origin : (n,) array
        The node of the plan mesh that each copy is of.
    labels : (m,) array
        Subdomain of each triangle.
    left, right : (e, 2) arrays
        The copies of the start and end of each cut edge on its left and on its right in plan.
    """

    triangles: IntArray
    origin: IntArray
    labels: IntArray
    left: IntArray
    right: IntArray

    def __post_init__(self) -> None:
        for key in ("triangles", "origin", "labels", "left", "right"):
            object.__setattr__(self, key, ints(getattr(self, key)))

    @cached_property
    def node_labels(self) -> IntArray:
        """The subdomain of each copy, shape (n,); -1 for a copy without triangles."""
        labels = np.full(len(self.origin), -1)
        labels[self.triangles] = self.labels[:, None]
        return ints(labels)


def opened(mesh: PlanMesh) -> CutMesh:
    """Return the triangulation with one copy of each node for every sector around it.

    The first sector keeps the node's number, further copies come after all nodes.
    """
    triangles = mesh.triangles
    m = len(triangles)
    edges, sides = edge_table(triangles)
    cut = _edge_indices(edges, mesh.cut)
    is_cut = np.zeros(len(edges), dtype=bool)
    is_cut[cut] = True
    inner = (edge_sharing(sides, len(edges)) == 2) & ~is_cut
    pairs = _side_pairs(sides, inner)
    labels = component_labels(m, pairs // 3)
    # Around every other node the triangles close: one sector.
    ends = np.zeros(len(mesh.points), dtype=bool)
    ends[edges[~inner]] = True
    corners, sectors = _corner_sectors(triangles, pairs, ends)
    new, origin = _numbered(triangles, corners, sectors, len(mesh.points))
    left, right = _lips(new, origin, sides, cut, mesh.cut)
    return CutMesh(new, origin, labels, left, right)


def _edge_indices(edges: IntArray, wanted: IntArray) -> IntArray:
    """Return the indices of the ``wanted`` (e, 2) node pairs among sorted unique ``edges``."""
    base = int(max(edges.max(initial=0), wanted.max(initial=0))) + 1
    low, high = wanted.min(axis=1), wanted.max(axis=1)
    keys = edges[:, 0] * base + edges[:, 1]
    found = np.searchsorted(keys, low * base + high)
    missing = found >= len(keys)
    missing[~missing] = keys[found[~missing]] != (low * base + high)[~missing]
    if missing.any():
        raise ModelingError(
            f"{np.count_nonzero(missing)} of {len(wanted)} edges of the cut found no place in the mesh: it "
            "runs too close to itself or to the boundary of the horizon."
        )
    return np.asarray(found, dtype=np.int64)


def _side_pairs(sides: IntArray, inner: np.ndarray) -> IntArray:
    """Return the pairs of triangle sides (3 t + k) that lie on the same inner edge, shape (p, 2)."""
    flat = sides.ravel()
    chosen = np.flatnonzero(inner[flat])
    order = chosen[np.argsort(flat[chosen], kind="stable")]
    return order.reshape(-1, 2)


def _corner_sectors(triangles: IntArray, pairs: IntArray, chosen: BoolArray) -> tuple[IntArray, IntArray]:
    """Return the corners at chosen nodes (n,), as 3 t + k ascending, and the sector of each, shapes (c,).

    A sector is corners joined across inner edges, of which ``pairs`` (p, 2) are the sides.
    """
    nodes = triangles.ravel()
    a, b, c = chosen[triangles].T
    # what is joined at a node lies in two triangles around it
    near = a | b | c
    pairs = pairs[near[pairs[:, 0] // 3]]
    t, k = pairs // 3, pairs % 3
    start, end = 3 * t + (k + 1) % 3, 3 * t + (k + 2) % 3
    turned = nodes[start[:, 0]] != nodes[start[:, 1]]
    start[turned, 1], end[turned, 1] = end[turned, 1], start[turned, 1]
    joins = np.concatenate([corner[chosen[nodes[corner[:, 0]]]] for corner in (start, end)])
    corners = np.flatnonzero(chosen[nodes])
    return corners, component_labels(len(corners), np.searchsorted(corners, joins))


def _numbered(
    triangles: IntArray, corners: IntArray, sectors: IntArray, count: int
) -> tuple[IntArray, IntArray]:
    """Return the triangles with a number for each sector, and the node each number is a copy of.

    ``corners`` (c,) and their ``sectors`` (c,) as of :func:`_corner_sectors`; all others keep their nodes.
    """
    nodes = triangles.ravel()[corners]
    unique, first, inverse = np.unique(sectors, return_index=True, return_inverse=True)
    node = nodes[first]
    order = np.lexsort((first, node))
    rank = np.zeros(len(unique), dtype=np.int64)
    sorted_nodes = node[order]
    start = np.concatenate([[True], sorted_nodes[1:] != sorted_nodes[:-1]])
    extra = order[~start]
    rank[order[start]] = sorted_nodes[start]
    rank[extra] = count + np.arange(len(extra))
    origin = np.concatenate([np.arange(count), node[extra]])
    new = triangles.ravel().copy()
    new[corners] = rank[inverse]
    return new.reshape(-1, 3), origin


def _lips(
    new: IntArray, origin: IntArray, sides: IntArray, cut: IntArray, wanted: IntArray
) -> tuple[IntArray, IntArray]:
    """Return the copies of start and end of each cut edge in the triangle on its left and on its right."""
    position = np.full(int(sides.max()) + 1, -1)
    position[cut] = np.arange(len(cut))
    t, k = np.nonzero(position[sides] >= 0)
    edge = position[sides[t, k]]
    a, b = new[t, (k + 1) % 3], new[t, (k + 2) % 3]
    # A counter-clockwise triangle that runs along the edge in its own direction lies on its left.
    forward = origin[a] == wanted[edge, 0]
    left = np.full((len(cut), 2), -1)
    right = np.full((len(cut), 2), -1)
    left[edge[forward]] = np.stack([a, b], axis=1)[forward]
    right[edge[~forward]] = np.stack([b, a], axis=1)[~forward]
    return left, right
