"""Pieces of a fault joined across narrow gaps, left out, or made faults."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.cleaning.components import REPAIR
from graben.cleaning.shaping.bridging import bridged
from graben.cleaning.shaping.limits import distances
from graben.cleaning.shaping.trimming import part_of
from graben.settings import RepairSettings
from graben.surface import Surface, boundary_loops, strong_components, triangle_areas, triangle_normals
from graben.validators.measuring.measures import smallest_angles
from tests.cleaning.tasks import applied, found, proposed, result_of
from tests.cleaning.test_holes import corrugated, listric, off_truth
from tests.zoo import strongly_connected as zoo
from tests.zoo.shapes import F60, STEP, dipping, faults, joined, sheet, two_triangles

FAR = np.array([5e5, 5e6, -3e3])
ROOM = RepairSettings(max_extension=3.2 * STEP)


def plane(s, t):
    return s, 0.5 * t, -np.sqrt(0.75) * t


PLACES = pytest.mark.parametrize("place", [plane, corrugated, listric], ids=lambda p: p.__name__)


def whole_of(place) -> Surface:
    return sheet(20, 14, lambda i, j: place(STEP * i, STEP * j))


def uneven() -> Surface:
    """A corrugated sheet without any regularity, so that no rounding decides between two diagonals."""
    draw = np.random.default_rng(4).uniform(-0.2, 0.2, (2, 21 * 15))
    return sheet(20, 14, lambda i, j: corrugated(STEP * (i + draw[0]), STEP * (j + draw[1])))


def cut_up(surface: Surface, *columns: int, rows: slice = slice(None)) -> Surface:
    """A sheet of 20 by 14 cells without some columns, or some rows of them."""
    cells = np.arange(280).reshape(20, 14)[list(columns), rows].ravel()
    kept = np.ones(560, dtype=bool)
    kept[np.concatenate([cells, cells + 280])] = False
    return part_of(surface, kept)


def area(surface: Surface) -> float:
    return float(triangle_areas(surface.vertices, surface.triangles).sum())


def repaired(surface: Surface, settings=ROOM):
    task, changes, refusals = proposed(faults(surface, repair=settings), REPAIR)
    assert not refusals
    (change,) = changes
    return task, change


def same_rows(first, second) -> bool:
    """Whether every row of the first is one of the second, to the bit."""
    return {tuple(row) for row in first} <= {tuple(row) for row in second}


@PLACES
@pytest.mark.parametrize("columns", [(9,), (9, 10), (9, 10, 11)], ids=len)
def test_a_sheet_cut_in_two_is_rebuilt(place, columns):
    whole = whole_of(place)
    task, change = repaired(cut_up(whole, *columns))
    (made,) = change.surfaces["F"]
    old = task.fault("F").surface
    assert np.array_equal(made.vertices[: len(old.vertices)], old.vertices)
    assert strong_components(made.triangles).max() == 0
    assert len(boundary_loops(made.triangles)) == 1
    assert area(made) == pytest.approx(area(whole), rel=5e-3)
    new = made.vertices[len(old.vertices) :] + task_origin(whole, columns)
    assert off_truth(new, place) < (1e-6 if place is plane else 0.05) * STEP
    strip = change.declared["F"]
    assert smallest_angles(strip.vertices, strip.triangles).min() > 20
    assert distances(made, [old, strip]).max() == 0
    (step,) = change.steps
    assert step.size == pytest.approx(len(columns) * STEP, rel=0.2)
    assert "joined by a strip" in step.reason


def task_origin(whole: Surface, columns) -> np.ndarray:
    """The origin of the local frame of the model of a sheet cut up."""
    return faults(cut_up(whole, *columns)).local_origin()


def test_a_sheet_cut_across_the_dip_is_rebuilt():
    whole = whole_of(listric)
    task, change = repaired(cut_up(whole, *range(20), rows=slice(6, 8)))
    (made,) = change.surfaces["F"]
    assert area(made) == pytest.approx(area(whole), rel=5e-3)
    assert len(boundary_loops(made.triangles)) == 1
    assert not found(applied(task.model, change), "strongly-connected", REPAIR)


def test_a_ragged_gap_is_closed():
    whole = whole_of(corrugated)
    cells = np.arange(280).reshape(20, 14)
    away = np.concatenate([cells[9], cells[10], cells[11, ::3] + 280, cells[8, 1::4]])
    kept = np.ones(560, dtype=bool)
    kept[np.concatenate([away, cells[9] + 280, cells[10] + 280])] = False
    _, change = repaired(part_of(whole, kept))
    (made,) = change.surfaces["F"]
    assert area(made) == pytest.approx(area(whole), rel=5e-3)
    assert len(boundary_loops(made.triangles)) == 1


@pytest.mark.parametrize("turn", [False, True])
def test_a_piece_within_a_gap_is_joined_all_around(turn):
    whole = whole_of(corrugated)
    cells = np.arange(280).reshape(20, 14)
    ring = np.setdiff1d(cells[5:15, 2:12], cells[6:14, 3:11])
    cut = part_of(whole, ~np.isin(np.arange(560) % 280, ring))
    inner = strong_components(cut.triangles) == 1
    if turn:
        cut = replace(cut, triangles=np.where(inner[:, None], cut.triangles[:, [1, 0, 2]], cut.triangles))
    _, change = repaired(cut)
    (made,) = change.surfaces["F"]
    assert len(boundary_loops(made.triangles)) == 1
    assert area(made) == pytest.approx(area(whole), rel=1e-3)
    normals = triangle_normals(made.vertices, made.triangles)[:, 2]
    assert (normals > 0).all() or (normals < 0).all()


def test_pieces_that_touch_in_a_point_amid_a_gap_are_joined():
    whole = whole_of(corrugated)
    cells = np.arange(280).reshape(20, 14)
    # a triangle left in the gap hangs on one side by an edge and on the other by a corner
    away = np.concatenate([np.delete(cells[9], 7), cells[9] + 280])
    cut = part_of(whole, ~np.isin(np.arange(560), away))
    assert strong_components(cut.triangles).max() == 1
    _, change = repaired(cut)
    (made,) = change.surfaces["F"]
    assert len(boundary_loops(made.triangles)) == 1
    assert area(made) == pytest.approx(area(whole), rel=1e-3)


def test_three_pieces_become_one():
    task, change = repaired(cut_up(whole_of(corrugated), 5, 6, 13))
    (made,) = change.surfaces["F"]
    assert len(change.steps) == 2
    assert strong_components(made.triangles).max() == 0
    assert area(made) == pytest.approx(area(whole_of(corrugated)), rel=5e-3)
    assert not found(applied(task.model, change), "strongly-connected", REPAIR)


def test_a_piece_turned_the_other_way_is_turned_to_agree():
    cut = cut_up(whole_of(plane), 9, 10)
    small = strong_components(cut.triangles) == 1
    turned = replace(cut, triangles=np.where(small[:, None], cut.triangles[:, [1, 0, 2]], cut.triangles))
    _, change = repaired(turned)
    (made,) = change.surfaces["F"]
    normals = triangle_normals(made.vertices, made.triangles)[:, 2]
    assert (normals > 0).all() or (normals < 0).all()
    assert "turned" in change.steps[0].reason


def test_a_wide_gap_splits_the_fault():
    cut = cut_up(whole_of(plane), 9, 10, 11, 12)
    taken = dipping(60, 4, 4, "F (2)").moved(np.array([0, 0, 5000.0]))
    _, changes, _ = proposed(faults(cut, taken, repair=ROOM), REPAIR)
    (change,) = changes
    first, second = change.surfaces["F"]
    assert (first.name, second.name) == ("F", "F (3)")
    assert area(first) == pytest.approx(9 * 14 * STEP**2)
    assert area(second) == pytest.approx(7 * 14 * STEP**2)
    assert not change.declared
    assert "it lies 200 m from the rest, more than max_extension = 160 m" in change.steps[0].reason


def test_a_speck_is_left_out():
    cut = joined(whole_of(plane), two_triangles().moved(np.array([-2 * STEP, 0, 0])))
    task, change = repaired(cut)
    (made,) = change.surfaces["F"]
    assert np.array_equal(made.vertices, task.fault("F").surface.vertices[: 21 * 15])
    assert np.array_equal(made.triangles, cut.triangles[:560])
    assert change.steps[0].size == pytest.approx(STEP**2)
    assert "left out" in change.steps[0].reason


def test_pieces_that_lie_over_each_other_are_split():
    over = joined(dipping(60, 8, 8), dipping(60, 6, 8).moved(np.array([6 * STEP, -20, 30])))
    _, change = repaired(over)
    assert [s.name for s in change.surfaces["F"]] == ["F", "F (2)"]
    assert not change.declared


def test_pieces_that_face_each_other_along_little_are_split():
    beside = dipping(60, 8, 8).vertices[:9]
    shift = np.array([10 * STEP, 0, 0]) + beside[6]
    _, change = repaired(joined(dipping(60, 8, 8), dipping(60, 6, 8).moved(shift)))
    assert [s.name for s in change.surfaces["F"]] == ["F", "F (2)"]
    assert "only" in change.steps[0].reason


@pytest.mark.parametrize("case", zoo.FAILING, ids=lambda case: case.name)
def test_zoo(case):
    task, (change,), refusals = proposed(case.model, REPAIR)
    assert not refusals
    after = applied(task.model, change)
    assert not found(after, "strongly-connected", REPAIR)
    before = {(f.check, f.objects) for f in result_of(task.model, REPAIR).findings if f.status == "fail"}
    assert {(f.check, f.objects) for f in result_of(after, REPAIR).findings if f.status == "fail"} < before
    assert not proposed(after, REPAIR)[1]
    for made in change.surfaces["F"]:
        added = [change.declared[n] for n in ("F",) if n in change.declared]
        assert distances(made, [task.references["F"], *added]).max() == 0
        kept = np.isin(np.arange(len(made.vertices)), np.unique(made.triangles))
        assert kept.all() or made is change.surfaces["F"][0]


@pytest.mark.parametrize("case", zoo.PASSING, ids=lambda case: case.name)
def test_what_passes_is_left(case):
    assert proposed(case.model, REPAIR)[1:] == ([], [])


def test_all_triangles_stay_and_the_result_moves_with_the_fault():
    cut = cut_up(uneven(), 9, 10)
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    here, there = (bridge(x).surface for x in (cut, cut.with_vertices(cut.vertices @ turn.T + FAR)))
    assert np.array_equal(here.triangles[: len(cut.triangles)], cut.triangles)
    back = (there.vertices - FAR) @ turn
    assert len(here.vertices) == len(there.vertices)
    far = np.linalg.norm(here.vertices[:, None] - back[len(cut.vertices) :], axis=2).min(axis=0)
    assert far.max() < 1e-4 * STEP


def bridge(surface: Surface):
    part = strong_components(surface.triangles)
    return bridged(surface, part == 0, part == 1, 200.0, 1e-8)


def test_the_vertex_order_does_not_matter():
    cut = cut_up(uneven(), 9, 10)
    order = np.random.default_rng(2).permutation(len(cut.vertices))
    back = np.argsort(order)
    mixed = replace(cut, vertices=cut.vertices[order], triangles=back[cut.triangles])
    first, second = bridge(cut).surface, bridge(mixed).surface
    count = len(cut.vertices)
    assert len(first.vertices) == len(second.vertices)
    new = second.vertices[count:]
    far = np.linalg.norm(first.vertices[count:, None] - new, axis=2).min(axis=1)
    assert far.max() < 1e-4 * STEP


def test_a_vetoed_fault_is_left():
    task, _, _ = proposed(faults(cut_up(whole_of(plane), 9), F60.moved(FAR)), REPAIR)
    assert not REPAIR.propose(replace(task, vetoed=frozenset([frozenset(["F"])])))
