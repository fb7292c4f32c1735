"""The whole pipeline on models with a known answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import igl
import numpy as np
import pytest

from graben.demo import SyntheticModel, write
from graben.demo import build as demo
from graben.model import Fault, Horizon
from graben.modeling.fitting import fit_points
from graben.modeling.results import HorizonResult, Score
from graben.pipeline import RunResult, build, check
from graben.reading import read_model
from graben.repairs import repair
from graben.surface import Surface
from tests.models import grid_horizon, model_of, model_of_demo, plane_fault

#: Bars in percent of the largest throw, and the zone error as a share of the input's.
CUTOFF, THROW, ZONE = 4.0, 6.0, 0.25
FINER_OR_COARSER = 1.3


def smeared(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A level horizon with a smeared throw of 80 m in the middle that dies out along strike."""
    return -40.0 * np.tanh(x / 100.0) * np.maximum(1 - (y / 1500) ** 2, 0) ** 1.5


Runner = Callable[..., tuple[HorizonResult, Score]]


@pytest.fixture(scope="module")
def run_demo(tmp_path_factory: pytest.TempPathFactory) -> Runner:
    """Return what runs a synthetic model from its files, each once."""
    done: dict[str, tuple[HorizonResult, Score]] = {}

    def run(name: str, **how: object) -> tuple[HorizonResult, Score]:
        key = f"{name} {how}"
        if key not in done:
            done[key] = _ran(demo(name, **how), tmp_path_factory.mktemp(name))  # type: ignore[arg-type]
        return done[key]

    return run


def _ran(made: SyntheticModel, folder: Path) -> tuple[HorizonResult, Score]:
    write(made, folder)
    result = build(read_model(folder / "model.toml"))
    assert result.passed, repr(result)
    (horizon,) = result.horizons
    assert horizon.score is not None
    _lies_on_its_faults(horizon, result.repaired.faults)
    return horizon, horizon.score


@cache
def single() -> RunResult:
    """Return the run of the single fault as it is made, without files."""
    return build(model_of_demo(demo("single")))


def _lies_on_its_faults(horizon: HorizonResult, faults: tuple[Fault, ...]) -> None:
    """Every cut node within 0.1 m of its fault."""
    for cutoff in horizon.cutoffs:
        surface = next(f.surface for f in faults if f.name == cutoff.fault)
        for lip in (cutoff.hanging, cutoff.foot):
            squared = igl.point_mesh_squared_distance(
                lip.copy(), surface.vertices.copy(), surface.triangles.copy()
            )[0]
            assert np.sqrt(squared.max()) < 0.1


def figures(score: Score) -> np.ndarray:
    return np.array([score.cutoff.value, score.throw.value, score.zone.value])


@pytest.mark.parametrize(
    ("how", "slack"),
    [({}, 1.0), ({"step": 50.0}, FINER_OR_COARSER), ({"step": 200.0}, FINER_OR_COARSER)],
    ids=str,
)
def test_single_fault_within_its_bars(run_demo: Runner, how: dict[str, object], slack: float) -> None:
    horizon, score = run_demo("single", **how)
    assert score.cutoff.percent <= CUTOFF * slack
    assert score.throw.percent <= THROW * slack
    assert score.zone.value <= ZONE * slack * score.zone_input.value
    assert max(s.iterations for s in horizon.subdomains) <= 6


@pytest.mark.parametrize(
    ("name", "cutoff", "iterations"),
    [
        ("exit", 3.0, 6),
        ("cross", 6.0, 6),
        ("tee", 6.0, 6),
        ("reverse", 5.0, 6),
        ("low-dip", 4.0, 8),
        ("low-dip-12", 4.0, 8),
    ],
)
def test_other_models_within_their_bars(run_demo: Runner, name: str, cutoff: float, iterations: int) -> None:
    horizon, score = run_demo(name)
    assert score.cutoff.percent <= cutoff
    assert max(s.iterations for s in horizon.subdomains) <= iterations


@pytest.mark.parametrize(
    "how",
    [
        {"rotation": 17.0},
        {"rotation": 45.0},
        {"mirrored": True},
        {"shuffle": 5},
        {"shift": (432_000.0, 6_780_000.0)},
    ],
    ids=str,
)
@pytest.mark.parametrize("name", ["single", "tee"])
def test_score_does_not_depend_on_the_frame(run_demo: Runner, name: str, how: dict[str, object]) -> None:
    upright = run_demo(name)[1]
    turned = run_demo(name, **how)[1]
    assert figures(turned) == pytest.approx(figures(upright), rel=0.1)


