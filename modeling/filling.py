"""Undefined nodes of a grid where a fault passes are filled before the fault is traced."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from scipy import ndimage

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.formats.irap import grid_surface
from graben.model import Fault, GridGeometry, Horizon
from graben.modeling.algebra import Cholmod
from graben.modeling.energy import EdgePattern, assemble
from graben.surface import Surface

#: The parameters of the energy, as the method's own defaults: theta, and l in gammas.
THETA = 0.5
LENGTH_IN_GAMMAS = 10.0
#: Rings of defined nodes about a hole that take part: two decide the slope at its rim, one more its bend.
RINGS = 3
#: A surface is the grid's own when its nodes lie on those of the grid within this share of a cell.
ON_GRID = 1e-3

# A cell with two opposite corners undefined holds no triangle: diagonal neighbours belong to one hole.
_AROUND = np.ones((3, 3), dtype=bool)


def filled(horizon: Horizon, faults: tuple[Fault, ...], gamma: float) -> tuple[Horizon, int]:
    """Return a horizon with its undefined nodes filled where a fault passes, and the number of them.

    Filled are inner holes narrower than ``2 gamma`` whose plan area a fault crosses at elevations between
    those of the hole's rim, give or take half of ``gamma``. The values are those of least energy (paper
    Sect. 2), the defined nodes fixed. Holes that are open to the outside, and horizons that are not grids,
    stay as they are.

    Parameters
    ----------
    horizon : Horizon
        A horizon; returned itself when nothing is to be filled.
    faults : tuple of Fault
        The faults that may pass.
    gamma : float
        Half-width of the modeling zone, model units.
    """
    values = None if len(horizon.picks) or horizon.grid is None else _grid_values(horizon)
    if values is None or horizon.grid is None:
        return horizon, 0
    chosen = _chosen_holes(horizon.grid, values, faults, gamma)
    count = int(np.count_nonzero(chosen))
    if count == 0:
        return horizon, 0
    whole = _least_energy(horizon.grid, values, chosen, gamma)
    surface = grid_surface(horizon.name, horizon.grid, whole)
    note = f"{count} undefined grid nodes where a fault passes were filled."
    return replace(horizon, surface=surface, notes=(*horizon.notes, note)), count


def has_undefined(horizon: Horizon) -> bool:
    """Return whether a horizon is a grid with undefined nodes, so that :func:`filled` may fill some."""
    values = None if len(horizon.picks) or horizon.grid is None else _grid_values(horizon)
    return values is not None and not np.isfinite(values).all()


def _grid_values(horizon: Horizon) -> FloatArray | None:
    """Return the elevations on the grid, NaN where undefined; None when the surface is not the grid's own."""
    grid = horizon.grid
    if grid is None or len(horizon.surface.vertices) == 0:
        return None
    a = np.radians(grid.rotation)
    turn = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    local = (horizon.surface.vertices[:, :2] - grid.origin) @ turn.T / (grid.dx, grid.dy)
    nodes = np.round(local)
    size = np.array([grid.columns, grid.rows])
    if not (np.abs(local - nodes) <= ON_GRID).all() or (nodes < 0).any() or (nodes >= size).any():
        return None
    values = np.full((grid.columns, grid.rows), np.nan)
    i, j = nodes.astype(np.int64).T
    values[i, j] = horizon.surface.vertices[:, 2]
    return floats(values)


def _chosen_holes(
    grid: GridGeometry, values: FloatArray, faults: tuple[Fault, ...], gamma: float
) -> BoolArray:
    """Return which undefined nodes are to be filled, (columns, rows)."""
    undefined = ~np.isfinite(values)
    chosen = np.zeros_like(undefined)
    labels, count = ndimage.label(undefined, _AROUND)
    if count == 0 or not faults:
        return chosen
    depth = ndimage.distance_transform_edt(undefined, sampling=(grid.dx, grid.dy))
    widths = 2.0 * np.atleast_1d(ndimage.maximum(depth, labels, np.arange(1, count + 1)))
    open_ones = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
    places = grid.nodes()
    for label, box in enumerate(ndimage.find_objects(labels), start=1):
        if widths[label - 1] >= 2.0 * gamma or label in open_ones:
            continue
        window = tuple(slice(s.start - 1, s.stop + 1) for s in box)
        hole = labels[window] == label
        rim = ndimage.binary_dilation(hole, _AROUND) & ~undefined[window]
        heights = values[window][rim]
        low, high = float(heights.min()) - gamma / 2.0, float(heights.max()) + gamma / 2.0
        area = _area(places[window], hole)
        if any(_passes(fault.surface, area, low, high) for fault in faults):
            chosen[window] |= hole
    return chosen


def _area(places: FloatArray, hole: BoolArray) -> shapely.Geometry:
    """Return the plan area of the cells that have an undefined corner."""
    touched = hole[:-1, :-1] | hole[1:, :-1] | hole[1:, 1:] | hole[:-1, 1:]
    corners = np.stack([places[:-1, :-1], places[1:, :-1], places[1:, 1:], places[:-1, 1:]], axis=2)
    return shapely.union_all(shapely.polygons(corners[touched]))


def _passes(fault: Surface, area: shapely.Geometry, low: float, high: float) -> bool:
    """Return whether the part of a fault between two elevations lies over an area in plan."""
    corners = fault.vertices[fault.triangles]
    x0, y0, x1, y1 = area.bounds
    least, most = corners.min(axis=1), corners.max(axis=1)
    near = (most >= (x0, y0, low)).all(axis=1) & (least <= (x1, y1, high)).all(axis=1)
    pieces = [_between(corner, low, high) for corner in corners[near]]
    hulls = shapely.convex_hull([shapely.MultiPoint(piece) for piece in pieces if len(piece)])
    return bool(shapely.intersects(area, hulls).any())


def _between(corners: FloatArray, low: float, high: float) -> FloatArray:
    """Return the plan corners of the part of a triangle, (3, 3), between two elevations."""
    z = corners[:, 2]
    points = [corners[(z >= low) & (z <= high), :2]]
    for level in (low, high):
        for a, b in ((0, 1), (1, 2), (2, 0)):
            if (z[a] - level) * (z[b] - level) < 0:
                share = (level - z[a]) / (z[b] - z[a])
                points.append(((1.0 - share) * corners[a, :2] + share * corners[b, :2])[None])
    return floats(np.concatenate(points))


def _least_energy(grid: GridGeometry, values: FloatArray, chosen: BoolArray, gamma: float) -> FloatArray:
    """Return the values with the chosen nodes filled."""
    zone = ndimage.binary_dilation(chosen, _AROUND, iterations=RINGS) & (np.isfinite(values) | chosen)
    patch = grid_surface("", grid, floats(np.where(zone, 0.0, np.nan)))
    points = floats(patch.vertices[:, :2] - patch.vertices[:, :2].mean(axis=0))
    unknown, fixed = _split(chosen[zone])
    matrix = assemble(points, EdgePattern.of(patch.triangles, len(points)), THETA, LENGTH_IN_GAMMAS * gamma)
    rows = matrix.tocsr()[unknown]
    inner = rows[:, unknown].tocsc()
    given = values[zone][fixed]
    middle = given.mean()
    load = -(rows[:, fixed] @ (given - middle))
    result = values.copy()
    found = Cholmod().analyse(inner).factor(inner).solve(floats(load))
    result[chosen] = middle + found
    return floats(result)


def _split(unknown: BoolArray) -> tuple[IntArray, IntArray]:
    return ints(np.flatnonzero(unknown)), ints(np.flatnonzero(~unknown))
