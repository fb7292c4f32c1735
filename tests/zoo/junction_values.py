"""The zoo of junction-values: faults whose traces are joined where they do not quite meet."""

from __future__ import annotations

import numpy as np

from tests.zoo.cases import Case
from tests.zoo.networks import cut, field, flat, plane

#: A thousandth of a step is joined on the horizon; a millionth of the model's size is 1.5 mm here.
_GAP, _ROUNDING = 6e-4, 5e-6
_ONTO = ((0.3, -6.0), (-0.2, 6.0), 70.0)
_UPRIGHT = ((0.3, -6.0), (-0.2, 6.0), 90.0)
_MAIN = plane(*_ONTO[:2], "G")
_PLACE = (3.0, -10.3, None)


def _splay(short=0.0, onto=_ONTO, name: str = "F", **keys):
    return plane((-7.1, 0.3), (0.0, -0.2), name, onto=onto, short=short, **keys)


def _opening(z):
    """How far a splay stops short that passes the other down to 20 m above the horizon and no further."""
    return np.where(z > 0.6, -0.05, _GAP)


def _case(name: str, model, place=None, objects=("H", "F", "G"), **keys) -> Case:
    return Case(name, "junction-values", model, place, objects, **keys)


_BEYOND = -1.0  # by which splays pass it that are then cut back to the branch line
_OPPOSITE = plane((7.1, -0.7 + _GAP), (0.0, -0.2 + _GAP), "K", dip=110.0, onto=_ONTO, short=_BEYOND)
_BACK = (_ONTO[1], _ONTO[0], 110.0)  # the same fault, seen from its other side
_STAR = [plane((-6, -0.3), (6, 0.3)), plane((-6, -6), (6, 6), "G"), plane((1.0004, -8), (-0.9996, 8), "K")]

FAILING: tuple[Case, ...] = (
    _case("splay stops 3 cm short", cut(field(), _splay(_GAP), _MAIN), _PLACE, follows=("near-miss",)),
    _case("splay stops 3 mm short", cut(field(), _splay(6e-5), _MAIN), _PLACE, follows=("near-miss",)),
    _case(
        "opens above the horizon",
        cut(field(), _splay(_opening, parts=(2, 10)), _MAIN),
        _PLACE,
        follows=("near-miss",),
    ),
    _case(
        "short of a vertical fault",
        cut(field(), _splay(_GAP, _UPRIGHT), plane(*_UPRIGHT[:2], "G", dip=90.0)),
        _PLACE,
        follows=("functional", "near-miss"),
    ),
    _case(
        "splays that all but face each other",
        cut(field(), _splay(_BEYOND), _MAIN, _OPPOSITE, ends_on={"F": _ONTO, "K": _BACK}),
        _PLACE,
        ("H", "F", "K"),
    ),
)
PASSING: tuple[Case, ...] = (
    _case("splay that ends on it", cut(field(), _splay(_BEYOND), _MAIN, ends_on={"F": _ONTO})),
    _case("short by rounding", cut(field(), _splay(_ROUNDING), _MAIN), follows=("simplicial-complex",)),
    _case(
        "short by what is allowed",
        cut(field(), _splay(_GAP), _MAIN, checks={"junction-values": 0.1}),
        follows=("near-miss",),
    ),
    _case("too far to be joined", cut(field(), _splay(5e-3), _MAIN), follows=("near-miss",)),
    _case("proper crossing", cut(field(), plane((-7.1, 0.3), (7, -0.2)), _MAIN)),
    _case("three almost in one point", cut(field(flat), *_STAR)),
)
