"""Faults that cross or lie upon themselves: put back, moved, or cut; those that do not, left."""

from __future__ import annotations

import numpy as np
import pytest

from graben.cleaning import uncross
from graben.cleaning.shaping.limits import distances
from graben.cleaning.shaping.selfcut import collapsed, crossing_edges, patches, self_refined
from graben.cleaning.uncross import MOST_DROPPED, REPAIR
from graben.finding import Status
from graben.formats.tsurf import read_tsurf
from graben.surface import Surface, edge_sharing, edge_table, strong_components, triangle_areas
from graben.validators.measuring.crossings import crossings
from graben.validators.measuring.measures import angles_of
from tests.bench.tables import DATA
from tests.cleaning.tasks import applied, proposed, result_of
from tests.cleaning.test_trimming import sound
from tests.zoo import self_intersection as zoo
from tests.zoo.shapes import STEP, dipping, faults, moved_vertex, sheet

#: A fault that lies upon itself by more than a small layer, or whose flaps are too large, is left.
LEFT = ("rolled up", "two faults in one", "crossing along edges", "folded flat")
DOWN = STEP * np.array([0, 0.5, -np.sqrt(0.75)])


def looped() -> Surface:
    """A long fault with a loop of a few steps in it."""
    return _alpha(-2.6, 2.6, 40)


def _alpha(first: float, last: float, rows: int, columns: int = 6) -> Surface:
    def place(i, j):
        t = first + (last - first) * j / rows
        return STEP * i, 5 * STEP * t * (t * t - 1), -4 * STEP * t * t

    return sheet(columns, rows, place)


def spiked() -> Surface:
    """F60, larger, with a vertex pushed past its neighbours within the sheet."""
    surface = dipping(60, 10, 8)
    return moved_vertex(surface, 5 * 9 + 4, surface.vertices[5 * 9 + 4] + 1.6 * DOWN)


def with_rim_through(depth: float) -> Surface:
    """A fault and a sheet of its own that hangs on it, its rim through it by a depth."""
    return zoo.hanging(depth)


def folded_end() -> Surface:
    """A fault whose last row of triangles is folded back flat upon the one before."""

    def place(i, j):
        down = np.minimum(j, 22 - j)[:, None] * DOWN
        return STEP * i, down[:, 1], down[:, 2]

    return sheet(6, 12, place)


def pierced() -> Surface:
    """A tight fold with a vertex of its lower limb pushed through the upper one."""
    surface = zoo.folded(12.0)
    at = 3 * 9 + 7
    away = np.array([0.0, -np.sin(np.radians(60)), -np.cos(np.radians(60))])
    return moved_vertex(surface, at, surface.vertices[at] - 15.0 * away)


REPAIRED = {
    "a fold pushed through": pierced(),
    "a loop": looped(),
    "a vertex past its neighbours": spiked(),
    "a rim through it by 0.3 m": with_rim_through(0.3),
    "a rim through it by 5 m": with_rim_through(5.0),
    "a long arm, a small flap": _alpha(-2.0, 1.12, 24),
    "a loop without symmetry": _alpha(-2.6, 2.3, 37, 7),
    "an end folded back": folded_end(),
}


@pytest.mark.parametrize("name", REPAIRED)
def test_crossing_is_gone_within_the_limits(name):
    task, changes, refusals = proposed(faults(REPAIRED[name]), REPAIR)
    assert task.findings
    assert len(changes) == 1, refusals
    (made,) = changes[0].surfaces["F"]
    before = task.fault("F").surface
    model = applied(task.model, changes[0])
    after = result_of(model, REPAIR)
    assert not [f for f in after.findings if f.check == "self-intersection" and f.status is Status.FAIL]
    assert distances(made, [before]).max() <= task.max_move("F") * (1 + 1e-9)
    assert angles_of(made).min() >= min(1.0, angles_of(before).min())
    areas = [triangle_areas(s.vertices, s.triangles).sum() for s in (before, made)]
    assert areas[1] >= (1 - MOST_DROPPED) * areas[0]
    assert strong_components(made.triangles).max() <= strong_components(before.triangles).max()
    sound(made)
    # and again: nothing is left to do
    again = proposed(model, REPAIR)
    assert not again[0].findings
    assert changes[0].steps[0].objects == ("F",)


def test_a_loop_is_welded_to_one_sheet_and_its_area_is_stated():
    before = looped()
    _, (change,), _ = proposed(faults(before), REPAIR)
    (made,) = change.surfaces["F"]
    lost = [float(triangle_areas(s.vertices, s.triangles).sum()) for s in (before, made)]
    assert change.steps[0].size == pytest.approx(lost[0] - lost[1])
    assert change.steps[0].unit == "m²"
    # both far rims are still there
    ends = np.abs(before.vertices[:, 1]).max()
    assert np.abs(made.vertices[:, 1]).max() == ends
    assert np.isclose(made.vertices[:, 1].min(), -ends)
    assert np.isclose(made.vertices[:, 1].max(), ends)


def test_only_the_smaller_layer_goes():
    _, (change,), _ = proposed(faults(folded_end()), REPAIR)
    assert change.steps[0].size == pytest.approx(6 * STEP**2)


def test_vertices_away_from_the_crossing_stay_to_the_bit_and_in_order():
    for name in ("a loop", "a vertex past its neighbours", "a rim through it by 0.3 m"):
        task, (change,), _ = proposed(faults(REPAIRED[name]), REPAIR)
        (made,) = change.surfaces["F"]
        before = task.fault("F").surface
        where = [np.flatnonzero((before.vertices == p).all(axis=1)) for p in made.vertices]
        kept = np.array([w[0] for w in where if len(w)])
        assert len(kept) > 0.5 * len(before.vertices)
        assert (np.diff(kept) > 0).all()


