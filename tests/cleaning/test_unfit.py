"""Coordinates that are no place: restored where the surface is whole around them, else left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.cleaning.shaping.limits import distances
from graben.cleaning.shaping.regular import MOST_REGULAR
from graben.cleaning.unfit import MOST_TOGETHER, REPAIR, made_fit
from graben.surface import Surface, boundary_edges, triangle_areas
from tests.cleaning.tasks import applied, found, proposed
from tests.zoo.finite import FAILING, PASSING
from tests.zoo.shapes import AT_MIDDLE, F60, MIDDLE, NAN, STEP, dipping, faults, moved_vertex, sheet

OF_FAULTS = [case for case in FAILING if case.objects == ("F",)]


def area(surface: Surface) -> float:
    return float(triangle_areas(surface.vertices, surface.triangles).sum())


@pytest.mark.parametrize("case", OF_FAULTS, ids=lambda case: case.name)
def test_what_fails_passes_and_keeps_area_and_rim(case):
    task, (change,), refusals = proposed(case.model, REPAIR)
    assert not refusals
    after = applied(task.model, change)
    assert not found(after, "finite", REPAIR)
    (made,) = change.surfaces["F"]
    assert area(made) == pytest.approx(area(F60), rel=1e-12)
    assert len(boundary_edges(made.triangles)) == len(boundary_edges(F60.triangles))
    references = [task.references["F"], *change.declared.values()]
    assert distances(made, references).max() < 1e-9 * STEP
    assert proposed(after, REPAIR)[1] == []


@pytest.mark.parametrize("case", PASSING, ids=lambda case: case.name)
def test_what_passes_is_the_same_surface(case):
    for surface in case.model.surfaces:
        assert made_fit(surface).surface is surface


def test_restored_to_the_mean_and_nothing_else_moves():
    fit = made_fit(moved_vertex(F60, MIDDLE, [NAN, NAN, 1e30]))
    assert np.allclose(fit.surface.vertices[MIDDLE], AT_MIDDLE, atol=1e-12 * STEP)
    others = np.arange(len(F60.vertices)) != MIDDLE
    assert np.array_equal(fit.surface.vertices[others], F60.vertices[others])
    assert np.array_equal(fit.surface.triangles, F60.triangles)
    assert fit.restored.tolist() == [MIDDLE]


def test_neighbours_are_restored_together_up_to_a_number():
    large = dipping(60, 8, 8)
    row = 4 * 9 + 3 + np.arange(MOST_TOGETHER)
    fit = made_fit(moved_vertex(large, row, NAN))
    assert np.allclose(fit.surface.vertices, large.vertices, atol=1e-9)


def test_too_many_neighbours_go_with_their_triangles():
    large = dipping(60, 16, 16)
    block = (4 + np.arange(6))[:, None] * 17 + 4 + np.arange(6)
    assert block.size > MOST_REGULAR
    holed = made_fit(moved_vertex(large, block.ravel(), NAN))
    assert holed.lost == block.size
    gone = np.isin(large.triangles, block).any(axis=1)
    assert holed.dropped == gone.sum()
    assert area(holed.surface) == pytest.approx(triangle_areas(large.vertices, large.triangles[~gone]).sum())


@pytest.mark.parametrize(
    "lost",
    [
        [10],  # in the middle of the upper rim
        [0],  # a corner with two triangles
        [4],  # a corner with one
        [12, 13, 14, 17, 18],  # inside, more than are put in a mean
        [20, 25, 26, 21, 31],  # along the rim, two deep
    ],
    ids=str,
)
def test_a_regular_mesh_comes_back_whole(lost):
    fit = made_fit(moved_vertex(F60, lost, NAN))
    assert np.allclose(fit.surface.vertices, F60.vertices, atol=1e-9 * STEP)
    assert np.array_equal(fit.surface.triangles, F60.triangles)
    assert fit.restored.tolist() == sorted(lost)


def test_a_rim_is_restored_close_to_a_bent_sheet():
    bent = sheet(12, 8, lambda i, j: (STEP * i, 25 * j + 15 * np.cos(0.5 * i), -STEP * j))
    rim = [9 * 5, 9 * 6, 9 * 6 + 1, 9 * 12 + 4]
    made = made_fit(moved_vertex(bent, rim, NAN)).surface
    assert np.linalg.norm(made.vertices[rim] - bent.vertices[rim], axis=1).max() < 0.1 * STEP
    assert area(made) == pytest.approx(area(bent), rel=2e-3)


def test_a_place_that_makes_a_sliver_is_not_taken():
    x = [[0, 0, 0], [1, 0, 0], [0.5, 40, 0], [NAN] * 3, [-40, -1, 0]]
    fit = made_fit(Surface("F", x, [[0, 1, 2], [1, 0, 3], [0, 2, 4]]))
    assert (fit.lost, fit.dropped, len(fit.restored)) == (1, 1, 0)


def test_lines_follow_and_all_kinds_at_once():
    damaged = moved_vertex(moved_vertex(F60, MIDDLE, NAN), 0, np.inf)
    damaged = replace(damaged, triangles=np.concatenate([damaged.triangles, [[1, 2, 99], [-1, 3, 4]]]))
    damaged = replace(damaged, lines=np.arange(1, len(damaged.triangles) + 1))
    fit = made_fit(damaged)
    corners = damaged.vertices[damaged.triangles[fit.surface.lines - 1]]
    same = np.isfinite(corners)
    assert np.array_equal(fit.surface.vertices[fit.surface.triangles][same], corners[same])
    assert made_fit(fit.surface).surface is fit.surface
    assert not found(faults(fit.surface), "finite", REPAIR)


def test_rotation_shift_and_order_do_not_matter():
    bent = sheet(8, 8, lambda i, j: (STEP * i, 25 * j + 30 * np.cos(i), -STEP * j))
    plain = made_fit(moved_vertex(bent, [40, 41, 60], NAN)).surface
    turn = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    away = np.array([5e5, 6e6, 0])
    turned = made_fit(moved_vertex(bent.with_vertices(bent.vertices @ turn.T + away), [40, 41, 60], NAN))
    assert np.allclose(turned.surface.vertices, plain.vertices @ turn.T + away, atol=1e-8)
    order = np.random.default_rng(1).permutation(len(bent.triangles))
    mixed = made_fit(replace(moved_vertex(bent, [40, 41, 60], NAN), triangles=bent.triangles[order]))
    assert np.allclose(mixed.surface.vertices, plain.vertices, atol=1e-9)


def test_nothing_left_is_refused():
    nothing = F60.with_vertices(np.full_like(F60.vertices, NAN))
    assert made_fit(nothing).surface.triangles.size == 0
    _, changes, (refusal,) = proposed(faults(nothing, dipping(60, name="G")), REPAIR)
    assert not changes
    assert "F" in refusal.objects
