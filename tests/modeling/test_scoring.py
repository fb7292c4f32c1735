"""Scores of results made from the truth itself, and of the truth moved by known amounts."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from graben import demo
from graben.cutgraph import CutGraph
from graben.errors import InputError
from graben.formats.irap import grid_surface
from graben.model import Fault, Horizon
from graben.modeling.results import Cutoff, HorizonResult
from graben.modeling.scoring import score
from graben.surface import Surface

EXACT = 0.05  # what reading a curved truth off its grids and curves may cost, m


def faults_of(model: demo.SyntheticModel) -> tuple[Fault, ...]:
    return tuple(Fault(s) for s in model.faults)


def true_result(model: demo.SyntheticModel) -> HorizonResult:
    """Return a result that holds the truth: the grid's nodes, each block by itself, and the true lips."""
    geology, xy = model.geology, model.grid.nodes().reshape(-1, 2)
    upright = model.frame.inward(xy)
    d = np.stack([geology.distance(f, upright) for f in range(len(geology.faults))], axis=1)
    s = np.stack([fault.coordinates(upright)[0] for fault in geology.faults], axis=1)
    length = np.array([fault.half_length for fault in geology.faults])
    near = (np.abs(d) <= model.gamma) & (np.abs(s) <= length)
    if geology.branching is not None:
        b = geology.branching
        near[:, b.fault] &= s[:, b.fault] >= 0
    sides = np.where(d >= 0, 1, -1)
    z = np.full(len(xy), np.nan)
    for block, signs in enumerate(geology.blocks):
        mine = (sides * np.array(signs) >= 0).all(axis=1)
        z[mine] = model.horizon(block, xy[mine])
    points = np.column_stack([xy, z])
    horizon = Horizon(
        demo.HORIZON, grid_surface(demo.HORIZON, model.grid, model.values), model.grid.step, model.grid
    )
    names = tuple(s.name for s in model.faults)
    return HorizonResult(
        horizon=horizon,
        surface=Surface(demo.HORIZON, points, []),
        first=np.column_stack([xy, model.values.reshape(-1)]),
        subdomain=np.zeros(len(xy)),
        fixed=~near.any(axis=1),
        side=np.zeros(len(xy)),
        block=np.where(near, sides, 0),
        graph_faults=names,
        smears=np.zeros(len(names)),
        graph=CutGraph(demo.HORIZON, [], [], [], []),
        cutoffs=true_cutoffs(model),
        subdomains=(),
    )


def true_cutoffs(model: demo.SyntheticModel) -> tuple[Cutoff, ...]:
    """Return the true lips, paired by rank along strike, as a mesh might pair them."""
    lips = model.cutoffs
    result = []
    for hanging in lips:
        for foot in lips:
            pair = np.array([model.geology.blocks[hanging.block], model.geology.blocks[foot.block]])
            facing = np.delete(pair[0] * pair[1], hanging.fault) >= 0
            if hanging.fault != foot.fault or not hanging.side > 0 > foot.side or not facing.all():
                continue
            h, f = (c.points[np.argsort(c.s)][::10] for c in (hanging, foot))
            n = min(len(h), len(f))
            throw = f[:n, 2] - h[:n, 2]
            heave = np.linalg.norm((h[:n] - f[:n])[:, :2], axis=1)
            name = model.faults[hanging.fault].name
            result.append(Cutoff(name, hanging.s[::10][:n], h[:n], f[:n], throw, heave))
    return tuple(result)


@pytest.fixture(scope="module")
def single(tmp_path_factory: pytest.TempPathFactory) -> tuple[demo.SyntheticModel, Path]:
    model, folder = demo.build("single"), tmp_path_factory.mktemp("single")
    demo.write(model, folder)
    return model, folder / "truth"


@pytest.mark.parametrize("name", ["single", "exit", "cross", "tee", "reverse", "low-dip-12"])
def test_the_truth_scores_nothing(name: str, tmp_path: Path) -> None:
    model = demo.build(name)
    demo.write(model, tmp_path)
    s = score(tmp_path / "truth", true_result(model), faults_of(model))
    assert s is not None
    assert max(s.cutoff.value, s.throw.value, s.zone.value) < EXACT
    assert s.zone_input.value > 4.0


def test_the_input_of_single_is_off_by_about_ten_metres(single: tuple[demo.SyntheticModel, Path]) -> None:
    model, truth = single
    s = score(truth, true_result(model), faults_of(model))
    assert s is not None
    assert 8.0 < s.zone_input.value < 14.0
    largest = max(np.abs(c.throw).max() for c in model.cutoffs)
    assert s.zone_input.percent == pytest.approx(100.0 * s.zone_input.value / largest, rel=1e-3)


