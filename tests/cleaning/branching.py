"""A plane parent fault and a branch whose rim is a line in the parent's plane, which may run on past it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from graben.arrays import FloatArray, floats
from graben.model import Fault, Model
from graben.settings import RepairSettings
from graben.surface import Surface
from tests.models import grid_triangles

STEP = 100.0  #: edges of the parent, m
SIZE = (1600.0, 900.0)  #: the parent along strike and down dip, m
WIDE = 500.0  #: the branch away from the parent, m
MAX_MOVE = 50.0  #: m
_JITTER = 0.15  # shares of an edge by which vertices inside a fault lie off the lattice


@dataclass(frozen=True)
class Branching:
    """A branch line in the parent's plane, and how the branch lies on it.

    Parameters
    ----------
    line : tuple of two pairs
        Its ends: along strike and down dip from the parent's corner, m.
    off : float
        How far the branch's rim stops short of the parent along its own plane, m; negative beyond it.
    edge : float
        The branch's edges, m.
    size : pair of float
        The parent along strike and down dip, m.
    strike, dip : float
        Of the parent, degrees.
    angle : float
        Between the branch and the parent above the branch line, degrees.
    """

    line: tuple[tuple[float, float], tuple[float, float]]
    off: float = 0.0
    edge: float = STEP
    size: tuple[float, float] = SIZE
    strike: float = 37.0
    dip: float = 60.0
    angle: float = 70.0

    @property
    def ends(self) -> FloatArray:
        """The ends of the branch line, (2, 3), m."""
        corner, along, down, _ = self._frame()
        return floats([corner + s * along + d * down for s, d in self.line])

    @property
    def beyond(self) -> FloatArray:
        """The unit vector in the branch's plane away from the parent, square to the branch line, (3,)."""
        normal = self._frame()[3]
        across = np.cross(normal, np.subtract(*self.ends))
        across *= np.sign(across[2]) / np.linalg.norm(across)
        angle = np.radians(self.angle)
        return floats(np.cos(angle) * across + np.sin(angle) * normal)

    @property
    def shared(self) -> float:
        """The length of the branch line on the parent, m."""
        return float(shapely.LineString(self.line).intersection(shapely.box(0.0, 0.0, *self.size)).length)

    def model(self) -> Model:
        """The parent P and the branch B."""
        corner, along, down, _ = self._frame()
        start, end = self.ends
        faults = (
            _lattice("P", corner, self.size[0] * along, self.size[1] * down, STEP),
            _lattice("B", start + self.off * self.beyond, end - start, WIDE * self.beyond, self.edge),
        )
        repair = RepairSettings(max_move=MAX_MOVE)
        return Model("branching", (), tuple(map(Fault, faults)), unit="m", repair=repair)

    def _frame(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """The parent's corner, and the unit vectors along strike, down dip and upwards from it."""
        strike, dip = np.radians((self.strike, self.dip))
        along = np.array([np.sin(strike), np.cos(strike), 0.0])
        right = np.array([along[1], -along[0], 0.0])
        down = np.cos(dip) * right - [0.0, 0.0, np.sin(dip)]
        corner = np.array([130.0, -77.0, 300.0])
        return floats(corner), floats(along), floats(down), floats(np.cross(down, along))


def _lattice(name: str, corner: FloatArray, first: FloatArray, second: FloatArray, edge: float) -> Surface:
    """A plane sheet between two vectors from a corner, its vertices inside off the lattice."""
    columns, rows = (max(2, round(float(np.linalg.norm(way)) / edge)) for way in (first, second))
    i, j = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1), indexing="ij")
    inside = (i > 0) & (i < columns) & (j > 0) & (j < rows)
    rng = np.random.default_rng(columns)
    u, v = (k + inside * rng.uniform(-_JITTER, _JITTER, k.shape) for k in (i, j))
    points = corner + u[..., None] * first / columns + v[..., None] * second / rows
    return Surface(name, points.reshape(-1, 3), grid_triangles(columns + 1, rows + 1))
