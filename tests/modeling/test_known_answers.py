"""Every kind of fault and network against a known answer, by a generator of its own (``known_models``)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import triangle
from scipy.interpolate import RegularGridInterpolator

from graben.finding import Status
from graben.formats.irap import write_irap_ascii
from graben.formats.tsurf_writer import write_tsurf
from graben.model import Fault, GridGeometry, Horizon, Model
from graben.modeling import preparation
from graben.modeling.results import HorizonResult
from graben.pipeline import build
from graben.reading import read_model
from graben.surface import Surface
from tests.modeling.known_answers import Answer, Figures, figures
from tests.modeling.known_models import ILLEGAL, NETWORKS, OUTLINES, SHAPES, STRIPS, ZONES
from tests.modeling.test_euler import obeys_euler

#: Root mean square errors, shares of the largest throw. A lip is extended over gamma, 400 m; where a throw
#: dies out over 2 km, linear extension alone would err by (400 / 2000)^2 = 4 % of it.
CUTOFF, THROW = 0.04, 0.05
#: Largest distance of a cut node from its fault, m.
OFF = 0.1
MODELS = SHAPES | NETWORKS | OUTLINES | ZONES
FOOT = 0.3048
FAR = np.array([500_123.25, 6_000_000.5, 0.0])  # of UTM coordinates, m

strips = pytest.mark.skipif(
    not hasattr(preparation, "narrows"), reason="the preparation does not ask for narrows yet"
)


def rebuilt(answer: Answer) -> tuple[HorizonResult, Figures]:
    result = build(answer.model(), mend=False)
    (horizon,) = result.horizons
    return horizon, figures(answer, horizon, result.repaired.faults)


def is_good(found: Figures) -> None:
    assert set(found.types) == {0}, found
    assert found.turned == 0, found
    assert found.off < OFF, found
    assert found.cutoff <= CUTOFF * found.largest, found
    assert found.throw <= THROW * found.largest, found


@pytest.mark.parametrize("name", MODELS)
def test_known_answer(name: str) -> None:
    is_good(rebuilt(MODELS[name])[1])


@strips
@pytest.mark.parametrize("name", STRIPS)
def test_strip_within_gamma_keeps_its_middle(name: str) -> None:
    """No node of the strip lies beyond gamma of both faults; seismic shows its middle all the same."""
    horizon, found = rebuilt(STRIPS[name])
    is_good(found)
    assert any("Between the cuts of F1 and F2 the horizon is at most" in w for w in horizon.warnings)


@pytest.mark.parametrize("name", ["three through a point", "cross beside the boundary", "star"])
def test_cut_obeys_euler(name: str) -> None:
    model = MODELS[name].model()
    obeys_euler(model.moved(-model.local_origin()))


@pytest.mark.parametrize("name", ILLEGAL)
def test_what_has_no_answer_is_refused_in_words(name: str) -> None:
    result = build(ILLEGAL[name].model(), mend=False)
    assert not result.passed
    said = [f.message for f in result.after.findings if f.status is Status.FAIL]
    assert any("F1 and F2" in message for message in said), said


def test_repair_leaves_a_branch_as_good() -> None:
    answer = NETWORKS["T on the hanging side"]
    result = build(answer.model())
    assert result.passed, repr(result)
    is_good(figures(answer, result.horizons[0], result.repaired.faults))


def irregular(answer: Answer) -> Surface:
    """The horizon on nodes off the grid, each by up to a third of its step."""
    grid, values = answer.grid()
    nodes = grid.nodes().reshape(-1, 2)
    inner = ((nodes > 0) & (nodes < np.array(answer.size))).all(axis=1)
    moved = np.random.default_rng(3).uniform(-answer.step / 3, answer.step / 3, nodes.shape)
    plan = nodes + inner[:, None] * moved
    axes = [np.arange(n) * answer.step for n in (grid.columns, grid.rows)]
    z = RegularGridInterpolator(axes, values)(plan)
    return Surface("Top", np.column_stack([plan, z]), triangle.triangulate({"vertices": plan})["triangles"])


def test_irregular_nodes() -> None:
    answer = SHAPES["dip 60"]
    model = answer.model()
    surface = irregular(answer)
    step = float(np.sqrt(4 * np.prod(answer.size) / (np.sqrt(3) * len(surface.triangles))))
    result = build(replace(model, horizons=(Horizon("Top", surface, step),)), mend=False)
    is_good(figures(answer, result.horizons[0], model.faults))


def inward(surface: Surface) -> Surface:
    return surface.with_vertices(surface.vertices * FOOT - FAR)


def written(answer: Answer, folder: Path, kind: str) -> Model:
    """Write a model in feet and depths far from the origin, and read it."""
    grid, values = answer.grid()
    x, y, _ = FAR / FOOT
    geometry = GridGeometry(grid.columns, grid.rows, grid.dx / FOOT, grid.dy / FOOT, (float(x), float(y)))
    write_irap_ascii(folder / "top.irap", geometry, -values / FOOT)
    rough = irregular(answer)
    rough = rough.with_vertices((rough.vertices + FAR) / FOOT)
    write_tsurf(folder / "top.ts", [rough], z="depth", feature="horizon", unit="ft")
    faults = [s.with_vertices((s.vertices + FAR) / FOOT) for s in answer.surfaces()]
    write_tsurf(folder / "faults.ts", faults, z="depth", unit="ft")
    (folder / "model.toml").write_text(
        '[model]\nname = "k"\nz = "depth"\nunit = "ft"\n[[faults]]\nfile = "faults.ts"\n'
        f'[[horizons]]\nname = "Top"\nfile = "{kind}"\n[parameters]\ngamma = {answer.gamma / FOOT}\n'
    )
    return read_model(folder / "model.toml")


@pytest.mark.parametrize("kind", ["top.irap", "top.ts"])
def test_feet_and_depth_far_from_the_origin(kind: str, tmp_path: Path) -> None:
    """The same model in feet, counted down, at a northing of 6,000 km errs by the same metres."""
    answer = SHAPES["dip 60"]
    result = build(written(answer, tmp_path, kind), mend=False)
    (horizon,) = result.horizons
    scaled = replace(
        horizon,
        surface=inward(horizon.surface),
        first=horizon.first * FOOT - FAR,
        cutoffs=tuple(
            replace(c, hanging=c.hanging * FOOT - FAR, foot=c.foot * FOOT - FAR) for c in horizon.cutoffs
        ),
    )
    found = figures(answer, scaled, [Fault(s) for s in answer.surfaces()])
    is_good(found)
    if kind == "top.irap":
        assert found.cutoff == pytest.approx(rebuilt(answer)[1].cutoff, abs=0.01)
