"""The zoo of anchored: parts of a horizon that lie within gamma of a cut everywhere."""

from __future__ import annotations

from tests.zoo.cases import Case
from tests.zoo.networks import around, cut, field, plane
from tests.zoo.shapes import STEP


def _strip(width: float, gamma: float = 2.0):
    """Two faults from boundary to boundary, so many steps apart."""
    low, high = 0.15 - width / 2, 0.15 + width / 2
    return cut(
        field(), plane((-11, low), (11, low + 0.1)), plane((-11, high), (11, high + 0.1), "G"), gamma=gamma
    )


def _corner(legs: float):
    """A fault that cuts off a corner of the horizon."""
    return cut(field(), plane((9.9 - legs, 10.9), (10.9, 10.1 - legs)))


def _case(name: str, model, place=None, **keys) -> Case:
    return Case(name, "anchored", model, place, ("H",), **keys)


FAILING: tuple[Case, ...] = (
    _case("strip", _strip(1.4), (0.0, 0.15 * STEP, None)),
    _case("corner", _corner(4.0), (9.0 * STEP, 9.0 * STEP, None)),
    _case("margin", cut(field(), plane((8.7, -11), (8.9, 11))), (9.3 * STEP, 0.0, None)),
    _case("triangle", cut(field(), *around(0.9)), (0.4 * STEP, 0.3 * STEP, None), follows=("acyclic",)),
)
PASSING: tuple[Case, ...] = (
    _case("strip wider than gamma", _strip(5.4)),
    _case("strip within gamma, reduced", _strip(5.4, gamma=6.0)),
    _case("corner wider than gamma", _corner(7.0)),
    _case("triangle wider than gamma", cut(field(), *around(2.6, beyond=2.8)), follows=("acyclic",)),
)
