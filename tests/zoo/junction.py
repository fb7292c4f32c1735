"""The zoo of junction: faults that run together along a horizon."""

from __future__ import annotations

from tests.zoo.cases import Case
from tests.zoo.networks import cut, field, flat, plane

_LEVEL = field(flat)
# Its line at elevation 0, that of the flat horizon, is shared by those that dip against it.
_F = plane((-5, 0.13), (5, 0.13), top=4.0, bottom=-4.0)
_AGAINST = plane((5, 0.13), (-5, 0.13), "G", dip=50.0, top=4.0, bottom=-4.0)
_SLANTED = plane((-5, 0.1), (5, 0.3))


def _case(name: str, model, place=None, **keys) -> Case:
    return Case(name, "junction", model, place, ("H", "F", "G"), blocks=True, **keys)


FAILING: tuple[Case, ...] = (
    _case("branch line in the horizon", cut(_LEVEL, _F, _AGAINST), (0, 6.5, 0)),
    _case(
        "common upper rim in the horizon",
        cut(
            _LEVEL,
            plane((-5, 0.13), (5, 0.13), top=0.0, bottom=-4.0),
            plane((5, 0.13), (-5, 0.13), "G", dip=50.0, top=0.0, bottom=-4.0),
        ),
        (0, 6.5, 0),
    ),
    _case(
        "splay that starts in the horizon",
        cut(_LEVEL, _F, plane((3, 0.13), (-3.4, 0.13), "G", dip=50.0, top=0.0, bottom=-4.0)),
        (-10, 6.5, 0),
    ),
    _case("given twice", cut(field(), _SLANTED, plane((-5, 0.1003), (5, 0.3003), "G")), (0, 10, 0)),
)
PASSING: tuple[Case, ...] = (
    Case("branch line below", "junction", cut(field(lambda x, y: 20.0 + 0.0 * x), _F, _AGAINST)),
    Case("branch line rises through it", "junction", cut(field(), _F, _AGAINST)),
    Case("at a small angle", "junction", cut(field(), _SLANTED, plane((-5, 0.5), (5, -0.1), "G"))),
    Case("side by side", "junction", cut(field(), _SLANTED, plane((-5, 0.12), (5, 0.32), "G"))),
)