def test_fault_turned_against_the_grid_changes_little() -> None:
    """A fault in another direction than the grid's rows: throw as on the grid, to 2 % of it."""
    throws = []
    for angle in (0.0, 17.0, 45.0):
        a = np.radians(angle)
        c, s = np.cos(a), np.sin(a)

        def height(x: np.ndarray, y: np.ndarray, c: float = c, s: float = s) -> np.ndarray:
            u, v = c * x + s * y, -s * x + c * y
            taper = np.maximum(1.0 - (v / 1500.0) ** 2, 0.0) ** 1.5
            return 0.1 * u - 50.0 * taper * np.tanh(u / 120.0)

        fault = plane_fault((1500 * s, -1500 * c), (-1500 * s, 1500 * c))
        result = build(model_of(grid_horizon(height, size=6000.0), fault))
        throws.append(result.horizons[0].largest_throw)
    assert throws == pytest.approx([throws[0]] * 3, rel=0.02)


def test_plane_is_reproduced_with_theta_one() -> None:
    """On a plane the energy is zero, so nothing may move it: 1e-8 of its relief."""
    horizon = grid_horizon(lambda x, y: 0.1 * x + 0.05 * y - 30.0)
    model = model_of(
        horizon, plane_fault((0, -900), (60, 1000)), plane_fault((-700, 30), (800, 90), name="F2"), theta=1.0
    )
    result = build(model)
    (made,) = result.horizons
    assert made.converged
    v = made.surface.vertices
    relief = np.ptp(v[:, 2])
    assert v[:, 2] == pytest.approx(0.1 * v[:, 0] + 0.05 * v[:, 1] - 30.0, abs=1e-8 * relief)


def test_horizon_without_its_fault_is_left_alone() -> None:
    horizon = grid_horizon(lambda x, y: 0.1 * x)
    fault = plane_fault((0, -900), (60, 1000))
    above = Fault(fault.surface.moved(np.array([0.0, 0.0, 3000.0])))
    result = build(model_of(horizon, above))
    (made,) = result.horizons
    assert result.passed
    assert made.cutoffs == ()
    assert (made.surface.vertices == horizon.surface.vertices).all()
    assert [s.iterations for s in made.subdomains] == [0]
    none = build(model_of(horizon))
    assert (none.horizons[0].surface.vertices == made.surface.vertices).all()


def test_nodes_outside_gamma_keep_their_values() -> None:
    (horizon,) = single().horizons
    fixed = horizon.fixed
    assert fixed.sum() > 5000
    assert horizon.surface.vertices[fixed] == pytest.approx(horizon.first[fixed], rel=0, abs=1e-9)


def test_plain_iteration_gives_the_same_answer() -> None:
    fast = single().horizons[0]
    plain = build(model_of_demo(demo("single"), acceleration=False)).horizons[0]
    assert plain.converged
    assert plain.cutoffs[0].throw == pytest.approx(fast.cutoffs[0].throw, abs=0.2)


def test_throw_and_heave_have_their_signs() -> None:
    normal = single().horizons[0].cutoffs[0]
    assert normal.throw.max() > 100
    assert normal.heave[normal.throw.argmax()] > 0
    assert normal.throw[[0, -1]].tolist() == [0.0, 0.0]
    reverse = build(model_of_demo(demo("reverse"))).horizons[0].cutoffs[0]
    assert reverse.throw.min() < -100
    assert reverse.heave[reverse.throw.argmin()] < 0


def test_steeper_dip_less_heave() -> None:
    """heave = throw / tan(dip) on a plane fault and a level horizon."""
    for dip in (45.0, 70.0):
        horizon = grid_horizon(smeared)
        result = build(model_of(horizon, plane_fault((0, -1500), (0, 1500), dip=dip)))
        cutoff = result.horizons[0].cutoffs[0]
        assert cutoff.heave == pytest.approx(cutoff.throw / np.tan(np.radians(dip)), abs=1e-6)


def test_fault_too_short_in_depth_ends_with_type_2() -> None:
    horizon = grid_horizon(lambda x, y: -60.0 * np.tanh(x / 60.0) * np.maximum(1 - (y / 1500) ** 2, 0) ** 1.5)
    model = model_of(horizon, plane_fault((0, -1500), (0, 1500), depth=30.0))
    result = build(model, mend=False)
    (subdomain,) = result.horizons[0].subdomains
    assert not result.passed
    assert int(subdomain.termination.type) == 2
    assert subdomain.termination.fault == "F1"
    assert 10 < (subdomain.termination.short_by or 0) < 60
    assert "extend F1" in subdomain.termination.advice
    mended = build(model)
    assert mended.passed
    assert [a.action for a in mended.repairs] == ["margin"]
    assert mended.horizons[0].largest_throw == pytest.approx(120.0, rel=0.06)


@pytest.mark.parametrize("gamma", [30.0, 5000.0])
def test_gamma_narrower_than_a_step_and_wider_than_the_horizon(gamma: float) -> None:
    horizon = grid_horizon(
        lambda x, y: -40.0 * np.tanh(x / 100.0) * np.maximum(1 - (y / 1500) ** 2, 0) ** 1.5
    )
    result = build(model_of(horizon, plane_fault((0, -1500), (0, 1500)), gamma=gamma))
    assert result.passed
    assert any("gamma reduced" in w for w in result.horizons[0].warnings) == (gamma > 4000.0)


