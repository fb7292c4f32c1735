"""Cutting a surface along a level of a function: exact rims, good triangles, nothing else touched."""

from __future__ import annotations

import numpy as np
import pytest

from graben.cleaning.shaping.trimming import cut_along, divided, main_part, part_of, trimmed
from graben.surface import Surface, boundary_loops, edge_sharing, edge_table, triangle_areas
from graben.validators.measuring.measures import angles_of
from tests.zoo.shapes import STEP, sheet


def wavy(columns: int = 14, rows: int = 10, seed: int = 1) -> Surface:
    """A curved sheet with its vertices shaken by up to a fifth of a step in the sheet."""
    shake = np.random.default_rng(seed).uniform(-0.2, 0.2, (2, (columns + 1) * (rows + 1)))

    def place(i, j):
        x, y = i + shake[0], j + shake[1]
        return STEP * x, STEP * (0.5 * y + 0.3 * np.sin(0.4 * x)), -STEP * (0.87 * y + 0.2 * np.cos(0.5 * x))

    return sheet(columns, rows, place)


def area(surface: Surface) -> float:
    return float(triangle_areas(surface.vertices, surface.triangles).sum())


def sound(surface: Surface) -> None:
    """Assert a manifold surface without unused vertices."""
    edges, sides = edge_table(surface.triangles)
    assert edge_sharing(sides, len(edges)).max() <= 2
    assert np.array_equal(np.unique(surface.triangles), np.arange(len(surface.vertices)))
    assert all(len(np.unique(loop[:-1])) == len(loop) - 1 for loop in boundary_loops(surface.triangles))


LEVELS = [
    lambda v, s: v[:, 0] - s * STEP,
    lambda v, s: v[:, 0] + 0.61 * v[:, 2] - (s - 3) * STEP,
    lambda v, s: np.hypot(v[:, 0] - 7 * STEP, v[:, 2] + 4 * STEP) - s * STEP / 2,
]


@pytest.mark.parametrize("level", range(3))
@pytest.mark.parametrize("shift", np.linspace(2.05, 6.3, 9))
def test_cut_is_exact_and_without_slivers(level, shift):
    surface = wavy()
    values = LEVELS[level](surface.vertices, shift)
    kept, left = divided(surface, values)
    assert angles_of(kept).min() > 5.0
    assert angles_of(left).min() > 5.0
    # a snapped vertex leaves the curved surface a little
    assert area(kept) + area(left) == pytest.approx(area(surface), rel=5e-3)
    sound(kept)
    sound(left)
    cut = cut_along(surface, values)
    on_line = cut.values == 0
    # on a level that is linear in space the cut lies on the level itself
    if level < 2:
        assert np.abs(LEVELS[level](cut.surface.vertices, shift)[on_line]).max() < 1e-9 * STEP
    rim = kept.vertices[np.unique(np.concatenate(boundary_loops(kept.triangles)))]
    old = surface.vertices[np.unique(np.concatenate(boundary_loops(surface.triangles)))]
    new = rim[~(rim[:, None] == old).all(axis=2).any(axis=1)]
    assert len(new)
    placed = {tuple(p) for p in cut.surface.vertices[on_line]}
    assert all(tuple(p) in placed for p in new)


def test_what_is_away_from_the_cut_stays_to_the_bit():
    surface = wavy()
    values = surface.vertices[:, 0] - 4.3 * STEP
    kept = trimmed(surface, values)
    far = surface.vertices[values > 1.5 * STEP]
    where = [np.flatnonzero((kept.vertices == p).all(axis=1)) for p in far]
    assert all(len(w) == 1 for w in where)
    assert (np.diff(np.concatenate(where)) > 0).all()


def test_nothing_negative_is_the_same_surface_and_nothing_positive_no_triangle():
    surface = wavy()
    assert trimmed(surface, np.ones(len(surface.vertices))) is surface
    assert len(trimmed(surface, -np.ones(len(surface.vertices))).triangles) == 0
    assert trimmed(surface, np.maximum(surface.vertices[:, 0], 0)) is surface


def test_trimming_again_changes_nothing():
    surface = wavy()
    once = trimmed(surface, surface.vertices[:, 0] - 4.3 * STEP)
    again = trimmed(once, np.where(np.abs(v := once.vertices[:, 0] - 4.3 * STEP) < 1e-9, 0, v))
    assert again is once


def test_both_parts_have_the_same_edges_along_the_cut():
    surface = wavy()
    kept, left = divided(surface, surface.vertices[:, 0] - 5.15 * STEP)
    shared = {tuple(p) for p in kept.vertices} & {tuple(p) for p in left.vertices}
    along = np.array(sorted(shared))
    assert len(along) >= 11
    assert np.abs(along[:, 0] - 5.15 * STEP).max() < 1e-9


def test_held_vertices_stay_and_the_cut_goes_through_them():
    surface = wavy()
    values = surface.vertices[:, 0] - 4.0 * STEP
    held = np.ones(len(surface.vertices), dtype=bool)
    cut = cut_along(surface, values, held)
    assert np.array_equal(cut.surface.vertices[: len(surface.vertices)], surface.vertices)
    assert (cut.values[: len(values)] == 0).any()
    assert angles_of(trimmed(surface, values, held)).min() > 5.0


def test_corners_of_the_rim_stay_on_the_rim():
    flat = sheet(6, 6, lambda i, j: (STEP * i, STEP * j, 0 * i))
    kept = trimmed(flat, flat.vertices[:, 0] + 0.3 * flat.vertices[:, 1] - 2.1 * STEP)
    assert kept.vertices[:, 1].min() == 0
    assert kept.vertices[:, 1].max() == 6 * STEP
    missing = 0.5 * (2.1 + 0.3) * 6
    assert area(kept) == pytest.approx((36 - missing) * STEP**2, rel=1e-12)


def test_order_of_triangles_and_rotation_do_not_matter():
    surface = wavy()
    values = LEVELS[1](surface.vertices, 4.4)
    kept = trimmed(surface, values)
    order = np.random.default_rng(3).permutation(len(surface.triangles))
    mixed = trimmed(Surface("F", surface.vertices, surface.triangles[order]), values)
    assert np.array_equal(np.unique(kept.vertices, axis=0), np.unique(mixed.vertices, axis=0))
    turn = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    turned = trimmed(surface.with_vertices(surface.vertices @ turn.T + [5e5, 6e6, 0]), values)
    assert len(turned.triangles) == len(kept.triangles)
    assert area(turned) == pytest.approx(area(kept), rel=1e-9)


def test_main_part_is_the_largest():
    surface = wavy()
    middle = np.abs(surface.vertices[:, 0] - 4 * STEP) - STEP
    two = trimmed(surface, middle)
    main = main_part(two)
    assert 0.5 * area(two) < area(main) < area(two)
    assert main.vertices[:, 0].min() > 4.9 * STEP
    assert main_part(main) is main
    assert part_of(main, np.ones(len(main.triangles), dtype=bool)) is main


def test_lines_of_the_file_follow_their_triangles():
    surface = wavy()
    surface = Surface("F", surface.vertices, surface.triangles, np.arange(1, len(surface.triangles) + 1))
    cut = cut_along(surface, surface.vertices[:, 0] - 4.3 * STEP)
    assert np.array_equal(cut.surface.lines, cut.parent + 1)
    assert len(part_of(cut.surface, cut.kept).lines) == cut.kept.sum()
