"""The zoo of acyclic: faults that enclose a part of a horizon."""

from __future__ import annotations

from tests.zoo.cases import Case
from tests.zoo.networks import around, cut, field, flat, pipe, plane
from tests.zoo.shapes import STEP

_MIDDLE = (0.4 * STEP, 0.3 * STEP, None)  # of the polygons
_GRID = [
    *(plane((-9, y), (9, y + 0.3), name) for y, name in ((-3.2, "F"), (2.9, "G"))),
    *(plane((x, -8), (x + 0.2, 8), name) for x, name in ((-5.6, "K"), (0.2, "L"), (5.4, "M"))),
]
_ACROSS = [plane((-11, -4), (11, 3)), plane((-11, 3.5), (11, -4.2), "G")]


def _case(name: str, model, place=None, **keys) -> Case:
    return Case(name, "acyclic", model, place, ("H",), **keys)


FAILING: tuple[Case, ...] = (
    _case("small triangle", cut(field(), *around(0.9)), _MIDDLE, follows=("anchored",)),
    _case("large triangle", cut(field(), *around(2.6, beyond=2.8)), _MIDDLE, extended="warn"),
    _case("square of four", cut(field(), *around(3.6, 4, 2.9)), _MIDDLE, extended="warn"),
    _case("two rooms", cut(field(), *_GRID), (2.9 * STEP, 0.1 * STEP, None), extended="warn"),
    _case("small pipe", cut(field(), pipe(2.0)), (0.3 * STEP, 0.2 * STEP, None), follows=("anchored",)),
    _case("wide pipe", cut(field(), pipe(4.0)), (0.3 * STEP, 0.2 * STEP, None), extended="warn"),
)
PASSING: tuple[Case, ...] = (
    _case(
        "triangle open at a corner",
        cut(field(), *around(2.6, beyond=2.8, open_by=1.6)),
        follows=("near-miss",),
    ),
    _case("pipe open by a slit", cut(field(), pipe(4.0, turns=22))),
    _case("closed by the boundary", cut(field(), *_ACROSS)),
    _case("three through one point", cut(field(flat), *around(1e-5, beyond=5.0))),
    _case("comb", cut(field(), *_GRID[1:])),
)
