"""Which real horizons are functions of x and y, and that a real fault passes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graben.finding import Profile, Status
from graben.model import Model
from graben.reading import read_model
from graben.validators.runner import run_checks
from tests.zoo import Fakes

DATA = Path(__file__).parents[2].parent / "shared" / "data"


def verdicts(name: str) -> tuple[Model, dict[str, np.ndarray]]:
    """The model, and the worst place of every horizon that is not a function."""
    path = DATA / name / "model.toml"
    if not path.is_file():
        pytest.skip(f"no {path}")
    model = read_model(path)
    result, _ = run_checks(model.moved(-model.local_origin()), Profile.EXTENDED, Fakes())
    failed = [f for f in result.of("functional") if f.status is Status.FAIL]
    origin = model.local_origin()
    return model, {f.objects[0]: np.array([f.worst.x, f.worst.y, f.worst.z]) + origin for f in failed}


def test_folds_are_named_on_their_steep_limb():
    model, found = verdicts("hecho")
    # along the fold's profile x turns back on H1 to H7 by 0.18 to 2.6 steps, on H8 and H9 nowhere
    assert sorted(found) == [f"H{k}" for k in range(1, 8)]
    for horizon in model.horizons:
        if horizon.name in found:
            place = found[horizon.name]
            near = horizon.picks[np.abs(horizon.picks[:, 0] - place[0]) <= 2 * horizon.step]
            assert np.ptp(near[:, 2]) > 4 * horizon.step


@pytest.mark.parametrize("name", ["claudius", "drogon"])
def test_both_lips_of_a_fault_are_no_fold(name):
    assert verdicts(name)[1] == {}
