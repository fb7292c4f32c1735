"""Several kinds of damage on one fault: the repairs of its triangles, one after the other, by the planner."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from graben.cleaning import nonmanifold, orient, planner, slivers, stitch, t_vertices, unfit, weld
from graben.cleaning.planner import repaired
from graben.finding import Profile, Status
from graben.stages import Stages, quiet
from graben.surface import Surface
from graben.validators.runner import run_checks
from tests.cleaning.cracked import area, rim_length
from tests.cleaning.test_slivers import bent, split_at
from tests.zoo.shapes import faults

CHAIN = (
    unfit.REPAIR,
    weld.REPAIR,
    nonmanifold.REPAIR,
    orient.REPAIR,
    stitch.REPAIR,
    t_vertices.REPAIR,
    slivers.REPAIR,
)
CHECKS = ("finite", "duplicate", "degenerate", "manifold", "strongly-connected", "oriented")
Damage = Callable[[Surface, np.random.Generator], Surface]


def _some(surface: Surface, rng: np.random.Generator, count: int, inner: bool = False) -> np.ndarray:
    """Triangles of the first part of the surface, away from its rim where asked."""
    t = bent().triangles
    i, j = np.arange(143) // 11, np.arange(143) % 11
    deep = (i > 1) & (i < 11) & (j > 1) & (j < 9)
    there = deep[t].all(axis=1) if inner else np.ones(len(t), dtype=bool)
    left = [k for k in np.flatnonzero(there) if (surface.triangles == t[k]).all(axis=1).any()]
    chosen = rng.choice(left, min(count, len(left)), replace=False)
    return np.array([int(np.flatnonzero((surface.triangles == t[k]).all(axis=1))[0]) for k in chosen])


def with_nan(surface, rng):
    vertex = surface.triangles[_some(surface, rng, 1, inner=True)[0], 0]
    vertices = surface.vertices.copy()
    vertices[vertex, rng.integers(3)] = np.nan
    return surface.with_vertices(vertices)


def with_index(surface, rng):
    return replace(surface, triangles=np.concatenate([surface.triangles, [[0, 1, 10**6]]]))


def doubled(surface, rng):
    t = surface.triangles[_some(surface, rng, 4)]
    return replace(surface, triangles=np.concatenate([surface.triangles, t[:, [1, 2, 0]]]))


def unwelded(surface, rng):
    which = _some(surface, rng, 5)
    triangles = surface.triangles.copy()
    triangles[which] = len(surface.vertices) + np.arange(15).reshape(-1, 3)
    vertices = np.concatenate([surface.vertices, surface.vertices[surface.triangles[which]].reshape(-1, 3)])
    return replace(surface, vertices=vertices, triangles=triangles)


def with_fin(surface, rng):
    a, b, _ = surface.triangles[_some(surface, rng, 1, inner=True)[0]]
    tip = np.add(surface.vertices[[a, b]].mean(axis=0), [0, 20, 30])
    return replace(
        surface,
        vertices=np.vstack([surface.vertices, tip]),
        triangles=np.concatenate([surface.triangles, [[a, b, len(surface.vertices)]]]),
    )


def turned(surface, rng):
    triangles = surface.triangles.copy()
    which = _some(surface, rng, 6)
    triangles[which] = triangles[which][:, ::-1]
    return replace(surface, triangles=triangles)


def with_slivers(surface, rng):
    return split_at(surface, _some(surface, rng, 6), [rng.permutation([0.4999, 0.5, 1e-4]) for _ in range(6)])


def with_flat(surface, rng):
    a, b, _ = surface.triangles[_some(surface, rng, 1)[0]]
    return replace(surface, triangles=np.concatenate([surface.triangles, [[a, a, b]]]))


def with_hanging(surface, rng):
    """An edge inside with a vertex that only one of its triangles has."""
    t = int(_some(surface, rng, 1, inner=True)[0])
    a, b, c = surface.triangles[t]
    n = len(surface.vertices)
    return replace(
        surface,
        vertices=np.vstack([surface.vertices, surface.vertices[[a, b]].mean(axis=0)]),
        triangles=np.concatenate([np.delete(surface.triangles, t, axis=0), [[a, n, c], [n, b, c]]]),
    )


DAMAGES: tuple[Damage, ...] = (
    *(with_nan, with_index, doubled, unwelded, with_fin, turned, with_slivers, with_flat, with_hanging),
)


def gate(model, need, warning):
    return run_checks(model, Profile.EXTENDED, Stages(quiet), need, warning)


def mended(monkeypatch, surface):
    monkeypatch.setattr(planner, "REPAIRS", CHAIN)
    model = faults(surface)
    found = run_checks(model, Profile.EXTENDED, Stages(quiet))
    return repaired(model, gate, quiet, found)


def said(model, status: Status) -> list[str]:
    """What the checks answered say of a model; the holes that warnings name are another repair's."""
    result, _ = run_checks(model, Profile.EXTENDED, Stages(quiet))
    return [f.message for check in CHECKS for f in result.of(check) if f.status is status]


def sound(made) -> None:
    """Assert that all is repaired, with the area but for one ring of triangles, and the rim, as they were.

    A vertex without a place that is in the file twice cannot be told from others: it leaves a hole.
    """
    assert said(made.model, Status.FAIL) == [], made.left
    (fault,) = made.model.faults
    holes = len(said(made.model, Status.WARN))
    assert area(fault.surface) == pytest.approx(area(bent()), rel=1e-2 + 0.04 * holes)
    if not holes:
        assert rim_length(fault.surface) == pytest.approx(rim_length(bent()), rel=1e-2)


@pytest.mark.parametrize(
    "pair", list(combinations(DAMAGES, 2)), ids=lambda p: "-".join(d.__name__ for d in p)
)
@pytest.mark.parametrize("turn", [1, -1])
def test_two_kinds_at_once(monkeypatch, pair, turn):
    surface, rng = bent(), np.random.default_rng(sum(map(DAMAGES.index, pair)))
    for damage in pair[::turn]:
        surface = damage(surface, rng)
    assert said(faults(surface), Status.FAIL)
    made = mended(monkeypatch, surface)
    sound(made)
    assert made.actions
    again = mended(monkeypatch, made.model.faults[0].surface)
    assert again.model.faults[0].surface is made.model.faults[0].surface


@pytest.mark.parametrize("seed", range(8))
def test_all_kinds_at_once(monkeypatch, seed):
    surface, rng = bent(), np.random.default_rng(seed)
    for damage in rng.permutation(np.array(DAMAGES, dtype=object)):
        surface = damage(surface, rng)
    made = mended(monkeypatch, surface)
    sound(made)


def test_what_is_sound_is_the_same(monkeypatch):
    surface = bent()
    made = mended(monkeypatch, surface)
    assert made.model.faults[0].surface is surface
    assert made.actions == ()


def test_progress_counts_findings_in_words(monkeypatch):
    monkeypatch.setattr(planner, "REPAIRS", CHAIN)
    model, told = faults(with_flat(bent(), np.random.default_rng(0))), []
    repaired(
        model, gate, lambda _, what: told.append(what), run_checks(model, Profile.EXTENDED, Stages(quiet))
    )
    assert any(what.endswith(", 1 finding") for what in told)
    assert not any(what.endswith(", 1 findings") for what in told)
