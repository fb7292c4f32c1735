"""Corrupted networks, repaired: what is clean again, and that nothing is left without a word."""

from __future__ import annotations

import pytest

from graben.finding import Status
from graben.repairs import repair
from tests.cleaning.corruption import cases, judged

#: `make bench` takes 300.
COUNT = 30


@pytest.mark.parametrize("case", cases(COUNT), ids=lambda case: case.name)
def test_a_corrupted_network_passes_after_repair_near_its_input_and_near_the_clean_one(case) -> None:
    built = case.built()
    result = repair(built.model, "paper")
    again = repair(result.model, "paper")
    verdict = judged(built.clean, built.model, result.model, result.actions, again.before)
    assert verdict.passed, verdict
    failing = {(f.check, f.objects) for f in result.after.findings if f.status is Status.FAIL}
    assert failing <= {(note.check, note.objects) for note in result.left}
    changed = {
        name
        for fault in result.model.faults
        for name in (fault.name, result.lineage[fault.name])
        if not any(fault.surface is given.surface for given in built.model.faults)
    }
    assert changed <= {name for action in result.actions for name in (*action.objects, *_after(action))}
    assert again.actions == ()
    assert all(a.surface is b.surface for a, b in zip(again.model.faults, result.model.faults, strict=True))


def _after(action) -> tuple[str, ...]:
    return tuple(measures.name for measures in action.after)
