"""Regular grids and fault polygons of rebuilt horizons, against what the geometry says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from graben.demo import build as demo
from graben.errors import ModelingError
from graben.model import GridGeometry
from graben.modeling.products import (
    Opening,
    cutoff_polygons,
    fault_polygons,
    parts,
    polygons_of,
    regular_grid,
)
from graben.modeling.results import Cutoff, HorizonResult
from graben.pipeline import build
from graben.surface import Surface
from tests.models import model_of_demo
from tests.reports.sample import ORIGIN, cut_result, uncut_result


@pytest.fixture(scope="module", params=["cross", "tee", "reverse"])
def rebuilt(request) -> HorizonResult:
    (result,) = build(model_of_demo(demo(request.param))).horizons
    return result


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


@pytest.mark.parametrize(("throw", "kind"), [(138.0, Opening.GAP), (-138.0, Opening.OVERLAP)])
def test_polygons_say_what_they_are_and_lie_on_the_lips(throw, kind):
    result = cut_result(throw=throw)
    (polygon,) = polygons_of(result)
    assert (polygon.fault, polygon.piece, polygon.kind) == ("F1", 1, kind)
    assert polygon.shape.exterior.is_ccw
    corners = {tuple(p) for p in shapely.get_coordinates(polygon.shape, include_z=True).round(6).tolist()}
    lips = np.concatenate([result.cutoffs[0].hanging, result.cutoffs[0].foot]).round(6)
    assert corners == {tuple(p) for p in lips.tolist()}


def test_a_scissor_fault_has_a_gap_and_an_overlap_that_meet_between_the_lips():
    y = np.linspace(0.0, 10.0, 11)
    half = (y - 5.2) / 10.0
    hanging = np.stack([half, y, -half - 100.0], axis=1)
    foot = np.stack([-half, y, half - 100.0], axis=1)
    result = replace(cut_result(), cutoffs=(Cutoff("S", y, hanging, foot, 2 * half, 2 * half),))
    overlap, gap = sorted(polygons_of(result), key=lambda p: p.shape.centroid.y)
    assert (overlap.kind, gap.kind) == (Opening.OVERLAP, Opening.GAP)
    at = shapely.get_coordinates(gap.shape, include_z=True)
    # Where the lips cross, between two rows, both have the same elevation.
    np.testing.assert_allclose(at[np.argmin(at[:, 1])], [0.0, 5.2, -100.0], atol=1e-9)


def test_a_line_that_winds_about_itself_still_gives_valid_polygons():
    turn = np.linspace(0.0, 4.5 * np.pi, 90)
    line = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1) * (1.0 + 0.1 * turn)[:, None]
    beside = line * [1.3, 1.3, 1.0]
    zero = np.zeros(len(turn))
    polygons = cutoff_polygons(Cutoff("S", turn, beside, line, zero, zero))
    assert polygons
    assert all(p.is_valid and p.area > 0 for p in polygons)


def test_gaps_are_what_the_horizon_leaves_out_and_overlaps_what_it_has_twice(rebuilt):
    faces = shapely.polygons(rebuilt.surface.vertices[rebuilt.surface.triangles][:, :, :2])
    cover = shapely.union_all(faces)
    places = rebuilt.horizon.surface.vertices[:, :2]
    outline = shapely.box(*places.min(axis=0), *places.max(axis=0))
    found = polygons_of(rebuilt)
    assert all(p.shape.is_valid and not p.shape.interiors for p in found)
    gaps, twice = (
        shapely.force_2d(shapely.union_all([p.shape for p in found if p.kind is kind])) for kind in Opening
    )
    missing = outline.difference(cover)
    size = max(gaps.area, twice.area)
    assert missing.symmetric_difference(gaps).area < 1e-6 * size
    assert shapely.area(faces).sum() - cover.area == pytest.approx(twice.area, abs=1e-6 * size)


def test_grid_takes_no_node_across_a_fault(rebuilt):
    """Each node is that of the triangles over it: undefined in a gap, of the hanging wall in an overlap."""
    nodes = rebuilt.horizon.grid.nodes()
    values = regular_grid(rebuilt)
    found = polygons_of(rebuilt)
    gap, overlap = (
        shapely.contains_xy(
            shapely.union_all([p.shape for p in found if p.kind is kind]), nodes[..., 0], nodes[..., 1]
        )
        for kind in Opening
    )
    assert gap.any() or overlap.any()
    np.testing.assert_array_equal(np.isnan(values), gap)
    hanging = rebuilt.block[rebuilt.surface.triangles].max(axis=(1, 2)) > 0
    upper = Surface("hanging", rebuilt.surface.vertices, rebuilt.surface.triangles[hanging])
    np.testing.assert_allclose(regular_grid(replace(rebuilt, surface=upper))[overlap], values[overlap])


def test_parts_are_the_surface_divided():
    result = cut_result()
    ((label, whole),) = parts(result)
    assert (label, whole.name) == (0, "Top A part 0")
    np.testing.assert_array_equal(whole.vertices, result.surface.vertices)
    np.testing.assert_array_equal(whole.triangles, result.surface.triangles)
    # Two sheets that share no node: the second is part 3.
    count = len(result.surface.vertices)
    both = Surface(
        "Top A",
        np.concatenate([result.surface.vertices, result.surface.vertices + np.array([1e4, 0.0, 0.0])]),
        np.concatenate([result.surface.triangles + count, result.surface.triangles]),
    )
    divided = replace(
        result,
        surface=both,
        first=both.vertices,
        block=np.tile(result.block, (2, 1)),
        subdomain=np.repeat([0, 3], count),
    )
    (first, a), (second, b) = parts(divided)
    assert (first, second) == (0, 3)
    np.testing.assert_array_equal(a.vertices[a.triangles], both.vertices[both.triangles[len(a.triangles) :]])
    np.testing.assert_array_equal(b.vertices[b.triangles], both.vertices[both.triangles[: len(a.triangles)]])
