"""Faults extended along their own trend: known answers, identities and limits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial import Delaunay, cKDTree

from graben.arrays import FloatArray, IntArray, ints
from graben.cleaning.shaping.extension import Extension, extended
from graben.cleaning.shaping.rim_chains import rim_chain, stretch_chain
from graben.cleaning.shaping.turning import oriented
from graben.errors import GrabenError
from graben.proximity import nearest
from graben.surface import Surface, boundary_loops, triangle_areas, triangle_dips
from tests.models import grid_triangles

ALONG, DOWN = np.linspace(0.0, 2000.0, 21), np.linspace(0.0, 800.0, 9)
DIP = np.radians(60)
NORMAL = np.array([0.0, np.sin(DIP), np.cos(DIP)])
Shape = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray, FloatArray]]


def plane(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    return a, b * np.cos(DIP), -b * np.sin(DIP)


def listric(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    top, radius = np.radians(70), 3000.0
    angle = top - b / radius
    return a, radius * (np.cos(angle) - np.cos(top)), -radius * (np.sin(top) - np.sin(angle))


def corrugated(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    wave = 80 * np.sin(2 * np.pi * a / 900)
    x, y, z = plane(a, b)
    return x, y + wave * NORMAL[1], z + wave * NORMAL[2]


def sheet(shape: Shape, along: FloatArray = ALONG, down: FloatArray = DOWN) -> Surface:
    a, b = np.meshgrid(along, down, indexing="ij")
    points = np.stack(shape(a, b), axis=-1).reshape(-1, 3)
    return Surface("F", points, grid_triangles(len(along), len(down)))


def bottom(surface: Surface) -> IntArray:
    rows = len(surface.vertices) // len(ALONG)
    return ints(np.arange(len(ALONG)) * rows + rows - 1)


def least_angle(surface: Surface, triangles: IntArray) -> float:
    edges = np.diff(surface.vertices[surface.triangles[triangles][:, [0, 1, 2, 0]]], axis=1)
    size = np.linalg.norm(edges, axis=2)
    cosine = -(edges * np.roll(edges, 1, axis=1)).sum(axis=2) / size / np.roll(size, 1, axis=1)
    return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))).min())


def assert_sound(made: Extension, old: Surface) -> None:
    new = made.surface
    assert made.folded == 0
    assert np.array_equal(new.vertices[: len(old.vertices)], old.vertices)
    assert np.array_equal(new.triangles[: len(old.triangles)], old.triangles)
    assert np.array_equal(made.triangles, np.arange(len(old.triangles), len(new.triangles)))
    assert len(boundary_loops(new.triangles)) == len(boundary_loops(old.triangles))
    assert oriented(new).triangles.shape == new.triangles.shape
    turned = oriented(new).triangles
    assert np.array_equal(turned, new.triangles) or not (turned == new.triangles).all(axis=1).any()
    far = cKDTree(new.vertices).query(new.vertices, 2)[0][:, 1]
    assert far.min() > 1.0


@pytest.mark.parametrize("length", [30.0, 100.0, 130.0, 250.0, 1000.0])
def test_a_rectangle_extended_on_one_side_is_a_longer_rectangle(length: float) -> None:
    surface = sheet(plane)
    made = extended(surface, bottom(surface), length)
    assert_sound(made, surface)
    assert abs(made.surface.vertices @ NORMAL).max() < 1e-9
    assert made.patch.vertices[:, 0].min() == pytest.approx(0.0, abs=1e-9)
    assert made.patch.vertices[:, 0].max() == pytest.approx(2000.0)
    assert triangle_areas(made.patch.vertices, made.patch.triangles).sum() == pytest.approx(2000 * length)
    assert length < 60 or least_angle(made.surface, made.triangles) > 30


def test_two_sides_meet_in_a_corner() -> None:
    surface = sheet(plane)
    chain = [*bottom(surface), *np.arange(len(surface.vertices) - 1)[::-1][:8]]
    made = extended(surface, ints(chain), 250.0)
    assert_sound(made, surface)
    area = triangle_areas(made.patch.vertices, made.patch.triangles).sum()
    assert area == pytest.approx(2250 * 1050 - 2000 * 800)
    assert least_angle(made.surface, made.triangles) > 15


def test_a_whole_rim_grows_into_a_larger_rectangle() -> None:
    surface = sheet(plane)
    chain = rim_chain(surface, 36, 36)
    assert chain[0] == chain[-1]
    made = extended(surface, chain, 300.0)
    assert_sound(made, surface)
    area = triangle_areas(made.patch.vertices, made.patch.triangles).sum()
    assert area == pytest.approx(2600 * 1400 - 2000 * 800)
    assert least_angle(made.surface, made.triangles) > 15


def test_a_parallelogram_stays_one() -> None:
    surface = sheet(lambda a, b: (a + 0.5 * b, 0.5 * b, -0.8 * b))
    made = extended(surface, bottom(surface), 300.0)
    assert_sound(made, surface)
    assert triangle_areas(made.patch.vertices, made.patch.triangles).sum() == pytest.approx(2000 * 300)


def test_a_taper_ends_at_the_vertices_without_length() -> None:
    surface = sheet(plane)
    length = np.array([0.0, 60, 120, 250, 300, 250, 120, 60, 0])
    made = extended(surface, bottom(surface)[5:14], length)
    assert_sound(made, surface)
    area = triangle_areas(made.patch.vertices, made.patch.triangles).sum()
    assert area == pytest.approx(100 * length.sum(), rel=1e-6)
    assert least_angle(made.surface, made.triangles) > 15


@pytest.mark.parametrize(("shape", "share"), [(plane, 1e-12), (listric, 0.003), (corrugated, 0.03)])
@pytest.mark.parametrize("rows", [1, 2, 4, 6])
def test_what_was_cut_off_comes_back(shape: Shape, share: float, rows: int) -> None:
    down = np.linspace(0.0, 1800.0, 19)
    whole, cut = sheet(shape, down=down), sheet(shape, down=down[:-rows])
    made = extended(cut, bottom(cut), 100.0 * rows)
    assert_sound(made, cut)
    lost = nearest(whole.vertices, made.surface.vertices, made.surface.triangles).distance
    grown = nearest(made.surface.vertices, whole.vertices, whole.triangles).distance
    assert max(lost.max(), grown.max()) < share * 100 * rows


def test_a_curve_straightens_and_does_not_curl() -> None:
    surface = sheet(listric, down=np.linspace(0.0, 1200.0, 13))
    made = extended(surface, bottom(surface), 9000.0, edge=300.0)
    assert made.folded == 0
    dips = triangle_dips(made.patch.vertices, made.patch.triangles)
    assert dips.min() > 70 - np.degrees(1200 / 3000) - 31


def test_the_way_the_chain_runs_does_not_matter() -> None:
    surface = sheet(corrugated)
    length = np.linspace(50.0, 300.0, len(ALONG))
    one = extended(surface, bottom(surface), length)
    two = extended(surface, ints(bottom(surface)[::-1]), length[::-1])
    assert np.array_equal(one.surface.vertices, two.surface.vertices)
    assert np.array_equal(one.surface.triangles, two.surface.triangles)


def test_it_turns_and_shifts_with_the_model() -> None:
    surface = sheet(corrugated)
    c, s = np.cos(0.65), np.sin(0.65)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    offset = np.array([5e5, 6e6, 0.0])
    one = extended(surface, bottom(surface), 270.0).surface
    two = extended(surface.with_vertices(surface.vertices @ turn.T + offset), bottom(surface), 270.0).surface
    assert np.array_equal(one.triangles, two.triangles)
    assert abs(one.vertices @ turn.T + offset - two.vertices).max() < 1e-6


def test_a_steep_rough_fault_stays_a_function_of_x_and_y() -> None:
    rng = np.random.default_rng(0)
    surface = sheet(lambda a, b: (a, 0.17 * b + 2 * rng.standard_normal(a.shape), -0.98 * b))
    made = extended(surface, bottom(surface), 400.0)
    assert made.folded == 0
    corners = made.surface.vertices[made.surface.triangles]
    up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert (up[made.triangles] > 0).all() or (up[made.triangles] < 0).all()


@pytest.mark.parametrize("length", [200.0, 500.0])
def test_a_round_fault_grows_all_around(length: float) -> None:
    radius, angle = np.meshgrid(np.linspace(0.1, 1, 7), np.arange(36) * np.pi / 18)
    flat = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1).reshape(-1, 2)
    points = np.column_stack([1500 * flat[:, 0], 350 * flat[:, 1], -606 * flat[:, 1]])
    surface = oriented(Surface("E", points, Delaunay(flat).simplices))
    made = extended(surface, boundary_loops(surface.triangles)[0], length)
    assert_sound(made, surface)
    assert least_angle(made.surface, made.triangles) > 15


def test_no_length_changes_nothing() -> None:
    surface = sheet(plane)
    made = extended(surface, bottom(surface), 0.0)
    assert made.surface is surface
    assert len(made.patch.triangles) == 0


def test_what_folds_over_is_said() -> None:
    surface = sheet(plane)
    middle = surface.vertices[surface.triangles].mean(axis=1)
    notch = (abs(middle[:, 0] - 1000) < 200) & (middle[:, 1] > 200)
    kept = Surface("N", surface.vertices, surface.triangles[~notch])
    chain = boundary_loops(kept.triangles)[0]
    assert extended(kept, chain, 100.0).folded == 0
    assert extended(kept, chain, 600.0).folded > 0


def test_vertices_inside_are_no_rim() -> None:
    with pytest.raises(GrabenError, match="no stretch of the rim"):
        extended(sheet(plane), ints([30, 31]), 100.0)
    with pytest.raises(GrabenError, match="no rim leads"):
        rim_chain(sheet(plane), 30, 31)


def test_a_stretch_that_misses_a_fraction_of_an_edge_is_the_side() -> None:
    surface = sheet(plane)
    side = bottom(surface)
    ends = surface.vertices[side]
    path = np.concatenate([[ends[0] + 0.7 * (ends[1] - ends[0])], ends[1:-1], [ends[-2] + [30.0, 0, 0]]])
    assert sorted(stretch_chain(surface, path, 1e-3)) == sorted(side)
    part = np.concatenate([[ends[4] + [20.0, 0, 0]], ends[5:9], [ends[8] + [20.0, 0, 0]]])
    assert sorted(stretch_chain(surface, part, 1e-3)) == sorted(side[4:9])
    assert len(stretch_chain(surface, part + np.array([0, 0, 50.0]), 1e-3)) == 0


def test_a_stretch_around_the_rim_is_closed() -> None:
    surface = sheet(plane)
    loop = boundary_loops(surface.triangles)[0]
    chain = stretch_chain(surface, surface.vertices[loop], 1e-3)
    assert chain[0] == chain[-1]
    assert set(chain.tolist()) == set(loop.tolist())


@pytest.mark.parametrize("length", [60.0, 120.0, 300.0])
def test_a_flat_last_row_is_not_continued_into_a_lid(length: float) -> None:
    """Four rows that dip 40, 40, 40 and 18 degrees would be level a row further on."""
    dips = np.radians([40.0, 40.0, 40.0, 18.0])
    rows = np.vstack([[0.0, 0.0], np.cumsum(230.0 * np.column_stack([np.cos(dips), -np.sin(dips)]), axis=0)])
    along = np.repeat(np.arange(12) * 200.0, len(rows))
    points = np.column_stack([along, np.tile(rows, (12, 1))])
    surface = Surface("F", points, grid_triangles(12, len(rows)))
    made = extended(surface, ints(np.arange(12) * len(rows) + len(rows) - 1), length)
    assert_sound(made, surface)
    assert made.flat == 0
    assert triangle_dips(made.patch.vertices, made.patch.triangles).min() > 18.0
