"""The courses of a lip: the planes in which its nodes move on their fault (paper Sect. 6, formula 6)."""

from __future__ import annotations

import numpy as np

from graben.arrays import FloatArray


def courses(
    points: FloatArray, closed: bool, first_rate: FloatArray, last_rate: FloatArray, reach: float
) -> tuple[FloatArray, FloatArray]:
    """Return v(t) of formula (6) at the nodes of a lip, as the planes in which they move.

    The parts of v(t) are taken per unit of elevation, not of length: then a lip that rises or falls as a
    whole moves along strike by (1 - t)^2 and t^2 of what its ends do, and no node passes another. With unit
    vectors the nodes beside a junction whose branch line plunges along the fault would stay behind it.

    Parameters
    ----------
    points : (k, 2) array
        The lip in plan; its fault dips to the right of the way.
    closed : bool
        Whether it ends where it starts; then it has no guides.
    first_rate, last_rate : (2,) arrays
        How far the guides at its ends go in plan per unit of elevation.
    reach : float
        As of :func:`graben.modeling.movement.guides_of`.

    Returns
    -------
    directions : (k, 2) array
        Across the lip, up-dip, unit vectors.
    slants : (k,) array
        How far each plane leans to the left of its direction per unit of elevation.
    """
    normal, t = _normals(points, closed, reach)
    left = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
    if closed:
        return normal, np.zeros(len(points))
    return normal, (1 - t) ** 2 * (left[0] @ first_rate) + t**2 * (left[-1] @ last_rate)


def _normals(points: FloatArray, closed: bool, reach: float) -> tuple[FloatArray, FloatArray]:
    """Return the normals of a lip (k, 2), averaged over ``reach``, and the share of its length up to each."""
    step = np.diff(points, axis=0)
    length = np.hypot(*step.T)
    unit = step / np.maximum(length, np.finfo(float).tiny)[:, None]
    before = np.concatenate([unit[-1:] if closed else unit[:1], unit])
    after = np.concatenate([unit, unit[:1] if closed else unit[-1:]])
    tangent = before + after
    # The fault dips to the right of the way: its left is up-dip.
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    normal /= np.maximum(np.hypot(*normal.T), np.finfo(float).tiny)[:, None]
    along = np.concatenate([[0.0], np.cumsum(length)])
    return _smoothed(normal, along, reach), along / max(along[-1], np.finfo(float).tiny)


def _smoothed(normal: FloatArray, along: FloatArray, reach: float) -> FloatArray:
    """Return unit normals (k, 2) averaged over ``reach`` along a line, turned by less than 60 degrees."""
    away = (along[:, None] - along[None, :]) / reach
    mean = np.exp(-0.5 * away**2) @ normal
    mean /= np.maximum(np.hypot(*mean.T), np.finfo(float).tiny)[:, None]
    turned = (mean * normal).sum(axis=1) <= 0.5
    return np.where(turned[:, None], normal, mean)
