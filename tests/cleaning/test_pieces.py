"""Faults that meet in several pieces made to meet in one: moved, cut or split, each within its limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.cleaning.parted import area_of
from graben.cleaning.pieces import REPAIR
from graben.cleaning.shaping.limits import distances
from graben.finding import Status
from graben.reading import read_model
from graben.settings import ContactRule, RepairSettings
from graben.surface import strong_components
from tests.bench.tables import DATA
from tests.cleaning.tasks import applied, proposed, result_of
from tests.zoo import pairwise_connected as zoo
from tests.zoo.pairwise_connected import bent
from tests.zoo.shapes import STEP, dipping, faults

LARGE = dipping(60, 20, 32)
REPAIRED = ("meet twice", "the line forks", "a closed line")


def solved(task, change):
    """Assert that a change ends what asks for repair and goes not beyond max_move."""
    for name, surfaces in change.surfaces.items():
        for made in surfaces:
            assert distances(made, [task.references[name]]).max() <= task.max_move(name)
    after = result_of(applied(task.model, change), REPAIR)
    assert not [f for f in after.findings if f.check == "pairwise-connected" and f.status is Status.FAIL]


@pytest.mark.parametrize("case", zoo.FAILING, ids=lambda case: case.name)
def test_zoo(case):
    task, changes, refusals = proposed(case.model, REPAIR)
    if case.name not in REPAIRED:
        assert not changes
        assert bool(refusals) == (case.name == "a rim on and off")
        return
    assert len(changes) == 1, refusals
    solved(task, changes[0])


@pytest.mark.parametrize("case", zoo.PASSING, ids=lambda case: case.name)
def test_what_passes_is_left(case):
    _, changes, refusals = proposed(case.model, REPAIR)
    assert not changes
    assert not refusals


def meeting_again(rows: int, **limits: float):
    """A fault that bends through another, and comes back through it for so many rows beyond the 22nd step."""
    return faults(LARGE, bent(20 + rows), repair=RepairSettings(**limits))


def test_a_shallow_end_is_moved_back():
    task, changes, refusals = proposed(meeting_again(1, max_move=30.0), REPAIR)
    assert len(changes) == 1, refusals
    solved(task, changes[0])
    assert "moved back" in changes[0].steps[0].reason
    assert changes[0].steps[0].size <= 30.0
    # the first line stays
    model = applied(task.model, changes[0])
    assert [c for c in _met(model) if c.piece == 0]


def _met(model):
    from graben.cleaning.shaping.pushing import met

    return met(model.faults[0].surface, model.faults[1].surface, 1e-6 * model.size)


def test_a_small_end_is_cut_away():
    task, changes, refusals = proposed(meeting_again(2, max_move=2.0, max_extension=200.0), REPAIR)
    assert len(changes) == 1, refusals
    (change,) = changes
    solved(task, change)
    assert "cut away" in change.steps[0].reason
    (made,) = change.surfaces["G"]
    assert change.steps[0].size == pytest.approx(area_of(task.fault("G").surface) - area_of(made))
    assert 0 < area_of(task.fault("G").surface) - area_of(made) < 0.15 * area_of(made)


def test_a_fault_that_bends_is_split_in_two():
    task, changes, refusals = proposed(meeting_again(8), REPAIR)
    assert len(changes) == 1, refusals
    (change,) = changes
    solved(task, change)
    names = [s.name for s in change.surfaces["G"]]
    assert names == ["G", "G (2)"]
    first, second = change.surfaces["G"]
    assert area_of(first) + area_of(second) == pytest.approx(area_of(task.fault("G").surface), rel=1e-3)
    assert strong_components(first.triangles).max() == strong_components(second.triangles).max() == 0
    shared = {tuple(p) for p in first.vertices} & {tuple(p) for p in second.vertices}
    assert len(shared) >= 11


def test_the_name_of_a_part_is_free():
    far = dipping(60, 4, 4, "G (2)").moved(np.array([0, 0, 90 * STEP]))
    _, (change,), _ = proposed(faults(LARGE, bent(28), far), REPAIR)
    assert [s.name for s in change.surfaces["G"]] == ["G", "G (3)"]


@pytest.mark.parametrize("rule", ["accept", "forbid"])
def test_a_rule_is_respected(rule):
    model = replace(meeting_again(8), contacts=(ContactRule(faults=("F", "G"), rule=rule),))
    task, changes, refusals = proposed(model, REPAIR)
    assert not changes
    assert not refusals
    assert not REPAIR.propose(task)


def test_a_vetoed_pair_is_left():
    task, _, _ = proposed(meeting_again(8), REPAIR)
    assert not REPAIR.propose(replace(task, vetoed=frozenset([frozenset(["F", "G"])])))


def test_the_other_fault_is_tried_where_one_is_vetoed():
    task, _, _ = proposed(meeting_again(8), REPAIR)
    made = REPAIR.propose(replace(task, vetoed=frozenset([frozenset(["G"])])))
    assert all("G" not in getattr(m, "surfaces", ()) for m in made)


@pytest.mark.skipif(not (DATA / "drogon").is_dir(), reason="no real data here")
def test_two_faults_of_drogon_that_meet_twice():
    task, changes, refusals = proposed(read_model(DATA / "drogon" / "model.toml"), REPAIR)
    assert len(changes) == 1, refusals
    solved(task, changes[0])
