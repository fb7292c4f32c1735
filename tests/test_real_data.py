"""Real data, where they lie beside the project."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import igl
import numpy as np
import pytest

from graben.finding import Status
from graben.model import Model
from graben.pipeline import RunResult, build
from graben.reading import read_model
from graben.repairs import repair
from tests.lips import misfits

DATA = Path(__file__).parents[2] / "shared" / "data"
#: A step of horizons on which a repair of faults takes a quarter of the time, and Drogon's own gamma, m.
COARSE, GAMMA = 200.0, 200.0
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


def coarse(folder: Path) -> Model:
    """Return Drogon with its horizons on wider grids and gamma as it is, read from a copy in a folder."""
    model = shutil.copytree(DATA / "drogon", folder / "drogon") / "model.toml"
    text, count = re.subn(r"^step = .*$", f"step = {COARSE}", model.read_text(), flags=re.M)
    assert count == 4
    model.write_text(f"{text}\n[parameters]\ngamma = {GAMMA}\n")
    return read_model(model)


def test_drogon_lies_on_its_points(tmp_path: Path) -> None:
    """The faults are repaired under coarse horizons: at each of its steps the gate looks at all four."""
    mended = repair(coarse(tmp_path))
    assert [(a.action, a.objects[-1]) for a in mended.actions] == [("pieces", "F6 (2)"), ("margin", "F2")]
    fine = read_model(DATA / "drogon" / "model.toml")
    assert {fine.gamma(fault, horizon) for fault in fine.faults for horizon in fine.horizons} == {GAMMA}
    result = build(replace(fine, faults=mended.model.faults), mend=False)
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
