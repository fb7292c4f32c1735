"""Where the tangent planes of a horizon meet the guides of its cut nodes: the step of Newton's method.

The iteration seeks z = u(P(z)) for each node of the cut, P(z) its place at elevation z on its guide. With s
the slope of u along the guide, per unit of elevation, u(P(z + d)) is about u(P(z)) + s d, so that
d = (u - z) / (1 - s). The plain iteration takes d = u - z, whose error shrinks by the factor s only. What the
tangent leaves out is that u itself changes with the cut.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.compiled import compiled

#: A horizon nearly as steep as its guide meets it anywhere: the step is then no more than twice, and no less
#: than half, that of the plain iteration.
_LEAST_SLOPE, _MOST_SLOPE = -1.0, 0.5


def tangent_step(z: FloatArray, image: FloatArray, slopes: FloatArray) -> FloatArray:
    """Return the elevations at which the tangents meet the guides, (c,), model units.

    Parameters
    ----------
    z, image : (c,) arrays
        Elevations of the nodes of the cut, and those of the solution there, model units.
    slopes : (c,) array
        Rise of the solution along each guide per unit of elevation.
    """
    return z + (image - z) / (1.0 - np.clip(slopes, _LEAST_SLOPE, _MOST_SLOPE))


@dataclass(frozen=True, eq=False)
class Slopes:
    """The triangles around some nodes, for the slopes of piecewise linear functions there: :meth:`of`."""

    around: IntArray
    at: IntArray
    count: int

    @staticmethod
    def of(triangles: IntArray, nodes: IntArray) -> Slopes:
        """Prepare for nodes (c,) that have triangles among (m, 3), all alike oriented."""
        place = np.full(int(triangles.max()) + 1, -1)
        place[nodes] = np.arange(len(nodes))
        around = triangles[(place[triangles] >= 0).any(axis=1)]
        return Slopes(ints(around), ints(place[around]), len(nodes))

    def gradients(self, points: FloatArray, values: FloatArray) -> FloatArray:
        """Return the gradient at the nodes: the mean over their triangles by area, (c, 2), without unit.

        Parameters
        ----------
        points : (n, 2) array
            Positions, model units; no triangle without area.
        values : (n,) array
            Elevations, model units.
        """
        sums = np.zeros((self.count, 3))
        _add_slopes(np.array(points), np.array(values), self.around, self.at, sums)
        return floats(sums[:, :2] / sums[:, 2:])


@compiled
def _add_slopes(
    points: FloatArray, values: FloatArray, around: IntArray, at: IntArray, sums: FloatArray
) -> None:
    """Add twice the area times the slope, and twice the area, of each triangle to its nodes, (c, 3)."""
    for t in range(len(around)):
        a, b, c = around[t]
        b_x, b_y, rise = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], values[b] - values[a]
        c_x, c_y, climb = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], values[c] - values[a]
        for k in range(3):
            node = at[t, k]
            if node >= 0:
                sums[node, 0] += rise * c_y - climb * b_y
                sums[node, 1] += climb * b_x - rise * c_x
                sums[node, 2] += b_x * c_y - b_y * c_x
