"""pairwise-connected: two faults meet in nothing or in one connected polyline (Sect. 3.2, condition 2)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.finding import Element, Part
from graben.validators.context import Check, CheckContext, Defect, Need, Scope
from graben.validators.measuring.contact import Contact, ContactKind
from graben.validators.measuring.measures import amount, components, part_at
from graben.words import plural

#: Ends of lines that are one place, and how near an end comes to another line to lie on it, in contact
#: distances: what lies between two kinds of contact is counted to neither.
_ONE = 100.0
#: Lines that are too short to fork or to close, in contact distances.
_SHORT = 4.0 * _ONE
#: Pieces that a message names one by one.
_NAMED = 3


def _run(context: CheckContext) -> list[Defect]:
    by_pair = groupby(context.evidence.contacts, key=lambda c: c.surfaces)
    found = [_judged(context, list(contacts)) for _, contacts in by_pair]
    return [d for d in found if d is not None]


def _judged(context: CheckContext, contacts: Sequence[Contact]) -> Defect | None:
    """Return what is wrong with how two faults meet; None for one connected polyline."""
    first, second = (context.model.faults[k].name for k in contacts[0].surfaces)
    title = f"{first} and {second}"
    pieces = [list(same) for _, same in groupby(contacts, key=lambda c: c.piece)]
    parts = tuple(_part(piece, context.unit) for piece in pieces)
    areas = [c for c in contacts if c.kind is ContactKind.AREA]
    if areas:
        size = amount(sum(c.size for c in areas), parts[0].unit)
        more = f"; they meet in {len(pieces)} pieces in all" if len(pieces) > len(areas) else ""
        return _defect(
            contacts,
            (first, second),
            f"{title} coincide over an area of {size}{more}.",
            "Take the common part out of one of the two, or keep only one of them.",
            parts,
            worst=parts[0],
            blocks=True,
        )
    if len(pieces) > 1:
        return _defect(
            contacts,
            (first, second),
            f"{title} meet in {len(pieces)} pieces: {_named(parts)}.",
            "Cut the smaller pieces away, split the fault that bends, or move one so that they meet once.",
            parts,
            worst=parts[1],
        )
    if parts[0].kind == "point":
        return _defect(
            contacts,
            (first, second),
            f"{title} touch in a single point.",
            "Move one of the two so that they cross in a line or stay apart.",
            parts,
            worst=parts[0],
        )
    forks, rings = _shape(pieces[0], context.contact)
    knots = [part_at("fork", degree, place) for place, degree in forks]
    knots += [
        part_at("closed line", 1, ring[np.argmax(ring[:, 2])], _length(ring), context.unit) for ring in rings
    ]
    if not knots:
        return None
    what = f"forks at {plural(len(forks), 'point')}" if forks else "is closed"
    return _defect(
        contacts,
        (first, second),
        f"The line in which {title} meet {what}.",
        "Cut one of the two so that they meet in one line from end to end.",
        (*knots, *parts),
        worst=knots[0],
    )


def _part(piece: Sequence[Contact], unit: str) -> Part:
    """Return a connected piece with its dimension."""
    first = piece[0]
    if first.kind is ContactKind.AREA:
        return part_at("area", first.count, first.places[0], first.size, f"{unit}²" if unit else "")
    if first.kind in (ContactKind.POINT, ContactKind.VERTEX):
        return part_at("point", 1, first.places[0], 0.0, unit)
    return part_at("line", sum(c.count for c in piece), first.places[0], sum(c.size for c in piece), unit)


def _named(parts: Sequence[Part]) -> str:
    """Return pieces in words, the largest ones by themselves."""
    words = [
        "a point" if p.kind == "point" else f"a {p.kind} of {amount(p.value or 0.0, p.unit)}"
        for p in parts[:_NAMED]
    ]
    rest = len(parts) - len(words)
    words += [f"{rest} smaller"] if rest else []
    return f"{', '.join(words[:-1])} and {words[-1]}"


def _shape(piece: Sequence[Contact], contact: float) -> tuple[list[tuple[FloatArray, int]], list[FloatArray]]:
    """Return the forks of a piece, as places with the number of their branches, and its closed lines."""
    paths = [path for c in piece for path in c.paths if _length(path) > _SHORT * contact]
    rings = [p for p in paths if np.array_equal(p[0], p[-1])]
    paths = [p for p in paths if not np.array_equal(p[0], p[-1])]
    if not paths:
        return [], rings
    ends = np.concatenate([p[[0, -1]] for p in paths])
    onward = np.array([_along(q, _SHORT * contact) for p in paths for q in (p, p[::-1])])
    node = _together(ends, _ONE * contact)
    forks = []
    for k in np.flatnonzero(np.bincount(node) > 2):
        # lines that run on side by side are one
        branches = int(_together(onward[node == k], _ONE * contact).max()) + 1
        if branches > 2:
            forks.append((ends[np.argmax(node == k)], branches))
    # in a connected part with as many lines as ends of lines one comes round
    part = components(int(node.max()) + 1, node.reshape(-1, 2))
    lines = np.bincount(part[node[::2]], minlength=part.max() + 1)
    closed = np.flatnonzero((lines >= np.bincount(part)) & (not forks))
    return forks, rings + [paths[int(np.argmax(part[node[::2]] == k))] for k in closed]


def _together(points: FloatArray, reach: float) -> IntArray:
    """Return the number of the group of each point, those within ``reach`` of each other joined."""
    return components(len(points), cKDTree(points).query_pairs(reach, output_type="ndarray"))


def _along(path: FloatArray, distance: float) -> FloatArray:
    """Return the point of a polyline that lies a distance from its begin."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    return np.array([np.interp(distance, way, path[:, k]) for k in range(3)])


def _length(path: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def _defect(
    contacts: Sequence[Contact],
    objects: tuple[str, str],
    message: str,
    remedy: str,
    parts: tuple[Part, ...],
    *,
    worst: Part,
    blocks: bool = False,
) -> Defect:
    return Defect(
        objects,
        message,
        remedy,
        count=len(parts),
        value=worst.value if worst.value is not None else float(worst.count),
        unit=worst.unit if worst.value is not None else "branches",
        place=floats(worst.place),
        elements=ints(np.unique(np.concatenate([c.triangles[0] for c in contacts]))),
        element=Element.TRIANGLE,
        places=floats([p.place for p in parts]),
        paths=tuple(path for c in contacts for path in c.paths),
        parts=parts,
        blocks=blocks,
    )


CHECK = Check(
    "pairwise-connected",
    "3.2, condition 2",
    "Two faults meet in nothing or in one connected polyline.",
    "A junction moves along the line in which two faults meet: from one piece of it no way leads to the "
    "next, and a point or an area is no way at all.",
    _run,
    need=Need.COMPLEX,
    scope=Scope.MODEL,
    blocks_when="faults that coincide over an area",
    repairable=True,
)
