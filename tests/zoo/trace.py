"""The zoo of trace: traces that end nowhere, come in pieces, are left out, or are none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.settings import RepairSettings
from graben.surface import Surface
from tests.zoo.cases import Case
from tests.zoo.networks import SLOPE, cut, field, plane
from tests.zoo.shapes import STEP, without

_HOLE = (-2.0, 2.0, -2.0, 2.0)
_F = plane((-7.1, 0.3), (7.3, -0.2), parts=(12, 4))
_BESIDE = plane((-6.3, 2.25), (6.2, 2.23), "G")


def _windowed(low: float, high: float) -> Surface:
    """The fault with a window in its middle between two elevations, in steps."""
    x, _, z = (_F.vertices[_F.triangles].mean(axis=1) / STEP).T
    return without(_F, np.flatnonzero((np.abs(x) < 2.0) & (low < z) & (z < high)))


def _dome(x, y):
    """A horizon that rises above a fault whose top is at 50 m."""
    return SLOPE * x + 120.0 * np.exp(-(x**2 + y**2) / (2.0 * 100.0**2))


def _thrown(x, y):
    """A horizon thrown down by a step and a half south of the fault."""
    return SLOPE * x - 1.5 * STEP / (1.0 + np.exp(y / (0.3 * STEP)))


def _case(name: str, model, place=None, objects=("H", "F"), **keys) -> Case:
    return Case(name, "trace", model, place, objects, **keys)


_SHORT_OF_G = replace(
    cut(field(hole=_HOLE), plane((-7.1, 1.4), (1.5, 1.3)), _BESIDE), repair=RepairSettings(max_extension=20.0)
)
_FLAT_LID = Surface("F", [[-100, -110, 0], [120, -90, 0], [10, 140, 0]], [[0, 1, 2]])

FAILING: tuple[Case, ...] = (
    _case("through a hole", cut(field(hole=_HOLE), _F), (-2 * STEP, 4, None), follows=("horizon",)),
    _case(
        "ends in a hole",
        cut(field(hole=_HOLE), plane((-7.1, 0.3), (-1.4, 0.2))),
        (-2 * STEP, 10, None),
        follows=("horizon",),
    ),
    _case("hole before another fault", _SHORT_OF_G, (-2 * STEP, 66, None), follows=("horizon",)),
    _case(
        "lies in the horizon",
        cut(field(lambda x, y: 0.0 * x), _FLAT_LID),
        objects=("H",),
        blocks=True,
        follows=("z-monotone", "min-dip"),
    ),
    _case(
        "window in the fault",
        cut(field(), _windowed(-1.0, 1.0)),
        (-235, 7, None),
        extended="warn",
        follows=("manifold",),
    ),
    _case(
        "horizon rises over the fault",
        cut(field(_dome), plane((-7.1, 0.3), (7.3, -0.2), top=1.0)),
        (253, 0, None),
        extended="warn",
    ),
    _case(
        "short piece",
        cut(field(), plane((-0.9, 0.3), (0.9, 0.2))),
        (-4, 13, 0),
        extended="warn",
        paper="warn",
    ),
    _case(
        "stub beyond a junction",
        cut(field(), plane((-7.1, 0.3), (0.6, -0.2)), plane((0, -6), (0, 6), "G", dip=80.0)),
        (15, -9, None),
        extended="warn",
        paper="warn",
        follows=("near-miss",),
    ),
    _case(
        "too short below",
        cut(field(_thrown), plane((-7.1, 0.3), (7.3, -0.2), bottom=-1.2)),
        extended="warn",
        paper="warn",
    ),
    _case(
        "too short above",
        cut(field(_thrown), plane((-7.1, 0.3), (7.3, -0.2), top=0.2)),
        extended="warn",
        paper="warn",
    ),
    _case(
        "cuts nothing",
        cut(field(), plane((-5, 0.3), (5, 0.2), top=-2.0, bottom=-4.0)),
        objects=("F",),
        extended="warn",
        paper="warn",
    ),
    _case(
        "ends just short",
        cut(field(), plane((-5, 0.3), (5, 0.2), top=-0.5, bottom=-3.0)),
        extended="warn",
        paper="warn",
    ),
)
PASSING: tuple[Case, ...] = (
    _case("hole beside it", cut(field(hole=(-2, 2, 4, 7)), _F)),
    _case("window below the horizon", cut(field(), _windowed(-2.0, -1.0))),
    _case("leaves the domain by a hair", cut(field(), plane((-7.1, 0.3), (10 - 1e-5, 0.2)))),
    _case(
        "ends on another",
        cut(
            field(),
            plane((-7.1, 0.3), (1.0, -0.27)),
            plane((0.3, -6), (-0.2, 6), "G"),
            ends_on={"F": ((0.3, -6), (-0.2, 6), 70.0)},
        ),
    ),
    _case("long enough", cut(field(_thrown), plane((-7.1, 0.3), (7.3, -0.2), top=1.0, bottom=-2.2))),
    _case("just over two steps", cut(field(), plane((-1.1, 0.3), (1.0, 0.2)))),
)
