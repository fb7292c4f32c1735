"""The ledger: every change a repair made, with its reason, and what was left, with the reason for that."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from graben.arrays import FloatArray, bools, ints
from graben.finding import CheckResult, Finding, Status
from graben.surface import Surface, boundary_edges, mean_dip_direction, strong_components, triangle_areas
from graben.validators.finite import usable


@dataclass(frozen=True)
class Measures:
    """What a fault measures at one time.

    Parameters
    ----------
    name : str
        The fault.
    vertices, triangles, components : int
        Counts; components are joined through edges.
    area : float
        Square model units.
    rim : float
        Length of all its edges with one triangle, model units.
    dip : float
        Angle of the mean normal against the vertical, degrees.
    """

    name: str
    vertices: int
    triangles: int
    components: int
    area: float
    rim: float
    dip: float


def measured(surface: Surface) -> Measures:
    """Return the measures of a surface; triangles without three finite corners do not count."""
    t = surface.triangles
    inside = np.flatnonzero(((t >= 0) & (t < len(surface.vertices))).all(axis=1))
    place = bools(usable(surface.vertices).all(axis=1))
    t = ints(t[inside[place[t[inside]].all(axis=1)]], -1, 3)
    ends = surface.vertices[boundary_edges(t)] if len(t) else np.zeros((0, 2, 3))
    return Measures(
        surface.name,
        len(surface.vertices),
        len(surface.triangles),
        int(strong_components(t).max(initial=-1)) + 1 if len(t) else 0,
        float(triangle_areas(surface.vertices, t).sum()),
        float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()),
        mean_dip_direction(surface.vertices, t)[1] if len(t) else 0.0,
    )


@dataclass(frozen=True)
class RepairAction:
    """One change.

    Parameters
    ----------
    action : str
        Id of the repair.
    check : str
        Id of the check whose finding it answers.
    objects : tuple of str
        Names of the surfaces changed.
    count : int
        How many elements were changed.
    max_move : float
        The largest distance of a vertex of these surfaces from what they were before this change and what was
        added to them on purpose, model units.
    place : (x, y, z) or None
        One place of the change, elevation.
    reason : str
        One sentence.
    size, unit : float or None, str
        How much, where that is not a move of vertices: the length of an extension or of a trim, an area.
    before, after : tuple of Measures
        Of the faults that the change replaced, and of those that took their place.
    """

    action: str
    check: str
    objects: tuple[str, ...]
    count: int
    max_move: float
    place: tuple[float, float, float] | None
    reason: str
    size: float | None = None
    unit: str = ""
    before: tuple[Measures, ...] = ()
    after: tuple[Measures, ...] = ()

    def moved(self, offset: FloatArray) -> RepairAction:
        """Return the action with its place moved by ``offset``, shape (3,), model units."""
        return replace(self, place=_moved(self.place, offset))


@dataclass(frozen=True)
class Left:
    """A finding that repair left, or a part of one, and why.

    Parameters
    ----------
    check : str
        Id of its check.
    objects : tuple of str
        Names of the surfaces concerned.
    action : str
        Id of the repair that looked at it; empty where there is none for it.
    place : (x, y, z) or None
        Where, elevation.
    reason : str
        One sentence: why it is left.
    advice : str
        One sentence: what a person should do.
    needed, unit : float or None, str
        How much more of a limit it would take.
    """

    check: str
    objects: tuple[str, ...]
    action: str
    place: tuple[float, float, float] | None
    reason: str
    advice: str
    needed: float | None = None
    unit: str = ""

    def moved(self, offset: FloatArray) -> Left:
        """Return the note with its place moved by ``offset``, shape (3,), model units."""
        return replace(self, place=_moved(self.place, offset))


def left_over(
    result: CheckResult, noted: Iterable[Left], answered: Mapping[str, Sequence[str]]
) -> tuple[Left, ...]:
    """Return what is left of a repaired model: every finding that fails, and warnings that a repair refused.

    Parameters
    ----------
    result : CheckResult
        Of the repaired model.
    noted : iterable of Left
        What repairs left on the way; notes on what is no longer found are dropped.
    answered : mapping of str to sequence of str
        By the check: the repairs that answer it.
    """
    notes: dict[tuple[str, tuple[str, ...]], list[Left]] = {}
    for note in noted:
        notes.setdefault((note.check, note.objects), []).append(note)
    found: list[Left] = []
    for finding in result.findings:
        if finding.status not in (Status.FAIL, Status.WARN):
            continue
        own = notes.get((finding.check, finding.objects), [])
        if not own and finding.status is Status.FAIL:
            asked = " and ".join(answered.get(finding.check, ()))
            why = "No repair answers this."
            if asked:
                why = f"Nothing that {asked} can do within max_move and max_extension takes this away."
            own = [Left(finding.check, finding.objects, "", None, why, "")]
        found += [_completed(note, finding) for note in own]
    return tuple(found)


def _completed(note: Left, finding: Finding) -> Left:
    """Return a note with the place and the remedy of its finding where it has none of its own."""
    worst = finding.worst
    place = note.place or (None if worst is None else (worst.x, worst.y, worst.z))
    return replace(note, place=place, advice=note.advice or finding.remedy)


def place_of(point: FloatArray | None) -> tuple[float, float, float] | None:
    """Return a point (3,) as the ledger has it."""
    if point is None:
        return None
    x, y, z = (float(c) for c in point)
    return x, y, z


def _moved(place: tuple[float, float, float] | None, offset: FloatArray) -> tuple[float, float, float] | None:
    if place is None:
        return None
    x, y, z = (float(c) for c in np.array(place) + offset)
    return x, y, z
