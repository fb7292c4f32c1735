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
        first, second = (points[self.around[:, k]] - points[self.around[:, 0]] for k in (1, 2))
        rise, climb = (values[self.around[:, k]] - values[self.around[:, 0]] for k in (1, 2))
        # Twice the area times the slope, and twice the area, of each triangle.
        shares = (
            rise * second[:, 1] - climb * first[:, 1],
            climb * first[:, 0] - rise * second[:, 0],
            first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0],
        )
        mine = self.at >= 0
        x, y, area = (
            np.bincount(self.at[mine], np.repeat(share, 3)[mine.ravel()], minlength=self.count)
            for share in shares
        )
        return floats(np.stack([x / area, y / area], axis=1))
