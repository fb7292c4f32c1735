"""What is known along the cutoffs beside their lips: dip, sense, nodes; and one line for each fault."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import pairwise

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.cutgraph import CutGraph, NodeKind
from graben.modeling.cutoffs import paths
from graben.modeling.results import Cutoff, HorizonResult
from graben.proximity import nearest
from graben.surface import Surface, mean_dip_direction, triangle_normals

#: Throws below this share of the largest of their fault cannot be told from none: rebuilt throws of the
#: models with a known answer are off by 1 to 7 % of it (docs/results.md).
TOLD = 0.05


class Sense(StrEnum):
    """Which way a fault moved, as far as throw tells: strike-slip leaves none."""

    NORMAL = "normal"
    REVERSE = "reverse"
    BOTH = "normal and reverse"
    NONE = "none"


@dataclass(frozen=True, eq=False)
class Along:
    """What stands along one cutoff beside its lips, k rows.

    Parameters
    ----------
    cutoff : Cutoff
        The pair of lips.
    piece : int
        Number of the piece of its fault on this horizon, from 1.
    kinds : (k,) array
        :class:`NodeKind` of the node of the cut graph that each row came from.
    dip : (k, 2) array
        Dip of the fault at the hanging and at the foot lip, degrees, 0 to 90.
    azimuth : (k, 2) array
        Direction of dip there, degrees clockwise from north, 0 to 360.
    """

    cutoff: Cutoff
    piece: int
    kinds: IntArray
    dip: FloatArray
    azimuth: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "kinds", ints(self.kinds))
        object.__setattr__(self, "dip", floats(self.dip, -1, 2))
        object.__setattr__(self, "azimuth", floats(self.azimuth, -1, 2))

    @property
    def middle(self) -> FloatArray:
        """The place halfway between the two lips, (k, 3)."""
        return floats((self.cutoff.hanging + self.cutoff.foot) / 2.0)

    def senses(self, least: float) -> list[Sense]:
        """Return the sense of each row; throws up to ``least``, model units, are none."""
        signs = np.sign(np.where(np.abs(self.cutoff.throw) <= least, 0.0, self.cutoff.throw))
        return [(Sense.REVERSE, Sense.NONE, Sense.NORMAL)[int(sign) + 1] for sign in signs]

    def stretches(self) -> list[slice]:
        """Return the rows between junctions: at one, throw may jump, and s repeats."""
        return stretches(self.cutoff)


def stretches(cutoff: Cutoff) -> list[slice]:
    """Return the rows of a cutoff between its junctions, at which s repeats."""
    breaks = np.flatnonzero(np.diff(cutoff.s) <= 0.0) + 1
    stops = [0, *breaks.tolist(), len(cutoff.s)]
    return [slice(a, b) for a, b in pairwise(stops)]


def along(result: HorizonResult, faults: Sequence[Surface]) -> tuple[Along, ...]:
    """Return what stands along each cutoff of a rebuilt horizon, in the order of ``result.cutoffs``.

    Parameters
    ----------
    result : HorizonResult
        A rebuilt horizon.
    faults : sequence of Surface
        The faults it was rebuilt with; those that do not cut it are passed over.
    """
    named = {f.name: f for f in faults}
    # Far from the origin, squared distances would cost the digits that tell triangles apart.
    origin = {name: f.vertices.mean(axis=0) for name, f in named.items() if len(f.vertices)}
    count: dict[str, int] = {}
    found = []
    for cutoff, nodes in zip(result.cutoffs, _nodes(result.graph, result.cutoffs), strict=True):
        count[cutoff.fault] = count.get(cutoff.fault, 0) + 1
        fault, offset = named[cutoff.fault], origin[cutoff.fault]
        local = fault.moved(-offset)
        lips = [_attitude(local, lip - offset) for lip in (cutoff.hanging, cutoff.foot)]
        dip, azimuth = (np.stack([lip[k] for lip in lips], axis=1) for k in (0, 1))
        found.append(Along(cutoff, count[cutoff.fault], result.graph.kinds[nodes], dip, azimuth))
    return tuple(found)


def _nodes(graph: CutGraph, cutoffs: Sequence[Cutoff]) -> list[IntArray]:
    """Return the node of the cut graph that each row of each cutoff came from."""
    found: list[IntArray] = []
    for f in np.unique(graph.faults):
        edges = graph.edges[graph.faults == f]
        for path in paths(edges):
            nodes = np.append(edges[path, 0], edges[path[-1], 1])
            cutoff = cutoffs[len(found)]
            # At a junction rows share a node, and its s.
            found.append(ints(nodes[np.cumsum(np.append(0, np.diff(cutoff.s) > 0.0))]))
    return found


def _attitude(fault: Surface, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return dip and direction of dip of a fault next to points (k, 3), degrees, (k,) each.

    Between the vertices, whose normals are those of their triangles by area, the normal is interpolated: so
    there is one dip on an edge as well.
    """
    vertices, triangles = fault.vertices, fault.triangles
    (dx, dy), dip = mean_dip_direction(vertices, triangles)
    c, s = np.cos(np.radians(dip)), np.sin(np.radians(dip))
    normals = triangle_normals(vertices, triangles)
    # To the side of the mean normal: a fault that passes through the vertical keeps its sides.
    normals = normals * np.where(normals @ [dx * s, dy * s, c] < 0, -1.0, 1.0)[:, None]
    whole = np.zeros_like(vertices)
    np.add.at(whole, triangles.ravel(), np.repeat(normals, 3, axis=0))
    near = nearest(points, vertices, triangles)
    corners = triangles[near.simplex]
    normal = (_shares(near.place, vertices[corners])[:, :, None] * whole[corners]).sum(axis=1)
    normal = normal * np.where(normal[:, 2:] < 0, -1.0, 1.0)
    level = np.hypot(normal[:, 0], normal[:, 1])
    azimuth = np.degrees(np.arctan2(normal[:, 0], normal[:, 1])) % 360.0
    return floats(np.degrees(np.arctan2(level, normal[:, 2]))), floats(azimuth)


