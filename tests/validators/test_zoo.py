"""Every check on the zoo: what is wrong is named with its place, what comes close passes."""

from __future__ import annotations

import numpy as np
import pytest

from graben.finding import Profile, Status
from graben.validators.registry import CHECKS, known_ids
from graben.validators.runner import run_checks
from tests.zoo import FAILING, PASSING
from tests.zoo_shapes import STEP

LATER = {"self-intersection", "z-monotone", "near-miss", "horizon", "junction-values"}
PREPARED = {"simplicial-complex"}  # says whether the complex can be made; its zoo is in test_runner


def named(cases):
    return pytest.mark.parametrize("case", cases, ids=[f"{c.check}: {c.name}" for c in cases])


@named(FAILING)
def test_a_defect_is_named_with_its_place(case):
    result, evidence = run_checks(case.model, Profile.EXTENDED, case.providers)
    found = result.of(case.check)
    assert [(str(f.status), f.objects) for f in found] == [(case.extended, case.objects)]
    (finding,) = found
    assert finding.message.endswith(".")
    assert finding.remedy.endswith(".")
    assert case.blocks == any(f is finding for f in evidence.blocking)
    if case.place is not None:
        worst = np.array([finding.worst.x, finding.worst.y, finding.worst.z])
        want = np.array([w if p is None else p for w, p in zip(worst, case.place, strict=True)], float)
        assert np.linalg.norm(finding.places - want, axis=1).min() <= STEP
        assert np.linalg.norm(finding.places - worst, axis=1).min() <= 1e-9 * STEP


@named(FAILING)
def test_the_paper_profile_is_the_stricter(case):
    result, _ = run_checks(case.model, Profile.PAPER, case.providers)
    assert [str(f.status) for f in result.of(case.check)] == [case.paper]
    assert result.passed == all(f.status is not Status.FAIL for f in result.findings)


@named(FAILING)
def test_places_lie_on_the_model(case):
    result, _ = run_checks(case.model, Profile.EXTENDED, case.providers)
    points = np.concatenate(
        [s.vertices for s in case.model.surfaces] + [h.picks for h in case.model.horizons]
    )
    points = points[np.isfinite(points).all(axis=1)]
    if isinstance(case.providers.shape, str) or case.check in ("trace", "junction", "acyclic", "anchored"):
        return
    for finding in result.of(case.check):
        for place in finding.places:
            assert np.isfinite(place).all()
            assert np.linalg.norm(points - place, axis=1).min() <= 2.5 * STEP


@named(PASSING)
def test_what_comes_close_passes(case):
    result, evidence = run_checks(case.model, Profile.PAPER, case.providers)
    assert [f.status for f in result.of(case.check)] == [Status.PASS]
    assert not [f for f in evidence.blocking if f.check == case.check]


@pytest.mark.parametrize(
    "check", [c for c in CHECKS if c.run is not None and c.id not in PREPARED], ids=lambda c: c.id
)
def test_the_zoo_is_complete(check):
    assert sum(c.check == check.id for c in FAILING) >= 3
    assert sum(c.check == check.id for c in PASSING) >= 3


def test_every_id_occurs_in_every_result():
    for case in (*FAILING, *PASSING):
        result, _ = run_checks(case.model, Profile.EXTENDED, case.providers)
        assert tuple(dict.fromkeys(f.check for f in result.findings)) == known_ids()
        assert {f.check for f in result.findings if "not part of this version" in f.message} == LATER
