"""No verdict depends on the order of vertices, on the direction of north or on where the origin is."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from graben.finding import Profile
from graben.model import Fault, Horizon, Model
from graben.validators.registry import known_ids
from graben.validators.runner import run_checks, shifted
from tests.strategies import cases, motions, nonsense
from tests.zoo import FAILING, PASSING, Fakes
from tests.zoo_shapes import STEP

EASY = settings(max_examples=80, deadline=None, derandomize=True, database=None)


@EASY
@given(cases((*FAILING, *PASSING)), motions())
def test_a_verdict_moves_with_the_model(case, motion):
    before, _ = run_checks(case.model, Profile.EXTENDED, case.providers)
    moved = motion.model(case.model)
    origin = moved.local_origin()
    after, _ = run_checks(moved.moved(-origin), Profile.EXTENDED, motion.providers(case.providers, origin))
    after = shifted(after, origin)
    assert [(f.check, f.status, f.objects, f.count) for f in before.findings] == [
        (f.check, f.status, f.objects, f.count) for f in after.findings
    ]
    for old, new in zip(before.of(case.check), after.of(case.check), strict=True):
        if old.worst is None or case.name == "infinite point":
            continue  # what remains of a point with a lost coordinate depends on the axes
        assert np.isclose(old.worst.value, new.worst.value, rtol=1e-5, atol=1e-6)
        worst = np.array([new.worst.x, new.worst.y, new.worst.z])
        assert np.linalg.norm(motion.points(old.places) - worst, axis=1).min() <= STEP


@EASY
@given(nonsense("F"), nonsense("G"), nonsense("H"), st.sampled_from(Profile))
def test_nonsense_is_a_finding_and_never_an_exception(first, second, third, profile):
    picks = third.vertices
    model = Model("nonsense", (Horizon("H", third, 50.0, picks=picks),), (Fault(first), Fault(second)))
    result, _ = run_checks(model, profile, Fakes())
    assert tuple(dict.fromkeys(f.check for f in result.findings)) == known_ids()
    assert all(np.isfinite(f.places).all() for f in result.findings)
