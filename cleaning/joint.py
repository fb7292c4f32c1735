"""Vertices that several faults share moved in all of them at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from graben.arrays import FloatArray
from graben.cleaning.repairing import Task
from graben.cleaning.shaping.limits import reaches
from graben.surface import Surface
from graben.validators.measuring.measures import remembered, smallest_angles
from graben.validators.measuring.plan import covers_once, narrowest_overlap, projected
from graben.validators.z_monotone import LEVEL, SLIVER, critical_points


@dataclass(frozen=True, eq=False)
class Joint:
    """A fault that was moved, and the others that move with it by the vertices they share."""

    surface: Surface
    others: Mapping[str, Surface]


def joint_move(task: Task, before: Surface, moved: Surface, taken: Mapping[str, Surface]) -> Joint:
    """Return a moved fault with the vertices of other faults that lay at those moved, moved too.

    Parameters
    ----------
    task : Task
        With all faults.
    before, moved : Surface
        The fault, vertex by vertex.
    taken : mapping of str to Surface
        Other faults as they are changed already.
    """
    changed = (before.vertices != moved.vertices).any(axis=1)
    asked = before.vertices[changed]
    others = {}
    for fault in task.model.faults:
        if fault.name == before.name:
            continue
        other = taken.get(fault.name, fault.surface)
        low, high = _bounds(other)
        if not ((asked >= low) & (asked <= high)).all(axis=1).any():
            continue
        own = _same(other.vertices, asked)
        if (own >= 0).any():
            points = other.vertices.copy()
            points[own >= 0] = moved.vertices[changed][own[own >= 0]]
            others[fault.name] = other.with_vertices(points)
    return Joint(moved, others)


def sound_with(task: Task, joint: Joint, taken: Mapping[str, Surface]) -> bool:
    """Return whether the faults that move along stay within max_move and as sound as they were.

    Never where these faults together, with those ``taken`` along before, were tried in vain.
    """
    if frozenset({joint.surface.name, *taken, *joint.others}) in task.vetoed:
        return False
    level = task.model.checks.get("z-monotone", LEVEL)
    for name, made in joint.others.items():
        before = task.fault(name).surface
        if reaches(made, [task.references[name]]).max(initial=0.0) > task.max_move(name):
            return False
        if any(a > b for a, b in zip(_faults_of(made, level), _faults_of(before, level), strict=True)):
            return False
    return True


def _faults_of(surface: Surface, level: float) -> tuple[int, int, int, int]:
    """Return how many defects of the kinds a move can make a surface has."""
    plan = projected(surface)
    found = critical_points(surface, level)
    return (
        len(plan.vertical) + len(plan.overturned),
        int(not covers_once(surface, narrowest_overlap(surface, plan))),
        len(found.vertices) + len(found.level),
        int((smallest_angles(surface.vertices, surface.triangles) < SLIVER).sum()),
    )


@remembered
def _bounds(surface: Surface) -> tuple[FloatArray, FloatArray]:
    """Return the least and greatest coordinates of a surface, shape (3,) each."""
    low = np.fmin.reduce(surface.vertices, axis=0, initial=np.inf)
    return low, np.fmax.reduce(surface.vertices, axis=0, initial=-np.inf)


def _same(points: FloatArray, others: FloatArray) -> FloatArray:
    """Return for each point the position of one of others that is equal to the bit, -1 for none, (n,)."""
    both = np.concatenate([others, points]) + 0.0
    place = np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)
    known = np.full(place.max(initial=-1) + 1, -1)
    known[place[: len(others)]] = np.arange(len(others))
    return np.asarray(known[place[len(others) :]])
