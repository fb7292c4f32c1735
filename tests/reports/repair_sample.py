"""A repair made by hand: a fault that moved and was cut back, one extended, one split, one gone, one kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.arrays import BoolArray, FloatArray
from graben.cleaning.ledger import Left, RepairAction, measured
from graben.finding import CheckResult, Finding, Profile, Status, Worst
from graben.model import Fault, Model
from graben.repairs import RepairResult
from graben.surface import Surface
from graben.validators.registry import known_ids
from tests.models import grid_horizon, model_of, plane_fault

#: Far from the origin, as UTM coordinates are.
AWAY = np.array([432_000.0, 6_780_000.0, -2000.0])
MOVE, EXTENSION, CUT = 25.0, 260.0, 400.0
PLACE = (432_100.0, 6_780_200.0, -2010.0)


def part(surface: Surface, keep: BoolArray, name: str) -> Surface:
    """Some triangles of a surface under a name, without the vertices that none of them uses."""
    used, inverse = np.unique(surface.triangles[keep], return_inverse=True)
    return Surface(name, surface.vertices[used], inverse.reshape(-1, 3))


def eastings(surface: Surface) -> FloatArray:
    """How far east of AWAY the middle of each triangle lies, shape (m,)."""
    return np.asarray(surface.vertices[surface.triangles].mean(axis=1)[:, 0] - AWAY[0])


def normal(surface: Surface) -> FloatArray:
    a, b, c = surface.vertices[surface.triangles[0]]
    n = np.cross(b - a, c - a)
    return np.asarray(n / np.linalg.norm(n))


def given(names: tuple[str, ...] = ("F1", "F2", "F3", "F4", "F5")) -> Model:
    horizon = grid_horizon(lambda x, y: 0 * x + 0.02 * y, size=6000.0, step=200.0)
    lines = [((-2000, -300), (1500, -300)), ((-2000, 500), (0, 500)), ((-1500, 1500), (1500, 1500))]
    lines += [((-2500, 2300), (2000, 2300)), ((-2500, -2300), (-2000, -2300))]
    faults = [
        plane_fault(*line, name=name, depth=450, parts=(31, 10))
        for line, name in zip(lines, names, strict=True)
    ]
    return replace(model_of(horizon, *faults), name="by hand").moved(AWAY)


def findings(*open_: Finding) -> CheckResult:
    """These findings, and a pass of every other check."""
    silent = [Finding(check, Status.PASS) for check in known_ids() if all(f.check != check for f in open_)]
    ordered = sorted([*open_, *silent], key=lambda f: known_ids().index(f.check))
    return CheckResult(Profile.PAPER, tuple(ordered))


def repaired(
    names: tuple[str, ...] = ("F1", "F2", "F3", "F4", "F5"), *, passed: bool = False
) -> RepairResult:
    """The whole of it; names are those of the input."""
    model = given(names)
    first, second, third, _, fifth = (f.surface for f in model.faults)
    bent = first.vertices.copy()
    bent[150] += MOVE * normal(first)
    moved = part(first.with_vertices(bent), eastings(first) < 1500 - CUT, first.name)
    longer = plane_fault(
        (-2000, 500), (EXTENSION, 500), name=second.name, depth=450, parts=(35, 10)
    ).surface.moved(AWAY)
    halves = [
        part(third, eastings(third) < 0, third.name),
        part(third, eastings(third) > 0, f"{third.name} (2)"),
    ]
    faults = (*map(Fault, (moved, longer, *halves)), model.faults[3])
    m = measured
    # fmt: off
    actions = (
        RepairAction("unfold", "functional", (first.name,), 1, MOVE, PLACE, f"{first.name} was unfolded.",
                     None, "", (m(first),), (m(moved),)),
        RepairAction("contacts", "near-miss", (second.name, first.name), 4, 0.0, None,
                     "It was extended along its own trend.", EXTENSION, "m", (m(second),), (m(longer),)),
        RepairAction("parts", "strongly-connected", (third.name,), 2, 0.0, PLACE, "It was split.", None, "",
                     (m(third),), tuple(map(m, halves))),
        RepairAction("specks", "strongly-connected", (fifth.name,), 1, 0.0, None, "It was a speck.", 450000.0,
                     "m²", (m(fifth),), ()),
    )
    # fmt: on
    failing = Finding(
        "z-monotone", Status.FAIL, (first.name,), 2, Worst(3.0, "m", *PLACE), "A <summit>.", "Look <there>."
    )
    warning = Finding("near-miss", Status.WARN, (second.name,), 1, None, "It stops short.", "Extend it.")
    left = (
        Left("near-miss", (second.name,), "contacts", None, "It is too far.", "Draw it on.", 12.5, "m"),
        Left("z-monotone", (first.name,), "slopes", PLACE, "It needs <more>.", "Raise max_move.", 73.2, "m"),
    )
    after = findings(warning) if passed else findings(warning, failing)
    lineage = {s.name: s.name for s in (moved, longer, halves[0], model.faults[3].surface)}
    lineage[halves[1].name] = third.name
    before = findings(replace(failing, count=9), replace(warning, check="trace", status=Status.FAIL))
    return RepairResult(
        model,
        replace(model, faults=faults),
        actions,
        left[: 1 if passed else 2],
        before,
        after,
        lineage,
        1.5,
        300.0,
    )


def untouched() -> RepairResult:
    """Nothing was found and nothing done."""
    model = given()
    same = {f.name: f.name for f in model.faults}
    return RepairResult(model, model, (), (), findings(), findings(), same, 0.5, 200.0)
