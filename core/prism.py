"""The closed prism over an outline in plan between two depths."""

from __future__ import annotations

from dataclasses import dataclass

import manifold3d
import numpy as np

from graben.arrays import FloatArray, IntArray
from graben.errors import ModelingError
from graben.surface import Surface, boundary_edges


@dataclass(frozen=True, eq=False)
class Prism:
    """A closed upright prism, its triangles turned outward.

    Parameters
    ----------
    surface : Surface
        The nodes of the outline at the foot, then, in the same order, at the head; x and y are those of the
        outline to the bit. First the triangles of the wall, then those of the foot, then of the head.
    wall_count : int
        How many triangles stand in the wall.
    """

    surface: Surface
    wall_count: int

    @property
    def wall(self) -> Surface:
        """The upright part of the prism: all of its vertices, the triangles over the outline."""
        solid = self.surface
        return Surface(solid.name, solid.vertices, solid.triangles[: self.wall_count])


def prism(name: str, nodes: FloatArray, edges: IntArray, low: float, high: float) -> Prism:
    """Return the closed prism over an outline.

    The arrays are made here and manifold3d says whether they bound a solid. Its own extrusion is not used:
    it rounds x and y to 8 decimals or so, and a solid made of arrays keeps them but sorts the vertices.

    Parameters
    ----------
    name : str
        Name of the surface.
    nodes : (n, 2) array
        Nodes of the outline in plan, each used by an edge, model units.
    edges : (n, 2) array
        Directed edges of the outline, its inside to the left. Several loops are parts, or holes.
    low, high : float
        Elevations of foot and head, model units.

    Returns
    -------
    Prism

    Raises
    ------
    ModelingError
        When the outline has no inside, or does not close.

    Examples
    --------
    >>> square = np.array([[0.0, 0], [2, 0], [2, 1], [0, 1]])
    >>> made = prism("box", square, np.array([[0, 1], [1, 2], [2, 3], [3, 0]]), -3.0, 0.0)
    >>> volume(made.surface)
    6.0
    """
    n = len(nodes)
    loops = _loops(edges, n)
    order = np.concatenate(loops) if loops else np.zeros(0, dtype=np.int64)
    cap = np.zeros((0, 3), dtype=np.int64)
    if loops and np.isfinite(nodes).all():
        local = nodes - nodes.mean(axis=0)  # what is thin is judged by the size of the coordinates
        turns = manifold3d.triangulate([np.ascontiguousarray(local[loop]) for loop in loops])
        cap = order[np.asarray(turns, dtype=np.int64).reshape(-1, 3)]
    a, b = edges.T
    wall = np.concatenate([np.stack([a, b, b + n], axis=1), np.stack([a, b + n, a + n], axis=1)])
    vertices = np.concatenate([np.column_stack([nodes, np.full(n, level)]) for level in (low, high)])
    made = Surface(name, vertices, np.concatenate([wall, cap[:, ::-1], cap + n]))
    if not bounds_solid(made):
        raise ModelingError(
            f"The outline of {name} with {n} nodes bounds no area in plan: it must close, turn "
            "counter-clockwise and not cross itself."
        )
    return Prism(made, len(wall))


def over(name: str, horizon: Surface, low: float, high: float) -> Prism:
    """Return the closed prism over all of a surface that covers the plan once, such as a horizon.

    ``low`` and ``high`` are the elevations of foot and head, model units. Its nodes are the boundary nodes of
    the surface, in the order of its vertices.
    """
    a, b, c = (horizon.vertices[corner, :2] for corner in horizon.triangles.T)
    u, v = b - a, c - a
    down = u[:, 0] * v[:, 1] < u[:, 1] * v[:, 0]
    if down.any():
        rim = boundary_edges(np.where(down[:, None], horizon.triangles[:, ::-1], horizon.triangles))
    else:
        rim = horizon.rim
    nodes, local = np.unique(rim, return_inverse=True)
    return prism(name, horizon.vertices[nodes, :2], local.reshape(-1, 2), low, high)


def bounds_solid(surface: Surface) -> bool:
    """Return whether a surface is closed, its triangles turned outward, and holds something (manifold3d)."""
    centre = surface.vertices.mean(axis=0) if len(surface.vertices) else np.zeros(3)
    mesh = manifold3d.Mesh64(
        np.ascontiguousarray(surface.vertices - centre), surface.triangles.astype(np.uint64)
    )
    made = manifold3d.Manifold(mesh)
    return bool(made.status() == manifold3d.Error.NoError and made.volume() > 0.0)


def volume(surface: Surface) -> float:
    """Return the volume inside a closed surface whose triangles are turned outward, cubic model units.

    V = 1/6 sum over the triangles of a . (b x c), with the corners counted from the middle of the surface.
    """
    corners = surface.vertices[surface.triangles] - surface.vertices.mean(axis=0)
    return float(np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0)


def _loops(edges: IntArray, count: int) -> list[IntArray]:
    """Return directed edges joined into closed loops of nodes; none where they do not close."""
    if (
        len(edges) == 0
        or (np.bincount(edges[:, 0], minlength=count) != np.bincount(edges[:, 1], minlength=count)).any()
    ):
        return []
    onward: list[list[int]] = [[] for _ in range(count)]
    for a, b in edges.tolist():
        onward[a].append(b)
    loops = []
    for start in range(count):
        while onward[start]:
            # As many edges leave a node as reach it, so that a walk ends only where it began.
            loop = [start]
            while (node := onward[loop[-1]].pop()) != start:
                loop.append(node)
            loops.append(np.array(loop, dtype=np.int64))
    return loops
