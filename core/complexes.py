"""One simplicial complex of several surfaces (paper Sect. 3.2, condition 1), as a value."""

from __future__ import annotations

from dataclasses import dataclass

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.surface import edge_table


@dataclass(frozen=True, eq=False)
class Complex:
    """Surfaces refined along their intersections: shared vertices are shared by index.

    Parameters
    ----------
    vertices : (n, 3) array
        Model units.
    triangles : (m, 3) array
        Vertex indices.
    owner : (m,) array
        Surface of each triangle: index into the list the complex was made from.
    parent : (m,) array
        Triangle of that surface which each triangle is a part of.
    """

    vertices: FloatArray
    triangles: IntArray
    owner: IntArray
    parent: IntArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", floats(self.vertices, -1, 3))
        object.__setattr__(self, "triangles", ints(self.triangles, -1, 3))
        object.__setattr__(self, "owner", ints(self.owner))
        object.__setattr__(self, "parent", ints(self.parent))

    def edges(self) -> tuple[IntArray, IntArray]:
        """Return ``edges`` (e, 2) and ``sides`` (m, 3), see :func:`graben.surface.edge_table`."""
        return edge_table(self.triangles)
