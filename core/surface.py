"""Triangulated surfaces in space, and what can be measured on their arrays."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints

if TYPE_CHECKING:
    import pyvista

#: Above this dip, degrees, a fault has no side towards which it dips.
_VERTICAL = 89.9


@dataclass(frozen=True, eq=False)
class Surface:
    """A triangulated surface.

    Parameters
    ----------
    name : str
        Name, unique in its model.
    vertices : (n, 3) array
        x, y and elevation (positive up), model units.
    triangles : (m, 3) array
        Vertex indices. May be unfit (out of range, repeated): the checks say so.
    lines : (m,) array, optional
        Line of each triangle in the file it was read from, 1-based; empty when unknown.
    file : Path, optional
        The file it was read from; None for a surface made in Python.

    Examples
    --------
    >>> Surface("F1", [[0, 0, 0], [1, 0, 0], [0, 1, 1]], [[0, 1, 2]])
    Surface 'F1': 3 vertices, 1 triangle
    """

    name: str
    vertices: FloatArray
    triangles: IntArray
    lines: IntArray = field(default_factory=lambda: ints([]))
    file: Path | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", floats(self.vertices, -1, 3))
        object.__setattr__(self, "triangles", ints(self.triangles, -1, 3))
        object.__setattr__(self, "lines", ints(self.lines))

    def __repr__(self) -> str:
        plural = "" if len(self.triangles) == 1 else "s"
        return f"Surface {self.name!r}: {len(self.vertices)} vertices, {len(self.triangles)} triangle{plural}"

    @cached_property
    def rim(self) -> IntArray:
        """The edges with one triangle, directed as in that triangle, shape (b, 2)."""
        return boundary_edges(self.triangles)

    @property
    def median_edge(self) -> float:
        """Median length of the sides of its fit triangles, model units; 0 without any."""
        fit = ((self.triangles >= 0) & (self.triangles < len(self.vertices))).all(axis=1)
        corners = self.vertices[self.triangles[fit]]
        corners = corners[np.isfinite(corners).all(axis=(1, 2))]
        if not len(corners):
            return 0.0
        return float(np.median(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)))

    def moved(self, offset: FloatArray) -> Surface:
        """Return the surface shifted by ``offset``, shape (3,), model units."""
        return replace(self, vertices=self.vertices + offset)

    def with_vertices(self, vertices: FloatArray) -> Surface:
        """Return the surface with other vertex positions, shape (n, 3), and the same triangles."""
        return replace(self, vertices=vertices)

    def to_pyvista(self) -> pyvista.PolyData:
        """Return the surface as ``pyvista.PolyData``."""
        import pyvista

        return pyvista.PolyData.from_regular_faces(self.vertices, self.triangles)


def triangle_normals(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the normals of the triangles, length twice the area, shape (m, 3), square model units.

    >>> triangle_normals(floats([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), ints([[0, 1, 2]])).tolist()
    [[0.0, 0.0, 1.0]]
    """
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.asarray(np.cross(b - a, c - a), dtype=np.float64)