@pytest.mark.parametrize("dip", [90.0, 110.0])
def test_vertical_and_overturned_faults(dip: float) -> None:
    horizon = grid_horizon(
        lambda x, y: -40.0 * np.tanh(x / 100.0) * np.maximum(1 - (y / 1500) ** 2, 0) ** 1.5
    )
    result = build(model_of(horizon, plane_fault((0, -1500), (0, 1500), dip=dip)))
    assert result.horizons[0].converged
    cutoff = result.horizons[0].cutoffs[0]
    assert np.abs(cutoff.throw).max() > 60.0
    assert np.abs(cutoff.heave) == pytest.approx(np.abs(cutoff.throw / np.tan(np.radians(dip))), abs=1e-6)


def test_unit_less_model_of_any_size() -> None:
    """The same model a thousand times smaller gives the same figures: no tolerance is in metres."""
    whole = single()
    small = model_of_demo(demo("single"))
    shrunk = replace(
        small,
        unit="none",
        parameters=small.parameters.model_copy(update={"gamma": 0.4, "tolerance": 1e-4}),
        horizons=tuple(
            replace(h, surface=h.surface.with_vertices(h.surface.vertices / 1000), step=0.1, grid=None)
            for h in small.horizons
        ),
        faults=tuple(Fault(f.surface.with_vertices(f.surface.vertices / 1000)) for f in small.faults),
    )
    result = build(shrunk)
    assert result.passed
    assert 1000 * result.horizons[0].largest_throw == pytest.approx(whole.horizons[0].largest_throw, rel=1e-6)


def test_a_fault_that_cuts_nothing_is_named() -> None:
    horizon = grid_horizon(smeared)
    cutting = plane_fault((0, -1500), (0, 1500))
    deep = Fault(plane_fault((500, -900), (500, 900), name="F2").surface.moved(np.array([0.0, 0.0, -3000.0])))
    aside = Fault(plane_fault((0, -900), (0, 900), name="F3").surface.moved(np.array([9000.0, 0.0, 0.0])))
    result = build(model_of(horizon, cutting, deep, aside))
    assert result.passed
    said = {f.objects: f.message for f in result.after.of("trace")}
    assert "below" in said[("F2",)]
    assert "beside H in plan" in said[("F3",)]
    assert ("F1",) not in said


def test_sharp_picks_hold_the_throw_and_smeared_ones_do_not() -> None:
    """Points on both sides right up to the fault show their throw; smeared ones are not followed."""
    rng = np.random.default_rng(1)
    xy = rng.uniform(-1500, 1500, (3600, 2))
    fault = plane_fault((0, -2000), (0, 2000))
    heave = 60.0 / np.tan(np.radians(60.0))
    throws = []
    for width in (1e-9, 120.0):
        side = np.tanh(xy[:, 0] / width)
        picks = np.column_stack([xy, -30.0 * side])
        gap = (np.abs(xy[:, 0]) < heave / 2) & (width < 1.0)
        fitted = fit_points(picks[~gap], 100.0)
        surface = Surface("H", fitted.vertices, fitted.triangles)
        horizon = Horizon("H", surface, 100.0, picks=picks[~gap], smoothing=fitted.smoothing)
        (cutoff,) = build(model_of(horizon, fault)).horizons[0].cutoffs
        throws.append(np.median(cutoff.throw))
    assert throws[0] == pytest.approx(60.0, abs=1.5)
    assert throws[1] == pytest.approx(60.0, abs=6.0)


def test_results_print_and_convert() -> None:
    result = single()
    assert "type 0" in repr(result)
    assert "<table>" in result._repr_html_()
    assert set(result.to_pyvista().keys()) == {"Top", "F1"}
    assert result["Top"].to_pyvista().n_points == len(result["Top"].first)


def test_the_other_calls_print_and_convert() -> None:
    fault = plane_fault((0, -1500), (0, 1500), dip=20.0)
    twice = replace(
        fault.surface, triangles=np.concatenate([fault.surface.triangles, fault.surface.triangles[:3]])
    )
    model = model_of(grid_horizon(smeared), Fault(twice))
    found = check(model)
    assert not found.passed
    assert "duplicate" in repr(found)
    assert "<table>" in found._repr_html_()
    assert found.to_pyvista()["duplicate F1"].n_points == 3
    mended = repair(model)
    assert mended.after.passed
    assert [a.action for a in mended.actions] == ["weld"]
    assert "weld" in repr(mended)
    assert "weld" in mended._repr_html_()
    assert mended.to_pyvista()["F1"].n_cells == len(fault.surface.triangles)
    again = repair(mended.model)
    assert again.actions == ()
    assert again.model is mended.model
    untouched = repair(model_of(grid_horizon(smeared), fault))
    assert (
        untouched.model.faults[0] is fault
        or (untouched.model.faults[0].surface.vertices == fault.surface.vertices).all()
    )