@pytest.mark.parametrize(("up", "down"), [(3.0, 0.0), (2.0, 2.0), (0.0, -4.0)])
def test_lips_moved_in_elevation_score_just_that(
    single: tuple[demo.SyntheticModel, Path], up: float, down: float
) -> None:
    model, truth = single
    result = true_result(model)
    (c,) = result.cutoffs
    moved = Cutoff(
        c.fault,
        c.s,
        c.hanging + np.array([0.0, 0.0, up]),
        c.foot + np.array([0.0, 0.0, down]),
        c.throw + down - up,
        c.heave,
    )
    s = score(truth, replace(result, cutoffs=(moved,)), faults_of(model))
    assert s is not None
    assert s.cutoff.value == pytest.approx(np.sqrt((up**2 + down**2) / 2.0), abs=0.02)
    assert s.throw.value == pytest.approx(abs(down - up), abs=0.02)


def test_a_zone_moved_in_elevation_scores_just_that(single: tuple[demo.SyntheticModel, Path]) -> None:
    model, truth = single
    result = true_result(model)
    lifted = result.surface.vertices + np.array([0.0, 0.0, 2.5])
    s = score(truth, replace(result, surface=result.surface.with_vertices(lifted)), faults_of(model))
    assert s is not None
    assert s.zone.value == pytest.approx(2.5, abs=EXACT)


def test_nodes_in_the_gap_are_left_out_but_lips_are_not(single: tuple[demo.SyntheticModel, Path]) -> None:
    model, truth = single
    result = true_result(model)
    upright = model.frame.inward(result.first[:, :2])
    fault = model.geology.faults[0]
    s, _ = fault.coordinates(upright)
    gap = (np.abs(model.geology.distance(0, upright)) < 15.0) & (np.abs(s) < 1500.0)
    assert gap.any()
    spoiled = result.surface.vertices.copy()
    spoiled[gap, 2] += 1000.0
    out = replace(result, surface=result.surface.with_vertices(spoiled))
    first, second = (score(truth, r, faults_of(model)) for r in (out, replace(out, side=gap)))
    assert first is not None and second is not None
    assert first.zone.value < EXACT
    assert second.zone.value > 10.0


def test_small_throws_do_not_count(single: tuple[demo.SyntheticModel, Path]) -> None:
    model, truth = single
    result = true_result(model)
    (c,) = result.cutoffs
    small = np.abs(c.throw) < 0.2 * np.abs(c.throw).max()
    assert small.any()
    foot = c.foot.copy()
    foot[small, 2] += 5.0
    s = score(truth, replace(result, cutoffs=(replace(c, foot=foot),)), faults_of(model))
    assert s is not None
    assert s.cutoff.value < EXACT


@pytest.mark.parametrize(
    ("rotation", "mirrored", "shuffle"),
    [(17.0, False, None), (45.0, False, 2), (0.0, True, None), (30.0, True, 5)],
)
def test_scores_do_not_depend_on_the_frame(
    rotation: float, mirrored: bool, shuffle: int | None, tmp_path: Path
) -> None:
    values = []
    for k, how in enumerate([{}, {"rotation": rotation, "mirrored": mirrored, "shuffle": shuffle}]):
        model = demo.build("cross", **how)  # type: ignore[arg-type]
        demo.write(model, tmp_path / str(k))
        result = true_result(model)
        tilted = tuple(
            replace(c, foot=c.foot + np.array([0.0, 0.0, 3.0]), throw=c.throw + 3.0) for c in result.cutoffs
        )
        s = score(tmp_path / str(k) / "truth", replace(result, cutoffs=tilted), faults_of(model))
        assert s is not None
        values.append([e.value for e in (s.cutoff, s.throw, s.zone_input)])
    np.testing.assert_allclose(values[0], values[1], rtol=1e-2)


def test_without_a_cut_there_is_no_score(single: tuple[demo.SyntheticModel, Path]) -> None:
    model, truth = single
    assert score(truth, replace(true_result(model), cutoffs=()), faults_of(model)) is None


def test_a_model_that_leaves_a_fault_out_is_scored_on_the_others(tmp_path: Path) -> None:
    model = demo.build("cross")
    demo.write(model, tmp_path)
    whole = true_result(model)
    part = replace(
        whole,
        graph_faults=("F1",),
        smears=np.zeros(1),
        block=whole.block[:, :1],
        cutoffs=tuple(c for c in whole.cutoffs if c.fault == "F1"),
    )
    s = score(tmp_path / "truth", part, faults_of(model)[:1])
    assert s is not None
    assert s.cutoff.value < EXACT


def test_a_damaged_truth_is_told_in_a_sentence(
    single: tuple[demo.SyntheticModel, Path], tmp_path: Path
) -> None:
    model, truth = single
    result, faults = true_result(model), faults_of(model)
    with pytest.raises(InputError, match=r"truth\.json does not exist"):
        score(tmp_path, result, faults)
    other = tmp_path / "truth"
    shutil.copytree(truth, other)
    (other / "cutoffs" / "Top.csv").write_text("fault,x,y\nF1,1,2\n")
    with pytest.raises(InputError, match=r"Top\.csv holds no cutoffs"):
        score(other, result, faults)
    (other / "truth.json").write_text('{"schema": 1}')
    with pytest.raises(InputError, match=r"truth\.json is no index"):
        score(other, result, faults)
    renamed = replace(result, horizon=replace(result.horizon, name="Base"))
    with pytest.raises(InputError, match="no horizon 'Base'"):
        score(truth, renamed, faults)
