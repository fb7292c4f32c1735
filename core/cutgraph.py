"""The cut graph of a horizon (paper Sect. 3.3) as a value."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import IntEnum

from graben.arrays import FloatArray, IntArray, floats, ints


class NodeKind(IntEnum):
    """What a node of the cut graph is (paper Sect. 4, Table 1)."""

    INTERIOR = 0  #: on one fault, two edges
    TIP = 1  #: an end on the rim of its fault, inside the horizon
    EXIT = 2  #: an end on the outer boundary of the horizon
    JUNCTION = 3  #: where faults meet
    LOOSE = 4  #: an end that lies nowhere: not on the rim, on another fault or on the outer boundary


@dataclass(frozen=True, eq=False)
class DroppedTrace:
    """A piece of U ∩ W_i left out of the cut graph: fault index, plan length, middle (3,) and why."""

    fault: int
    length: float
    place: FloatArray
    reason: str


@dataclass(frozen=True, eq=False)
class CutGraph:
    """G = U ∩ (W_1 ∪ … ∪ W_N), resampled.

    Parameters
    ----------
    horizon : str
        Name of the horizon.
    nodes : (n, 3) array
        On the horizon and on their faults, model units.
    kinds : (n,) array
        :class:`NodeKind` of each node.
    edges : (e, 2) array
        Node indices, directed so that the edge's fault dips to the right of the way in plan.
    faults : (e,) array
        Index of the fault of each edge in the model.
    dropped : tuple of DroppedTrace
        Pieces left out.
    filled : (k, 3) array
        Undefined nodes of the horizon that were filled before it was traced, model units.
    """

    horizon: str
    nodes: FloatArray
    kinds: IntArray
    edges: IntArray
    faults: IntArray
    dropped: tuple[DroppedTrace, ...] = field(default=())
    filled: FloatArray = field(default_factory=lambda: floats([], 0, 3))

    def __post_init__(self) -> None:
        object.__setattr__(self, "nodes", floats(self.nodes, -1, 3))
        object.__setattr__(self, "kinds", ints(self.kinds))
        object.__setattr__(self, "edges", ints(self.edges, -1, 2))
        object.__setattr__(self, "faults", ints(self.faults))
        object.__setattr__(self, "filled", floats(self.filled, -1, 3))

    def moved(self, offset: FloatArray) -> CutGraph:
        """Return the graph shifted by ``offset``, shape (3,)."""
        dropped = tuple(replace(d, place=floats(d.place + offset)) for d in self.dropped)
        return replace(self, nodes=self.nodes + offset, dropped=dropped, filled=self.filled + offset)