def _shares(places: FloatArray, corners: FloatArray) -> FloatArray:
    """Return the barycentric coordinates, (k, 3), of places (k, 3) in triangles, corners (k, 3, 3)."""
    to = corners - places[:, None]
    opposite = np.linalg.norm(np.cross(np.roll(to, -1, axis=1), np.roll(to, -2, axis=1)), axis=2)
    return floats(opposite / np.maximum(opposite.sum(axis=1, keepdims=True), np.finfo(np.float64).tiny))


@dataclass(frozen=True, eq=False)
class FaultThrow:
    """One fault on one horizon in numbers.

    Parameters
    ----------
    horizon, fault : str
        Names.
    pieces : int
        Pieces of its trace.
    ends : tuple of str
        What the ends of the pieces are, in their order: tip, exit, junction or loose.
    length : float
        Plan length of the trace, all pieces, model units.
    throw : float
        Throw of largest magnitude, with its sign, model units.
    heave : float
        Heave of largest magnitude, with its sign, model units.
    place : (3,) array
        Where the throw is largest, halfway between the lips.
    mean : float
        Mean magnitude of the throw along the trace, model units.
    dip : float
        Mean dip of the fault along its cutoffs, degrees.
    sense : Sense
        Which way it moved.
    changes : (c, 3) array
        Places between which the sense changes along strike, halfway between the lips.
    """

    horizon: str
    fault: str
    pieces: int
    ends: tuple[str, ...]
    length: float
    throw: float
    heave: float
    place: FloatArray
    mean: float
    dip: float
    sense: Sense
    changes: FloatArray

    @property
    def ratio(self) -> float:
        """Largest throw over length.

        Faults that end at tips on both sides have 0.001 to 0.1 of displacement in most collections
        (Y.-S. Kim and D. J. Sanderson, Earth-Science Reviews 68, 2005).
        """
        return abs(self.throw) / self.length if self.length > 0 else 0.0

    def moved(self, offset: FloatArray) -> FaultThrow:
        """Return the same with its places shifted by ``offset``, shape (3,)."""
        return replace(self, place=floats(self.place + offset), changes=floats(self.changes + offset, -1, 3))


