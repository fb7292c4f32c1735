"""Faults too short for a horizon's cutoffs are extended by what is missing, and no others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben import demo
from graben.arrays import floats
from graben.cleaning import margin
from graben.cleaning.shaping.rim_lengths import resting, rim_needs
from graben.proximity import nearest
from graben.settings import RepairSettings
from graben.surface import Surface, triangle_areas
from graben.validators.trace import TOO_SHORT
from tests.cleaning.tasks import applied, found, proposed, task_of
from tests.models import grid_triangles, model_of_demo
from tests.zoo.cases import Case
from tests.zoo.trace import FAILING, PASSING

SHORT = {c.name: c for c in FAILING if c.name.startswith("too short")}
short_cases = pytest.mark.parametrize("case", SHORT.values(), ids=list(SHORT))


@short_cases
def test_a_fault_too_short_is_extended_until_nothing_is_missing(case: Case) -> None:
    task, changes, refusals = proposed(case.model, margin.REPAIR)
    (change,), (surface,) = changes, changes[0].surfaces["F"]
    assert not refusals
    old = task.fault("F").surface
    assert np.array_equal(surface.vertices[: len(old.vertices)], old.vertices)
    patch = change.declared["F"]
    far = nearest(surface.vertices[len(old.vertices) :], patch.vertices, patch.triangles).distance
    assert far.max() == pytest.approx(0.0, abs=1e-9)
    after = applied(task.model, change)
    assert not found(after, "trace", margin.REPAIR)
    assert proposed(after, margin.REPAIR)[1] == []


@short_cases
def test_it_goes_on_to_the_side_where_it_is_missing(case: Case) -> None:
    _, (change,), _ = proposed(case.model, margin.REPAIR)
    added = change.declared["F"].vertices[:, 2]
    old = task_of(case.model, margin.REPAIR).fault("F").surface.vertices[:, 2]
    if case.name.endswith("below"):
        assert added.min() < old.min()
        assert added.max() < old.max()
    else:
        assert added.max() > old.max()
        assert added.min() > old.min()


@short_cases
def test_what_takes_more_than_is_allowed_is_left_with_the_number(case: Case) -> None:
    strict = replace(case.model, repair=RepairSettings(max_extension=5.0))
    task, changes, (refusal,) = proposed(strict, margin.REPAIR)
    assert not changes
    (missing,) = {p.value for f in task.findings for p in f.parts if p.kind == TOO_SHORT}
    assert missing is not None
    assert refusal.needed is not None
    assert refusal.needed >= missing - 5.0
    assert "max_extension" in refusal.reason


@pytest.mark.parametrize("case", PASSING, ids=lambda c: c.name)
def test_a_fault_long_enough_asks_for_nothing(case: Case) -> None:
    assert not task_of(case.model, margin.REPAIR).findings


@pytest.mark.parametrize("name", ["single", "tee", "reverse", "low-dip-12", "short"])
def test_the_synthetic_models_have_long_enough_faults(name: str) -> None:
    assert not task_of(model_of_demo(demo.build(name)), margin.REPAIR).findings


def sheet() -> Surface:
    a, b = np.meshgrid(np.arange(11) * 100.0, np.arange(5) * 100.0, indexing="ij")
    return Surface("F", np.stack([a, 0.5 * b, -b], axis=-1).reshape(-1, 3), grid_triangles(11, 5))


def test_lengths_taper_off_beyond_the_places() -> None:
    surface = sheet()
    ((chain, far),) = rim_needs(
        surface, floats([[500.0, 200.0, -400.0]]), floats([50.0]), np.zeros(55, dtype=bool)
    )
    assert far[0] == far[-1] == 0.0
    assert far.max() == 50.0
    assert set(surface.vertices[chain, 2]) == {-400.0}
    assert abs(surface.vertices[chain[far == 50.0], 0] - 500.0).max() <= surface.median_edge


def test_a_rim_that_rests_on_another_fault_is_held() -> None:
    surface = sheet()
    wall = Surface("G", [[-5000, -500, -400], [6000, -500, -400], [500, 2000, -400]], [[0, 1, 2]])
    held = resting(surface, [wall], 1e-3)
    assert set(np.flatnonzero(held)) == set(np.flatnonzero(surface.vertices[:, 2] == -400.0))
    assert rim_needs(surface, floats([[500.0, 200.0, -400.0]]), floats([50.0]), held) == []


@short_cases
def test_it_goes_on_by_what_is_missing_and_a_stated_margin(case: Case) -> None:
    task, (change,), _ = proposed(case.model, margin.REPAIR)
    (step,) = change.steps
    fault = task.fault("F")
    needs = margin._missing(task, fault)[1]
    edge = min(fault.surface.median_edge, *(h.step for h in task.model.horizons))
    assert step.size == pytest.approx(1.2 * needs.max() + 0.3 * edge)


@short_cases
def test_the_ledger_says_what_else_the_fault_became(case: Case) -> None:
    task, (change,), _ = proposed(case.model, margin.REPAIR)
    before, (after,) = task.fault("F").surface, change.surfaces["F"]
    areas = [triangle_areas(s.vertices, s.triangles).sum() for s in (before, after)]
    assert f"its area grew by {100 * (areas[1] / areas[0] - 1):.2g} %" in change.steps[0].reason
    flatter = Surface("F", after.vertices * [1.0, 1.0, 0.5], after.triangles)
    assert "its least dip fell from" in margin._effects(before, flatter)
