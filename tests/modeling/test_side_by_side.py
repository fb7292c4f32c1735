"""Tasks side by side: the same results in the same order, and no worker left behind."""

from __future__ import annotations

import os
from functools import cache

import numpy as np
import pytest

from graben.arrays import FloatArray, IntArray
from graben.complexes import Complex
from graben.errors import ModelingError
from graben.model import Model
from graben.modeling import building, problems
from graben.modeling.algebra import Cholmod
from graben.modeling.iteration import Problem
from graben.modeling.preparation import CutHorizon, prepared
from graben.modeling.problems import Stage
from graben.modeling.results import HorizonResult
from graben.modeling.side_by_side import worked
from graben.modeling.tracing import cut_graph
from graben.refinement import refined
from tests.models import grid_horizon, model_of, plane_fault

COSTS = [3.0, 1.0, 2.0, 5.0, 0.5]


@pytest.mark.parametrize("workers", [1, 2, 3, 8])
def test_results_do_not_depend_on_the_number_of_workers(workers: int) -> None:
    assert worked(lambda task: task**2, COSTS, workers, worth=0.0) == [0, 1, 4, 9, 16]


def test_work_is_shared_and_what_is_not_worth_a_process_stays_here() -> None:
    here = os.getpid()
    places = worked(lambda _: os.getpid(), COSTS, 2, worth=1.0)
    assert places[3] == here
    assert len(set(places)) == 2
    assert worked(lambda _: os.getpid(), COSTS, 2, worth=100.0) == [here] * 5
    assert worked(lambda _: os.getpid(), [], 2, worth=0.0) == []


def test_what_a_copy_cannot_do_is_done_or_fails_here() -> None:
    here = os.getpid()

    def dying(task: int) -> int:
        if os.getpid() != here:
            os._exit(9)
        return task

    assert worked(dying, COSTS, 2, worth=0.0) == [0, 1, 2, 3, 4]

    def failing(task: int) -> int:
        raise ModelingError(f"task {task} cannot be done")

    with pytest.raises(ModelingError, match="cannot be done"):
        worked(failing, COSTS, 2, worth=0.0)


@pytest.fixture
def small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Solve even the smallest parts by themselves, each in a process of its own."""
    monkeypatch.setattr(problems, "_LEAST_PART", 0)
    monkeypatch.setattr(building, "_WORTH_A_PROCESS", 0)


@cache
def field() -> tuple[Model, CutHorizon, Complex]:
    """Return a horizon that one fault divides and that two others cut far from it and from each other."""
    horizon = grid_horizon(_displaced, size=6000.0, step=100.0)
    faults = (
        plane_fault((-3500.0, 0.0), (3500.0, 0.0), name="through", parts=(40, 9)),
        plane_fault((-2000.0, 1700.0), (-800.0, 1700.0), name="left"),
        plane_fault((900.0, 1800.0), (2000.0, 1800.0), name="right"),
    )
    model = model_of(horizon, *faults, gamma=400.0)
    network = refined([f.surface for f in faults])
    return model, prepared(model, horizon, cut_graph(model, horizon, network)), network


def _displaced(x: FloatArray, y: FloatArray) -> FloatArray:
    throw = 60.0 * np.exp(-((np.abs(y) / 1500.0) ** 2))
    return np.asarray(0.05 * y - 0.5 * throw * np.tanh(y / 150.0))


def same(one: HorizonResult, other: HorizonResult) -> bool:
    arrays = ("first", "subdomain", "fixed", "side", "block")
    return np.array_equal(one.surface.vertices, other.surface.vertices) and all(
        np.array_equal(getattr(one, key), getattr(other, key)) for key in arrays
    )


@pytest.mark.usefixtures("small_parts")
def test_a_horizon_is_the_same_to_the_bit_with_any_number_of_workers() -> None:
    results = [building.rebuilt(*field(), workers=workers) for workers in (1, 2, 3)]
    assert results[0].converged
    assert len(results[0].subdomains) == 2
    assert same(results[0], results[1]) and same(results[0], results[2])
    told = [[(s.iterations, s.history, s.termination) for s in r.subdomains] for r in results]
    assert told[0] == told[1] == told[2]


def test_small_parts_of_a_subdomain_are_solved_together() -> None:
    stage = Stage.of(*field(), Cholmod())
    assert [len(stage.parts(a.subdomain)) for a in field()[1].anchors] == [1, 1]


@pytest.mark.usefixtures("small_parts")
def test_parts_of_a_subdomain_are_independent() -> None:
    model, horizon, network = field()
    stage = Stage.of(model, horizon, network, Cholmod())
    labels = horizon.cut.node_labels
    above = labels[np.argmax(np.where(labels >= 0, horizon.first[:, 1], -np.inf))]
    parts = stage.parts(int(above))
    assert len(parts) == 3
    for part in parts:
        rows, local, _ = stage.problem(int(part))
        others = stage.part[local][stage.part[local] >= 0]
        assert set(others.tolist()) == {int(part)}
        assert np.isin(horizon.cut.triangles[rows], local).all()


@pytest.mark.usefixtures("small_parts")
def test_where_one_part_fails_the_others_are_rebuilt(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = building.rebuilt(*field())
    solved = Stage.problem

    def failing(self: Stage, part: int) -> tuple[IntArray, IntArray, Problem]:
        if "left" in {self.model.faults[f].name for f in np.unique(self.lips.faults[self.cut_of(part)])}:
            raise ModelingError("This part cannot be solved.")
        return solved(self, part)

    monkeypatch.setattr(Stage, "problem", failing)
    result = building.rebuilt(*field(), workers=1)
    assert sorted(int(s.termination.type) for s in result.subdomains) == [0, 1]
    at_left = (result.first[:, 0] < 0) & (result.first[:, 1] > 1000.0)
    assert np.array_equal(result.surface.vertices[at_left], result.first[at_left])
    assert np.array_equal(result.surface.vertices[~at_left], whole.surface.vertices[~at_left])
