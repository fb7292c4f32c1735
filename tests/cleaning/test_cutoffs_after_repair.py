"""Cutoffs of models that were corrupted, repaired and run, against those of the clean ones."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from graben.arrays import FloatArray, floats
from graben.demo import SyntheticModel
from graben.demo import build as demo
from graben.finding import Profile
from graben.model import Model
from graben.modeling.results import HorizonResult
from graben.pipeline import build
from graben.proximity import nearest
from graben.repairs import repair
from graben.surface import Surface, triangle_normals
from tests.cleaning.corruption import corrupted
from tests.models import model_of_demo

#: Half a base in metres over which the slope of a horizon is taken.
_BASE = 5.0
#: Share of a limit by which a cutoff must be moved in one model at least: else nothing is shown.
_SHOWN = 1e-4
CASES = [
    ("single", ("bumps", "overturned", "holes", "slivers"), 1),
    ("single", ("parted", "slivers", "not-finite"), 2),
    ("tee", ("gaps", "bumps", "holes", "slivers"), 3),
    ("tee", ("overturned", "holes", "not-finite"), 4),
]


@cache
def made(name: str) -> SyntheticModel:
    return demo(name, step=200.0)


@cache
def clean(name: str) -> Model:
    return model_of_demo(made(name))


@cache
def clean_run(name: str) -> HorizonResult:
    (horizon,) = build(clean(name), Profile.PAPER, mend=False).horizons
    return horizon


def lips(result: HorizonResult, fault: str, side: str) -> list[FloatArray]:
    return [getattr(c, side) for c in result.cutoffs if c.fault == fault]


def moves(before: HorizonResult, after: HorizonResult, fault: Surface, side: str) -> tuple[FloatArray, ...]:
    """Distances in plan, at the same place along strike, and the points of the repaired run, dip directions
    in plan and dips there."""
    mean = triangle_normals(fault.vertices, fault.triangles).sum(axis=0)
    along = np.array([-mean[1], mean[0]]) / np.hypot(*mean[:2])
    points, away = [], []
    for line in lips(after, fault.name, side):
        t = line[:, :2] @ along
        offsets = np.full(len(line), np.inf)
        for old in lips(before, fault.name, side):
            order = np.argsort(old[:, :2] @ along)
            s, xy = (old[:, :2] @ along)[order], old[order, :2]
            there = (t >= s[0]) & (t <= s[-1])
            at = np.column_stack([np.interp(t, s, xy[:, k]) for k in range(2)])
            offsets[there] = np.minimum(offsets, np.linalg.norm(at - line[:, :2], axis=1))[there]
        known = np.isfinite(offsets)
        points.append(line[known])
        away.append(offsets[known])
    where = floats(np.concatenate(points), -1, 3)
    n = triangle_normals(fault.vertices, fault.triangles)
    n = n[nearest(where, fault.vertices, fault.triangles).simplex]
    n = n * np.where(n[:, 2:] < 0, -1.0, 1.0)
    flat = np.linalg.norm(n[:, :2], axis=1)
    dip = floats(np.arctan2(flat, n[:, 2]))
    return floats(np.concatenate(away)), where, floats(n[:, :2] / flat[:, None]), dip


def slopes(model: SyntheticModel, points: FloatArray, way: FloatArray) -> FloatArray:
    """How steeply the true horizon through each point falls in the dip direction of the fault, radians."""
    blocks = range(len(model.geology.blocks))
    high, middle, low = (
        np.stack([model.horizon(b, points[:, :2] + k * _BASE * way) for b in blocks]) for k in (-1, 0, 1)
    )
    own = np.abs(middle - points[:, 2]).argmin(axis=0), np.arange(len(points))
    return floats(np.arctan2(high[own] - low[own], 2.0 * _BASE))


@cache
def repaired_run(name: str, kinds: tuple[str, ...], seed: int) -> HorizonResult:
    broken = corrupted(clean(name), kinds, np.random.default_rng(seed)).model
    mended = repair(broken, Profile.PAPER)
    assert not mended.before.passed
    assert mended.passed, mended
    (horizon,) = build(mended.model, Profile.PAPER, mend=False).horizons
    return horizon


@pytest.mark.parametrize(("name", "kinds", "seed"), CASES, ids=[f"{n}-{'+'.join(k)}" for n, k, _ in CASES])
def test_cutoffs_are_those_of_the_clean_model_within_the_largest_move(name, kinds, seed):
    after = repaired_run(name, kinds, seed)
    assert after.converged
    largest, share = 0.0, 0.0
    for fault in clean(name).faults:
        for side in ("hanging", "foot"):
            away, points, way, dip = moves(clean_run(name), after, fault.surface, side)
            assert len(away) > 0.8 * sum(map(len, lips(after, fault.name, side)))
            limit = clean(name).max_move(fault) / np.sin(dip - slopes(made(name), points, way))
            assert (away <= limit).all(), f"{fault.name}, {side}: {away.max():.1f} m"
            largest, share = max(largest, float(away.max())), max(share, float((away / limit).max()))
    print(f"{name} {'+'.join(kinds)}: {largest:.2f} m, {share:.1%} of what is allowed")


def test_some_cutoffs_do_move():
    name, kinds, seed = CASES[0]
    after = repaired_run(name, kinds, seed)
    fault = clean(name).faults[0]
    away = moves(clean_run(name), after, fault.surface, "hanging")[0]
    assert away.max() > _SHOWN * clean(name).max_move(fault)
