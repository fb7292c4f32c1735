"""Holes of a fault: the closed rims of a part of it other than its outer one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.surface import Surface, chained, strong_components, triangle_normals
from graben.validators.measuring.measures import ZERO_HEIGHT, lengths, remembered, welded_mesh_of

#: Least length of the mean of the unit normals along a hole, 0.7 where they lean 45 degrees from it: they
#: agree around a hole in a sheet; around the end of a pipe or of a ring fault they cancel each other.
FLAT = 0.7


@dataclass(frozen=True, eq=False)
class Opening:
    """A hole.

    Parameters
    ----------
    loop : (k + 1,) array
        Vertices along its rim, first = last.
    triangles : (k,) array
        The triangle of the surface at each edge of it.
    length : float
        Around it, model units.
    """

    loop: IntArray
    triangles: IntArray
    length: float

    @property
    def edges(self) -> int:
        """How many edges it has."""
        return len(self.triangles)


@remembered
def openings(surface: Surface) -> tuple[Opening, ...]:
    """Return the holes of a surface, the longest first.

    Of the closed rims of each part that is joined through edges, the outer one encloses the most: its vector
    area 1/2 sum p_i x p_(i+1), which is the same for every surface that it bounds, is the largest. Another
    one is a hole where the triangles along it form a sheet, see FLAT. So a pipe has none, nor has a ring
    fault steeper than 45 degrees; a crack without width is one. Vertices at one place count as one.

    Parameters
    ----------
    surface : Surface
        With finite coordinates.
    """
    mesh = welded_mesh_of(surface)
    edges, sides = mesh.edges, mesh.sides
    loops = [loop for loop in chained(edges[mesh.sharing == 1]) if loop[0] == loop[-1] and len(loop) > 2]
    if len(loops) < 2:
        return ()
    beside = np.empty(len(edges), dtype=np.int64)
    beside[sides.ravel()] = np.repeat(np.arange(len(sides)), 3)
    base = len(surface.vertices)
    keys = edges[:, 0] * base + edges[:, 1]
    part = strong_components(mesh.triangles)
    rims: dict[int, list[tuple[float, IntArray, IntArray]]] = {}
    for loop in loops:
        a, b = np.minimum(loop[:-1], loop[1:]), np.maximum(loop[:-1], loop[1:])
        along = beside[np.searchsorted(keys, a * base + b)]
        enclosed = float(np.linalg.norm(vector_area(surface.vertices[loop])))
        rims.setdefault(int(part[along[0]]), []).append((enclosed, loop, along))
    holes = []
    for own in rims.values():
        outer = int(np.argmax([enclosed for enclosed, _, _ in own]))
        for _, loop, along in own[:outer] + own[outer + 1 :]:
            if _flat(surface.vertices, mesh.triangles[along], loop):
                length = float(lengths(np.diff(surface.vertices[loop], axis=0)).sum())
                holes.append(Opening(ints(loop), ints(mesh.kept[along]), length))
    return tuple(sorted(holes, key=lambda hole: -hole.length))


def vector_area(points: FloatArray) -> FloatArray:
    """Return the vector area of a closed line, shape (3,), square model units.

    ``points`` (k + 1, 3) repeats the first at the end. The integral of the unit normal over any surface that
    the line bounds.

    >>> vector_area(np.array([[0.0, 0, 9], [1, 0, 9], [1, 1, 9], [0, 0, 9]])).tolist()
    [0.0, 0.0, 0.5]
    """
    off = points - points[0]
    return floats(0.5 * np.cross(off[:-1], off[1:]).sum(axis=0))


def _flat(vertices: FloatArray, triangles: IntArray, loop: IntArray) -> bool:
    """Return whether the triangles along a loop form a sheet, whichever way each is turned."""
    normals = triangle_normals(vertices, triangles)
    size, edge = lengths(normals), lengths(np.diff(vertices[loop], axis=0))
    # one edge of each is one of the loop: the way around says to which side a triangle lies
    turned = (triangles == loop[:-1, None]) & (np.roll(triangles, -1, axis=1) == loop[1:, None])
    sign = np.where(turned.any(axis=1), 1.0, -1.0)
    longest = lengths(vertices[triangles] - vertices[np.roll(triangles, 1, axis=1)]).max(axis=1)
    sound = size > ZERO_HEIGHT * longest**2
    weight = edge[sound]
    total = ((sign[sound] * weight / size[sound])[:, None] * normals[sound]).sum(axis=0)
    return bool(np.linalg.norm(total) >= FLAT * weight.sum())
