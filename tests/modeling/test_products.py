"""Regular grids and fault polygons of rebuilt horizons, against what the geometry says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from graben.errors import ModelingError
from graben.model import GridGeometry
from graben.modeling.products import cutoff_polygons, fault_polygons, regular_grid
from graben.modeling.results import Cutoff
from graben.surface import Surface
from tests.reports.sample import ORIGIN, cut_result, uncut_result


def test_grid_of_an_uncut_horizon_is_its_input():
    result = uncut_result()
    values = regular_grid(result)
    np.testing.assert_allclose(values.ravel(), result.horizon.surface.vertices[:, 2], rtol=0, atol=1e-6)


def test_grid_is_undefined_in_the_gap_and_nowhere_else():
    result = cut_result(throw=400.0)  # a gap of up to 231 m is wider than the grid's step
    gap = shapely.union_all([polygon for _, polygon in fault_polygons(result)])
    nodes = result.horizon.grid.nodes()
    inside = shapely.contains_xy(gap, nodes[..., 0], nodes[..., 1])
    assert inside.sum() > 10
    np.testing.assert_array_equal(np.isnan(regular_grid(result)), inside)


def test_grid_shows_the_hanging_wall_in_an_overlap():
    result = cut_result(throw=-400.0)
    grid = GridGeometry(2, 1, 1.0, 1.0, (ORIGIN[0] + 3000.0, ORIGIN[1] + 3000.0))
    row = int(np.argmin(result.cutoffs[0].throw))
    hanging, foot = result.cutoffs[0].hanging[row], result.cutoffs[0].foot[row]
    middle = (hanging + foot) / 2
    grid = replace(grid, origin=(float(middle[0]), float(middle[1])))
    values = regular_grid(replace(result, horizon=replace(result.horizon, grid=grid)))
    # The lips are 400 m apart in elevation: the sample is at the upper one.
    np.testing.assert_allclose(values, hanging[2], atol=30.0)


def test_grid_of_a_plane_is_the_plane_on_any_grid():
    grid = GridGeometry(23, 17, 31.0, 47.0, (ORIGIN[0] + 700.0, ORIGIN[1] + 400.0), rotation=33.0)
    result = cut_result(throw=0.0)
    points = result.surface.vertices.copy()
    plane = np.array([0.1, -0.2])
    points[:, 2] = (points[:, :2] - ORIGIN) @ plane
    surface = Surface("plane", points, result.surface.triangles)
    values = regular_grid(replace(result, surface=surface, horizon=replace(result.horizon, grid=grid)))
    np.testing.assert_allclose(values, (grid.nodes() - ORIGIN) @ plane, atol=1e-6)


def test_nodes_outside_the_horizon_are_undefined():
    grid = GridGeometry(3, 1, 10_000.0, 1.0, (ORIGIN[0] - 5000.0, ORIGIN[1] + 3000.0))
    result = uncut_result()
    values = regular_grid(replace(result, horizon=replace(result.horizon, grid=grid)))
    assert np.isnan(values).tolist() == [[True], [False], [True]]


def test_horizon_without_a_grid_is_told():
    result = uncut_result("Lone")
    with pytest.raises(ModelingError, match="Lone"):
        regular_grid(replace(result, horizon=replace(result.horizon, grid=None)))


@pytest.mark.parametrize("throw", [138.0, -138.0])
def test_area_of_the_polygon_is_the_integral_of_heave(throw):
    result = cut_result(throw=throw)
    ((name, polygon),) = fault_polygons(result)
    cutoff = result.cutoffs[0]
    # Heave is measured along x, so it is integrated over y.
    y = cutoff.foot[:, 1]
    assert name == "F1"
    assert polygon.is_valid
    assert polygon.area == pytest.approx(abs(np.trapezoid(cutoff.heave, y)), rel=1e-9)


def test_lips_that_lie_on_each_other_give_no_polygon():
    line = cut_result().cutoffs[0]
    below = line.foot - [0.0, 0.0, 50.0]
    vertical = Cutoff("V", line.s, below, line.foot, np.full(len(line.s), 50.0), np.zeros(len(line.s)))
    assert cutoff_polygons(vertical) == []


def test_scissor_fault_gives_two_polygons():
    y = np.linspace(0.0, 10.0, 11)
    half = (y - 5.0) / 10.0
    hanging = np.stack([half, y, -half], axis=1)
    foot = np.stack([-half, y, half], axis=1)
    polygons = cutoff_polygons(Cutoff("S", y, hanging, foot, 2 * half, 2 * half))
    assert len(polygons) == 2
    assert all(p.is_valid for p in polygons)
    assert sum(p.area for p in polygons) == pytest.approx(2 * 0.5 * 5.0 * 1.0)
