"""Runs of a fault's rim that stop short of other faults: stretches that belong together, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graben.arrays import FloatArray, floats
from graben.surface import Surface
from graben.validators.measuring.rim_labels import RimLabel
from graben.validators.measuring.rims import Stretch

#: Stretches of one side of a fault: their chords differ by less than this, degrees.
_ONE_SIDE = 60.0
#: What lies free between stretches of one run is no longer than so many times these.
_FREE = 2.0
#: A run is a side of its fault, and not a corner of it, where its stretches at other faults are this share of
#: the fault's extent along the run.
_SIDE = 0.4
#: A gap is no wider than this share of the run along it: wider, the fault just ends somewhere.
_NARROW = 0.75


@dataclass(frozen=True, eq=False)
class Run:
    """A part of a rim that faces other faults, with what lies free in between.

    Parameters
    ----------
    stretches : tuple of Stretch
        Those at other faults, in their order along the rim.
    path : (k, 3) array
        From the begin of the first to the end of the last, model units.
    """

    stretches: tuple[Stretch, ...]
    path: FloatArray

    @property
    def gaps(self) -> tuple[Stretch, ...]:
        """The stretches that stop short."""
        return tuple(s for s in self.stretches if s.label is RimLabel.GAP)

    @property
    def length(self) -> float:
        """Of the stretches at other faults, model units."""
        return sum(s.length for s in self.stretches)

    def is_side(self, surface: Surface) -> bool:
        """Return whether the run is a side of its fault that is clearly meant to meet the others."""
        # the fault's extent along the run, askew where the run is: measured beside the way to its middle
        middle = 0.5 * (self.path[0] + self.path[-1])
        axes = np.stack([middle - surface.vertices.mean(axis=0), _chord(self.path)], axis=1)
        along = np.linalg.lstsq(axes, (surface.vertices - middle).T, rcond=None)[0][1]
        extent = float(np.ptp(along))
        widest = max((s.greatest for s in self.gaps), default=0.0)
        whole = float(np.linalg.norm(np.diff(self.path, axis=0), axis=1).sum())
        return self.length >= _SIDE * extent and widest <= _NARROW * whole


def runs_of(stretches: Sequence[Stretch], neighbours: set[str], tolerance: float) -> list[Run]:
    """Return the runs of a rim that face some faults and hold a gap.

    Parameters
    ----------
    stretches : sequence of Stretch
        All of one fault, in their order along its rims.
    neighbours : set of str
        The faults that count.
    tolerance : float
        Ends nearer than this follow each other, model units.
    """
    found: list[list[Stretch]] = []
    for ring in _rings(stretches, tolerance):
        facing = [k for k, s in enumerate(ring) if s.neighbour in neighbours]
        if not facing:
            continue
        start = _widest_break(ring, facing)
        ordered = ring[start:] + ring[:start]
        current: list[Stretch] = []
        between: list[Stretch] = []
        for stretch in ordered:
            if stretch.neighbour not in neighbours:
                between.append(stretch)
                continue
            if current and not _belong(current, between, stretch):
                found.append(current)
                current, between = [], []
            current += [*between, stretch] if current else [stretch]
            between = []
        found.append(current)
    runs = [
        Run(
            tuple(s for s in part if s.neighbour in neighbours),
            floats(np.concatenate([s.path for s in part])),
        )
        for part in found
    ]
    return [run for run in runs if run.gaps]


def _rings(stretches: Sequence[Stretch], tolerance: float) -> list[list[Stretch]]:
    """Return stretches in lists that follow each other."""
    rings: list[list[Stretch]] = []
    for stretch in stretches:
        follows = rings and np.linalg.norm(rings[-1][-1].path[-1] - stretch.path[0]) <= tolerance
        if follows:
            rings[-1].append(stretch)
        else:
            rings.append([stretch])
    return rings


def _widest_break(ring: Sequence[Stretch], facing: Sequence[int]) -> int:
    """Return the facing stretch after the longest part of a rim that faces nothing."""
    best, widest = facing[0], -1.0
    for before, after in zip([facing[-1] - len(ring), *facing[:-1]], facing, strict=True):
        free = sum(ring[k].length for k in range(before + 1, after))
        if free > widest:
            best, widest = after, free
    return best


def _belong(current: Sequence[Stretch], between: Sequence[Stretch], following: Stretch) -> bool:
    """Return whether a stretch is of the same side as those before: in line with them, and not far off."""
    free = sum(s.length for s in between)
    facing = [s for s in current if s.label is not RimLabel.FREE]
    last = facing[-1] if facing else current[-1]
    cosine = float(_chord(last.path) @ _chord(following.path))
    near = free <= _FREE * (sum(s.length for s in current) + following.length)
    return bool(near and cosine >= np.cos(np.radians(_ONE_SIDE)))


def _chord(path: FloatArray) -> FloatArray:
    way = path[-1] - path[0]
    return np.asarray(way / max(float(np.linalg.norm(way)), np.finfo(float).tiny), dtype=np.float64)
