"""What repair did to each fault: how far its vertices moved, what was added to it and what was cut off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from graben.arrays import BoolArray, FloatArray, bools, floats, ints
from graben.cleaning.ledger import Measures, measured
from graben.cleaning.shaping.limits import joined
from graben.proximity import nearest
from graben.reports.shapes import usable
from graben.surface import Surface, boundary_edges, triangle_normals

if TYPE_CHECKING:
    from graben.repairs import RepairResult

#: What lies off a rim counts as beyond it where it leaves the surface at less than this sine: 45 degrees.
_FLAT = float(np.sqrt(0.5))
#: Distances that are equal but for rounding; what counts as none, last digits of the coordinates.
_ROUNDING, _ULPS = 1e-9, 16.0
#: What lies beyond a rim by less than this share of the median edge is a moved vertex, no addition.
_LEAST = 0.01


@dataclass(frozen=True, eq=False)
class FaultChange:
    """One fault before and after repair.

    Parameters
    ----------
    name : str
        Its name in the result; that of the input where it was left out.
    source : str
        The fault of the input that it came from.
    given, made : Surface or None
        The surfaces, usable triangles alone; ``made`` is None for a fault that was left out.
    before, after : Measures or None
        Of both.
    changed : bool
        Whether anything is different.
    moves : (n,) array
        Distance of each vertex of ``made`` from ``given``, model units.
    beyond : (n,) array of bool
        Whether a vertex lies beyond the rim of ``given``: it was added, not moved.
    added : (m,) array of bool
        Whether the middle of a triangle of ``made`` lies beyond the rim of ``given``.
    extended : float
        How far ``made`` reaches beyond ``given``, at vertices and middles of triangles, model units.
    cut_back : float
        How far ``given`` reaches beyond what was made of it, model units.
    """

    name: str
    source: str
    given: Surface
    made: Surface | None
    before: Measures
    after: Measures | None
    changed: bool
    moves: FloatArray
    beyond: BoolArray
    added: BoolArray
    extended: float
    cut_back: float

    @property
    def largest_move(self) -> float:
        """The largest distance of a vertex that was not added, model units."""
        return float(self.moves[~self.beyond].max(initial=0.0))

    @property
    def mean_move(self) -> float:
        """The mean distance of the vertices that were not added, model units."""
        own = self.moves[~self.beyond]
        return float(own.mean()) if len(own) else 0.0

    @property
    def largest_at(self) -> FloatArray | None:
        """Where the largest move is, else where most was added; None where neither is."""
        for own in (~self.beyond, self.beyond):
            if self.made is not None and self.moves[own].max(initial=0.0) > 0:
                return floats(self.made.vertices[own][np.argmax(self.moves[own])])
        return None


def fault_changes(result: RepairResult) -> tuple[FaultChange, ...]:
    """Return what became of each fault, in the order of the result; those left out stand last."""
    given = {f.name: f.surface for f in result.input.faults}
    parts: dict[str, list[Surface]] = {}
    for fault in result.model.faults:
        parts.setdefault(_source(result, fault.name), []).append(fault.surface)
    changes = []
    for fault in result.model.faults:
        source = _source(result, fault.name)
        changes.append(_change(given[source], fault.surface, parts[source], source))
    for name, surface in given.items():
        if name not in parts:
            changes.append(_still(surface, name, name, None, changed=True))
    return tuple(changes)


def _source(result: RepairResult, name: str) -> str:
    return result.lineage.get(name, name)


def _change(given: Surface, made: Surface, parts: Sequence[Surface], source: str) -> FaultChange:
    if made is given or _equal(given, made):
        return _still(given, made.name, source, usable(made), changed=False)
    old, new = usable(given), usable(made)
    moves, beyond = compared(new.vertices, old)
    # middles as well: triangles can come and go while their corners stay
    away, added = compared(_middles(new), old)
    more = max(float(d[b].max(initial=0.0)) for d, b in ((moves, beyond), (away, added)))
    lost, off = compared(floats(np.concatenate([old.vertices, _middles(old)])), usable(_whole(parts)))
    return FaultChange(
        made.name,
        source,
        old,
        new,
        measured(given),
        measured(made),
        True,
        moves,
        beyond,
        added,
        more,
        float(lost[off].max(initial=0.0)),
    )


def _still(given: Surface, name: str, source: str, made: Surface | None, *, changed: bool) -> FaultChange:
    """Return a fault that stayed as it was, or was left out."""
    zeros, none = np.zeros(len(made.vertices) if made else 0), np.zeros(len(made.triangles) if made else 0)
    before = measured(given)
    after = None if made is None else before
    moves, added = floats(zeros), bools(none > 0)
    return FaultChange(
        name, source, usable(given), made, before, after, changed, moves, bools(zeros > 0), added, 0.0, 0.0
    )


def _middles(surface: Surface) -> FloatArray:
    """Return the middles of the triangles, shape (m, 3)."""
    return floats(surface.vertices[surface.triangles].mean(axis=1), -1, 3)


def _whole(parts: Sequence[Surface]) -> Surface:
    """Return parts as one surface: where they were split is no rim of it."""
    whole = reduce(joined, parts)
    if len(parts) == 1:
        return whole
    vertices, index = np.unique(whole.vertices, axis=0, return_inverse=True)
    known = (whole.triangles >= 0) & (whole.triangles < len(whole.vertices))
    triangles = np.where(known, index.reshape(-1)[np.where(known, whole.triangles, 0)], -1)
    return replace(whole, vertices=floats(vertices), triangles=ints(triangles))


def _equal(one: Surface, other: Surface) -> bool:
    return (
        one.name == other.name
        and np.array_equal(one.vertices, other.vertices, equal_nan=True)
        and np.array_equal(one.triangles, other.triangles)
    )


def compared(points: FloatArray, reference: Surface) -> tuple[FloatArray, BoolArray]:
    """Return how far points lie from a surface, and whether they lie beyond its rim rather than off it.

    Parameters
    ----------
    points : (n, 3) array
        Places, model units.
    reference : Surface
        Usable triangles alone.

    Returns
    -------
    distance : (n,) array
        Model units; 0 where it is no more than rounding.
    beyond : (n,) array of bool
        The nearest place is on the rim, and the way from there leaves the surface at less than 45 degrees.
    """
    count = len(points)
    if not count or not len(reference.triangles):
        return floats(np.zeros(count)), bools(np.zeros(count, dtype=np.bool_))
    # Large coordinates first lose their offset, which would cost digits of small distances.
    origin = np.round(reference.vertices.mean(axis=0))
    own, other = points - origin, reference.moved(-origin)
    found = nearest(own, other.vertices, other.triangles)
    noise = _ULPS * float(np.spacing(np.abs(reference.vertices).max(initial=1.0)))
    away = np.where(found.distance <= noise, 0.0, found.distance)
    beyond = np.zeros(count, dtype=np.bool_)
    rim = boundary_edges(other.triangles)
    off = np.flatnonzero(away > _LEAST * reference.median_edge)
    if len(off) and len(rim):
        to_rim = nearest(own[off], other.vertices, ints(rim)).distance
        on_rim = to_rim <= away[off] * (1.0 + _ROUNDING) + noise
        normals = triangle_normals(other.vertices, other.triangles)[found.simplex[off]]
        rise = np.abs(((own[off] - found.place[off]) * normals).sum(axis=1))
        beyond[off] = on_rim & (rise < _FLAT * away[off] * np.linalg.norm(normals, axis=1))
    return floats(away), bools(beyond)
