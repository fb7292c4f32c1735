"""Faults that touch, or must not meet, moved apart; contacts that are meant, left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.cleaning.separate import REPAIR
from graben.cleaning.shaping.limits import distances
from graben.cleaning.shaping.pushing import clearance, heights, met, pushed, side_of
from graben.finding import Status
from graben.settings import ContactRule
from graben.validators.measuring.contact import ContactKind
from tests.cleaning.tasks import applied, proposed, result_of
from tests.zoo import pairwise_connected, simplicial_complex
from tests.zoo.near_miss import G, splay
from tests.zoo.shapes import STEP, dipping, faults, sheet
from tests.zoo.simplicial_complex import F, coplanar, joined_at_rim, roof, tip

ZOO = {f"{c.check}: {c.name}": c for m in (pairwise_connected, simplicial_complex) for c in m.FAILING}
MOVED = [k for k in ZOO if "touching" in k]
#: What other repairs answer, or none: crossings and T-contacts, several pieces, and what coincides widely.
LEFT = [k for k in ZOO if k not in MOVED]


def arch(lift: float = 0.0):
    """A fault that comes down to F in an arch, tangent to it along a strip, ``lift`` above it."""

    def place(i, j):
        h = 0.02 * (j - 5) ** 2 + lift / STEP
        d = 3.4 + j
        return STEP * (5.4 + i), STEP * (0.5 * d + np.sqrt(0.75) * h), STEP * (0.5 * h - np.sqrt(0.75) * d)

    return sheet(6, 10, place, "G")


def check_apart(model, rule=()):
    task, changes, refusals = proposed(replace(model, contacts=rule), REPAIR)
    assert len(changes) == 1, refusals
    (change,) = changes
    (name,) = change.surfaces
    (made,) = change.surfaces[name]
    before = task.fault(name).surface
    (other,) = (f.surface for f in task.model.faults if f.name != name)
    assert np.array_equal(made.triangles, before.triangles)
    assert distances(made, [before]).max() <= task.max_move(name)
    clear = clearance(task.contact, before, other)
    assert clear >= 10 * task.contact
    assert clear >= 1e-3 * min(before.median_edge, other.median_edge)
    # apart still at four times the distance at which they touch
    assert not met(made, other, 0.4 * clear)
    after = result_of(applied(task.model, change), REPAIR)
    assert not [f for f in after.findings if f.check in REPAIR.checks and f.status is Status.FAIL]
    assert len(change.steps) == 1
    assert change.steps[0].size == pytest.approx(
        np.linalg.norm(made.vertices - before.vertices, axis=1).max()
    )
    return task, change


@pytest.mark.parametrize("name", MOVED)
def test_touching_faults_are_moved_apart(name):
    check_apart(ZOO[name].model)


def test_tangent_faults_are_moved_apart_by_little_and_nearby_only():
    task, change = check_apart(faults(F, arch()))
    (name,) = change.surfaces
    moved = np.linalg.norm(change.surfaces[name][0].vertices - task.fault(name).surface.vertices, axis=1)
    assert moved.max() < 0.02 * STEP
    assert (moved == 0).any()


@pytest.mark.parametrize("name", LEFT)
def test_what_is_no_touch_is_left(name):
    _, changes, refusals = proposed(ZOO[name].model, REPAIR)
    assert not changes
    assert bool(refusals) == name.endswith("overlap")


@pytest.mark.parametrize(
    "case", [*pairwise_connected.PASSING, *simplicial_complex.PASSING], ids=lambda c: c.name
)
def test_what_passes_is_left(case):
    _, changes, refusals = proposed(case.model, REPAIR)
    assert not changes
    assert not refusals


def test_a_wide_overlap_is_refused_with_its_area():
    _, _, refusals = proposed(faults(F, coplanar()), REPAIR)
    assert "37500 m²" in refusals[0].reason
    assert "100 % of G" in refusals[0].reason


def test_an_overlap_at_the_end_is_trimmed():
    # G runs on in the plane of F beyond its lower rim, and begins two steps above it
    lower = sheet(
        12,
        30,
        lambda i, j: (STEP * (2.3 + i), STEP * 0.5 * (14.6 + j), -STEP * np.sqrt(0.75) * (14.6 + j)),
        "G",
    )
    task, changes, refusals = proposed(faults(F, lower), REPAIR)
    assert len(changes) == 1, refusals
    assert "cut away" in changes[0].steps[0].reason
    assert changes[0].steps[0].unit == "m²"
    after = result_of(applied(task.model, changes[0]), REPAIR)
    assert not [f for f in after.findings if f.check in REPAIR.checks and f.status is Status.FAIL]


@pytest.mark.parametrize("rule", ["accept", "force"])
def test_a_rule_that_wants_the_contact_is_respected(rule):
    meant = (ContactRule(faults=("G", "F"), rule=rule),)
    for model in (faults(F, roof(), contacts=meant), faults(F, tip(), contacts=meant)):
        _, changes, refusals = proposed(model, REPAIR)
        assert not changes
        assert not refusals


FORBID = (ContactRule(faults=("F", "G"), rule="forbid"),)


def test_forbid_moves_a_rim_off():
    check_apart(faults(splay(0), G), FORBID)


def test_forbid_takes_a_shallow_crossing_away():
    task, changes, refusals = proposed(faults(arch(-8.0), F, contacts=FORBID), REPAIR)
    assert len(changes) == 1, refusals
    model = applied(task.model, changes[0])
    assert not met(model.faults[0].surface, model.faults[1].surface, task.contact)


def test_forbid_cuts_a_stub_and_refuses_a_long_one_with_numbers():
    task, changes, refusals = proposed(faults(splay(-60), G, contacts=FORBID), REPAIR)
    assert len(changes) == 1, refusals
    assert "cut away" in changes[0].steps[0].reason
    model = applied(task.model, changes[0])
    assert not met(model.faults[0].surface, model.faults[1].surface, task.contact)
    _, changes, refusals = proposed(faults(splay(-300), G, contacts=FORBID), REPAIR)
    assert not changes
    assert refusals[0].needed > 0


def test_shared_vertices_of_a_third_fault_stay():
    first, second = joined_at_rim()
    third = first.with_vertices(first.vertices)
    held = np.zeros(len(first.vertices), dtype=bool)
    held[::2] = True
    core = np.zeros(len(first.vertices), dtype=bool)
    core[10:14] = True
    push = pushed(third, second, core, 1.0, 0.5, held)
    assert np.array_equal(push.surface.vertices[held], first.vertices[held])


def test_heights_and_sides_do_not_depend_on_single_turned_triangles():
    plane = dipping(60, 6, 4)
    turned = replace(plane, triangles=np.r_[plane.triangles[:20][:, ::-1], plane.triangles[20:]])
    above = np.array([[100.0, 60.0, -30.0], [100.0, 40.0, -100.0]])
    assert np.array_equal(np.abs(heights(above, plane)), np.abs(heights(above, turned)))
    assert np.array_equal(np.sign(heights(above, plane)), [1, -1])
    assert side_of(plane.moved(np.array([0, 0, 5.0])), plane, np.arange(5)) == 1.0


def test_repair_twice_is_repair_once_and_rotation_does_not_matter():
    turn = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    sizes = []
    for place in (lambda v: v, lambda v: v @ turn.T + [5e5, 6e6, 0]):
        model = faults(*(s.with_vertices(place(s.vertices)) for s in (F, roof())))
        task, (change,), _ = proposed(model, REPAIR)
        sizes.append(change.steps[0].size)
        assert not proposed(applied(task.model, change), REPAIR)[1]
    assert sizes[1] == pytest.approx(sizes[0], rel=1e-2)


def test_kinds_of_the_tests_are_what_they_say():
    kinds = {c.kind for c in met(F, arch(), 1e-3)}
    assert kinds <= {
        ContactKind.AREA,
        ContactKind.LINE,
        ContactKind.POINT,
        ContactKind.CROSSING,
        ContactKind.T,
    }
    assert kinds
