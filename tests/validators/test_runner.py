"""What waits for what, what blocks what, and what a tolerance in [checks] does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.cutgraph import DroppedTrace
from graben.finding import Profile, Status
from graben.validators.registry import CHECKS, find, known_ids
from graben.validators.runner import run_checks, shifted
from tests.zoo.degenerate import FAILING as DEGENERATE
from tests.zoo.shapes import (
    F60,
    NAN,
    STEP,
    Fakes,
    L,
    N,
    T,
    dipping,
    faults,
    folded_points,
    graph,
    level,
    moved_vertex,
)


class Counting(Fakes):
    """Providers that count what they are asked for."""

    def __init__(self, **values):
        super().__init__(**values)
        object.__setattr__(self, "asked", [])

    def complex(self, model):
        self.asked.append("complex")
        return super().complex(model)

    def graph(self, model, horizon, complex):
        self.asked.append(("graph", horizon.name))
        return super().graph(model, horizon, complex)

    def anchoring(self, model, horizon, graph):
        self.asked.append(("anchoring", horizon.name))
        return super().anchoring(model, horizon, graph)


BROKEN = moved_vertex(F60, 3, [NAN, 0, 0])


def test_all_passes_on_a_plain_model():
    providers = Counting()
    result, evidence = run_checks(faults(F60, horizons=[level("A"), level("B")]), Profile.PAPER, providers)
    assert result.passed
    assert evidence.complex is not None
    assert list(evidence.graphs) == list(evidence.anchors) == ["A", "B"]
    assert not evidence.blocked("A")
    asked = ["complex", ("graph", "A"), ("graph", "B"), ("anchoring", "A"), ("anchoring", "B")]
    assert providers.asked == asked


def test_an_unfit_fault_blocks_every_horizon_and_nothing_is_asked():
    providers = Counting()
    result, evidence = run_checks(faults(BROKEN, horizons=[level("A")]), Profile.EXTENDED, providers)
    assert providers.asked == []
    assert [f.check for f in evidence.blocked("A")] == ["finite"]
    for check in ("degenerate", "strongly-connected", "pairwise-connected", "trace", "acyclic", "anchored"):
        (finding,) = result.of(check)
        assert finding.status is Status.SKIPPED
        assert "waits for finite" in finding.message
    assert not result.passed


def test_an_unfit_horizon_blocks_itself_alone():
    bad = level("A", points=folded_points(110))
    providers = Counting()
    result, evidence = run_checks(faults(F60, horizons=[bad, level("B")]), Profile.EXTENDED, providers)
    assert [f.check for f in evidence.blocked("A")] == ["functional"]
    assert evidence.blocked("B") == ()
    assert ("graph", "B") in providers.asked
    assert ("graph", "A") not in providers.asked
    assert result.of("trace")[0].status is Status.SKIPPED
    assert "A" in result.of("trace")[0].message


def test_an_unfit_horizon_leaves_the_fault_checks_alone():
    horizon = level("A")
    horizon = replace(horizon, surface=moved_vertex(horizon.surface, 0, [NAN, 0, 0]))
    result, evidence = run_checks(faults(F60, horizons=[horizon]), Profile.EXTENDED, Fakes())
    assert evidence.complex is not None
    statuses = {c: result.of(c)[0].status for c in ("duplicate", "strongly-connected", "min-dip")}
    assert statuses["duplicate"] is Status.SKIPPED
    assert statuses["strongly-connected"] is statuses["min-dip"] is Status.PASS


@pytest.mark.parametrize(
    ("fakes", "check", "blocked"),
    [
        (Fakes(shape="no room."), "simplicial-complex", ("A", "B")),
        (Fakes(graphs={"A": "no room."}), "trace", ("A",)),
        (Fakes(anchors={"A": "no room."}), "anchored", ("A",)),
    ],
)
def test_what_cannot_be_prepared_fails_the_check_that_asked(fakes, check, blocked):
    result, evidence = run_checks(faults(F60, horizons=[level("A"), level("B")]), Profile.EXTENDED, fakes)
    (finding,) = result.of(check)
    assert finding.status is Status.FAIL
    assert finding.message.endswith("no room.")
    assert tuple(n for n in ("A", "B") if evidence.blocked(n)) == blocked
    assert [f.check for f in result.findings if f.status is Status.FAIL] == [check]


def test_findings_stand_in_the_order_of_the_table_and_of_the_model():
    both = faults(BROKEN, moved_vertex(dipping(60, name="A"), 0, [0, NAN, 0]), horizons=[level("Z")])
    result, _ = run_checks(both, Profile.EXTENDED, Fakes())
    assert [f.objects for f in result.of("finite")] == [("F",), ("A",)]
    assert tuple(dict.fromkeys(f.check for f in result.findings)) == known_ids()


@pytest.mark.parametrize(
    ("check", "model", "loose", "tight"),
    [
        ("degenerate", faults(dipping(60)), 1.0, 50.0),
        ("min-dip", faults(dipping(40)), 35.0, 45.0),
        ("functional", faults(horizons=[level(points=folded_points(75))]), 85.0, 60.0),
    ],
)
def test_a_tolerance_in_checks_moves_the_limit(check, model, loose, tight):
    found = []
    for value in (loose, tight):
        result, _ = run_checks(replace(model, checks={check: value}), Profile.PAPER, Fakes())
        found.append(result.of(check)[0].status is Status.PASS)
    assert found == [True, False]
    assert find(check).tolerance


def test_a_shift_of_the_result_moves_all_places():
    case = next(c for c in DEGENERATE if c.name == "sliver")
    result, _ = run_checks(case.model, Profile.EXTENDED, Fakes())
    offset = np.array([1e5, -2e5, 30.0])
    (before,), (after,) = result.of("degenerate"), shifted(result, offset).of("degenerate")
    assert np.allclose(after.places, before.places + offset)
    worst = np.array([[f.worst.x, f.worst.y, f.worst.z] for f in (before, after)])
    assert np.allclose(worst[1], worst[0] + offset)


def test_a_loose_end_and_a_left_out_piece_of_one_trace_are_one_finding():
    short = DroppedTrace(0, 0.8 * STEP, STEP * np.array([7.0, 4, 0]), "shorter than 2 steps")
    nodes = [(1, 4), (2, 4), (3, 4), (4, 4), (5, 4)]
    net = graph(nodes, [T, N, N, N, L], [(0, 1), (1, 2), (2, 3), (3, 4)], [0] * 4, [short])
    result, _ = run_checks(faults(F60, horizons=[level()]), Profile.EXTENDED, Fakes(graphs={"H": net}))
    (finding,) = result.of("trace")
    assert finding.status is Status.FAIL
    assert "left out" in finding.message


def test_no_fault_at_all_is_no_defect():
    result, evidence = run_checks(faults(horizons=[level()]), Profile.PAPER, Fakes())
    assert result.passed
    assert "H" in evidence.graphs


def test_every_check_says_what_it_asks_for():
    assert len(set(known_ids())) == len(CHECKS) == 19
    for check in CHECKS:
        assert check.sentence.endswith(".")
        assert check.section
    with pytest.raises(KeyError):
        find("no such check")
