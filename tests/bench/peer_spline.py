"""The simplest strong peer: a thin-plate spline through the reliable nodes of each block."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RBFInterpolator

from graben.arrays import FloatArray
from tests.bench.peer_task import Task

#: Nodes within this many gamma of a trace are all taken, of the others every THIN-th along both axes.
NEAR, THIN = 2.5, 3
#: Halvings of a section, some hundreds of metres high, to below a millimetre.
HALVINGS = 24


@dataclass(frozen=True)
class Options:
    """How the spline is set up.

    Parameters
    ----------
    around : bool
        A block's spline also runs through the nodes of other blocks beyond the tips of the faults between.
    smoothing : float
        Of scipy's RBFInterpolator.
    neighbors : int or None
        Nearest nodes taken at each place; None takes all of the thinned set.
    """

    around: bool
    smoothing: float = 0.0
    neighbors: int | None = None


@dataclass(frozen=True, eq=False)
class Splines:
    """A spline for each block."""

    fitted: tuple[RBFInterpolator, ...]

    def pieces(self) -> int:
        """Return the number of sheets: nothing joins them."""
        return len(self.fitted)

    def elevations(self, block: int, xy: FloatArray) -> FloatArray:
        """Return the elevation of a block at plan positions (k, 2), m."""
        return np.asarray(self.fitted[block](xy))

    def lip(self, fault: int, block: int, sections: list[FloatArray]) -> FloatArray:
        """Return where the spline of a block meets the sections of a fault, (k, 3)."""
        low, high = (np.array([s[k, 2] for s in sections]) for k in (0, -1))
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            above = middle - self.elevations(block, _plan(sections, middle))
            low, high = np.where(above < 0.0, middle, low), np.where(above < 0.0, high, middle)
        return np.column_stack([_plan(sections, low), low])


def _plan(sections: list[FloatArray], z: FloatArray) -> FloatArray:
    """Return the plan positions (k, 2) at which lines that rise are at elevations (k,)."""
    return np.array(
        [[np.interp(at, s[:, 2], s[:, k]) for k in (0, 1)] for s, at in zip(sections, z, strict=True)]
    )


def fitted(task: Task, options: Options) -> Splines:
    """Return the splines of all blocks."""
    kept = task.reliable & (_thinned(task) | (task.away < NEAR * task.made.gamma))
    splines = []
    for signs in task.blocks:
        agrees = task.sides * np.array(signs) >= 0
        if options.around:
            agrees |= task.beyond
        nodes = task.nodes[kept & agrees.all(axis=1)]
        splines.append(
            RBFInterpolator(
                nodes[:, :2], nodes[:, 2], smoothing=options.smoothing, neighbors=options.neighbors
            )
        )
    return Splines(tuple(splines))


def _thinned(task: Task) -> np.ndarray:
    i, j = np.indices((task.made.grid.columns, task.made.grid.rows)).reshape(2, -1)
    return np.asarray((i % THIN == 0) & (j % THIN == 0))
