"""Trace ends that lie nowhere: what is extended, and what is left with which number."""

from __future__ import annotations

import numpy as np
import pytest

from graben.cleaning import trace_ends
from graben.cleaning.repairing import Change
from graben.validators.measuring.trace_measures import Goal, LooseEnd
from tests.cleaning.tasks import applied, proposed, task_of
from tests.zoo import trace

LOOSE = [c for c in trace.FAILING if "hole" in c.name]


@pytest.mark.parametrize("case", LOOSE, ids=lambda c: c.name)
def test_an_end_at_a_hole_is_no_matter_of_the_fault(case) -> None:
    _, changes, refusals = proposed(case.model, trace_ends.REPAIR)
    assert not changes
    assert refusals
    assert all("hole" in r.reason and "Close the hole" in r.advice for r in refusals)
    assert all(r.place is not None for r in refusals)


@pytest.mark.parametrize("case", trace.PASSING, ids=lambda c: c.name)
def test_legal_ends_ask_for_nothing(case) -> None:
    assert not task_of(case.model, trace_ends.REPAIR).findings


def test_a_fault_goes_on_past_the_place_that_its_trace_lacks() -> None:
    case = next(c for c in trace.PASSING if c.name == "just over two steps")
    task = task_of(case.model, trace_ends.REPAIR)
    (horizon,), graph = task.model.horizons, task.evidence.graphs["H"]
    end = int(np.argmax(graph.nodes[:, 0]))
    loose = LooseEnd(end, False, 40.0, Goal.BOUNDARY, "H")
    assert trace_ends._refused(task, task.fault("F"), horizon, graph, loose) is None
    change = trace_ends._extension(task, task.fault("F"), [(horizon, graph, loose)])
    assert isinstance(change, Change)
    after = result_graph(applied(task.model, change))
    assert after.nodes[:, 0].max() > graph.nodes[end, 0] + 40.0
    assert after.nodes[:, 0].min() == pytest.approx(graph.nodes[:, 0].min(), abs=1.0)
    far = LooseEnd(end, False, 4000.0, Goal.BOUNDARY, "H")
    refusal = trace_ends._refused(task, task.fault("F"), horizon, graph, far)
    assert refusal is not None
    assert refusal.needed is not None
    assert refusal.needed > 3000.0


def result_graph(model):
    return task_of(model, trace_ends.REPAIR).evidence.graphs["H"]
