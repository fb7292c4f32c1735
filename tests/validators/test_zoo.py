"""The gate on the zoo: what is wrong is named with its place, and nothing else; what comes close passes."""

from __future__ import annotations

import jsonschema
import numpy as np
import pytest

from graben.finding import Element, Finding, Profile, Status
from graben.proximity import nearest
from graben.schema import schemas
from graben.validators.registry import CHECKS, known_ids
from tests.zoo import FAILING, PASSING, said
from tests.zoo.cases import Case
from tests.zoo.shapes import STEP

SPEAKS = (Status.WARN, Status.FAIL)
VALID = jsonschema.Draft202012Validator(schemas()["check"])
#: How far a place may lie off the surfaces: what finite says of a lost coordinate is a guess, a hole in a
#: horizon has its place inside, and the part that a cycle encloses has it at the mean height of the cycle.
OFF = {"finite": STEP, "horizon": 2.5 * STEP, "acyclic": STEP}
ON = 1e-3 * STEP


def named(cases):
    return pytest.mark.parametrize("case", cases, ids=[f"{c.check}: {c.name}" for c in cases])


profiles = pytest.mark.parametrize("profile", Profile, ids=str)


def speaking(case: Case, profile: Profile) -> list[Finding]:
    """The findings that warn or fail."""
    return [f for f in said(case, profile)[0].findings if f.status in SPEAKS]


def places_of(case: Case, worst: np.ndarray) -> np.ndarray:
    """Where the case is wrong, shape (p, 3); what cannot be told is taken from the finding."""
    rows = case.place if np.ndim(case.place[0]) else [case.place]
    return np.array([[w if c is None else c for c, w in zip(row, worst, strict=True)] for row in rows], float)


@profiles
@named(FAILING)
def test_a_defect_is_named(case, profile):
    found = said(case, profile)[0].of(case.check)
    assert [(str(f.status), f.objects) for f in found] == [(getattr(case, profile.value), case.objects)]
    (finding,) = found
    assert finding.message.endswith(".")
    assert finding.remedy.endswith(".")


@profiles
@named((*FAILING, *PASSING))
def test_nothing_else_is_said(case, profile):
    own = {case.check} if case in FAILING else set()
    assert {f.check for f in speaking(case, profile)} == own | set(case.follows)


@named([c for c in FAILING if c.place is not None])
def test_the_place_of_a_defect_is_given(case):
    (finding,) = said(case, Profile.EXTENDED)[0].of(case.check)
    worst = np.array([finding.worst.x, finding.worst.y, finding.worst.z])
    want = places_of(case, worst)
    assert np.linalg.norm(want - worst, axis=1).min() <= STEP + ON
    apart = np.linalg.norm(want[:, None] - finding.places, axis=2)
    assert apart.min(axis=1).max() <= STEP + ON


@profiles
@named(FAILING)
def test_what_blocks(case, profile):
    blocking = said(case, profile)[1].blocking
    assert any((f.check, f.objects) == (case.check, case.objects) for f in blocking) == case.blocks
    assert {f.check for f in blocking} <= {case.check, *case.follows}


@profiles
@named(PASSING)
def test_what_comes_close_passes(case, profile):
    result, evidence = said(case, profile)
    assert [f.status for f in result.of(case.check)] == [Status.PASS]
    assert result.passed or case.follows
    assert not [f for f in evidence.blocking if f.check == case.check]


@named((*FAILING, *PASSING))
def test_places_lie_on_the_model(case):
    surfaces = [s for s in case.model.surfaces if np.isfinite(s.vertices).all() and len(s.triangles)]
    picks = [h.picks[np.isfinite(h.picks).all(axis=1)] for h in case.model.horizons]
    for finding in speaking(case, Profile.EXTENDED):
        spots = [p.place for p in finding.parts]
        if finding.worst is not None:
            spots.append((finding.worst.x, finding.worst.y, finding.worst.z))
        points = np.concatenate([finding.places, *finding.paths, np.reshape(spots, (-1, 3))])
        assert np.isfinite(points).all()
        parts = [np.linalg.norm(points[:, None] - p, axis=2).min(axis=1) for p in picks if len(p)]
        for s in surfaces:
            inside = ((s.triangles >= 0) & (s.triangles < len(s.vertices))).all(axis=1)
            parts.append(nearest(points, s.vertices, s.triangles[inside]).distance)
        assert not len(points) or np.min(parts, axis=0).max() <= OFF.get(finding.check, ON)


@named(FAILING)
def test_elements_can_be_found_again(case):
    _, evidence = said(case, Profile.EXTENDED)
    surfaces = {s.name: s for s in case.model.surfaces}
    picks = {h.name: len(h.picks) for h in case.model.horizons}
    for finding in speaking(case, Profile.EXTENDED):
        first = finding.objects[0]
        graph = evidence.graphs.get(first)
        count = {
            Element.NONE: 0,
            Element.VERTEX: len(surfaces[first].vertices),
            Element.TRIANGLE: len(surfaces[first].triangles),
            Element.PICK: picks.get(first, 0),
            Element.NODE: 0 if graph is None else len(graph.nodes),
            Element.EDGE: 0 if graph is None else len(graph.edges),
            Element.SUBDOMAIN: len(evidence.anchors.get(first, ())),
        }[finding.element]
        assert ((finding.elements >= 0) & (finding.elements < count)).all()


@profiles
@named((*FAILING, *PASSING))
def test_every_id_occurs_in_order_and_the_json_is_valid(case, profile):
    result, _ = said(case, profile)
    assert tuple(dict.fromkeys(f.check for f in result.findings)) == known_ids()
    assert list(VALID.iter_errors(result.as_dict())) == []
    assert result.passed == all(f.status is not Status.FAIL for f in result.findings)


@pytest.mark.parametrize("check", CHECKS, ids=lambda c: c.id)
def test_the_zoo_is_complete(check):
    assert sum(c.check == check.id for c in FAILING) >= 3
    assert sum(c.check == check.id for c in PASSING) >= 3


def test_no_two_cases_of_a_check_have_one_name():
    names = [(c.check, c.name) for c in (*FAILING, *PASSING)]
    assert len(set(names)) == len(names)


def test_the_paper_profile_is_the_stricter():
    rank = [Status.PASS, Status.SKIPPED, Status.WARN, Status.FAIL]
    for case in (*FAILING, *PASSING):
        pairs = zip(*(said(case, p)[0].findings for p in (Profile.PAPER, Profile.EXTENDED)), strict=True)
        for paper, extended in pairs:
            assert (paper.check, paper.objects, paper.message) == (
                extended.check,
                extended.objects,
                extended.message,
            )
            assert rank.index(paper.status) >= rank.index(extended.status)
