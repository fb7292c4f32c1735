"""Finer steps: the errors of the cutoffs do not grow, and their positions converge with order 1 or better."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graben.demo import build as demo
from graben.demo import write
from graben.demo_catalogue import THROW
from graben.pipeline import build
from graben.reading import read_model
from graben.synthetic import SMEAR
from tests.models import model_of_demo

STEPS = (200.0, 100.0, 50.0)
#: The rim of the zone lies in the clear here. At the models' own 400 m it lies in the tail of the smear,
#: which decays over 40 m, less than any of the steps: no order shows before these resolve it.
CLEAR = 5 * SMEAR
#: What the fixed point may be off by, small against what a step changes, m.
TOLERANCE = 1e-3
#: An error that the step no longer decides may waver by this share.
WAVER = 0.02
#: Of the largest throw: what halving the finest step for ever would change.
REMAINDER = 0.005
#: The lips are compared on this share of their fault, at so many places; tips lie where they are.
SHARE, PLACES = 0.9, 400


def lines(name: str, step: float) -> dict[str, np.ndarray]:
    """Return the elevation along each lip of a rebuilt model at fixed distances along strike.

    A lip lies on its fault, so at one distance along strike its elevation is its position.
    """
    made = demo(name, step=step)
    (horizon,) = build(model_of_demo(made, gamma=CLEAR, tolerance=TOLERANCE), mend=False).horizons
    assert horizon.converged
    found = {}
    for fault in made.geology.faults:
        for side in ("hanging", "foot"):
            points = np.concatenate([getattr(c, side) for c in horizon.cutoffs if c.fault == fault.name])
            strike = fault.coordinates(points[:, :2])[0]
            # A branch starts on its parent: the lips are compared from clear of it on.
            whole = fault.columns[0] <= -fault.half_length
            first = -SHARE * fault.half_length if whole else 2 * STEPS[0]
            at = np.linspace(first, SHARE * fault.half_length, PLACES)
            order = np.argsort(strike)
            found[f"{fault.name} {side}"] = np.interp(at, strike[order], points[order, 2])
    return found


def rms(x: np.ndarray) -> float:
    return float(np.sqrt((x**2).mean()))


@pytest.mark.parametrize("name", ["single", "tee"])
def test_cutoff_errors_shrink_or_stay(tmp_path: Path, name: str) -> None:
    """The error of the published scores, which the step no longer decides alone."""
    errors = []
    for step in STEPS:
        write(demo(name, step=step), tmp_path / f"{step:g}")
        (horizon,) = build(read_model(tmp_path / f"{step:g}" / "model.toml"), mend=False).horizons
        assert horizon.score is not None
        errors.append(horizon.score.cutoff.value)
    assert errors[1] <= (1 + WAVER) * errors[0]
    assert errors[2] <= (1 + WAVER) * errors[1]
    assert errors[2] < errors[0]


@pytest.mark.parametrize("name", ["single", "tee"])
def test_cutoffs_converge_with_order_one_or_better(name: str) -> None:
    """Richardson: with differences d_1, d_2 of three steps, order log2(d_1 / d_2)."""
    coarse, middle, fine = (lines(name, step) for step in STEPS)
    assert len(fine) == {"single": 2, "tee": 4}[name]
    for lip in fine:
        first, second = rms(coarse[lip] - middle[lip]), rms(middle[lip] - fine[lip])
        order = np.log2(first / second)
        assert order >= 1.0, f"{lip}: {first:.3f} m, then {second:.3f} m"
        assert second / (2.0**order - 1.0) < REMAINDER * THROW, lip
