"""How two surfaces meet in one place, as a value."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from graben.arrays import FloatArray, IntArray


class ContactKind(StrEnum):
    """How two surfaces meet in one place."""

    CROSSING = "proper crossing"  #: in a line on which each passes through the other
    T = "T-contact"  #: the rim of one lies on the other
    LINE = "touching in a line"  #: in a line, without passing through
    POINT = "touching in a point"
    AREA = "overlap in an area"
    EDGE = "common edge"  #: in edges that both have, equal to the bit
    VERTEX = "common vertex"  #: in a vertex that both have, equal to the bit


@dataclass(frozen=True, eq=False)
class Contact:
    """One kind of contact on one connected piece of the intersection of two surfaces.

    Parameters
    ----------
    surfaces : tuple of two int
        Indices into the list that the complex was made from, the smaller first.
    piece : int
        Number of the connected piece of W_i ∩ W_j, from 0: areas first, then the longest.
    kind : ContactKind
        How they meet there.
    count : int
        Pairs of triangles that hold a stretch of a crossing; edges of a line; triangles of the first surface
        in an area; 1 for a point.
    size : float
        Length or area, model units; 0 for points.
    triangles : tuple of two (k,) arrays
        The original triangles of either surface that take part.
    places : (p, 3) array
        The middle of each path (of a closed one its highest point), the longest first; the point; the point
        of an area nearest to its middle.
    paths : tuple of (k, 3) arrays
        The lines, the longest first; they end where they fork, and a closed one ends where it begins.
    passing : float
        Length in which the surfaces pass through one another there, by no more than the contact distance:
        a rim meant to lie on the other that strays to both sides of it. 0 for other kinds.
    rims : tuple of int
        Which of the surfaces end there, where it is a T-contact.
    """

    surfaces: tuple[int, int]
    piece: int
    kind: ContactKind
    count: int
    size: float
    triangles: tuple[IntArray, IntArray]
    places: FloatArray
    paths: tuple[FloatArray, ...] = ()
    passing: float = 0.0
    rims: tuple[int, ...] = ()
