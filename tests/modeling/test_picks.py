"""Picks beside a fault: trusted where they jump as those further out ask for, whatever the relief."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from graben.arrays import FloatArray, floats
from graben.model import Fault, Horizon, Model
from graben.modeling.picks import _wide_planes
from graben.modeling.quality import Doubt
from graben.pipeline import build
from graben.reading import read_model
from tests.modeling.test_refitting import horizon_of
from tests.models import model_of, plane_fault

CLAUDIUS = Path(__file__).parents[3] / "shared" / "data" / "claudius" / "model.toml"
THROW = 90.0
HEAVE = THROW / np.tan(np.radians(60.0))
FAULT = plane_fault((0, -2000), (0, 2000))


def relief(xy: FloatArray) -> FloatArray:
    """Folds 900 m long, of a sixth of the throw."""
    return np.asarray(15.0 * np.sin(xy[:, 0] / 140.0 + 0.7) * np.cos(xy[:, 1] / 170.0))


def sparse_model(gamma: float, smear: float, seed: int = 0, spacing: float = 70.0) -> Model:
    """A fault 60 degrees steep through sparse picks, smeared over so much to either side."""
    model = model_of(sparse_horizon(smear, seed, spacing), FAULT)
    return replace(model, parameters=model.parameters.model_copy(update={"gamma": gamma}))


@cache
def sparse_horizon(smear: float, seed: int, spacing: float) -> Horizon:
    xy = np.random.default_rng(seed).uniform(-1500.0, 1500.0, (int((3000.0 / spacing) ** 2), 2))
    share = np.clip(xy[:, 0] / max(smear, 1e-9), -1.0, 1.0)
    gap = np.abs(xy[:, 0]) < HEAVE / 2 if smear == 0.0 else np.zeros(len(xy), dtype=bool)
    picks = np.column_stack([xy, relief(xy) - 0.5 * THROW * share])[~gap]
    return horizon_of(floats(picks))


def trusted(model: Model) -> bool:
    (told,) = build(model, mend=False).horizons[0].misfit.masked
    assert told.within > 50
    return told.left_out == 0


@pytest.mark.parametrize("gamma", [250.0, 400.0, 500.0])
def test_sharp_picks_are_trusted_whatever_gamma_and_smeared_ones_are_not(gamma: float) -> None:
    for seed in range(3):
        assert trusted(sparse_model(gamma, 0.0, seed))
        assert not trusted(sparse_model(gamma, 200.0, seed))


@pytest.mark.skipif(not CLAUDIUS.exists(), reason="the real data are not there")
def test_the_throw_of_a_real_fault_hangs_on_no_gamma_and_no_origin() -> None:
    whole = read_model(CLAUDIUS)
    model = replace(whole, horizons=tuple(h for h in whole.horizons if h.name.startswith("D")))
    assert len(model.horizons) == 1
    model = replace(model, parameters=model.parameters.model_copy(update={"gamma": None}))
    model = replace(model, faults=tuple(Fault(f.surface) for f in model.faults))
    (usual,) = build(model, mend=False).horizons[0].cutoffs
    assert usual.throw.max() == pytest.approx(130.0, abs=10.0)
    # Planes through the picks within 150 m say 85 m on the whole; the ends of the fault have less.
    assert 60.0 < usual.throw.mean() < 90.0
    shifted = model.moved(floats([1003.3, -717.7, 0.0]))
    (there,) = build(shifted, mend=False).horizons[0].cutoffs
    assert there.throw.max() == pytest.approx(usual.throw.max(), rel=1e-3)
    for gamma in (200.0, 250.0, 300.0, 400.0):
        other = replace(model, parameters=model.parameters.model_copy(update={"gamma": gamma}))
        (cutoff,) = build(other, mend=False).horizons[0].cutoffs
        assert cutoff.throw.max() == pytest.approx(usual.throw.max(), rel=0.05)


def test_wide_planes_are_exact_on_planes_and_unknown_without_picks_around() -> None:
    xy = np.random.default_rng(1).uniform(-100.0, 100.0, (200, 2)) + 5e5
    picks = floats(np.column_stack([xy, 3.0 + 0.2 * (xy[:, 0] - 5e5) - 0.1 * (xy[:, 1] - 5e5)]))
    places = floats([[5e5, 5e5], [5e5 + 900.0, 5e5]])
    found = _wide_planes(picks, places, 120.0)
    np.testing.assert_allclose(found[0], [3.0, 0.2, -0.1], atol=1e-9)
    assert np.isnan(found[1]).all()
    line = floats(np.column_stack([np.linspace(-50, 50, 30), np.zeros(30), np.ones(30)]))
    assert np.isnan(_wide_planes(line, floats([[0.0, 0.0]]), 120.0)).all()


def test_relief_that_a_zone_skips_is_said_with_a_gamma_that_follows_it() -> None:
    """Smeared next to the fault, so that nothing of the zone is used: a fold within it is lost."""
    model = sparse_model(560.0, 100.0, spacing=40.0)
    (horizon,) = model.horizons
    fold = 60.0 * np.exp(-(((horizon.picks[:, 0] - 450.0) / 60.0) ** 2))
    picks = floats(horizon.picks + np.outer(fold, [0.0, 0.0, 1.0]))
    model = replace(model, horizons=(horizon_of(picks, 60.0),))
    result = build(model, mend=False)
    (told,) = result.horizons[0].misfit.missed
    assert told.clear and told.far == 560.0
    assert told.near == pytest.approx(3.0 * result.horizons[0].smears[0])
    assert told.rms > 15.0 > 3.0 * told.beyond
    assert told.near < abs(told.place[0]) < told.far
    (said,) = [d for d in result.horizons[0].doubts if d.kind is Doubt.MISSED]
    assert f"beyond its smear, by {told.rms:.1f} m" in str(said)
    assert f"lower gamma to about {told.near:.0f} m" in str(said)
    assert str(said) in result.horizons[0].warnings
    better = replace(model, parameters=model.parameters.model_copy(update={"gamma": told.near}))
    after = build(better, mend=False).horizons[0]
    assert not [d for d in after.doubts if d.kind is Doubt.MISSED]
    assert after.misfit.missed[0].rms < 0.25 * told.rms
