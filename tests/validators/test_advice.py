"""A remedy is one clear instruction, and a worst value says what it is the worst of."""

from __future__ import annotations

import pytest

from graben.finding import Finding, Status
from graben.model import Model
from graben.pipeline import check
from tests.zoo.networks import around, cut, field, pipe, plane


def told(model: Model, name: str) -> Finding:
    (found,) = [f for f in check(model).of(name) if f.status in (Status.WARN, Status.FAIL)]
    return found


@pytest.mark.parametrize("faults", [around(2.6, beyond=2.8), [pipe(4.0)]])
def test_a_cycle_that_can_be_modeled_asks_for_nothing(faults) -> None:
    found = told(cut(field(), *faults), "acyclic")
    assert found.status is Status.WARN
    assert found.remedy.startswith("Nothing")
    assert "gap" not in found.remedy


def test_a_cycle_that_cannot_says_what_opens_it() -> None:
    several, alone = (told(cut(field(), *faults), "acyclic") for faults in (around(0.9), [pipe(2.0)]))
    assert several.status is alone.status is Status.FAIL
    assert several.remedy.startswith("Leave a gap in one of the faults")
    assert alone.remedy.startswith("Smooth the horizon beside the fault")


def test_of_a_gap_that_widens_the_worst_is_called_the_least() -> None:
    # F stops short of G, nearer at one end of its side than at the other
    model = cut(field(), plane((-7, 0.3), (-2.2, 0.3), dip=70.0), plane((0, -6), (0.3, 6), "G", dip=50.0))
    found = told(model, "near-miss")
    assert found.worst is not None
    assert " to " in found.message
    assert "The worst given is the least distance" in found.message
    least = min(p.value for p in found.parts if p.value is not None)
    assert found.worst.value == pytest.approx(least)
