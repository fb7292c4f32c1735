"""Meshes made anew where a move turns triangles over, and lips spaced anew where they fold."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from graben.arrays import BoolArray, FloatArray, IntArray, floats
from graben.demo import HORIZON, MARGIN
from graben.demo_surfaces import SPACING, sheet
from graben.formats.irap import grid_surface
from graben.model import Fault, GridGeometry, Horizon, Model
from graben.modeling import moves
from graben.modeling.cutting import CutMesh, opened
from graben.modeling.energy import EdgePattern
from graben.modeling.noise import node_areas
from graben.modeling.picks import NodeData
from graben.modeling.remeshing import Remeshed, plan_areas, remeshed
from graben.modeling.results import HorizonResult, Subdomain, TerminationType
from graben.modeling.triangulation import PlanMesh
from graben.pipeline import build
from graben.settings import Parameters
from graben.surface import boundary_edges
from graben.synthetic import SMEAR, Geology, Regional, TrueFault
from tests.modeling.test_low_dips import dipping, error, half_heave
from tests.models import grid_triangles

COUNT, STEP = 15, 100.0
ROUNDING = 1e-9
MIDDLE = COUNT // 2 * COUNT + COUNT // 2


def grid() -> tuple[FloatArray, IntArray]:
    """A square grid with one corner in the origin."""
    x, y = np.meshgrid(STEP * np.arange(COUNT), STEP * np.arange(COUNT), indexing="ij")
    return floats(np.stack([x.ravel(), y.ravel()], axis=1)), grid_triangles(COUNT, COUNT)


def dragged(points: FloatArray, node: int, by: tuple[float, float]) -> FloatArray:
    moved = points.copy()
    moved[node] += by
    return moved


def none(points: FloatArray) -> BoolArray:
    return np.zeros(len(points), dtype=bool)


def all_of(triangles: IntArray) -> BoolArray:
    return np.ones(len(triangles), dtype=bool)


def least_angle(points: FloatArray, triangles: IntArray) -> float:
    corners = points[triangles]
    angles = []
    for k in range(3):
        u, v = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        angles.append(np.arctan2(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], (u * v).sum(axis=1)))
    return float(np.degrees(np.min(angles)))


def edges_of(made: Remeshed, triangles: IntArray, count: int) -> tuple[set[tuple[int, int]], ...]:
    """The directed edges with one triangle, after and before, in the numbers of after."""
    before = made.renumbered(boundary_edges(triangles), count)
    return {(a, b) for a, b in boundary_edges(made.triangles).tolist()}, {(a, b) for a, b in before.tolist()}


def test_a_valid_mesh_comes_back_unchanged() -> None:
    points, triangles = grid()
    made = remeshed(points, triangles, none(points), all_of(triangles))
    assert made is not None
    assert made.points is points
    assert made.triangles is triangles
    assert (made.weights.toarray() == np.eye(len(points))).all()


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("by", [(130.0, 20.0), (-20.0, 220.0), (150.0, -140.0)])
def test_what_is_turned_over_is_made_anew(by: tuple[float, float], held: bool) -> None:
    points, triangles = grid()
    moved = dragged(points, MIDDLE, by)
    stays = none(points)
    stays[MIDDLE] = held
    assert (plan_areas(moved, triangles) <= 0).any()
    made = remeshed(moved, triangles, stays, all_of(triangles))
    assert made is not None
    areas = plan_areas(made.points, made.triangles)
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(plan_areas(points, triangles).sum(), rel=ROUNDING)
    assert (made.points[: len(made.kept)] == moved[made.kept]).all()
    assert (MIDDLE in made.kept) or not held
    after, before = edges_of(made, triangles, len(points))
    assert after == before
    # A held node beside the rim of its region leaves triangles no choice.
    assert least_angle(made.points, made.triangles) > (5.0 if held else 20.0)


def test_linear_fields_are_carried_exactly() -> None:
    points, triangles = grid()
    moved = dragged(points, MIDDLE, (130.0, 20.0))
    made = remeshed(moved, triangles, none(points), all_of(triangles))
    assert made is not None
    field = moved @ [0.3, -0.7] + 12.0
    assert made.weights @ field == pytest.approx(made.points @ [0.3, -0.7] + 12.0, abs=ROUNDING * field.max())
    assert (made.weights.toarray() >= 0).all()


def test_quality_is_not_worse() -> None:
    """Slivers of a mesh of random nodes, handed in as bad, give way to better triangles."""
    random = np.random.default_rng(4)
    start, triangles = grid()
    points = start.copy()
    inner = np.setdiff1d(np.arange(len(points)), boundary_edges(triangles))
    points[inner] += random.uniform(-33.0, 33.0, (len(inner), 2))
    assert (plan_areas(points, triangles) > 0).all()
    each = np.array([least_angle(points, t[None]) for t in triangles])
    bad = each < 25.0
    bad &= ~np.isin(triangles, boundary_edges(triangles)).any(axis=1)
    assert bad.sum() > 5
    made = remeshed(points, triangles, none(points), all_of(triangles), bad)
    assert made is not None
    old = {tuple(t) for t in made.renumbered(triangles, len(points)).tolist()}
    replaced = np.array([t for t in made.triangles.tolist() if tuple(t) not in old])
    assert least_angle(made.points, made.triangles) >= each.min()
    assert least_angle(made.points, replaced) > each[bad].min()
    # A second remeshing of a mesh without bad triangles changes nothing.
    again = remeshed(made.points, made.triangles, none(made.points), all_of(made.triangles))
    assert again is not None
    assert again.triangles is made.triangles


def test_a_rim_that_folds_cannot_be_mended() -> None:
    points, triangles = grid()
    beyond = dragged(points, COUNT // 2, (15.0 * STEP, 0.0))
    assert remeshed(beyond, triangles, none(points), all_of(triangles)) is None
    moved = dragged(points, MIDDLE, (130.0, 20.0))
    allowed = ~np.isin(triangles, MIDDLE).any(axis=1)
    assert remeshed(moved, triangles, none(points), allowed) is None


def test_result_does_not_depend_on_the_place_and_is_the_same_each_time() -> None:
    points, triangles = grid()
    moved = dragged(points, MIDDLE, (130.0, 20.0))
    offset = np.array([432_000.0, 6_780_000.0])
    made, twin, far = (
        remeshed(p, triangles, none(points), all_of(triangles)) for p in (moved, moved, moved + offset)
    )
    assert made is not None
    assert twin is not None
    assert far is not None
    assert (made.points == twin.points).all()
    assert (made.triangles == twin.triangles).all()
    assert far.points - offset == pytest.approx(made.points, abs=1e-6)


def slit(overlap: float) -> tuple[CutMesh, FloatArray]:
    """A grid cut along its middle row from the middle on; the lips lie over each other by ``overlap``."""
    points, triangles = grid()
    row = np.arange(COUNT // 2, COUNT) * COUNT + COUNT // 2
    mesh = PlanMesh(
        np.column_stack([points, np.zeros(len(points))]),
        triangles,
        np.stack([row[:-1], row[1:]], axis=1),
        none(points),
    )
    cut = opened(mesh)
    place = points[cut.origin]
    across = place[:, 1] - points[MIDDLE, 1]
    upper = np.zeros(len(place), dtype=bool)
    upper[cut.triangles[(place[cut.triangles][:, :, 1].mean(axis=1) > points[MIDDLE, 1])]] = True
    lip = np.isin(cut.origin, row[1:])
    side = np.where(lip, np.where(upper, 1.0, -1.0), np.sign(across))
    ahead = np.clip((place[:, 0] - points[MIDDLE, 0]) / STEP, 0.0, 3.0) / 3.0
    fade = np.clip(1.0 - np.abs(across) / (4.0 * STEP), 0.0, 1.0)
    place[:, 1] -= 0.5 * overlap * side * ahead * fade
    return cut, place


def test_lips_that_lie_over_each_other() -> None:
    """Around the tip of a reverse fault the region holds both lips, and is divided."""
    cut, place = slit(120.0)
    assert (plan_areas(place, cut.triangles) > 0).all()
    node = MIDDLE + 2 * COUNT + 2
    moved = dragged(place, node, (30.0, 160.0))
    assert (plan_areas(moved, cut.triangles) <= 0).any()
    lips = np.unique(np.concatenate([cut.left, cut.right]))
    held = none(moved)
    held[lips] = True
    made = remeshed(moved, cut.triangles, held, all_of(cut.triangles))
    assert made is not None
    areas = plan_areas(made.points, made.triangles)
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(plan_areas(place, cut.triangles).sum(), rel=ROUNDING)
    after, before = edges_of(made, cut.triangles, len(moved))
    assert after == before


def test_remeshings_one_after_the_other_are_one() -> None:
    points, triangles = grid()
    moved = dragged(points, MIDDLE, (130.0, 20.0))
    first = remeshed(moved, triangles, none(points), all_of(triangles))
    assert first is not None
    fresh = len(first.points) - 1
    beside = np.isin(first.triangles, fresh).any(axis=1)
    second = remeshed(first.points, first.triangles, none(first.points), all_of(first.triangles), beside)
    assert second is not None
    both = first.then(second)
    assert (both.points[: len(both.kept)] == moved[both.kept]).all()
    field = moved @ [0.3, -0.7]
    assert both.weights @ field == pytest.approx(both.points @ [0.3, -0.7], abs=ROUNDING * field.max())


def test_what_picks_say_is_carried_to_new_nodes() -> None:
    """Picks on a plane say at each node, wherever it went, what the plane says there."""
    points, triangles = grid()
    slope = np.array([0.3, -0.7])
    there = np.flatnonzero(points[:, 0] < 9.5 * STEP)
    told = NodeData(there, points[there] @ slope, np.tile(slope, (len(there), 1)))
    areas = node_areas(points, triangles)
    pattern = EdgePattern.of(triangles, len(points))
    problem = SimpleNamespace(points=points, pattern=pattern, data=told, stiffness=2.0 * areas[there])
    moved = dragged(points, MIDDLE, (130.0, 20.0))
    made = remeshed(moved, triangles, none(points), all_of(triangles))
    assert made is not None
    data, stiffness = moves._data(problem, made, moved)  # type: ignore[arg-type]
    assert data.z == pytest.approx(made.points[data.nodes] @ slope, abs=ROUNDING * STEP * COUNT)
    assert data.gradient == pytest.approx(np.tile(slope, (len(data.nodes), 1)), rel=ROUNDING)
    known = np.zeros(len(made.points), dtype=bool)
    known[data.nodes] = True
    assert known[made.points[:, 0] < 8.5 * STEP].all()
    assert not known[made.points[:, 0] > 9.5 * STEP].any()
    fresh = data.nodes >= len(made.kept)
    assert fresh.any()
    density = stiffness / node_areas(made.points, made.triangles)[data.nodes]
    assert density[fresh] == pytest.approx(2.0, rel=ROUNDING)
    assert stiffness[~fresh] == pytest.approx(2.0 * areas[made.kept[data.nodes[~fresh]]], rel=ROUNDING)


def narrow(smears: float) -> tuple[Geology, Model]:
    """A fault of 12 degrees, half of whose heave is about the width of the zone that is free to move."""
    geology, model = dipping(12.0, -0.1)
    gamma = half_heave(geology) + smears * SMEAR
    return geology, replace(model, parameters=model.parameters.model_copy(update={"gamma": gamma}))


def ended(model: Model) -> tuple[HorizonResult, Subdomain]:
    (horizon,) = build(model, mend=False).horizons
    (subdomain,) = horizon.subdomains
    return horizon, subdomain


def test_a_solve_that_needs_a_new_mesh(monkeypatch: pytest.MonkeyPatch) -> None:
    geology, model = narrow(-0.5)
    horizon, subdomain = ended(model)
    assert subdomain.termination.type is TerminationType.CONVERGED
    assert subdomain.remeshings >= 1
    faces, vertices = horizon.surface.triangles, horizon.surface.vertices
    assert (plan_areas(vertices[:, :2], faces) > 0).all()
    counts = {len(a) for a in (horizon.first, horizon.subdomain, horizon.fixed, horizon.side, horizon.block)}
    assert counts == {len(vertices)}
    assert np.unique(faces).tolist() == list(range(len(vertices)))
    # What is new lies on the input between what was there: the input is smooth, its triangles have 100 m.
    inside = ~horizon.fixed & (horizon.side == 0)
    seismic = geology.seismic(horizon.first[inside, :2])
    assert np.abs(horizon.first[inside, 2] - seismic).max() < 2.0
    with monkeypatch.context() as without:
        without.setattr(moves, "remeshed", lambda *_: None)
        stuck, left = ended(model)
    assert left.termination.type is TerminationType.STAGNATION
    assert "triangles would turn over" in left.termination.advice
    assert left.remeshings == 0
    assert error(geology, horizon) < error(geology, stuck)
    again, _ = ended(model)
    assert (again.surface.vertices == vertices).all()
    assert (again.surface.triangles == faces).all()


def test_a_new_mesh_is_as_good_as_one_that_was_not_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where shorter steps get there as well, after twice as many, the mesh made anew is no worse."""
    geology, model = narrow(0.0)
    horizon, subdomain = ended(model)
    assert subdomain.remeshings >= 1
    monkeypatch.setattr(moves, "remeshed", lambda *_: None)
    slow, patient = ended(model)
    assert patient.termination.type is TerminationType.CONVERGED
    assert subdomain.iterations < patient.iterations
    assert error(geology, horizon) <= 1.02 * error(geology, slow)


