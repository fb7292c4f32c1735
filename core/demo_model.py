"""The values of synthetic models with a known answer: frame, true cutoffs, and the model with its truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from graben.arrays import FloatArray, floats
from graben.demo_catalogue import SIZE
from graben.model import GridGeometry
from graben.surface import Surface
from graben.synthetic import Geology

HORIZON = "Top"  #: name of the horizon of every model
MARGIN = 300.0  #: faults reach this far above and below the horizon, m


@dataclass(frozen=True)
class Frame:
    """The plan movement from a model's upright frame to its coordinates: mirrored, rotated, shifted.

    ``rotation`` in degrees counter-clockwise about the domain's middle, ``mirrored`` turns x round there
    first, ``shift`` in m.
    """

    rotation: float = 0.0
    mirrored: bool = False
    shift: tuple[float, float] = (0.0, 0.0)

    def outward(self, xy: FloatArray) -> FloatArray:
        """Return model coordinates of upright plan positions (..., 2)."""
        c, s = self._turn
        x, y = self._flip * (xy[..., 0] - 0.5 * SIZE[0]), xy[..., 1] - 0.5 * SIZE[1]
        return floats(
            np.stack(
                [
                    x * c - y * s + 0.5 * SIZE[0] + self.shift[0],
                    x * s + y * c + 0.5 * SIZE[1] + self.shift[1],
                ],
                axis=-1,
            )
        )

    def inward(self, xy: FloatArray) -> FloatArray:
        """Return upright plan positions of model coordinates (..., 2)."""
        c, s = self._turn
        x, y = xy[..., 0] - self.shift[0] - 0.5 * SIZE[0], xy[..., 1] - self.shift[1] - 0.5 * SIZE[1]
        upright = [self._flip * (x * c + y * s) + 0.5 * SIZE[0], y * c - x * s + 0.5 * SIZE[1]]
        return floats(np.stack(upright, axis=-1))

    def grid(self, step: float) -> GridGeometry:
        """Return the grid over the domain."""
        corner = np.array([SIZE[0] if self.mirrored else 0.0, 0.0])
        x, y = self.outward(corner).tolist()
        columns, rows = (round(extent / step) + 1 for extent in SIZE)
        return GridGeometry(columns, rows, step, step, (x, y), self.rotation)

    @property
    def _turn(self) -> tuple[float, float]:
        a = np.radians(self.rotation)
        return float(np.cos(a)), float(np.sin(a))

    @property
    def _flip(self) -> float:
        return -1.0 if self.mirrored else 1.0


@dataclass(frozen=True, eq=False)
class TrueCutoff:
    """A true cutoff line in the model's coordinates.

    Parameters
    ----------
    fault, side, block : int
        Index of the fault; 1 hanging, -1 foot; index of the block.
    s : (k,) array
        Straight distance along strike from the end at which the fault dips to the right of the way, m.
    points : (k, 3) array
        On the triangulated fault, m.
    throw : (k,) array
        Elevation of foot minus hanging at the same s, m.
    """

    fault: int
    side: int
    block: int
    s: FloatArray
    points: FloatArray
    throw: FloatArray


@dataclass(frozen=True, eq=False)
class SyntheticModel:
    """A synthetic model and its truth.

    Parameters
    ----------
    name : str
        Name in the catalogue.
    grid : GridGeometry
        Of the horizon.
    values : (columns, rows) array
        Elevation of the smeared horizon, m.
    faults : tuple of Surface
        The faults.
    gamma : float
        Half-width of the zone that the smear makes unreliable, m.
    noise : float
        Standard deviation of the noise in the values, m.
    geology : Geology
        What is true, in the upright frame.
    frame : Frame
        From there to the model's coordinates.
    """

    name: str
    grid: GridGeometry
    values: FloatArray
    faults: tuple[Surface, ...]
    gamma: float
    noise: float
    geology: Geology
    frame: Frame

    def horizon(self, block: int, xy: FloatArray) -> FloatArray:
        """Return the true horizon of a block at plan positions (..., 2) of the model, m."""
        return self.geology.horizon(self.geology.blocks[block], self.frame.inward(xy))

    @cached_property
    def cutoffs(self) -> tuple[TrueCutoff, ...]:
        """The true cutoff lines, fault by fault, block by block."""
        result = []
        for f, fault in enumerate(self.geology.faults):
            for b, signs in enumerate(self.geology.blocks):
                if signs[f] == 0:
                    continue
                for s, upright in self.geology.cutoffs(f, signs):
                    points = np.column_stack([self.frame.outward(upright[:, :2]), upright[:, 2]])
                    from_end = s - fault.columns[0]
                    if self.frame.mirrored:  # the fault dips to the right of the opposite way
                        from_end, points = (fault.columns[-1] - s)[::-1], points[::-1]
                    result.append(TrueCutoff(f, signs[f], b, floats(from_end), floats(points), floats([])))
        return tuple(replace(c, throw=_throw(c, result, self.geology.blocks)) for c in result)


def _throw(cutoff: TrueCutoff, others: list[TrueCutoff], blocks: tuple[tuple[int, ...], ...]) -> FloatArray:
    """Return foot minus hanging at each s of a lip, against the nearest lip across the fault."""
    signs = blocks[cutoff.block]
    best = np.full(cutoff.s.shape, np.inf)
    facing = np.full(cutoff.s.shape, np.nan)
    for other in others:
        theirs = blocks[other.block]
        pairs = [a * b != -1 for g, (a, b) in enumerate(zip(signs, theirs, strict=True)) if g != cutoff.fault]
        if other.fault != cutoff.fault or other.side == cutoff.side or not all(pairs):
            continue
        s, z = other.s, other.points[:, 2]
        beyond = np.maximum(np.maximum(s[0] - cutoff.s, cutoff.s - s[-1]), 0.0)
        facing = np.where(beyond < best, np.interp(cutoff.s, s, z), facing)
        best = np.minimum(best, beyond)
    return floats(cutoff.side * (facing - cutoff.points[:, 2]))