@pytest.mark.parametrize("case", zoo.FAILING, ids=lambda case: case.name)
def test_zoo_is_repaired_or_refused_with_numbers(case):
    task, changes, refusals = proposed(case.model, REPAIR)
    if case.name in LEFT:
        assert not changes
        assert len(refusals) == 1
        assert "%" in refusals[0].reason
        assert refusals[0].advice
        assert ("not joined" in refusals[0].reason) == (case.name in LEFT[1:3])
        assert refusals[0].place is not None
        return
    assert len(changes) == 1
    after = result_of(applied(task.model, changes[0]), REPAIR)
    assert not [f for f in after.findings if f.check == "self-intersection" and f.status is Status.FAIL]


@pytest.mark.parametrize("case", zoo.PASSING, ids=lambda case: case.name)
def test_what_passes_is_left(case):
    task, changes, refusals = proposed(case.model, REPAIR)
    assert not task.findings
    assert not changes
    assert not refusals
    assert not REPAIR.propose(task)


def test_a_fault_vetoed_is_left():
    task, _, _ = proposed(faults(spiked()), REPAIR)
    assert not REPAIR.propose(type(task)(**{**vars(task), "vetoed": frozenset([frozenset(["F"])])}))


def test_rotation_and_shift_do_not_matter():
    turn = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    for name in ("a loop", "a loop without symmetry", "a rim through it by 5 m", "an end folded back"):
        surface = REPAIRED[name]
        other = surface.with_vertices(surface.vertices @ turn.T + [5e5, 6e6, 0])
        sizes = []
        for s in (surface, other):
            _, (change,), _ = proposed(faults(s), REPAIR)
            (made,) = change.surfaces["F"]
            sizes.append(float(triangle_areas(made.vertices, made.triangles).sum()))
        assert sizes[1] == pytest.approx(sizes[0], rel=1e-3)


def test_refinement_of_a_surface_by_itself_has_its_area_and_the_line_of_crossing():
    surface = _alpha(-1.45, 1.5, 12)
    found = crossings(surface, 1e-6)
    concerned = np.zeros(len(surface.triangles), dtype=bool)
    concerned[np.unique(found.pairs)] = True
    network = self_refined(surface, concerned, 1e-6)
    areas = [triangle_areas(s.vertices, s.triangles).sum() for s in (surface, network)]
    assert areas[1] == pytest.approx(areas[0], rel=1e-12)
    assert patches(network).max() == 2
    line = crossing_edges(network)
    assert np.ptp(line[:, :, 1]) < 1e-9 * STEP
    assert np.linalg.norm(line[:, 1] - line[:, 0], axis=1).sum() == pytest.approx(6 * STEP)


@pytest.mark.skipif(not (DATA / "cfm").is_dir(), reason="no real data here")
def test_a_real_fault_that_crosses_itself_by_centimetres_is_moved_by_centimetres():
    (file,) = (DATA / "cfm").glob("*Big_Bear*.ts")
    (surface,) = read_tsurf(file)
    task, changes, refusals = proposed(faults(surface.upward("elevation")), REPAIR)
    assert "through each other" in task.findings[0].message
    assert len(changes) == 1, refusals
    assert 0 < changes[0].steps[0].size < 1.0
    assert not proposed(applied(task.model, changes[0]), REPAIR)[0].findings


def test_sheets_of_their_own_are_moved_apart_without_any_refinement(monkeypatch):
    def never(*_):
        raise AssertionError("refined")

    monkeypatch.setattr(uncross, "self_refined", never)
    _, changes, _ = proposed(faults(with_rim_through(0.3)), REPAIR)
    assert 0.25 < changes[0].steps[0].size < 0.35


def test_slivers_are_collapsed_and_the_rim_kept():
    sheet_ = dipping(60, 6, 4)
    # the middle vertex split in two, a thousandth of a step apart: two slivers between them
    at = 2 * 5 + 2
    vertices = np.concatenate([sheet_.vertices, sheet_.vertices[[at]] + 1e-3 * DOWN])
    triangles = sheet_.triangles.copy()
    right = (triangles == at).any(axis=1) & (vertices[triangles].mean(axis=1)[:, 0] > vertices[at, 0])
    triangles[right] = np.where(triangles[right] == at, len(vertices) - 1, triangles[right])
    edges, sides = edge_table(triangles)
    open_ = edges[edge_sharing(sides, len(edges)) == 1]
    ends = np.setdiff1d(open_[(open_ == at).any(axis=1)], [at])
    slivers = [[at, len(vertices) - 1, end] for end in ends]
    triangles = np.concatenate([triangles, slivers])
    split = Surface("F", vertices, triangles)
    assert angles_of(split).min() < 0.1
    movable = np.zeros(len(vertices), dtype=bool)
    movable[-1] = True
    new, kept, parent = collapsed(vertices, triangles, np.arange(len(triangles)), movable)
    assert len(kept) == len(sheet_.triangles)
    assert angles_of(Surface("F", new, kept)).min() == pytest.approx(angles_of(sheet_).min(), abs=1e-9)
    assert np.array_equal(parent, np.arange(len(kept)))
    # nothing may go that is not said to be movable
    none = collapsed(vertices, triangles, np.arange(len(triangles)), np.zeros(len(vertices), dtype=bool))
    assert np.array_equal(none[1], triangles)
