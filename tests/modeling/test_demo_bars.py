"""The bars of the synthetic models, and that no score hangs on the frame or on the order of anything."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import igl
import numpy as np
import pytest

from graben import demo
from graben.model import GridGeometry, Model
from graben.modeling.results import HorizonResult, Score, TerminationType
from graben.modeling.scoring import score
from graben.pipeline import build
from graben.surface import Surface
from tests.models import model_of_demo

#: Largest cutoff errors, percent of the largest throw.
BARS = {"single": 3.0, "exit": 3.0, "reverse": 5.0, "cross": 6.0, "tee": 6.0}
#: No cut node lies further than this from its fault, m.
ON_FAULT = 0.1
#: Share of itself by which a score may change with frame and order.
CHANGE = 0.1
#: Neither a multiple of the directions of a grid nor of a hexagonal lattice, degrees.
ANGLE = 33.0


@dataclass(frozen=True)
class Run:
    """A model, what became of its horizon, and its score."""

    model: Model
    horizon: HorizonResult
    score: Score
    truth: Path


Runner = Callable[..., Run]


def ran(model: Model, truth: Path) -> Run:
    (horizon,) = build(model, mend=False).horizons
    found = score(truth, horizon, model.faults)
    assert found is not None
    return Run(model, horizon, found, truth)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Runner:
    """Return what runs a synthetic model as it stands, each once."""
    done: dict[str, Run] = {}

    def upright(name: str) -> Run:
        if name not in done:
            done[name] = written(demo.build(name), tmp_path_factory.mktemp(name))
        return done[name]

    return upright


def written(made: demo.SyntheticModel, folder: Path) -> Run:
    demo.write(made, folder)
    return ran(model_of_demo(made), folder / "truth")


def off_fault(run: Run) -> float:
    """Return the largest distance of a cut node from its fault, m."""
    surfaces = {fault.name: fault.surface for fault in run.model.faults}
    furthest = 0.0
    for cutoff in run.horizon.cutoffs:
        vertices, triangles = (
            a.copy() for a in (surfaces[cutoff.fault].vertices, surfaces[cutoff.fault].triangles)
        )
        lips = np.concatenate([cutoff.hanging, cutoff.foot])
        furthest = max(furthest, float(igl.point_mesh_squared_distance(lips, vertices, triangles)[0].max()))
    return float(np.sqrt(furthest))


def assert_same(found: Run, plain: Run) -> None:
    """Every subdomain ended with type 0, and every score is the plain one's within CHANGE of itself."""
    assert found.horizon.converged
    for what in ("cutoff", "throw", "zone"):
        one, other = (getattr(r.score, what).value for r in (found, plain))
        assert one == pytest.approx(other, rel=CHANGE), what


def under_a_fixed_lattice(made: demo.SyntheticModel) -> demo.SyntheticModel:
    """Return a turned model as seismic shows it on a grid that is not turned."""
    columns, rows = made.grid.columns, made.grid.rows
    grid = GridGeometry(columns, rows, made.grid.step, made.grid.step, (0.0, 0.0))
    return replace(made, grid=grid, values=made.geology.seismic(made.frame.inward(grid.nodes())))


def reordered(surface: Surface, seed: int) -> Surface:
    """Return the same surface with vertices, triangles and the corners of each in another order."""
    random = np.random.default_rng(seed)
    order = random.permutation(len(surface.vertices))
    corners = np.argsort(order)[random.permutation(surface.triangles)]
    turns = (np.arange(3) + random.integers(3, size=len(corners))[:, None]) % 3
    return Surface(surface.name, surface.vertices[order], np.take_along_axis(corners, turns, axis=1))


@pytest.mark.parametrize("name", BARS)
def test_cutoffs_within_their_bars_on_their_faults_and_type_0(run: Runner, name: str) -> None:
    done = run(name)
    assert done.score.cutoff.percent <= BARS[name]
    assert {s.termination.type for s in done.horizon.subdomains} == {TerminationType.CONVERGED}
    assert off_fault(done) < ON_FAULT


@pytest.mark.parametrize("name", BARS)
def test_turned_with_its_grid(run: Runner, tmp_path: Path, name: str) -> None:
    turned = written(demo.build(name, rotation=ANGLE), tmp_path)
    assert_same(turned, run(name))
    assert off_fault(turned) < ON_FAULT


@pytest.mark.parametrize("name", ["single", "cross", "tee", "reverse"])
def test_turned_under_its_grid(run: Runner, tmp_path: Path, name: str) -> None:
    """``exit`` is left out: turned under its grid it leaves the horizon elsewhere."""
    turned = written(under_a_fixed_lattice(demo.build(name, rotation=ANGLE)), tmp_path)
    assert_same(turned, run(name))
    assert off_fault(turned) < ON_FAULT


def test_coarse_grid_under_faults_that_cross(tmp_path: Path) -> None:
    """Gamma is two steps only: what is known beside a wedge between faults lies on their other sides."""
    turned = written(under_a_fixed_lattice(demo.build("cross", step=200.0, rotation=ANGLE)), tmp_path)
    assert turned.horizon.converged
    assert turned.score.cutoff.percent <= BARS["cross"]


@pytest.mark.parametrize("name", ["exit", "cross", "reverse"])
def test_mirrored(run: Runner, tmp_path: Path, name: str) -> None:
    assert_same(written(demo.build(name, mirrored=True), tmp_path), run(name))


@pytest.mark.parametrize("name", ["exit", "cross", "tee"])
def test_vertices_triangles_and_faults_in_another_order(run: Runner, name: str) -> None:
    plain = run(name)
    faults = tuple(replace(f, surface=reordered(f.surface, k)) for k, f in enumerate(plain.model.faults))
    (horizon,) = plain.model.horizons
    mixed = replace(horizon, surface=reordered(horizon.surface, 9), grid=None)
    assert_same(ran(replace(plain.model, faults=faults[::-1], horizons=(mixed,)), plain.truth), plain)