def told_from(largest: float, tolerance: float, noise: float | None = None) -> float:
    """Return the throw below which there is none to speak of on a fault, model units.

    Parameters
    ----------
    largest : float
        The largest magnitude on the fault, model units.
    tolerance : float
        At which the iteration ended, model units.
    noise : float, optional
        Standard deviation of the input, model units: lips inherit it.
    """
    return max(TOLD * largest, tolerance, noise or 0.0)


def fault_throws(
    result: HorizonResult, faults: Sequence[Surface], tolerance: float
) -> tuple[FaultThrow, ...]:
    """Return every fault that cuts a rebuilt horizon in numbers, in the order of its cutoffs.

    Parameters
    ----------
    result : HorizonResult
        A rebuilt horizon.
    faults : sequence of Surface
        The faults it was rebuilt with.
    tolerance : float
        At which the iteration ended, model units.
    """
    lines = along(result, faults)
    names = dict.fromkeys(a.cutoff.fault for a in lines)
    return tuple(
        _fault_throw(result, name, [a for a in lines if a.cutoff.fault == name], tolerance) for name in names
    )


def _fault_throw(result: HorizonResult, name: str, lines: Sequence[Along], tolerance: float) -> FaultThrow:
    throw, heave = (np.concatenate([getattr(a.cutoff, key) for a in lines]) for key in ("throw", "heave"))
    share = np.concatenate([_lengths(a.cutoff.s) for a in lines])
    length = float(share.sum())
    weights = share if length > 0 else np.ones_like(share)
    row = int(np.argmax(np.abs(throw)))
    least = told_from(float(np.abs(throw[row])), tolerance, result.horizon.noise)
    changes = [a.middle[k : k + 2].mean(axis=0) for a in lines for k in sign_changes(a.cutoff.throw, least)]
    return FaultThrow(
        horizon=result.name,
        fault=name,
        pieces=len(lines),
        ends=tuple(NodeKind(int(a.kinds[k])).name.lower() for a in lines for k in (0, -1)),
        length=length,
        throw=float(throw[row]),
        heave=float(heave[np.argmax(np.abs(heave))]),
        place=floats(np.concatenate([a.middle for a in lines])[row]),
        mean=float(np.average(np.abs(throw), weights=weights)),
        dip=float(np.average(np.concatenate([a.dip.mean(axis=1) for a in lines]), weights=weights)),
        sense=_sense(throw, least),
        changes=floats(changes, -1, 3),
    )


def _lengths(s: FloatArray) -> FloatArray:
    """Return the length of the trace that each row stands for; they add up to that of the trace."""
    half = np.diff(s) / 2.0
    return floats(np.append(half, 0.0) + np.append(0.0, half))


def _sense(throw: FloatArray, least: float) -> Sense:
    normal, reverse = bool((throw > least).any()), bool((throw < -least).any())
    if normal and reverse:
        return Sense.BOTH
    return Sense.NORMAL if normal else Sense.REVERSE if reverse else Sense.NONE


def sign_changes(throw: FloatArray, least: float) -> IntArray:
    """Return the rows after which throw changes its sign, passing over magnitudes up to ``least``.

    >>> sign_changes(floats([5, 8, 1, -1, -7, -9]), 2.0).tolist()
    [2]
    """
    clear = np.flatnonzero(np.abs(throw) > least)
    turns = np.flatnonzero(np.diff(np.sign(throw[clear])) != 0)
    return ints([_zero(throw, int(clear[t]), int(clear[t + 1])) for t in turns])


def _zero(throw: FloatArray, first: int, last: int) -> int:
    """Return the row between two of opposite sign after which throw crosses zero."""
    signs: BoolArray = throw[first : last + 1] * throw[first] > 0
    return first + int(np.flatnonzero(~signs)[0]) - 1
