"""Where the tangent planes of a horizon meet the guides of its cut nodes: the step of Newton's method.

The iteration seeks z = u(P(z)) for each node of the cut, P(z) its place at elevation z on its guide. With s
the slope of u along the guide, per unit of elevation, u(P(z + d)) is about u(P(z)) + s d, so that
d = (u - z) / (1 - s). The plain iteration takes d = u - z, whose error shrinks by the factor s only. What the
tangent leaves out is that u itself changes with the cut.
"""

from __future__ import annotations

import numpy as np

from graben.arrays import FloatArray, IntArray, floats

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


def gradients(points: FloatArray, values: FloatArray, triangles: IntArray, nodes: IntArray) -> FloatArray:
    """Return the slope of a piecewise linear function at some nodes: the mean over their triangles by area.

    Parameters
    ----------
    points : (n, 2) array
        Positions, model units.
    values : (n,) array
        Elevations, model units.
    triangles : (m, 3) array
        All alike oriented, none without area.
    nodes : (c,) array
        Nodes, each with a triangle.

    Returns
    -------
    (c, 2) array, without unit.
    """
    place = np.full(len(points), -1)
    place[nodes] = np.arange(len(nodes))
    around = triangles[(place[triangles] >= 0).any(axis=1)]
    first, second = (points[around[:, k]] - points[around[:, 0]] for k in (1, 2))
    rise, climb = (values[around[:, k]] - values[around[:, 0]] for k in (1, 2))
    # Twice the area, and twice the area times the slope, of each triangle.
    shares = np.stack(
        [
            rise * second[:, 1] - climb * first[:, 1],
            climb * first[:, 0] - rise * second[:, 0],
            first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0],
        ]
    )
    at = place[around]
    mine = at >= 0
    sums = [
        np.bincount(at[mine], np.repeat(share, 3).reshape(at.shape)[mine], minlength=len(nodes))
        for share in shares
    ]
    return floats((sums[:2] / sums[2]).T)
