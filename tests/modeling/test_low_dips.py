"""Flat faults: every dip and slope of the horizon converges, also where the horizon runs along its fault."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.arrays import floats
from graben.demo import MARGIN, names
from graben.demo import build as demo
from graben.demo_catalogue import THROW
from graben.demo_surfaces import SPACING, sheet
from graben.formats.irap import grid_surface
from graben.model import Fault, GridGeometry, Horizon, Model
from graben.modeling.calming import calmed
from graben.modeling.results import HorizonResult, TerminationType
from graben.modeling.tracing import cut_graph
from graben.pipeline import build
from graben.refinement import refined
from graben.settings import Parameters
from graben.surface import Surface
from graben.synthetic import SMEAR, Geology, Regional, TrueFault
from tests.models import grid_triangles, model_of_demo, plane_fault

SIZE = (6400.0, 6400.0)
AZIMUTH, HALF_LENGTH = 12.0, 2000.0
MOST_ITERATIONS = 8


def dipping(
    dip: float, slope: float, step: float = 100.0, amplitude: float = 30.0, throw: float = THROW
) -> tuple[Geology, Model]:
    """A corrugated fault in the middle of a plane; gamma is half the heave and two smears.

    A positive slope dips against the fault, a negative one with it.
    """
    middle = (SIZE[0] / 2, SIZE[1] / 2)
    regional = Regional(-1500.0, abs(slope), AZIMUTH + (180.0 if slope < 0 else 0.0), middle)
    columns = np.linspace(-HALF_LENGTH, HALF_LENGTH, round(2 * HALF_LENGTH / SPACING) + 1)
    fault = TrueFault(
        "F1",
        middle,
        AZIMUTH,
        dip,
        -1500.0,
        throw,
        HALF_LENGTH,
        1.5,
        floats(columns),
        amplitude,
        2000.0,
    )
    geology = Geology(regional, (fault,), None, SIZE)
    grid = GridGeometry(round(SIZE[0] / step) + 1, round(SIZE[1] / step) + 1, step, step, (0.0, 0.0))
    values = geology.seismic(grid.nodes())
    half = half_heave(geology)
    gamma = half + 2 * SMEAR
    zone = np.abs(geology.distance(0, grid.nodes())) < gamma + half
    low, high = values[zone].min() - MARGIN, values[zone].max() + MARGIN
    horizon = Horizon("Top", grid_surface("Top", grid, values), step, grid)
    surface = sheet(fault, float(low), float(high))
    return geology, Model(
        "dips", (horizon,), (Fault(surface),), parameters=Parameters.model_validate({"gamma": gamma})
    )


def half_heave(geology: Geology) -> float:
    return float(geology.half_heaves[0][1].max())


def error(geology: Geology, horizon: HorizonResult) -> float:
    """Return the root mean square error of both lips in elevation, as a share of the throw."""
    (cutoff,) = horizon.cutoffs
    fault, wrong = geology.faults[0], []
    for lip, sign in ((cutoff.hanging, 1), (cutoff.foot, -1)):
        along = fault.coordinates(lip[:, :2])[0]
        order = np.argsort(along)
        ((s, points),) = geology.cutoffs(0, (sign,))
        wrong.append(np.interp(s, along[order], lip[order, 2]) - points[:, 2])
    return float(np.sqrt((np.concatenate(wrong) ** 2).mean())) / abs(fault.throw)


@pytest.mark.parametrize("slope", [0.1, -0.1, 0.25])
@pytest.mark.parametrize("dip", [45.0, 30.0, 20.0, 12.0])
def test_every_dip_and_slope_converges(dip: float, slope: float) -> None:
    geology, model = dipping(dip, slope)
    result = build(model, mend=False)
    assert result.passed, repr(result)
    (horizon,) = result.horizons
    assert max(s.iterations for s in horizon.subdomains) <= MOST_ITERATIONS
    # With a heave of 1.2 km each lip is extended over 800 m.
    assert error(geology, horizon) <= (0.05 if (dip, slope) == (12.0, -0.1) else 0.01)


@pytest.mark.parametrize(
    "how",
    [{"step": 50.0}, {"step": 200.0}, {"amplitude": 0.0}, {"amplitude": 60.0}, {"throw": 60.0}],
    ids=str,
)
def test_horizon_along_its_fault_converges(how: dict[str, float]) -> None:
    """In the gap the horizon shows the fault itself."""
    geology, model = dipping(12.0, -0.1, **how)
    result = build(model, mend=False)
    assert result.passed, repr(result)
    (horizon,) = result.horizons
    assert max(s.iterations for s in horizon.subdomains) <= MOST_ITERATIONS
    assert error(geology, horizon) <= 0.05


def test_gamma_below_half_the_heave_is_said_to_be_too_narrow() -> None:
    """The lips lie outside the zone, where nothing moves: no step is valid, and type 1 says what to do."""
    geology, model = dipping(12.0, -0.1, step=200.0)
    gamma = half_heave(geology) - SMEAR
    narrow = replace(model, parameters=model.parameters.model_copy(update={"gamma": gamma}))
    (horizon,) = build(narrow, mend=False).horizons
    (ended,) = (s.termination for s in horizon.subdomains)
    assert (ended.type, ended.name, ended.fault) == (TerminationType.STAGNATION, "stagnation", "F1")
    assert ended.side is not None
    assert f"triangles would turn over. Raise gamma from {gamma:.4g} m" in ended.advice
    place = np.array([[ended.x, ended.y]], dtype=float)
    assert np.abs(geology.faults[0].coordinates(place)[0]) < HALF_LENGTH / 2


@pytest.mark.parametrize("step", [50.0, 100.0, 200.0])
def test_trace_runs_in_the_middle_of_the_gap(step: float) -> None:
    geology, model = dipping(12.0, -0.1, step)
    local = model.moved(-model.local_origin())
    graph = cut_graph(local, local.horizons[0], refined([f.surface for f in local.faults]))
    assert len(graph.edges) == len(graph.nodes) - 1, "one line from tip to tip"
    away = geology.distance(0, graph.nodes[:, :2] + model.local_origin()[:2])
    assert np.abs(away).max() < half_heave(geology) / 4


@pytest.mark.parametrize("name", names())
def test_other_horizons_are_left_as_they_are(name: str) -> None:
    model = model_of_demo(demo(name))
    surface = model.horizons[0].surface
    assert calmed(surface, [f.surface for f in model.faults]) is surface


@pytest.mark.parametrize("dip", [88.0, 90.0, 110.0])
def test_no_horizon_runs_along_a_steep_fault(dip: float) -> None:
    surface = dipping(12.0, -0.1)[1].horizons[0].surface
    fault = plane_fault((0, -1500), (0, 1500), dip=dip, depth=900.0).surface
    assert calmed(surface, [fault.moved(np.array([3200.0, 3200.0, -1500.0]))]) is surface


def test_only_the_gap_is_calmed() -> None:
    geology, model = dipping(12.0, -0.1)
    before = model.horizons[0].surface
    after = calmed(before, [model.faults[0].surface])
    changed = np.flatnonzero(after.vertices[:, 2] != before.vertices[:, 2])
    assert len(changed) > 100
    assert (after.vertices[:, :2] == before.vertices[:, :2]).all()
    away = np.abs(geology.distance(0, before.vertices[changed, :2]))
    assert away.max() < half_heave(geology) + 2 * SMEAR
    assert np.abs(after.vertices - before.vertices).max() < 0.1 * THROW


def test_a_peak_between_its_sides_is_calmed_away() -> None:
    """The height above a level-sided fault becomes the straight ramp between the values around the gap."""
    x, y = np.meshgrid(np.linspace(-1000, 1000, 21), np.linspace(-1000, 1000, 21), indexing="ij")
    fault = plane_fault((0, -1100), (0, 1100), dip=12.0, depth=400.0).surface
    slope = np.tan(np.radians(12.0))
    # Above the fault: -50 m to the left, 50 to the right, and up and down in a gap of 1 km.
    rise = np.clip((np.abs(x) - 500.0) / 500.0, 0.0, 1.0) * np.sign(x) * 50.0
    noise = np.where(np.abs(x) < 450.0, 0.3 * np.sin(x / 90.0) * np.cos(y / 150.0), 0.0)
    vertices = np.stack([x, y, -slope * x + rise + noise], axis=-1).reshape(-1, 3)
    horizon = Surface("H", vertices, grid_triangles(21, 21))
    height = calmed(horizon, [fault]).vertices[:, 2] + slope * vertices[:, 0]
    inner = np.abs(vertices[:, 0]) <= 500.0
    assert (np.diff(height.reshape(21, 21), axis=0)[4:16] > 0).all(), "grows from side to side"
    assert height[inner].reshape(-1, 21).std(axis=1).max() < 0.01 * THROW