def triangle_areas(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the areas of the triangles in space, shape (m,), square model units."""
    return np.asarray(0.5 * np.linalg.norm(triangle_normals(vertices, triangles), axis=1), dtype=np.float64)


def triangle_dips(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the dip of each triangle, shape (m,), degrees in [0, 90]; 90 where the area is zero."""
    n = triangle_normals(vertices, triangles)
    return np.asarray(np.degrees(np.arctan2(np.hypot(n[:, 0], n[:, 1]), np.abs(n[:, 2]))), dtype=np.float64)


def mean_dip_direction(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, float]:
    """Return the area-weighted mean plan direction of dip and the mean dip of a surface.

    The normals are turned to one side of the surface by their main axis, not each upwards, so that a fault
    that passes through the vertical keeps its two sides. Above 89.9 degrees, where the dip does not define
    it, the direction points to the right of the strike taken in [0, 180) degrees.

    Returns
    -------
    direction : (2,) array
        Unit vector in plan, down-dip.
    dip : float
        Degrees: the angle of the mean normal against the vertical.

    >>> direction, dip = mean_dip_direction(floats([[0, 0, 0], [0, 1, 0], [1, 0, -1]]), ints([[0, 2, 1]]))
    >>> direction.tolist(), round(dip, 6)
    ([1.0, 0.0], 45.0)
    """
    n = triangle_normals(vertices, triangles)
    size = np.linalg.norm(n, axis=1)
    n, size = n[size > 0], size[size > 0]
    if len(n) == 0:
        return floats([1.0, 0.0]), 0.0
    axis = np.linalg.eigh((n / size[:, None]).T @ n)[1][:, -1]
    mean = (n * np.where(n @ axis < 0, -1.0, 1.0)[:, None]).sum(axis=0)
    mean = -mean if mean[2] < 0 else mean
    horizontal = float(np.hypot(mean[0], mean[1]))
    if horizontal == 0.0:
        return floats([1.0, 0.0]), 0.0
    dip = float(np.degrees(np.arctan2(horizontal, mean[2])))
    direction = mean[:2] / horizontal
    if dip > _VERTICAL:
        strike = np.array([-direction[1], direction[0]])
        # In [0, 180) degrees from north, clockwise, the strike points east, or north.
        if strike[0] < 0 or (strike[0] == 0 and strike[1] < 0):
            strike = -strike
        direction = np.array([strike[1], -strike[0]])
    return floats(direction + 0.0), dip


def edge_table(triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Return the unique edges of a triangulation and the edge index of each triangle side.

    Returns
    -------
    edges : (e, 2) array
        Vertex indices, the smaller first.
    sides : (m, 3) array
        Edge opposite to each corner: side k of triangle t is ``edges[sides[t, k]]``.

    >>> edges, sides = edge_table(ints([[0, 1, 2], [2, 1, 3]]))
    >>> edges.tolist()
    [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]]
    >>> sides.tolist()
    [[2, 1, 0], [3, 4, 2]]
    """
    order, ordered, new = _ordered_sides(triangles)
    inverse = np.empty(len(order), dtype=np.int64)
    inverse[order] = np.cumsum(new) - 1
    unique, base = ordered[new], _base(triangles)
    edges = np.stack([unique // base, unique % base], axis=1)
    return ints(edges, -1, 2), ints(inverse.reshape(3, -1).T)


def _ordered_sides(triangles: IntArray) -> tuple[IntArray, IntArray, BoolArray]:
    """Return the sides of triangles (m, 3) in the order of their edges.

    Returns
    -------
    order : (3 m,) array
        The sides: k m + t is that opposite to corner k of triangle t.
    keys : (3 m,) array
        Of their edges, ascending: the smaller vertex index times :func:`_base`, plus the other.
    new : (3 m,) bool array
        Where the next edge begins.
    """
    a, b, c = triangles.T
    first, second = np.concatenate([b, c, a]), np.concatenate([c, a, b])
    keys = np.minimum(first, second) * _base(triangles) + np.maximum(first, second)
    # a stable sort uses the runs that a surface's own order has: several times as fast as np.unique there
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    new = np.ones(len(keys), dtype=bool)
    new[1:] = keys[1:] != keys[:-1]
    return order, keys, new


def _base(triangles: IntArray) -> int:
    return int(triangles.max(initial=0)) + 1


def edge_sharing(sides: IntArray, edge_count: int) -> IntArray:
    """Return how many triangles share each edge, shape (e,)."""
    return ints(np.bincount(sides.ravel(), minlength=edge_count))


def strong_components(triangles: IntArray) -> IntArray:
    """Return the strongly connected component of each triangle (paper Sect. 3.1), shape (m,).

    Two triangles are in one component when a chain of triangles that share edges joins them.

    >>> strong_components(ints([[0, 1, 2], [2, 1, 3], [3, 4, 5]])).tolist()
    [0, 0, 1]
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    m = len(triangles)
    edges, sides = edge_table(triangles)
    graph = coo_array(
        (np.ones(3 * m), (np.repeat(np.arange(m), 3), m + sides.ravel())),
        shape=(m + len(edges), m + len(edges)),
    )
    labels = connected_components(graph, directed=False)[1][:m]
    return ints(np.unique(labels, return_inverse=True)[1])


def boundary_edges(triangles: IntArray) -> IntArray:
    """Return the edges with one triangle, directed as in that triangle, shape (b, 2)."""
    order, _, new = _ordered_sides(triangles)
    alone = new.copy()
    alone[:-1] &= new[1:]
    k, t = np.divmod(order[alone], max(len(triangles), 1))
    as_given = np.argsort(3 * t + k)
    k, t = k[as_given], t[as_given]
    return ints(np.stack([triangles[t, (k + 1) % 3], triangles[t, (k + 2) % 3]], axis=1), -1, 2)


def chained(edges: IntArray) -> list[IntArray]:
    """Return undirected edges joined into chains that end at vertices of degree other than 2.

    Parameters
    ----------
    edges : (e, 2) array
        Vertex indices.

    Returns
    -------
    list of (k,) arrays
        Vertex indices along each chain; a closed loop repeats its first vertex at the end. The order
        depends on the vertex indices alone.
    """
    if len(edges) == 0:
        return []
    nodes, flat = np.unique(edges, return_inverse=True)
    local = flat.reshape(-1, 2)
    around: list[list[tuple[int, int]]] = [[] for _ in nodes]
    for e, (a, b) in enumerate(local.tolist()):
        around[a].append((b, e))
        around[b].append((a, e))
    used = np.zeros(len(edges), dtype=bool)

    def walk(start: int, step: tuple[int, int]) -> IntArray:
        chain = [start]
        node, e = step
        while True:
            used[e] = True
            chain.append(node)
            onward = [s for s in around[node] if not used[s[1]]]
            if len(around[node]) != 2 or not onward:
                return ints(nodes[chain])
            node, e = onward[0]

    ends = [n for n in range(len(nodes)) if len(around[n]) != 2]
    chains = [walk(n, s) for n in ends for s in sorted(around[n]) if not used[s[1]]]
    chains += [walk(n, min(around[n])) for n in range(len(nodes)) if not all(used[s[1]] for s in around[n])]
    return chains


def boundary_loops(triangles: IntArray) -> list[IntArray]:
    """Return the boundary of a triangulation as chains of vertex indices, longest (in vertices) first."""
    return sorted(chained(boundary_edges(triangles)), key=len, reverse=True)
