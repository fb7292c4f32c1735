"""Hexagonal lattices: the nodes of equilateral triangles, on which E_H has no preferred direction."""

from __future__ import annotations

import numpy as np

from graben.arrays import FloatArray, floats

#: Edge length of equilateral triangles with one node on each unit square.
EDGE_OF_UNIT_STEP = float(np.sqrt(2.0 / np.sqrt(3.0)))


def edge_of(step: float) -> float:
    """Return the edge length of the lattice with one node on each step^2 of area; model units.

    >>> round(edge_of(50.0), 2)
    53.73
    """
    return step * EDGE_OF_UNIT_STEP


def hexagonal(
    low: FloatArray, high: FloatArray, edge: float, angle: float = 0.0, origin: FloatArray | None = None
) -> FloatArray:
    """Return the nodes of a lattice of equilateral triangles that lie in a rectangle.

    Parameters
    ----------
    low, high : (2,) arrays
        Corners of the rectangle, along the axes, model units.
    edge : float
        Edge length of the triangles, model units; :func:`edge_of` gives that of a step.
    angle : float
        Direction of the rows, degrees, counter-clockwise from x.
    origin : (2,) array, optional
        A node of the lattice; default the middle of the rectangle, so that the nodes lie mirrored about it
        when the rows follow an axis.

    Returns
    -------
    (n, 2) array
        Row by row.

    Examples
    --------
    >>> hexagonal(floats([-1, -1]), floats([1, 1]), 1.0).round(3).tolist()[:2]
    [[-0.5, -0.866], [0.5, -0.866]]
    """
    low, high = floats(low), floats(high)
    start = (low + high) / 2.0 if origin is None else floats(origin)
    a = np.radians(angle)
    turn = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    corners = np.array([[x, y] for x in (low[0], high[0]) for y in (low[1], high[1])])
    local = (corners - start) @ turn.T / edge
    height = np.sqrt(0.75)
    rows = np.arange(np.floor(local[:, 1].min() / height), np.ceil(local[:, 1].max() / height) + 1)
    places = np.arange(np.floor(local[:, 0].min()) - 1, np.ceil(local[:, 0].max()) + 2)
    row, place = np.meshgrid(rows, places, indexing="ij")
    nodes = np.stack([place + 0.5 * np.mod(row, 2.0), row * height], axis=-1).reshape(-1, 2)
    points = start + edge * nodes @ turn
    # Nodes on the rim of the rectangle belong to it, whatever the rounding.
    slack = 1e-9 * edge
    return floats(points[((points >= low - slack) & (points <= high + slack)).all(axis=1)])