def crossing(turn: float, rising: float) -> tuple[Geology, Model]:
    """Two flat faults that cross at 80 degrees or so, on a step of 200 m.

    Where they cross the smeared horizon, which rises towards ``rising`` (degrees), is nearly as steep as they
    are, and both traces run along the line in which they meet.
    """
    size = (7000.0, 7000.0)
    regional = Regional(-2500.0, 0.1, rising, (3500.0, 3500.0))
    columns = floats(np.linspace(-1600.0, 1600.0, round(3200.0 / SPACING) + 1))
    made = []
    for name, centre, azimuth, dip, throw in (
        ("A", (3500.0, 3500.0), 90.0, 29.1, 146.0),
        ("B", (3600.0, 3550.0), 90.0 + turn, 33.3, 103.0),
    ):
        elevation = float(regional(floats(centre)))
        made.append(
            TrueFault(name, centre, azimuth, dip, elevation, throw, 1600.0, 1.5, columns, 30.0, 2000.0)
        )
    geology = Geology(regional, tuple(made), None, size)
    surfaces = []
    for fault, trace in zip(made, geology.traces, strict=True):
        z = fault.elevation_at(columns, trace(columns))
        surfaces.append(sheet(fault, float(z.min()) - 125.0 - MARGIN, float(z.max()) + 125.0 + MARGIN))
    nodes = GridGeometry(36, 36, 200.0, 200.0, (0.0, 0.0))
    surface = grid_surface(HORIZON, nodes, geology.seismic(nodes.nodes()))
    horizon = Horizon(HORIZON, surface, 200.0, nodes)
    faults = tuple(Fault(s) for s in surfaces)
    return geology, Model(
        "crossing", (horizon,), faults, parameters=Parameters.model_validate({"gamma": 600.0})
    )


