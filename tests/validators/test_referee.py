"""OpenGeode-Inspector as referee of the checks of single surfaces, where both look at the same thing.

Where they do not, by definition:

- It takes vertices nearer than 1e-6 (absolute) for one and triangles lower than that for degenerate; graben
  compares bits, and heights with 1e-9 of the longest side. So no surface here has anything in between.
- A triangle with a repeated corner has an edge to itself for it, which it calls non-manifold; graben leaves
  such triangles out of `manifold`, since `degenerate` names them.
- It names the ends of a non-manifold edge as non-manifold vertices; graben names the edge alone.
- Triangles that touch, and triangles twice, intersect for it; for graben they touch, and are `duplicate`. So
  what graben says must be among what it says, and all of it where no two sheets touch.
- It does not compare triangles that share an edge or a corner the way exact arithmetic does: a fold on
  itself next to a common edge is none for it. Those are compared in test_self_intersection.
"""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

from graben.formats.tsurf import read_tsurf
from graben.model import Fault, Model
from graben.surface import Surface
from graben.validators.context import CheckContext, Defect
from graben.validators.measuring.crossings import crossings
from graben.validators.measuring.measures import angles_of, mesh_of, places_of
from graben.validators.registry import find
from tests.validators.inspector import ISSUES, inspected
from tests.zoo import FAILING, PASSING
from tests.zoo.shapes import STEP, dipping, sheet

pytest.importorskip("opengeode_inspector")
CFM = Path(__file__).parents[2].parent / "shared" / "data" / "cfm"
CHECKS = (
    "degenerate",
    "duplicate",
    "manifold",
    "oriented",
    "strongly-connected",
    "self-intersection",
    "functional",
)
#: Folded on itself beside common edges, in one plane.
FOLDED = "self-intersection: a vertex past its neighbours"
Issues = dict[str, dict[str, list]]


def _usable(surface: Surface) -> bool:
    inside = ((surface.triangles >= 0) & (surface.triangles < len(surface.vertices))).all()
    return bool(np.isfinite(surface.vertices).all() and inside and len(surface.triangles))


def _rough(seed: int, relief: float) -> Surface:
    """A sheet with noise, that crosses itself where the relief is large; no two of its parts touch."""
    flat = sheet(24, 24, lambda i, j: (STEP * i, STEP * j, 0 * i))
    noise = np.random.default_rng(seed).normal(size=flat.vertices.shape) * STEP * [0.1, 0.1, relief]
    return flat.with_vertices(flat.vertices + noise)


def _loose(seed: int) -> Surface:
    rng = np.random.default_rng(seed)
    middles = rng.normal(size=(150, 1, 3)) * 2 * STEP
    corners = middles + rng.normal(size=(150, 3, 3)) * STEP
    return Surface("F", corners.reshape(-1, 3), np.arange(450))


ZOO = {
    f"{case.check}: {case.name}": surface
    for case in (*FAILING, *PASSING)
    if case.check in CHECKS
    for surface in case.model.surfaces
    if surface.name == "F" and _usable(surface)
}
GENERIC = {f"rough {r}": _rough(k, r) for k, r in enumerate((0.2, 1.0, 3.0))} | {
    f"loose {k}": _loose(k) for k in range(3)
}
GOOD = {
    "plane": dipping(60, 20, 20),
    "bent": sheet(30, 20, lambda i, j: (STEP * i, 90 * np.sin(j / 3), -20 * j)),
}


@pytest.fixture(scope="module")
def referee(tmp_path_factory: pytest.TempPathFactory) -> Issues:
    return inspected({**ZOO, **GENERIC, **GOOD}, tmp_path_factory.mktemp("referee"))


def defect(surface: Surface, check: str) -> Defect | None:
    """What graben's own check says of the surface as a fault."""
    model = Model("m", (), (Fault(surface),))
    said = find(check).run(CheckContext(model, frozenset({surface.name})))
    return said[0] if said else None


def places(points: np.ndarray) -> set[tuple[float, ...]]:
    """Places as a set, to a hundredth of a millimetre."""
    return {tuple(row) for row in (np.round(np.reshape(points, (-1, 3)), 5) + 0.0).tolist()}


