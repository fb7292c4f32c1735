"""Faults given one way up and one way down: as little as possible, only where needed, or refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from graben.cleaning import monotone
from graben.cleaning.monotone import MARGIN, REPAIR
from graben.cleaning.repairing import Change, Refusal, Task
from graben.cleaning.shaping.limits import distances
from graben.cleaning.shaping.slope_program import Bounds, moves, slopes
from graben.finding import Finding, Profile, Status
from graben.model import Model
from graben.settings import RepairSettings
from graben.stages import Stages, quiet
from graben.surface import Surface, triangle_dips, triangle_normals
from graben.validators.measuring.plan import projected
from graben.validators.runner import run_checks
from graben.validators.z_monotone import critical_points
from tests.zoo import min_dip, z_monotone
from tests.zoo.shapes import F60, STEP, dipping, faults, sheet

Z = {c.name: c for c in z_monotone.FAILING}
REPAIRED = ("summit", "pit", "level crest", "level patch")
FLAT = {c.name: c for c in min_dip.FAILING}


def strict_task(model: Model, repair=REPAIR) -> Task:
    """The task of a repair on a model under profile paper, in its local frame."""
    local = model.moved(-model.local_origin())
    result, evidence = run_checks(local, Profile.PAPER, Stages(quiet), repair.need)
    findings = tuple(f for f in result.findings if f.check in repair.checks and repair.answers(f, local))
    return Task(local, findings, evidence, {f.name: f.surface for f in local.faults})


def outcome(task: Task, repair=REPAIR) -> tuple[list[Change], list[Refusal]]:
    made = repair.propose(task) if task.findings else []
    return [c for c in made if isinstance(c, Change)], [r for r in made if isinstance(r, Refusal)]


def model_with(*surfaces: Surface, **settings) -> Model:
    return faults(*surfaces, repair=RepairSettings(**settings))


def failing(surfaces, repair=REPAIR, **settings) -> list[Finding]:
    return list(strict_task(model_with(*surfaces, **settings), repair).findings)


def of_f(task: Task) -> Task:
    """The task with the findings of F alone."""
    return replace(task, findings=tuple(f for f in task.findings if f.objects == ("F",)))


def only(changes: list[Change], name: str = "F") -> Surface:
    assert len(changes) == 1
    return changes[0].surfaces[name][0]


def bump(surface: Surface, *places, height: float, width: float = 1.2) -> Surface:
    """The surface raised vertically around some vertices."""
    points = surface.vertices.copy()
    for k in places:
        away = np.linalg.norm(surface.vertices - surface.vertices[k], axis=1) / STEP
        points[:, 2] += height * STEP * np.exp(-0.5 * (away / width) ** 2)
    return surface.with_vertices(points)


def plane(dip: float = 40.0, columns: int = 16, rows: int = 12) -> Surface:
    return dipping(dip, columns, rows)


def listric() -> Surface:
    turn = np.radians(np.linspace(65, 30, 12))
    y = np.concatenate([[0], np.cumsum(STEP * np.cos(turn))])
    z = np.concatenate([[0], np.cumsum(-STEP * np.sin(turn))])
    return sheet(16, 12, lambda i, j: (STEP * i, y[j.astype(int)], z[j.astype(int)]))


def corrugated() -> Surface:
    return sheet(20, 12, lambda i, j: (STEP * i, 38 * j + 60 * np.sin(0.7 * i), -33 * j))


SHAPES = {"plane": plane(), "listric": listric(), "corrugated": corrugated()}


@pytest.mark.parametrize("name", Z)
def test_cases_of_the_zoo_are_repaired_or_refused(name):
    task = strict_task(Z[name].model)
    changes, refusals = outcome(task)
    assert bool(changes) == (name in REPAIRED)
    assert bool(refusals) == (name not in REPAIRED)
    if changes:
        made = only(changes)
        assert not failing([made])
        assert distances(made, [task.fault("F").surface]).max() <= task.max_move("F") * (1 + 1e-6)


def test_a_level_fault_is_refused_with_the_tilt_it_would_take():
    _, (refusal,) = outcome(strict_task(Z["level altogether"].model))
    # 200 across: half of it times the slope of one degree
    assert f"{100 * np.tan(np.radians(1)):.3g} m" in refusal.reason


@pytest.mark.parametrize("case", [*z_monotone.PASSING, *min_dip.PASSING], ids=lambda c: c.name)
def test_a_fault_that_passes_comes_back_as_it_is(case):
    asked = strict_task(Z["summit"].model).findings
    task = strict_task(case.model)
    assert not task.findings
    assert REPAIR.propose(replace(task, findings=asked)) == []


@pytest.mark.parametrize(
    ("name", "height"), [(n, h) for n in SHAPES for h in (1.5, 2.5, 4.0) if (n, h) != ("listric", 1.5)]
)
def test_bumps_get_a_way_down(name, height):
    clean = SHAPES[name]
    assert not len(critical_points(clean).vertices)
    before = bump(clean, 6 * 13 + 5, 12 * 13 + 7, height=height)
    task = strict_task(model_with(before, max_move=4 * STEP))
    assert [f.check for f in task.findings] == ["z-monotone"]
    changes, refusals = outcome(task)
    assert not refusals
    made = only(changes)
    assert not len(critical_points(made).vertices)
    assert not len(critical_points(made).level)
    # only down or up, and only some
    before = task.fault("F").surface
    assert np.array_equal(made.vertices[:, :2], before.vertices[:, :2])
    moved = (made.vertices != before.vertices).any(axis=1)
    assert 0 < moved.sum() < 0.7 * len(moved)
    rim = np.isin(np.arange(len(moved)), [i * 13 + j for i in range(17) for j in (0, 12)])
    assert not (moved & rim).any()
    star = np.isin(before.triangles, critical_points(before).vertices).any(axis=1)
    assert triangle_dips(made.vertices, made.triangles)[star].min() >= 1.0
    assert distances(made, [before]).max() <= task.max_move("F")
    assert not failing([made], max_move=4 * STEP)


def test_the_rim_stays_where_the_patch_can_do_without_it():
    before = bump(plane(), 8 * 13 + 2, height=2.0, width=0.8)
    task = strict_task(model_with(before, max_move=2 * STEP))
    made, old = only(outcome(task)[0]), task.fault("F").surface
    assert np.array_equal(made.vertices[::13], old.vertices[::13])
    assert not np.array_equal(made.vertices[1::13], old.vertices[1::13])
    assert not failing([made])


def test_normals_are_linear_in_the_moves():
    rng = np.random.default_rng(2)
    points, triangles = corrugated().vertices, corrugated().triangles
    way = np.array([0.6, 0.0, 0.8])
    t, ways = rng.normal(size=len(points)), rng.normal(size=(len(triangles), 3))
    matrix, right = slopes(
        points, triangles, way, Bounds(np.arange(len(triangles)), ways, np.zeros(len(triangles)))
    )
    before = triangle_normals(points, triangles)
    after = triangle_normals(points + t[:, None] * way, triangles)
    expected = (after * ways).sum(axis=1) / np.linalg.norm(before, axis=1)
    assert matrix @ t - right == pytest.approx(expected, abs=1e-12)


def test_moves_are_the_smallest():
    surface = bump(plane(40, 4, 4), 12, height=2.0)
    t = surface.triangles
    floor = np.tan(np.radians(1.0))
    triangles = np.where((triangle_normals(surface.vertices, t)[:, 2] < 0)[:, None], t[:, ::-1], t)
    bounds = Bounds(np.arange(len(t)), np.tile([0, 1, -floor], (len(t), 1)), np.zeros(len(t)))
    weights = np.linspace(1, 2, len(surface.vertices))
    up = np.array([0.0, 0, 1])
    found = moves(surface.vertices, triangles, up, bounds, weights, np.full(len(weights), np.inf))
    matrix, right = slopes(surface.vertices, triangles, up, bounds)
    dense = matrix.toarray()
    other = minimize(
        lambda x: (weights * x * x).sum() / STEP**2,
        np.zeros(len(weights)),
        jac=lambda x: 2 * weights * x / STEP**2,
        constraints={"type": "ineq", "fun": lambda x: dense @ x - right, "jac": lambda x: dense},
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
    )
    assert other.success
    assert found == pytest.approx(other.x, abs=1e-4 * STEP)
    assert (dense @ found - right).min() > -1e-9


def test_the_result_does_not_depend_on_north_or_offset():
    before = bump(corrugated(), 6 * 13 + 5, height=3.0)
    made = only(outcome(strict_task(model_with(before, max_move=4 * STEP)))[0])
    a = np.radians(37)
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    shift = np.array([5e5, 6e6, 0])
    task = strict_task(model_with(before.with_vertices(before.vertices @ turn.T + shift), max_move=4 * STEP))
    origin = model_with(before.with_vertices(before.vertices @ turn.T + shift)).local_origin()
    turned = only(outcome(task)[0])
    first = model_with(before).local_origin()
    assert turned.vertices + origin - shift == pytest.approx(
        (made.vertices + first) @ turn.T, abs=1e-4 * STEP
    )


def test_the_order_of_triangles_does_not_matter():
    before = bump(plane(), 6 * 13 + 5, height=3.0)
    made = only(outcome(strict_task(model_with(before, max_move=4 * STEP)))[0])
    order = np.random.default_rng(1).permutation(len(before.triangles))
    mixed = replace(before, triangles=before.triangles[order][:, [1, 2, 0]])
    other = only(outcome(strict_task(model_with(mixed, max_move=4 * STEP)))[0])
    assert other.vertices == pytest.approx(made.vertices, abs=1e-5 * STEP)


def test_what_is_refused_is_repaired_with_as_much_more_as_it_says():
    before = bump(plane(), 6 * 13 + 5, height=4.0)
    changes, (refusal,) = outcome(strict_task(model_with(before, max_move=2.0)))
    assert not changes
    assert refusal.needed > 0
    assert "max_move = 2 m" in refusal.reason
    task = strict_task(model_with(before, max_move=2.0 + 1.001 * refusal.needed))
    assert not failing([only(outcome(task)[0])])
    short = strict_task(model_with(before, max_move=2.0 + 0.5 * refusal.needed))
    assert not outcome(short)[0]


def test_one_patch_is_repaired_where_another_is_refused():
    both = bump(bump(plane(40, 30, 12), 5 * 13 + 6, height=2.2), 24 * 13 + 6, height=5.0)
    task = strict_task(model_with(both, max_move=10.0))
    changes, refusals = outcome(task)
    assert len(refusals) == 1
    before, made = task.fault("F").surface, only(changes)
    left = len(critical_points(made).vertices)
    assert left == len(critical_points(before).vertices) - changes[0].steps[0].count
    assert np.array_equal(made.vertices[20 * 13 :], before.vertices[20 * 13 :])


@pytest.mark.parametrize("name", FLAT)
def test_faults_are_steepened_on_request_only(name):
    model = FLAT[name].model
    assert not strict_task(model).findings
    asked = replace(model, repair=RepairSettings(steepen=True))
    task = strict_task(asked)
    made = only(outcome(task)[0])
    limit = float(model.checks.get("min-dip", model.parameters.min_dip))
    dips = triangle_dips(made.vertices, made.triangles)
    assert limit <= dips.min() < limit + 2 * MARGIN
    assert distances(made, [task.fault("F").surface]).max() <= task.max_move("F") * (1 + 1e-6)


def test_what_is_too_flat_by_too_much_still_gets_a_way_down():
    before = bump(plane(10.0), 6 * 13 + 5, height=0.5)
    task = strict_task(model_with(before, max_move=0.5 * STEP, steepen=True))
    assert {f.check for f in task.findings} == {"z-monotone", "min-dip"}
    changes, refusals = outcome(task)
    assert {r.check for r in refusals} == {"min-dip"}
    assert not len(critical_points(only(changes)).vertices)


def _branch(lean: float, name: str = "G") -> Surface:
    """A fault that ends on a column of the plane, on the same vertices, and goes away with its own dip."""
    line = plane().vertices.reshape(17, 13, 3)[8]
    away = np.array([0.3, 1.0, lean])
    return sheet(4, 12, lambda i, j: (line[j.astype(int)] + STEP * i[:, None] * away).T, name)


def test_shared_vertices_move_in_all_faults_that_have_them():
    first = plane()
    at = 8 * 13 + 6
    other = _branch(-0.9)
    raised = first.vertices[at] + [0, 0, 1.2 * STEP]
    first = first.with_vertices(
        np.where(np.arange(len(first.vertices))[:, None] == at, raised, first.vertices)
    )
    other = other.with_vertices(
        np.where((other.vertices == plane().vertices[at]).all(axis=1)[:, None], raised, other.vertices)
    )
    task = strict_task(model_with(first, other, max_move=STEP))
    (change,), refusals = outcome(
        replace(task, findings=tuple(f for f in task.findings if f.objects == ("F",)))
    )
    assert not refusals
    made, along = change.surfaces["F"][0], change.surfaces["G"][0]
    shared = {tuple(p) for p in made.vertices} & {tuple(p) for p in along.vertices}
    assert len(shared) == 13
    assert tuple(raised - task.model.local_origin()) not in shared
    assert not len(critical_points(made).vertices)


def test_moves_that_would_spoil_a_fault_are_not_made(monkeypatch):
    task = strict_task(Z["summit"].model)
    monkeypatch.setattr(monotone, "sound_with", lambda task, made, taken: False)
    changes, refusals = outcome(task)
    assert not changes
    assert len(refusals) == 1


def test_a_bent_over_part_keeps_its_place():
    """Moves of a summit near an overturned part make no triangle vertical or overturned."""
    before = bump(F60, 2 * 5 + 2, height=1.6, width=0.5)
    task = strict_task(model_with(before, max_move=STEP))
    assert [f.status for f in task.findings] == [Status.FAIL]
    made = only(outcome(task)[0])
    assert len(projected(made).overturned) + len(projected(made).vertical) == 0