def lip_error(geology: Geology, horizon: HorizonResult) -> float:
    """The root mean square distance in elevation of all cut nodes from the true horizon of their block, m."""
    at = np.flatnonzero(horizon.side != 0)
    places = horizon.surface.vertices[at]
    away = np.stack([geology.distance(f, places[:, :2]) for f in range(2)], axis=1)
    signs = np.where(horizon.block[at] != 0, horizon.block[at], np.sign(away)).astype(int)
    wrong = [geology.horizon(tuple(s), p[:2]) - p[2] for s, p in zip(signs.tolist(), places, strict=True)]
    return float(np.sqrt(np.mean(np.square(wrong))))


def test_lips_that_fold_at_a_crossing_are_spaced_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    geology, model = crossing(80.0, 85.0)
    horizon, subdomain = ended(model)
    assert subdomain.termination.type is TerminationType.CONVERGED
    assert (plan_areas(horizon.surface.vertices[:, :2], horizon.surface.triangles) > 0).all()
    # The horizon rises a little otherwise: nothing folds, and the error is of the same size.
    calm_geology, calm = crossing(80.0, 90.0)
    assert lip_error(geology, horizon) < 1.3 * lip_error(calm_geology, ended(calm)[0])
    monkeypatch.setattr(moves, "_spaced", lambda *_: iter(()))
    assert ended(model)[1].termination.type is TerminationType.STAGNATION
