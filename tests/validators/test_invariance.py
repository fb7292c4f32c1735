"""No verdict depends on the order of vertices, on the direction of north or on where the origin is."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from graben.finding import CheckResult, Element, Finding, Profile, Status
from graben.model import Fault, Horizon, Model
from graben.pipeline import check
from graben.proximity import nearest
from graben.reading import read_model
from graben.settings import Parameters
from graben.surface import Surface
from graben.validators.registry import known_ids
from tests.strategies import NASTY, Motion, motions, nonsense, tangles
from tests.zoo import FAILING, PASSING, said
from tests.zoo.shapes import STEP, faults, level, scene

HECHO = Path(__file__).parents[2].parent / "shared" / "data" / "hecho" / "model.toml"
FEW = settings(max_examples=80, deadline=None, derandomize=True, database=None)
#: How well places agree, in steps: rounding, and where a polyline is resampled from the other end.
NEAR = 0.02
#: The same for what finite guesses in place of a lost coordinate: that depends on the axes.
GUESSED = 2.5
#: How well values agree: a polyline resampled from its other end encloses another area by some 1e-6 of it.
RELATIVE = 1e-5
OF_THE_INPUT = (Element.VERTEX, Element.TRIANGLE, Element.PICK)


def moved_along(model: Model, before: CheckResult, motion: Motion, step: float = STEP) -> None:
    """Assert that the findings of the moved model are those of the model, moved."""
    after = check(motion.model(model), before.profile)
    assert [plain(f) for f in before.findings] == [plain(f) for f in after.findings]
    for old, new in zip(before.findings, after.findings, strict=True):
        near = step * (GUESSED if old.check == "finite" else NEAR)
        assert (old.worst is None) == (new.worst is None)
        if new.worst is not None:
            assert close(old.worst.value, new.worst.value, step)
            assert apart([(new.worst.x, new.worst.y, new.worst.z)], motion.points(old.places)) <= near
        assert len(old.places) == len(new.places)
        assert same_places(motion.points(old.places), new.places, near)
        assert [p.count for p in by_kind(old)] == [p.count for p in by_kind(new)]
        assert all(close(a.value, b.value, step) for a, b in zip(by_kind(old), by_kind(new), strict=True))
        lines = [motion.points(path) for path in old.paths]
        assert (beside(new.paths, lines) <= near) and (beside(lines, new.paths) <= near)
        # of several equal ones any may be named, but none that was not there
        known = motion.points([*old.places, *(p.place for p in old.parts)])
        for part in new.parts:
            spot = [np.array([part.place])]
            assert min(apart(part.place, known), beside(spot, lines)) <= near


def plain(finding: Finding) -> tuple:
    """What of a finding must be equal; numbers in a message may round to another last digit."""
    message = re.sub(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?", "#", finding.message)
    kinds = [(p.kind, p.objects, p.unit) for p in by_kind(finding)]
    # nodes and edges are numbered on a cut graph of its own
    size = len(finding.elements) if finding.element in OF_THE_INPUT else 0
    unit = None if finding.worst is None else finding.worst.unit
    return finding.check, finding.status, finding.objects, finding.count, unit, size, message, kinds


def by_kind(finding: Finding):
    """The parts in an order of their own; how large equal ones are is compared in the order of size."""
    return sorted(finding.parts, key=lambda p: (p.kind, p.objects, p.count, p.value or 0.0))


def beside(lines, others) -> float:
    """The largest distance of a corner of the first lines to the others; 0 without any."""
    if not len(lines) or not len(others):
        return 0.0 if not len(lines) else np.inf
    points, corners = np.concatenate(lines), np.concatenate(others)
    starts = np.cumsum([0, *map(len, others)])
    edges = [np.stack([k := np.arange(a, b), np.minimum(k + 1, b - 1)], 1) for a, b in pairwise(starts)]
    origin = corners.mean(axis=0)
    return float(nearest(points - origin, corners - origin, np.concatenate(edges)).distance.max())


def close(a: float | None, b: float | None, step: float) -> bool:
    return a is b is None or bool(np.isclose(a, b, rtol=RELATIVE, atol=RELATIVE * step))


def same_places(a, b, near: float) -> bool:
    """Whether each place of either set is near one of the other."""
    a, b = np.reshape(a, (-1, 3)), np.reshape(b, (-1, 3))
    return max(apart(a, b), apart(b, a)) <= near


def apart(a, b) -> float:
    """The largest distance of a point of the first set to the second; 0 for an empty one."""
    a, b = np.reshape(a, (-1, 3)), np.reshape(b, (-1, 3))
    if not len(a):
        return 0.0
    return float(np.linalg.norm(a[:, None] - b, axis=2).min(axis=1, initial=np.inf).max())


@pytest.mark.parametrize("case", (*FAILING, *PASSING), ids=lambda c: f"{c.check}: {c.name}")
def test_every_verdict_moves_with_its_model(case):
    moved_along(case.model, said(case, Profile.EXTENDED)[0], NASTY)


@FEW
@given(st.sampled_from((*FAILING, *PASSING)), motions())
def test_a_verdict_moves_with_the_model(case, motion):
    moved_along(case.model, said(case, Profile.EXTENDED)[0], motion)


def test_a_real_model_16_units_wide_has_the_same_verdict_elsewhere():
    if not HECHO.is_file():
        pytest.skip(f"no {HECHO}")
    model = read_model(HECHO)
    moved_along(model, check(model, Profile.PAPER), NASTY, min(h.step for h in model.horizons))


#: A fault whose trace forks, and another in pieces: lines of unequal length in one finding.
FORKED = Surface(
    "F",
    STEP * np.array([[0, 1, 0], [0, 0, 0], [0, 0, 1], [0, -2, 1], [0, 0, 2], [-1, 2, 1]]),
    [[4, 0, 3], [1, 3, 5], [2, 0, 5], [0, 4, 5]],
)
ACROSS = Surface("G", STEP * np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0]]), [[0, 1, 2]])


def holds_together(model: Model, profile: Profile) -> None:
    """Assert that the gate answers, with every id and with places that are places."""
    result = check(model, profile)
    assert tuple(dict.fromkeys(f.check for f in result.findings)) == known_ids()
    for finding in result.findings:
        assert np.isfinite(finding.places).all()
        assert finding.worst is None or np.isfinite(finding.worst.value)
        assert (finding.status is Status.PASS) <= (finding.count == 0)


@FEW
@given(nonsense("F"), nonsense("G"), nonsense("H"), st.sampled_from(Profile))
def test_nonsense_is_a_finding_and_never_an_exception(first, second, third, profile):
    horizon = Horizon("H", third, STEP, picks=third.vertices)
    holds_together(Model("nonsense", (horizon,), (Fault(first), Fault(second))), profile)


@FEW
@example(FORKED, ACROSS, Profile.EXTENDED)
@given(tangles("F"), tangles("G"), st.sampled_from(Profile))
def test_tangles_are_findings_and_never_an_exception(first, second, profile):
    horizon = level().moved(np.array([-4.0 * STEP + 3, -4.0 * STEP + 7, 11]))
    holds_together(faults(first, second, horizons=[horizon], parameters=Parameters(gamma=STEP)), profile)


def test_a_motion_changes_what_it_says():
    model = scene()
    moved = NASTY.model(model)
    old, new = model.horizons[0].surface, moved.horizons[0].surface
    assert not np.allclose(new.vertices, NASTY.points(old.vertices))
    corners = {tuple(map(tuple, np.sort(NASTY.points(old.vertices)[t], axis=0))) for t in old.triangles}
    assert corners == {tuple(map(tuple, np.sort(new.vertices[t], axis=0))) for t in new.triangles}
