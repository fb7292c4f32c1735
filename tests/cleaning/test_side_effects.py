"""What a change makes worse counts against what it mends."""

from __future__ import annotations

import pytest

from graben.cleaning import planner
from graben.cleaning.side_effects import grown, worsened
from graben.finding import CheckResult, Finding, Profile, Status
from graben.repairs import repair
from tests.zoo.trace import FAILING


def result(**counts: int) -> CheckResult:
    """Findings that warn of F, by check and count; of none where the count is 0."""
    return CheckResult(
        Profile.EXTENDED,
        tuple(
            Finding(check, Status.WARN if count else Status.PASS, ("H", "F") if count else (), count)
            for check, count in counts.items()
        ),
    )


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ({"trace": 6}, {"trace": 0}, -1.0),
        ({"trace": 6}, {"trace": 3}, -0.5),
        ({"trace": 6, "horizon": 100}, {"trace": 0, "horizon": 130}, -0.7),
        ({"trace": 6, "horizon": 100}, {"trace": 0, "horizon": 500}, 0.0),
        ({"trace": 6, "horizon": 0}, {"trace": 3, "horizon": 1}, 0.5),
        ({"trace": 6, "horizon": 100}, {"trace": 6, "horizon": 10}, 0.0),
    ],
)
def test_findings_that_grow_or_come_count_against_those_that_shrink(before, after, expected) -> None:
    assert worsened(("trace",), {"F"}, result(**before), result(**after)) == pytest.approx(expected)


def test_other_surfaces_do_not_count() -> None:
    assert worsened(("trace",), {"G"}, result(trace=6, horizon=0), result(trace=0, horizon=9)) == 0.0


def test_what_grew_is_named() -> None:
    before, after = result(trace=6, horizon=3, functional=2), result(trace=9, horizon=4, functional=2)
    assert [f.check for f in grown(("trace",), {"F"}, before, after)] == ["horizon"]


def test_a_change_that_worsens_more_than_it_mends_is_undone(monkeypatch: pytest.MonkeyPatch) -> None:
    case = next(c for c in FAILING if c.name.startswith("too short"))
    assert [a.action for a in repair(case.model).actions] == ["margin"]
    monkeypatch.setattr(planner, "worsened", lambda *given: 0.1)
    undone = repair(case.model)
    assert undone.actions == ()
    assert any(left.action == "margin" and "undone" in left.reason for left in undone.left)
