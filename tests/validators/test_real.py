"""The gate on real models: which horizons are functions of x and y, which faults meet, what is cut."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from graben.finding import CheckResult, Profile, Status
from graben.model import Model
from graben.reading import read_model
from graben.stages import Stages, quiet
from graben.surface import Surface
from graben.validators.context import Evidence, Need
from graben.validators.measuring.contacts import ContactKind
from graben.validators.runner import run_checks, shifted

DATA = Path(__file__).parents[2].parent / "shared" / "data"
#: The last stage that the tests ask about, where tracing four large horizons is not among it.
THROUGH = {"drogon": Need.COMPLEX}


@dataclass(frozen=True, eq=False)
class Seen:
    model: Model
    result: CheckResult
    evidence: Evidence


@cache
def looked_at(name: str) -> Seen:
    path = DATA / name / "model.toml"
    if not path.is_file():
        pytest.skip(f"no {path}")
    model = read_model(path)
    origin = model.local_origin()
    through = THROUGH.get(name, Need.ANCHORS)
    result, evidence = run_checks(model.moved(-origin), Profile.EXTENDED, Stages(quiet), through)
    return Seen(model, shifted(result, origin), evidence)


def pierces(surface: Surface, other: Surface) -> bool:
    """Whether a side of a triangle of the first surface passes through a triangle of the second."""
    origin = surface.vertices.mean(axis=0)
    corners, others = (s.vertices[s.triangles] - origin for s in (surface, other))
    start, end = corners.reshape(-1, 3), np.roll(corners, -1, axis=1).reshape(-1, 3)
    a, b, c = (others[:, k][None] for k in range(3))

    def volume(p, q, r, s):
        return np.einsum("...i,...i", np.cross(q - p, r - p), s - p)

    p, q = start[:, None], end[:, None]
    sides = volume(a, b, c, p) * volume(a, b, c, q) < 0
    turns = np.stack([volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)])
    return bool((sides & ((turns > 0).all(axis=0) | (turns < 0).all(axis=0))).any())


def test_folds_are_named_on_their_steep_limb():
    seen = looked_at("hecho")
    failed = [f for f in seen.result.of("functional") if f.status is Status.FAIL]
    found = {f.objects[0]: np.array([f.worst.x, f.worst.y, f.worst.z]) for f in failed}
    # along the fold's profile x turns back on H1 to H7 by 0.18 to 2.6 steps, on H8 and H9 nowhere
    assert sorted(found) == [f"H{k}" for k in range(1, 8)]
    for horizon in seen.model.horizons:
        if horizon.name in found:
            place = found[horizon.name]
            near = horizon.picks[np.abs(horizon.picks[:, 0] - place[0]) <= 2 * horizon.step]
            assert np.ptp(near[:, 2]) > 4 * horizon.step


@pytest.mark.parametrize("name", ["claudius", "drogon"])
def test_both_lips_of_a_fault_are_no_fold(name):
    assert {f.status for f in looked_at(name).result.of("functional")} == {Status.PASS}


def test_claudius_passes_and_its_fault_cuts_d_alone():
    seen = looked_at("claudius")
    assert seen.result.passed
    assert [name for name, graph in seen.evidence.graphs.items() if len(graph.edges)] == ["D"]


@pytest.mark.parametrize("name", ["claudius", "drogon", "hecho"])
def test_the_faults_that_cross_are_those_whose_sides_pass_through_triangles(name):
    seen = looked_at(name)
    surfaces = [f.surface for f in seen.model.faults]
    count = range(len(surfaces))
    pairs = {(i, j) for i, j in combinations(count, 2) if pierces(surfaces[i], surfaces[j])}
    pairs |= {(i, j) for i, j in combinations(count, 2) if pierces(surfaces[j], surfaces[i])}
    assert {c.surfaces for c in seen.evidence.contacts if c.kind is ContactKind.CROSSING} == pairs
    assert len(pairs) == (name == "hecho")
