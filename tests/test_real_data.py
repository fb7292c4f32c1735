"""Real data, where they lie beside the project."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import igl
import numpy as np
import pytest

from graben.finding import Status
from graben.pipeline import RunResult, build
from graben.reading import read_model
from tests.lips import misfits

DATA = Path(__file__).parents[2] / "shared" / "data"
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="needs ../shared/data")


@pytest.fixture(scope="module")
def claudius() -> RunResult:
    return build(read_model(DATA / "claudius" / "model.toml"))


def test_claudius_cuts_d_alone(claudius: RunResult) -> None:
    assert claudius.passed
    assert {h.name: len(h.cutoffs) for h in claudius.horizons} == {"A": 0, "B": 0, "C": 0, "D": 1}
    without = build(replace(claudius.model, faults=()))
    for name in "ABC":
        assert claudius[name].surface.vertices == pytest.approx(without[name].surface.vertices, abs=1e-6)


def test_claudius_throw_and_lips(claudius: RunResult) -> None:
    (cutoff,) = claudius["D"].cutoffs
    middle = (cutoff.s > cutoff.s.max() / 3) & (cutoff.s < 2 * cutoff.s.max() / 3)
    assert 65.0 < np.median(cutoff.throw[middle]) < 105.0
    fault = claudius.model.faults[0].surface
    for lip in (cutoff.hanging, cutoff.foot):
        away = igl.point_mesh_squared_distance(lip.copy(), fault.vertices.copy(), fault.triangles.copy())[0]
        assert np.sqrt(away.max()) < 0.1


def test_drogon_lies_on_its_points() -> None:
    result = build(read_model(DATA / "drogon" / "model.toml"))
    assert len(result.horizons) == 4
    for horizon in result.horizons:
        found = misfits(result.repaired, horizon)
        assert len(found) > 1000
        assert np.median(found) < 8.0


def test_hecho_models_what_is_a_function() -> None:
    result = build(read_model(DATA / "hecho" / "model.toml"))
    folded = {f.objects[0] for f in result.after.of("functional") if f.status is Status.FAIL}
    assert folded == {f"H{k}" for k in range(1, 8)}
    assert all(f.worst is not None for f in result.after.of("functional") if f.status is Status.FAIL)
    assert [h.name for h in result.horizons] == ["H8", "H9"]
    assert set(result.not_modeled) == folded
