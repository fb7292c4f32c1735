"""Faults brought back to functions of x and y: within max_move, nearly as they were, or refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.cleaning import unfold
from graben.cleaning.shaping.limits import distances
from graben.cleaning.shaping.slope_program import hinges
from graben.cleaning.unfold import REPAIR, STEEPEST
from graben.surface import Surface, boundary_edges, mean_dip_direction, triangle_areas, triangle_dips
from graben.validators.measuring.measures import mesh_of
from graben.validators.measuring.plan import covers_once, projected
from tests.cleaning.test_monotone import failing, model_with, only, outcome, strict_task
from tests.zoo import functional
from tests.zoo.shapes import STEP, joined, sheet

COLUMNS, ROWS = 24, 16
LIMIT = 0.5 * STEP
ZOO = {c.name: c for c in functional.FAILING}
COLUMN, ROW = (a.ravel() for a in np.meshgrid(np.arange(COLUMNS + 1), np.arange(ROWS + 1), indexing="ij"))


def steep(dip: float, seed: int = 0) -> Surface:
    """A gently curved steep fault with uneven triangles."""
    shake = np.random.default_rng(seed).uniform(-0.2, 0.2, (2, len(COLUMN)))
    c, s = np.cos(np.radians(dip)), np.sin(np.radians(dip))

    def place(i, j):
        x, y = i + shake[0], j + shake[1]
        h = 0.5 * np.sin(0.25 * x) + 0.3 * np.sin(0.3 * y)
        return STEP * x, STEP * (c * y + s * h), STEP * (c * h - s * y)

    return sheet(COLUMNS, ROWS, place)


def pushed(surface: Surface, way, share: float = 0.03, at=(12, 8), sign=None) -> Surface:
    """The surface with a patch moved by 0.8 of the limit along ``way``, to random sides or by sign."""
    radius = np.sqrt(share * COLUMNS * ROWS / np.pi)
    inside = np.hypot(COLUMN - at[0], ROW - at[1]) < radius
    side = np.random.default_rng(5).choice([-1.0, 1.0], len(COLUMN)) if sign is None else sign
    return surface.with_vertices(surface.vertices + (0.8 * LIMIT * inside * side)[:, None] * np.asarray(way))


def normal(dip: float):
    return [0, np.sin(np.radians(dip)), np.cos(np.radians(dip))]


def area(surface: Surface) -> float:
    return float(triangle_areas(surface.vertices, surface.triangles).sum())


def mean_dip(surface: Surface) -> float:
    return mean_dip_direction(surface.vertices, surface.triangles)[1]


@pytest.mark.parametrize("share", [0.01, 0.03, 0.05])
@pytest.mark.parametrize("dip", [70.0, 75.0, 80.0])
@pytest.mark.parametrize("kind", ["leans over", "along the normal", "in plan"])
def test_pushed_patches_come_back_nearly_as_they_were(kind, dip, share):
    clean = steep(dip)
    assert not failing([clean], REPAIR, max_move=LIMIT)
    if kind == "leans over":
        before = pushed(clean, normal(dip), share, sign=np.where(ROW <= 8, 1.0, -1.0))
    else:
        before = pushed(clean, normal(dip) if kind == "along the normal" else [0.6, 0.8, 0], share)
    task = strict_task(model_with(before, max_move=LIMIT), REPAIR)
    assert [f.check for f in task.findings] == ["functional"]
    changes, refusals = outcome(task, REPAIR)
    assert not refusals
    made = only(changes)
    assert not failing([made], REPAIR, max_move=LIMIT)
    old = task.fault("F").surface
    assert distances(made, [old]).max() <= LIMIT
    assert area(made) == pytest.approx(area(clean), rel=0.02)
    assert mean_dip(made) == pytest.approx(mean_dip(clean), abs=1.0)
    rim = np.unique(boundary_edges(made.triangles))
    assert np.array_equal(made.vertices[rim], old.vertices[rim])
    assert (made.vertices == old.vertices).all(axis=1).sum() > 0.4 * len(COLUMN)
    assert covers_once(made, 1e-6 * STEP)


@pytest.mark.parametrize("row", [4, 2, 0])
def test_the_rim_stays_where_the_patch_can_do_without_it(row):
    clean = steep(75.0)
    before = pushed(clean, normal(75.0), 0.02, at=(12, row))
    task = strict_task(model_with(before, max_move=LIMIT), REPAIR)
    made, old = only(outcome(task, REPAIR)[0]), task.fault("F").surface
    rim = np.unique(boundary_edges(made.triangles))
    assert np.array_equal(made.vertices[rim], old.vertices[rim])
    assert not failing([made], REPAIR, max_move=LIMIT)
    assert area(made) == pytest.approx(area(clean), rel=0.02)


def test_flatness_takes_longer_moves_and_comes_nearer_to_what_was(monkeypatch):
    clean = steep(75.0)
    before = pushed(clean, normal(75.0), 0.05)
    task = strict_task(model_with(before, max_move=LIMIT), REPAIR)
    made = only(outcome(task, REPAIR)[0])
    monkeypatch.setattr(unfold, "SMOOTHNESS", 1e-6)
    least = only(outcome(task, REPAIR)[0])
    moved, fewest = (np.linalg.norm(s.vertices - task.fault("F").surface.vertices) for s in (made, least))
    assert fewest < moved
    assert abs(area(made) - area(clean)) < 0.1 * abs(area(least) - area(clean))


def test_vertical_fault_is_refused_with_the_lean_it_would_take():
    changes, (refusal,) = outcome(strict_task(ZOO["vertical fault"].model, REPAIR), REPAIR)
    assert not changes
    # 200 m high: a plane that leans about its middle moves its rims by half of that times the slope
    most = float(refusal.reason.split("moves it by up to ")[1].split(" m")[0])
    assert 0.9 * 100 < most * np.tan(np.radians(STEEPEST)) < 1.3 * 100
    assert refusal.needed is None  # it is no matter of the limit


def test_overturned_fault_is_refused_and_repaired_with_as_much_more_as_it_says():
    model = ZOO["overturned fault"].model
    changes, (refusal,) = outcome(strict_task(model, REPAIR), REPAIR)
    assert not changes
    assert "would take" in refusal.reason
    for share, repaired in ((0.3, False), (1.001, True)):
        wide = model.repair.model_copy(update={"max_move": 25.0 + share * refusal.needed})
        changes, _ = outcome(strict_task(replace(model, repair=wide), REPAIR), REPAIR)
        assert bool(changes) == repaired


@pytest.mark.parametrize("case", functional.PASSING, ids=lambda c: c.name)
def test_a_fault_that_passes_comes_back_as_it_is(case):
    asked = strict_task(ZOO["vertical fault"].model, REPAIR).findings
    task = strict_task(case.model, REPAIR)
    if task.model.faults:
        assert REPAIR.propose(replace(task, findings=asked)) == [] or task.findings


def test_a_fault_over_itself_without_a_fold_is_refused():
    lower = sheet(6, 6, lambda i, j: (STEP * i, 0.5 * STEP * j, -STEP * j))
    upper = lower.moved(np.array([2 * STEP, 0, 3 * STEP]))
    changes, (refusal,) = outcome(strict_task(model_with(joined(lower, upper)), REPAIR), REPAIR)
    assert not changes
    # four cells long, a good step wide
    wide = float(refusal.reason.split("without a fold, ")[1].split(" m")[0])
    assert 0.5 * STEP < wide < 2 * STEP


def test_shared_vertices_stay():
    before = pushed(steep(75.0), normal(75.0), at=(9, 8))
    line = before.vertices.reshape(COLUMNS + 1, ROWS + 1, 3)[14]
    other = sheet(2, ROWS, lambda i, j: (line[j.astype(int)] + STEP * i[:, None] * [0.5, 1, 0.1]).T, "G")
    task = strict_task(model_with(before, other, max_move=LIMIT), REPAIR)
    changes, _ = outcome(
        replace(task, findings=tuple(f for f in task.findings if f.objects == ("F",))), REPAIR
    )
    made = only(changes)
    assert set(changes[0].surfaces) == {"F"}
    at = slice(14 * (ROWS + 1), 15 * (ROWS + 1))
    assert np.array_equal(made.vertices[at], task.fault("F").surface.vertices[at])


def test_the_result_does_not_depend_on_north_or_order():
    before = pushed(steep(75.0), normal(75.0))
    made = only(outcome(strict_task(model_with(before, max_move=LIMIT), REPAIR), REPAIR)[0])
    a = np.radians(130)
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    shift = np.array([5e5, 6e6, 0])
    order = np.random.default_rng(1).permutation(len(before.triangles))
    other = replace(before, vertices=before.vertices @ turn.T + shift, triangles=before.triangles[order])
    model = model_with(other, max_move=LIMIT)
    turned = only(outcome(strict_task(model, REPAIR), REPAIR)[0])
    first = model_with(before).local_origin()
    assert turned.vertices + model.local_origin() - shift == pytest.approx(
        (made.vertices + first) @ turn.T, abs=1e-4 * STEP
    )


def test_repair_twice_is_repair_once():
    before = pushed(steep(75.0), normal(75.0))
    task = strict_task(model_with(before, max_move=LIMIT), REPAIR)
    made = only(outcome(task, REPAIR)[0])
    again = replace(task, model=replace(task.model, faults=(replace(task.model.faults[0], surface=made),)))
    assert REPAIR.propose(again) == []


def test_only_the_patch_that_can_be_is_brought_back():
    clean = steep(75.0)
    before = pushed(pushed(clean, normal(75.0), at=(5, 8)), np.multiply(normal(75.0), 6), at=(19, 8))
    task = strict_task(model_with(before, max_move=LIMIT), REPAIR)
    changes, refusals = outcome(task, REPAIR)
    assert len(refusals) == 1
    made = only(changes)
    bad = [np.union1d(projected(s).overturned, projected(s).vertical) for s in (before, made)]
    assert 0 < len(bad[1]) < len(bad[0])
    assert np.isin(bad[1], bad[0]).all()
    assert triangle_dips(made.vertices, made.triangles).max() <= 90


def test_hinges_vanish_on_planes_and_do_not_change_along_the_way():
    surface = steep(75.0)
    way = np.array([0.0, 1.0, 0.0])
    rows = hinges(surface.vertices, surface.triangles, mesh_of(surface).joints, way)
    flat = surface.vertices @ np.array([0.3, 0.0, 0.7]) + 5
    assert np.abs(rows @ flat).max() < 1e-10 * STEP
    moved = surface.vertices + np.random.default_rng(0).normal(size=(len(COLUMN), 1)) * way
    again = hinges(moved, surface.triangles, mesh_of(surface).joints, way)
    assert abs(rows - again).max() < 1e-12
