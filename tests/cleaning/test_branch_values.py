"""Along the branch lines of repaired networks both faults are one: w_i = w_j."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from graben.arrays import FloatArray
from graben.model import Model
from graben.proximity import nearest
from graben.surface import Surface, edge_table
from tests.cleaning.corruption import Case, mended

CASES = [
    Case("cross", ("non-conforming",), 1),
    Case("tee", ("gaps",), 1),
    Case("on-branch", ("non-conforming",), 1),
    Case("splays", ("gaps",), 1),
]
#: Share of the model's size within which both elevations are to agree.
EQUAL = 1e-9


def edges_of(surface: Surface) -> set[tuple[bytes, bytes]]:
    """The edges of a surface as the bits of their ends."""
    keys = [v.tobytes() for v in np.ascontiguousarray(surface.vertices + 0.0)]
    return {tuple(sorted((keys[a], keys[b]))) for a, b in edge_table(surface.triangles)[0].tolist()}


def elevation(surface: Surface, points: FloatArray) -> FloatArray:
    """The elevation of a fault at plan positions of it, by the triangle that is nearest in plan."""
    flat = surface.vertices * [1.0, 1.0, 0.0]
    at = np.column_stack([points[:, :2], np.zeros(len(points))])
    found = nearest(at, flat, surface.triangles)
    a, b, c = (flat[surface.triangles[found.simplex, k]][:, :2] for k in range(3))
    z = surface.vertices[surface.triangles[found.simplex], 2]
    matrix = np.stack([b - a, c - a], axis=2)
    u = np.linalg.solve(matrix, (points[:, :2] - a)[:, :, None])[:, :, 0]
    return z[:, 0] + u[:, 0] * (z[:, 1] - z[:, 0]) + u[:, 1] * (z[:, 2] - z[:, 0])


def shared_lines(model: Model) -> dict[tuple[str, str], FloatArray]:
    """By two faults: the ends (e, 2, 3) of the edges they share to the bit."""
    lines = {}
    for first, second in combinations([f.surface for f in model.faults], 2):
        common = edges_of(first) & edges_of(second)
        if common:
            ends = np.frombuffer(b"".join(a + b for a, b in sorted(common))).reshape(-1, 2, 3)
            lines[first.name, second.name] = ends
    return lines


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_both_faults_have_the_same_edges_and_elevations_on_branch_lines(case):
    corrupted, result = mended(case)
    assert result.passed
    faults = {f.name: f.surface for f in result.model.faults}
    clean, lines = shared_lines(corrupted.clean), shared_lines(result.model)
    assert lines.keys() == clean.keys()
    broken = shared_lines(corrupted.model)
    assert sum(map(len, broken.values())) < sum(map(len, lines.values()))
    worst = 0.0
    for (one, two), ends in lines.items():
        was = np.linalg.norm(np.diff(clean[one, two], axis=1), axis=2).sum()
        assert np.linalg.norm(np.diff(ends, axis=1), axis=2).sum() == pytest.approx(was, rel=0.05)
        points = np.concatenate([ends.reshape(-1, 3), ends.mean(axis=1)])
        values = [elevation(faults[name], points) for name in (one, two)]
        for w in values:
            worst = max(worst, float(np.abs(w - points[:, 2]).max()))
        worst = max(worst, float(np.abs(values[0] - values[1]).max()))
    assert worst <= EQUAL * result.model.size


def test_a_fault_moved_off_its_branch_line_is_told():
    clean = CASES[1].built().clean
    (one, two), ends = next(iter(shared_lines(clean).items()))
    faults = {f.name: f.surface for f in clean.faults}
    moved = faults[two].with_vertices(faults[two].vertices + np.array([0.0, 0.0, 1e-6 * clean.size]))
    points = ends.reshape(-1, 3)
    away = elevation(faults[one], points) - elevation(moved, points)
    assert np.abs(away).max() > EQUAL * clean.size
    assert not edges_of(faults[one]) & edges_of(moved)