def agree(surface: Surface, issues: dict[str, list]) -> None:
    """Assert that both say the same of one surface."""
    vertices, triangles = surface.vertices, surface.triangles
    # duplicate
    groups = defaultdict(set)
    for vertex, place in enumerate(places_of(surface).tolist()):
        groups[place].add(vertex)
    twice = {frozenset(group) for group in groups.values() if len(group) > 1}
    assert {frozenset(group) for group in issues["colocated_points_groups"]} == twice
    # degenerate
    assert set(issues["degenerated_polygons"]) == set(np.flatnonzero(angles_of(surface) == 0).tolist())
    if len(mesh_of(surface).kept) < len(triangles):
        return  # triangles with a repeated corner
    # manifold
    edges = np.reshape(issues["non_manifold_edges"], (-1, 2)).astype(int)
    pinched = sorted(set(issues["non_manifold_vertices"]) - set(edges.ravel().tolist()))
    said = defect(surface, "manifold")
    expected = places(vertices[edges].mean(axis=1)) | places(vertices[pinched])
    on_holes = 0 if said is None else sum(len(loop) - 1 for loop in said.paths)
    assert (set() if said is None else places(said.places[: len(said.places) - on_holes])) == expected
    # oriented
    if not len(edges):
        wrong = np.reshape(issues["polygon_edges_with_wrong_adjacency"], (-1, 2)).astype(int)
        ends = np.stack([triangles[wrong[:, 0], (wrong[:, 1] + k) % 3] for k in (0, 1)], axis=1)
        said = defect(surface, "oriented")
        assert (set() if said is None else places(said.places)) == places(vertices[ends].mean(axis=1))


def crossing(surface: Surface) -> set[tuple[int, int]]:
    return set(map(tuple, crossings(surface, 1e-8 * Model("m", (), (Fault(surface),)).size).pairs.tolist()))


def intersecting(issues: dict[str, list]) -> set[tuple[int, int]]:
    return {(min(pair), max(pair)) for pair in issues["intersecting_elements"]}


@pytest.mark.parametrize("name", [*ZOO, *GENERIC, *GOOD])
def test_both_say_the_same_of_duplicates_degenerate_manifold_and_oriented(name: str, referee: Issues) -> None:
    agree({**ZOO, **GENERIC, **GOOD}[name], referee[name])


@pytest.mark.parametrize("name", [*GENERIC, *GOOD])
def test_both_name_the_same_crossing_pairs_where_no_sheets_touch(name: str, referee: Issues) -> None:
    assert crossing({**GENERIC, **GOOD}[name]) == intersecting(referee[name])


@pytest.mark.parametrize("name", ZOO)
def test_what_crosses_meets_for_the_referee_too(name: str, referee: Issues) -> None:
    if name != FOLDED:
        assert crossing(ZOO[name]) <= intersecting(referee[name])


def test_the_surfaces_have_every_kind_of_defect(referee: Issues) -> None:
    for kind in ISSUES:
        assert sum(bool(issues[kind]) for issues in referee.values()) >= 2, kind
    assert sum(bool(crossing(surface)) for surface in {**ZOO, **GENERIC}.values()) >= 8
    assert sum(not any(issues.values()) for issues in referee.values()) >= 10


def test_a_fold_beside_a_common_edge_is_seen_by_graben_alone(referee: Issues) -> None:
    assert len(crossing(ZOO[FOLDED])) > 10
    assert not intersecting(referee[FOLDED])


@pytest.mark.skipif(not CFM.is_dir(), reason="shared data are not here")
def test_both_say_the_same_of_all_142_real_faults(tmp_path: Path) -> None:
    read = (o.surface for file in sorted(CFM.glob("*.ts")) for o in read_tsurf(file))
    local = {s.name: s.moved(-Model("m", (), (Fault(s),)).local_origin()) for s in read}
    issues = inspected(local, tmp_path)
    assert len(local) == 142
    for name, surface in local.items():
        agree(surface, issues[name])
        if issues[name]["colocated_points_groups"]:
            # the lips of a crack touch
            assert not crossing(surface)
        else:
            assert crossing(surface) == intersecting(issues[name]), name
    assert sum(bool(i["colocated_points_groups"]) for i in issues.values()) == 3
    assert [name for name, surface in local.items() if crossing(surface)] == [
        "ETRA-BBFS-1992-Big_Bear_rupture-CFM6"
    ]
