"""Where two surfaces meet: kinds, lengths and counts that are known, whatever the digits and the frame."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graben.refinement import refined
from graben.surface import Surface
from graben.validators.measuring.contacts import Contact, ContactKind, contacts
from graben.validators.measuring.leaving import broken_by_holes
from tests.strategies import motions
from tests.validators.piercing import crosses_properly, touching_pairs
from tests.zoo.near_miss import G, splay
from tests.zoo.shapes import STEP, dipping, joined, scene, sheet
from tests.zoo.simplicial_complex import (
    F,
    coplanar,
    crossed_in_edges,
    joined_at_rim,
    roof,
    strayed,
    tip,
    with_hole,
)

TOLERANCE = 2e-3
EASY = settings(max_examples=25, deadline=None, derandomize=True, database=None)


def met(*surfaces: Surface, tolerance: float = TOLERANCE) -> tuple[Contact, ...]:
    return contacts(surfaces, refined(surfaces), tolerance)


def kinds(found: tuple[Contact, ...]) -> list[ContactKind]:
    return [c.kind for c in found]


def upright(x: float, start: float, end: float, columns: int, name: str = "G") -> Surface:
    """A vertical fault in the plane of one x, from one y to the other, 400 m high."""
    step = (end - start) / columns
    return sheet(columns, 4, lambda i, j: (x + 0 * i, start + step * i, -100.0 * j), name)


def test_faults_that_keep_apart_have_no_contact():
    assert met(splay(140), G) == ()
    assert met(splay(1), G) == ()


def test_a_crossing_has_the_length_of_the_line_and_its_pairs_of_triangles():
    pair = splay(-300).moved(np.array([3.0, 7, 11])), G
    (found,) = met(*pair)
    assert found.kind is ContactKind.CROSSING
    assert found.surfaces == (0, 1)
    (path,) = found.paths
    assert np.linalg.norm(path[-1] - path[0]) == pytest.approx(found.size)
    assert found.size == pytest.approx(8 * STEP, rel=0.1)
    touching, _ = touching_pairs(pair)
    crossing = touching[crosses_properly(pair, touching)]
    assert found.count == len(crossing) == len(path) - 1
    # the first surface comes first in the stack
    assert set(found.triangles[0]) == set(crossing.min(axis=1))


@pytest.mark.parametrize("angle", [2.0, 5.0, 30.0, 89.0])
def test_a_crossing_at_a_small_angle_is_one(angle):
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    plain = sheet(7, 5, lambda i, j: (100 * i, 100 * j, 0 * i))
    tilted = sheet(6, 9, lambda i, j: (40 + 80 * i, 233.3 + c * 60 * (j - 4.4), s * 60 * (j - 4.4)), "G")
    (found,) = met(plain, tilted, tolerance=1e-3)
    assert found.kind is ContactKind.CROSSING
    assert found.size == pytest.approx(480, rel=1e-9)


@pytest.mark.parametrize("decimals", [3, 2])
def test_a_rim_that_lies_on_the_other_to_the_digits_of_a_file_is_a_t_contact(decimals):
    rounded = [s.with_vertices(np.round(s.vertices, decimals)) for s in (splay(0), G)]
    (found,) = met(*rounded, tolerance=2.0 * 10.0**-decimals)
    assert found.kind is ContactKind.T
    assert found.rims == (0,)
    assert found.count == 8
    assert found.size == pytest.approx(8 * STEP, rel=1e-4)
    assert found.passing > 0


def test_a_stub_wider_than_the_tolerance_is_a_crossing():
    assert kinds(met(strayed(lambda row: 0.5 + 0 * row), G)) == [ContactKind.CROSSING]
    assert kinds(met(strayed(lambda row: 0.5 + 0 * row), G, tolerance=1.0)) == [ContactKind.T]


def test_a_rim_on_the_other_where_that_ends_in_the_middle_of_an_edge():
    """The line ends where the other does, though no vertex says so and rounding decides what crosses."""
    wall = sheet(1, 1, lambda i, j: (400.0 * i, 0 * i, -400.0 * j), "F")
    for noise in (0.0, 1e-10, -1e-10):
        (found,) = met(wall, upright(150 + noise, noise, 300, 3).moved(np.array([0, 0, 130])))
        assert (found.kind, found.rims) == (ContactKind.T, (1,))
        assert found.size == pytest.approx(270, abs=0.01)


def test_rims_that_run_on_each_other_end_both():
    first = sheet(2, 2, lambda i, j: (100.0 * i, 0 * i, -100.0 * j), "F")
    second = sheet(3, 3, lambda i, j: (200 + 50.0 * i, 60.0 * i, -200 / 3 * j), "G")
    (found,) = met(first, second)
    assert (found.kind, found.rims) == (ContactKind.T, (0, 1))
    assert found.size == pytest.approx(200)


def test_common_edges_are_told_by_equal_bits():
    for pair in (joined_at_rim(), crossed_in_edges()):
        (found,) = met(*pair)
        assert (found.kind, found.count) == (ContactKind.EDGE, 6)
        assert found.size == pytest.approx(6 * STEP)
    first, second = joined_at_rim()
    (off,) = met(first, second.moved(np.array([0, 0, 1e-9])))
    assert off.kind is ContactKind.T


def test_a_touching_corner_is_a_point():
    (found,) = met(F, tip())
    assert (found.kind, found.count, found.size) == (ContactKind.POINT, 1, 0.0)
    assert np.linalg.norm(found.places[0] - tip().vertices[0]) < TOLERANCE
    held = tip().with_vertices(tip().vertices + (F.vertices[60] - tip().vertices[0]))
    (found,) = met(F, held.with_vertices(np.vstack([F.vertices[60], held.vertices[1:]])))
    assert found.kind is ContactKind.VERTEX


@pytest.mark.parametrize("off", [0.0, 1e-4, -1e-4])
def test_a_ridge_that_touches_is_a_line_whichever_side_rounding_puts_it(off):
    normal = np.array([0, np.sqrt(0.75), 0.5])
    (found,) = met(F, roof().moved(off * normal))
    assert found.kind is ContactKind.LINE
    assert found.size == pytest.approx(4 * STEP, rel=1e-5)


@pytest.mark.parametrize("off", [0.0, 1e-3])
def test_an_overlap_has_the_area_in_which_they_lie_on_each_other(off):
    (found,) = met(F, coplanar().moved(np.array([0, 0, off])))
    assert found.kind is ContactKind.AREA
    assert found.size == pytest.approx(15 * STEP**2, rel=1e-4)


def test_two_sheets_side_by_side_do_not_overlap():
    """They have a rim in common, and the strip in which they lie on each other is no wider than that."""
    first, second = dipping(60, 4, 4), dipping(60, 4, 4, "G")
    assert kinds(met(first, second.moved(np.array([4 * STEP, 0, 0])))) == [ContactKind.EDGE]
    assert kinds(met(first, second.moved(np.array([4 * STEP - 1e-4, 0, 0])))) == [ContactKind.T]


def test_a_piece_may_hold_two_kinds():
    first, second = met(strayed(lambda row: np.maximum(row - 4, 0) * 30.0), G)
    assert {first.kind, second.kind} == {ContactKind.T, ContactKind.CROSSING}
    assert first.piece == second.piece == 0
    assert first.size + second.size == pytest.approx(8 * STEP, rel=1e-6)


def test_pieces_are_numbered_from_the_longest():
    found = met(strayed(lambda row: -20.0 * (row == 5)), G)
    assert [(c.piece, round(c.size)) for c in found] == [(0, 200), (1, 100)]


def test_each_pair_of_three_faults_on_one_line_has_its_contact():
    blades = []
    for k, name in enumerate("ABC"):
        way = np.array([np.cos(k), np.sin(k)])
        blades.append(
            sheet(4, 3, lambda i, j, way=way: (30 * way[0] * (i - 2), 30 * way[1] * (i - 2), -30 * j), name)
        )
    found = met(*blades)
    assert [c.surfaces for c in found] == [(0, 1), (0, 2), (1, 2)]
    assert kinds(found) == [ContactKind.EDGE] * 3
    found = met(*(b.moved(np.array([0, 0, 7.0 * k])) for k, b in enumerate(blades)))
    assert kinds(found) == [ContactKind.CROSSING] * 3
    assert [c.size for c in found] == pytest.approx([83, 76, 83])


def test_a_pair_within_the_tolerance_that_does_not_touch_is_in_contact():
    plain = sheet(4, 4, lambda i, j: (50 * i, 50 * j, 0 * i))
    above = upright(103, 20, 180, 4).moved(np.array([0, 0, 401e-3 + 400]))
    assert met(plain, above, tolerance=0.1) == ()
    (found,) = met(plain, above, tolerance=0.5)
    assert found.kind is ContactKind.T
    assert found.passing == 0


def test_no_tolerance_at_all_leaves_what_is_exact():
    assert kinds(met(splay(-300), G, tolerance=0.0)) == [ContactKind.CROSSING]
    assert kinds(met(*joined_at_rim(), tolerance=0.0)) == [ContactKind.EDGE]


def test_surfaces_without_triangles_meet_nothing():
    empty = Surface("E", np.zeros((0, 3)), np.zeros((0, 3), int))
    flat = Surface("D", [[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
    assert met(F, empty) == ()
    assert met(empty, empty) == ()
    assert met(F, flat, tip()) == met(F, flat) or kinds(met(F, flat, tip()))[-1] is ContactKind.POINT


ASIDE = np.array([2000.0, 0, 0])
SCENES = {
    "crossing": (splay(-300), G),
    "rim": (splay(0), G),
    "strayed rim": (strayed(lambda row: 0.8 * TOLERANCE * np.cos(2.3 * row)), G),
    "rim and crossing": (strayed(lambda row: np.maximum(row - 4, 0) * 30.0), G),
    "point": (F, tip()),
    "ridge": (F, roof()),
    "overlap": (F, coplanar()),
    "edges": crossed_in_edges(),
    "two kinds apart": (
        joined(F, F.moved(np.array([2000.0, 0, 0]))),
        joined(tip(), coplanar().moved(np.array([2000.0, 0, 0]))),
    ),
}


@EASY
@given(st.sampled_from(sorted(SCENES)), motions(), st.booleans(), st.booleans())
def test_contacts_do_not_depend_on_frame_order_or_orientation(name, motion, flip, swap):
    before = met(*SCENES[name])
    moved = [motion.surface(s) for s in SCENES[name]]
    if flip:
        moved[0] = Surface(moved[0].name, moved[0].vertices, moved[0].triangles[:, ::-1])
    centre = np.round(np.concatenate([s.vertices for s in moved]).mean(axis=0))
    moved = [s.moved(-centre) for s in moved]
    after = met(*(moved[::-1] if swap else moved))

    if swap:
        assert sorted((c.kind, round(c.size, 3)) for c in before) == sorted(
            (c.kind, round(c.size, 3)) for c in after
        )
        return
    assert [(c.kind, c.piece, c.count) for c in before] == [(c.kind, c.piece, c.count) for c in after]
    for old, new in zip(before, after, strict=True):
        assert new.size == pytest.approx(old.size, rel=1e-6, abs=1e-6)
        assert [len(t) for t in new.triangles] == [len(t) for t in old.triangles]
        places = motion.points(old.places) - centre
        apart = np.linalg.norm(places[:, None] - new.places, axis=2)
        assert apart.min(axis=1).max() < 0.01 * STEP


def test_a_hole_breaks_the_line_on_the_wall_only_near_the_horizon():
    horizon = scene(F).horizons[0].surface
    (ends,) = broken_by_holes(horizon, with_hole(2), 2 * STEP, 0.1)
    assert len(ends) == 2
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(STEP)
    assert np.allclose(ends[:, 0], horizon.vertices[:, 0].min())
    assert broken_by_holes(horizon, with_hole(5), 2 * STEP, 0.1) == []
    assert broken_by_holes(horizon, with_hole(2), 2 * STEP, STEP + 1) == []
    assert (
        broken_by_holes(horizon, dipping(60, 12, 8).moved(STEP * np.array([-6.3, 0.2, 0.15])), 1e3, 0.1) == []
    )
