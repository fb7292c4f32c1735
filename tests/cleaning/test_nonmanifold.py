"""Crowded edges and touching fans: fins and second sheets go, parts are taken apart, the rest stays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.arrays import ints
from graben.cleaning.nonmanifold import REPAIR, made_manifold
from graben.cleaning.shaping.fans import trouble
from graben.cleaning.shaping.limits import distances
from graben.cleaning.weld import welded
from graben.surface import Surface, strong_components
from tests.cleaning.cracked import area, outline, rim_length
from tests.cleaning.tasks import applied, found, proposed
from tests.zoo.manifold import FAILING, PASSING, perforated
from tests.zoo.shapes import AT_MIDDLE, F60, MIDDLE, STEP, dipping, faults, joined, sheet

OF_FAULTS = [case for case in FAILING if case.objects == ("F",) and case.extended == "fail"]
WHOLE = {"two holes that touch": perforated((2, 3), (3, 4)), "fin and hole": perforated((4, 4))}
NEAR = 0.5 * STEP


def wall(height: int) -> Surface:
    """F60 with a wall of so many rows along a line from rim to rim."""
    up = np.array([0, 40.0, 30.0])
    side = sheet(6, height, lambda i, j: (STEP * i, up[1] * j + F60.vertices[2, 1], up[2] * j))
    side = side.moved(np.array([0, 0, F60.vertices[2, 2]]))
    line = F60.vertices[2::5]
    near = np.linalg.norm(side.vertices[:, None] - line, axis=2)
    points = np.where((near.min(axis=1) < 1e-6)[:, None], line[near.argmin(axis=1)], side.vertices)
    return welded(joined(F60, side.with_vertices(points)))


def pocket(height: float) -> Surface:
    """F60 with a second sheet over one of its triangles, glued to it along three edges."""
    a, b, c = F60.triangles[13]
    tip = F60.vertices[[a, b, c]].mean(axis=0) + height * np.array([0, np.sin(np.pi / 3), 0.5])
    n = len(F60.vertices)
    return replace(
        F60,
        vertices=np.vstack([F60.vertices, tip]),
        triangles=np.concatenate([F60.triangles, [[a, b, n], [b, c, n], [c, a, n]]]),
    )


@pytest.mark.parametrize("case", OF_FAULTS, ids=lambda case: case.name)
def test_what_fails_passes_and_keeps_area_and_rim(case):
    task, (change,), refusals = proposed(case.model, REPAIR)
    assert not refusals
    (made,) = change.surfaces["F"]
    whole = WHOLE.get(case.name, F60)
    assert not found(applied(task.model, change), "manifold", REPAIR)
    assert area(made) == pytest.approx(area(whole), rel=1e-2)
    assert rim_length(made) == pytest.approx(rim_length(whole), rel=1e-2)
    assert not strong_components(made.triangles).any()
    assert distances(made, [task.references["F"]]).max() < 1e-9
    assert made_manifold(made, NEAR).surface is made
    assert welded(made) is made


@pytest.mark.parametrize("case", PASSING, ids=lambda case: case.name)
def test_what_passes_is_the_same_surface(case):
    for fault in case.model.faults:
        assert made_manifold(fault.surface, NEAR).surface is fault.surface


def test_a_fin_goes_and_all_else_stays_to_the_bit():
    fin = replace(
        F60,
        vertices=np.vstack([F60.vertices, np.add(AT_MIDDLE, [[25, 0, 60], [70, 0, 60]])]),
        triangles=np.concatenate([[[MIDDLE, MIDDLE + 5, 35], [MIDDLE + 5, 36, 35]], F60.triangles]),
    )
    made = made_manifold(fin, NEAR)
    assert np.array_equal(made.surface.vertices, F60.vertices)
    assert np.array_equal(made.surface.triangles, F60.triangles)
    assert made.dropped == 2
    assert made.area == pytest.approx(area(fin) - area(F60))


def test_a_large_sheet_becomes_a_component_of_its_own():
    both = wall(3)
    made = made_manifold(both, NEAR)
    assert trouble(made.surface.triangles) == (0, 0)
    assert made.dropped == 0
    part = strong_components(made.surface.triangles)
    assert part.max() == 1
    main = made.surface.triangles[part == part[0]]
    assert np.array_equal(main, both.triangles[: len(main)])
    assert np.array_equal(made.surface.vertices[: len(both.vertices)], both.vertices)
    assert made.copies == 7
    assert area(made.surface) == pytest.approx(area(both), rel=1e-2)
    assert welded(made.surface) is made.surface


@pytest.mark.parametrize("height", [0.05 * STEP, 0.4 * STEP])
def test_of_two_sheets_the_one_that_continues_the_surface_stays(height):
    made = made_manifold(pocket(height), NEAR).surface
    assert np.array_equal(made.triangles, F60.triangles)
    assert np.array_equal(made.vertices, F60.vertices)


def test_a_second_sheet_over_half_the_fault_goes():
    i, j = np.arange(35) // 5, np.arange(35) % 5
    patch, middle = (i > 0) & (i < 6) & (j > 0) & (j < 4), (i > 1) & (i < 5) & (j == 2)
    over = F60.triangles[patch[F60.triangles].all(axis=1)]
    lifted = F60.vertices + middle[:, None] * np.array([0, 3.0, 2.0])
    doubled = welded(joined(F60, replace(F60, vertices=lifted, triangles=over)))
    assert trouble(doubled.triangles)[0] > 5
    made = made_manifold(doubled, NEAR).surface
    assert trouble(made.triangles) == (0, 0)
    assert area(made) == pytest.approx(area(F60), rel=1e-2)
    assert not strong_components(made.triangles).any()


@pytest.mark.parametrize("corner", [0, 1, 2])
def test_a_triangle_with_a_wrong_corner_goes(corner):
    triangles = F60.triangles.copy()
    triangles[13, corner] = 29
    made = made_manifold(replace(F60, triangles=triangles), NEAR).surface
    assert trouble(made.triangles) == (0, 0)
    kept = {tuple(t) for t in made.triangles}
    assert sum(tuple(t) in kept for t in F60.triangles) >= 46
    assert welded(made) is made


def test_parts_of_one_size_that_touch_are_taken_apart():
    one = dipping(60, 3, 4)
    two = welded(joined(one, one.moved(one.vertices[-1])))
    assert trouble(two.triangles) == (0, 1)
    made = made_manifold(two, NEAR)
    assert trouble(made.surface.triangles) == (0, 0)
    assert (made.copies, made.dropped) == (1, 0)
    gap = np.linalg.norm(made.surface.vertices[-1] - two.vertices, axis=1).min()
    assert 1e-3 * STEP < gap < 0.05 * STEP


def test_no_triangle_fits_anywhere_is_refused_or_passes():
    rng = np.random.default_rng(0)
    for _ in range(20):
        wild = Surface("F", F60.vertices, rng.integers(35, size=(60, 3)))
        made = made_manifold(wild, NEAR)
        assert made_manifold(wild, NEAR).surface.triangles.tolist() == made.surface.triangles.tolist()
        crowded, _ = trouble(made.surface.triangles)
        assert crowded <= trouble(wild.triangles)[0]


def test_lines_rotation_shift_and_order():
    both = wall(2)
    both = replace(both, lines=np.arange(1, len(both.triangles) + 1))
    made = made_manifold(both, NEAR).surface
    assert np.array_equal(made.lines, both.lines)
    turn = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    moved = made_manifold(both.with_vertices(both.vertices @ turn.T + [5e5, 6e6, 0]), NEAR).surface
    assert np.array_equal(moved.triangles, made.triangles)
    order = np.random.default_rng(3).permutation(len(both.triangles))
    mixed = made_manifold(replace(both, triangles=ints(both.triangles[order])), NEAR).surface
    assert np.allclose(outline(mixed), outline(made), atol=1e-9)


def test_faults_with_their_own_trouble_are_changed_one_by_one():
    _, changes, _ = proposed(faults(pocket(10.0), replace(wall(1), name="G")), REPAIR)
    assert [list(c.surfaces) for c in changes] == [["F"], ["G"]]
