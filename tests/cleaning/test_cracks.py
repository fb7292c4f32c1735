"""Cracks between rims: vertices that face each other merged, edges split at vertices that lie on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.cleaning import stitch, t_vertices, weld
from graben.cleaning.shaping.fans import trouble
from graben.cleaning.stitch import stitched
from graben.cleaning.t_vertices import ON_EDGE, closed_at_edges
from graben.surface import Surface, boundary_loops, strong_components
from tests.cleaning.cracked import area, halves, hanging, outline, rim_length, strips
from tests.cleaning.tasks import applied, found, proposed
from tests.zoo import PASSING
from tests.zoo.duplicate import FAILING as DOUBLED
from tests.zoo.duplicate import slit
from tests.zoo.manifold import FAILING as OPEN
from tests.zoo.shapes import F60, STEP, faults, joined, sheet

GAP = 1e-4  # a 2e-6th of an edge, and within the contact distance of a model of 300 m


def whole(surface) -> bool:
    return len(boundary_loops(surface.triangles)) == 1 and not strong_components(surface.triangles).any()


@pytest.mark.parametrize("case", DOUBLED, ids=lambda case: case.name)
def test_what_is_doubled_is_welded(case):
    task, (change,), _ = proposed(case.model, weld.REPAIR)
    after = applied(task.model, change)
    (made,) = change.surfaces["F"]
    assert not found(after, "duplicate", weld.REPAIR)
    assert area(made) == pytest.approx(300 * 200, rel=1e-9)
    assert rim_length(made) == pytest.approx(1000, rel=1e-9)
    assert whole(made)
    assert weld.welded(made) is made


def test_halves_are_stitched():
    model = faults(halves(GAP))
    task, (change,), _ = proposed(model, stitch.REPAIR)
    after = applied(task.model, change)
    (made,) = change.surfaces["F"]
    assert not found(after, "strongly-connected", stitch.REPAIR)
    assert whole(made)
    assert trouble(made.triangles) == (0, 0)
    assert area(made) == pytest.approx(area(halves(0.0)), rel=1e-5)
    assert np.array_equal(made.vertices[:20], task.references["F"].vertices[:20])
    assert stitched(made, task.contact) is made


def test_wider_gaps_and_rims_along_themselves_are_left():
    apart = halves(2e-2 * STEP)
    assert stitched(apart, STEP) is apart
    opened = slit(0.01)
    assert stitched(opened, 0.005) is opened
    assert stitched(opened, 0.02) is not opened
    fine = sheet(40, 1, lambda i, j: (1e-3 * i, STEP * j, -STEP * j))
    assert stitched(fine, 2e-3) is fine


def test_what_is_held_stays():
    broken = halves(GAP)
    held = np.zeros(len(broken.vertices), dtype=bool)
    held[20:25] = True
    made = stitched(broken, 1e-3, held)
    assert whole(made)
    assert not (made.vertices[:, None] == broken.vertices[None, 15:20]).all(axis=2).any()
    held[15:20] = True
    assert stitched(broken, 1e-3, held) is broken


def test_a_third_sheet_is_not_stitched_to_an_edge():
    flat = halves(0.0)
    third = sheet(1, 4, lambda i, j: (STEP * 3 + GAP + 20 * i, 30 * j + 30 * i, -40 * j + 40 * i))
    three = joined(flat, third)
    assert trouble(stitched(three, 1e-3).triangles)[0] == 0


@pytest.mark.parametrize("off", [0.0, 1e-5 * STEP, 0.9 * ON_EDGE * STEP])
@pytest.mark.parametrize("made", [hanging, strips], ids=["one", "from rim to rim"])
def test_edges_are_split_at_vertices_on_them(made, off):
    broken = made(off=off)
    closed, split = closed_at_edges(broken, 1e-6)
    assert whole(closed)
    assert trouble(closed.triangles) == (0, 0)
    assert np.array_equal(closed.vertices, broken.vertices)
    assert len(split) == (1 if made is hanging else 4)
    assert area(closed) == pytest.approx(area(made()), rel=1e-3)
    ends = [made(), closed]
    assert rim_length(closed) == pytest.approx(1000 if made is hanging else 800, rel=1e-9), ends
    assert closed_at_edges(closed, 1e-6)[0] is closed


@pytest.mark.parametrize("ratio", [2, 3, 5])
def test_the_repair_answers_what_the_checks_see(ratio):
    task, (change,), _ = proposed(faults(strips(ratio)), t_vertices.REPAIR)
    assert {f.check for f in task.findings} == {"manifold", "strongly-connected"}
    after = applied(task.model, change)
    for check in t_vertices.REPAIR.checks:
        assert not found(after, check, t_vertices.REPAIR)
    assert whole(change.surfaces["F"][0])


def test_a_crack_that_is_seen_as_a_hole_is_closed():
    (case,) = (c for c in OPEN if c.name == "a vertex on one side of an edge")
    task, (change,), _ = proposed(case.model, t_vertices.REPAIR)
    assert not found(applied(task.model, change), "manifold", t_vertices.REPAIR)
    assert proposed(case.model, stitch.REPAIR)[1] == []


def test_rims_whose_vertices_alternate_are_joined():
    upper = sheet(4, 2, lambda i, j: (STEP * i, 30 * (j - 2), 40 * (2 - j)))
    lower = sheet(4, 2, lambda i, j: (STEP * i + 0.4 * STEP * ((i > 0) & (i < 4)), 30 * j, -40 * j))
    closed, split = closed_at_edges(weld.welded(joined(upper, lower)), 1e-6)
    assert whole(closed)
    assert len(split) == 6
    assert rim_length(closed) == pytest.approx(800)


def test_vertices_beside_edges_and_narrow_strips_are_left():
    for surface in (
        hanging(2 * ON_EDGE * STEP),
        F60,
        slit(0.01),
        sheet(6, 2, lambda i, j: (STEP * (i + 0.5 * (j == 2) * (i > 0) * (i < 6)), 0.05 * j, -0.05 * j)),
    ):
        assert closed_at_edges(surface, 1e-6)[0] is surface
        assert closed_at_edges(surface, 1e-6, most=0.0)[0] is surface


def test_a_third_triangle_is_not_put_at_an_edge():
    points = [[0, 0, 0], [50, 0, 0], [25, -40, 0], [25, 0, 0], [10, 40, 0], [40, 40, 0], [10, 10, 40]]
    surface = Surface("F", points, [[1, 0, 2], [0, 3, 4], [3, 1, 5], [3, 5, 4], [0, 6, 3]])
    assert trouble(surface.triangles)[0] == 0
    assert closed_at_edges(surface, 1e-6)[0] is surface


@pytest.mark.parametrize("repair", [stitch.REPAIR, t_vertices.REPAIR], ids=lambda r: r.id)
def test_what_passes_is_left(repair):
    for case in PASSING:
        if case.check in ("manifold", "strongly-connected", "duplicate", "degenerate", "oriented"):
            _, changes, _ = proposed(case.model, repair)
            assert changes == [], case.name


def test_lines_rotation_shift_and_order():
    broken = strips(3, off=1e-3)
    broken = replace(broken, lines=np.arange(1, len(broken.triangles) + 1))
    closed, _ = closed_at_edges(broken, 1e-6)
    for t, line in zip(closed.triangles, closed.lines, strict=True):
        assert len(np.intersect1d(t, broken.triangles[line - 1])) >= 1
    turn = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    moved = broken.with_vertices(broken.vertices @ turn.T + [5e5, 6e6, 0])
    assert np.array_equal(closed_at_edges(moved, 1e-6)[0].triangles, closed.triangles)
    order = np.random.default_rng(2).permutation(len(broken.triangles))
    mixed = closed_at_edges(replace(broken, triangles=broken.triangles[order], lines=[]), 1e-6)[0]
    assert np.array_equal(outline(mixed), outline(closed))
    assert len(mixed.triangles) == len(closed.triangles)
