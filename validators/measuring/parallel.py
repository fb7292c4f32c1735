"""Where a horizon runs nearly parallel to a fault: how its slope compares with that of the fault."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from graben.arrays import FloatArray
from graben.cutgraph import CutGraph
from graben.model import Horizon
from graben.surface import Surface
from graben.validators.measuring.flanks import Windows, at_way, flanks_of, hat, nodes_of, planes, ways
from graben.validators.measuring.measures import centroids_of, normals_of, sides_of


@dataclass(frozen=True, eq=False)
class Stretch:
    """A stretch of a trace, ``line`` (k, 3), with the largest ratio of slopes on it."""

    ratio: float
    line: FloatArray

    @property
    def length(self) -> float:
        """Length in plan, model units."""
        return float(ways(self.line)[-1])

    @property
    def place(self) -> FloatArray:
        """The middle of it, (3,)."""
        return at_way(self.line, self.length / 2)


def slope_ratios(
    horizon: Horizon, fault: Surface, graph: CutGraph, number: int, gammas: Mapping[int, float]
) -> tuple[Stretch, ...]:
    """Return the slope of a horizon along a fault's dip over that of the fault, stretch by stretch.

    The slope is that of robust planes through the nodes between gamma and 2 gamma from the trace, one on
    each side of it: nearer, a smeared step looks like a horizon that follows the fault. The steeper side
    counts. The fault's slope and direction of dip are those of its mean normal within gamma of the place.

    Parameters
    ----------
    horizon : Horizon
        In the frame of the graph.
    fault : Surface
        The fault.
    graph : CutGraph
        Of the horizon.
    number : int
        Index of the fault in the model; the graph has edges of it.
    gammas : mapping
        gamma of each fault of the graph, model units.

    Returns
    -------
    tuple of Stretch
        One for each length of about gamma along the trace. 1 is parallel, negative a horizon that dips
        against the fault. Stretches without reliable nodes, or where the fault has no dip, are missing.
    """
    gamma = gammas[number]
    flanks = flanks_of(nodes_of(horizon.surface), graph, number, gammas, 2.0 * gamma, horizon.step)
    windows = Windows.over(flanks, max(gamma, horizon.step))
    slopes = [planes(flanks, windows, side, gamma, 2.0 * gamma).slope for side in (-1, 1)]
    found = []
    for k, (centre, reach) in enumerate(windows):
        place = flanks.place(centre)
        normal = _normal(fault, place, gamma)
        lean = float(normal[:2] @ normal[:2])
        # the fault dips along normal[:2], with a slope of |normal[:2]| / normal[2]
        ratios = [
            -float(s[k] @ normal[:2]) * float(normal[2]) / lean
            for s in slopes
            if lean > 0 and np.isfinite(s[k]).all()
        ]
        if ratios:
            found.append(Stretch(max(ratios), flanks.stretch(centre - reach / 2, centre + reach / 2)))
    return tuple(found)


def _normal(fault: Surface, place: FloatArray, gamma: float) -> FloatArray:
    """Return the mean normal of a fault within about gamma of a place, either way round, (3,)."""
    away = np.linalg.norm(centroids_of(fault) - place, axis=1)
    reach = gamma + sides_of(fault).max(axis=1)
    normals = normals_of(fault) * hat(away / reach, 0.0, 1.0)[:, None]
    # turned to one side by their main axis, not each upwards: a fault may pass through the vertical
    axis = np.linalg.eigh(normals.T @ normals)[1][:, -1]
    return np.asarray((normals * np.where(normals @ axis < 0, -1.0, 1.0)[:, None]).sum(axis=0))
