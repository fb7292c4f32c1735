"""cycles: what it says of a cycle is what opens it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.cleaning import cycles
from graben.cutgraph import NodeKind
from graben.finding import Status
from graben.model import Fault
from graben.repairs import repair
from graben.surface import Surface
from graben.validators.acyclic import cycles as around
from graben.validators.measuring.measures import amount
from tests.cleaning.tasks import proposed, task_of
from tests.zoo import acyclic

CASES = {case.name: case for case in acyclic.FAILING}
#: How much wider than max_extension the gap is made.
WIDER = 1.3


def noted(model):
    """What repair leaves of acyclic under `paper`."""
    return [note for note in repair(model, "paper").left if note.check == "acyclic"]


@pytest.mark.parametrize("name", CASES)
def test_every_cycle_is_told_with_its_place(name):
    (note,) = noted(CASES[name].model)
    assert note.action == "cycles"
    assert "The cycle of" in note.reason
    if "pipe" in name:
        assert "no corner" in note.reason
    else:
        assert note.place is not None
        assert "costs least to open" in note.reason


@pytest.mark.parametrize("name", ["large triangle", "square of four"])
def test_the_fault_named_cut_back_so_far_opens_the_cycle(name):
    model = CASES[name].model
    (note,) = noted(model)
    fault = next(f for f in model.faults if f"at {f.name}:" in note.reason)
    cut = replace(
        model,
        faults=tuple(
            Fault(_cut_back(f.surface, np.array(note.place), WIDER * model.max_extension(f)))
            if f is fault
            else f
            for f in model.faults
        ),
    )
    left = repair(cut, "paper")
    assert [f.status for f in left.after.of("acyclic")] == [Status.PASS]
    assert not any(set(a.objects) & {fault.name} and "extended" in a.reason for a in left.actions)


def test_the_shortest_cut_is_that_of_the_shortest_end() -> None:
    task, _, (refusal,) = proposed(CASES["small triangle"].model, cycles.REPAIR)
    graph = task.evidence.graphs["H"]
    (cycle,) = around(graph)
    found = cycles.openings(graph, cycle)
    assert len(found) == 6
    assert f"{amount(found[0].length, 'm')} of its trace" in refusal.reason
    assert np.array_equal(refusal.place, found[0].place)
    tips = graph.nodes[graph.kinds == NodeKind.TIP]
    straight = np.linalg.norm(tips[:, None, :2] - np.array([o.place[:2] for o in found]), axis=2)
    assert found[0].length >= straight.min() - 1e-6
    assert [o.length for o in found] == sorted(o.length for o in found)


@pytest.mark.parametrize("case", acyclic.PASSING, ids=lambda c: c.name)
def test_no_cycle_asks_for_nothing(case) -> None:
    assert not task_of(case.model, cycles.REPAIR).findings


def _cut_back(surface: Surface, place: np.ndarray, gap: float) -> Surface:
    """The surface without what lies beyond a place, towards its nearer end, and without a gap before it."""
    plan = surface.vertices[:, :2]
    strike = np.linalg.eigh(np.cov(plan.T))[1][:, 1]
    along = (plan - place[:2]) @ strike
    inward = strike if -along.min() < along.max() else -strike
    middles = plan[surface.triangles].mean(axis=1)
    return replace(surface, triangles=surface.triangles[(middles - place[:2]) @ inward > gap])
