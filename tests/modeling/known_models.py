"""A catalogue of small models with a known answer, by what is hard about each; see ``known_answers``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from graben.arrays import BoolArray, FloatArray
from tests.modeling.known_answers import (
    Along,
    Answer,
    Arc,
    Height,
    Known,
    Parent,
    Straight,
    bump,
    dipping,
    listric,
    overturned,
    steady,
)

MIDDLE = (3000.0, 3000.0)
LEVEL = -1500.0  #: of the base in the middle, m
_PAST = 9000.0  # further than any place of the domain from a fault's middle, m


def base(xy: FloatArray) -> FloatArray:
    """Return a tilted, gently bent plane."""
    x, y = xy[..., 0] - MIDDLE[0], xy[..., 1] - MIDDLE[1]
    return np.asarray(LEVEL + 0.06 * x - 0.05 * y + 2e-6 * x * x - 1.5e-6 * x * y)


def _at(place: tuple[float, float]) -> float:
    return float(base(np.array(place)))


def _alone(
    shift: Along,
    throw: Along | None = None,
    half: float = 2000.0,
    line: Straight | Arc | None = None,
    depth: float = 500.0,
) -> Answer:
    fault = Known("F1", line or Straight(MIDDLE, 80.0), shift, throw or bump(120.0, half), (-half, half))
    return Answer(base, [fault], depth=depth)


def _through(
    name: str, azimuth: float, dip: float, throw: float, place: tuple[float, float] = MIDDLE
) -> Known:
    """A fault through the whole domain."""
    return Known(
        name, Straight(place, azimuth), dipping(dip, _at(place)), steady(throw), (-_PAST, _PAST), reach=2500.0
    )


def _branch(
    name: str,
    azimuth: float,
    side: int,
    dip: float = 65.0,
    throw: float = 90.0,
    place: tuple[float, float] = MIDDLE,
    parent: int = 0,
    length: float = 2400.0,
) -> Known:
    """A fault that ends on another at ``place``; its throw dies out away from there."""

    def dying(s: FloatArray) -> FloatArray:
        return np.asarray(throw * np.maximum(1.0 - (np.maximum(s, 0.0) / length) ** 2, 0.0) ** 1.5)

    ends = (Parent(parent, side),)
    return Known(name, Straight(place, azimuth), dipping(dip, _at(place)), dying, (-2600.0, length), ends)


#: Northwards through the middle, dipping east.
_MAIN = replace(_through("F1", 90.0, 60.0, 120.0), span=(-3600.0, 3600.0), reach=2000.0)


def _two(faults: Sequence[Known], **how: float) -> Answer:
    return Answer(base, list(faults), **how)  # type: ignore[arg-type]


def _side_by_side(apart: float, other: float, shift: float = 0.0, half: float = 2000.0) -> Answer:
    """Two faults along y; the second, dipping to the right of its way ``other``, stands ``apart`` east."""
    first = Known("F1", Straight(MIDDLE, 90.0), dipping(60.0, LEVEL), bump(100.0, half), (-half, half))
    line = Straight((MIDDLE[0] + apart, MIDDLE[1] + shift), other)
    second = Known("F2", line, dipping(60.0, LEVEL), bump(80.0, half), (-half, half))
    return Answer(base, [first, second], depth=250.0)


def _star(tilt: tuple[float, float], azimuths: Sequence[float], offsets: Sequence[float]) -> Answer:
    """Faults that end together in one slanting line; the blocks between them are moved each by itself."""
    faults, blocks = [], {}
    for k, azimuth in enumerate(azimuths):
        a = np.radians(azimuth)
        across = float(np.sin(a) * tilt[0] - np.cos(a) * tilt[1])
        along = float(np.cos(a) * tilt[0] + np.sin(a) * tilt[1])
        faults.append(
            Known(
                f"F{k + 1}",
                Straight(MIDDLE, azimuth),
                lambda z, across=across: across * (z - LEVEL),
                steady(80.0),
                (0.0, 4600.0),
                start=lambda z, along=along: along * (z - LEVEL),
            )
        )
        signs = [0] * len(azimuths)
        signs[k], signs[(k + 1) % len(azimuths)] = -1, 1
        blocks[tuple(signs)] = _tilted(offsets[k], 5e-5 * (-1) ** k)
    return Answer(base, faults, blocks=blocks)


def _tilted(offset: float, slope: float) -> Height:
    return lambda xy: np.asarray(offset * (1.0 + slope * (xy[..., 0] - MIDDLE[0])))


def _leaving(
    place: tuple[float, float],
    azimuth: float,
    dip: float = 60.0,
    throw: float = 100.0,
    length: float = 3000.0,
) -> Answer:
    """A fault that leaves the domain at ``place`` and dies out along ``azimuth`` from there."""

    def dying(s: FloatArray) -> FloatArray:
        return np.asarray(throw * np.maximum(1.0 - (np.maximum(s, 0.0) / length) ** 2, 0.0) ** 1.5)

    return Answer(
        base, [Known("F1", Straight(place, azimuth), dipping(dip, _at(place)), dying, (-2000.0, length))]
    )


def _ragged(xy: FloatArray) -> BoolArray:
    x, y = xy[..., 0], xy[..., 1]
    away = np.hypot(x - MIDDLE[0], y - MIDDLE[1])
    return np.asarray(away > 2700.0 + 180.0 * np.sin(x / 130.0) * np.cos(y / 170.0))


def _round_hole(xy: FloatArray) -> BoolArray:
    return np.asarray(np.hypot(xy[..., 0] - 4700.0, xy[..., 1] - 3000.0) < 450.0)


_SCISSOR = 350.0
_HALF_ARC = 1800.0 * float(np.radians(40.0))

#: Throw along strike: sign changes, and nothing over a stretch.
_PROFILES = {
    "scissor": lambda s: _SCISSOR * (s / 2200.0) * np.maximum(1.0 - (s / 2200.0) ** 2, 0.0) ** 2,
    "two patches": lambda s: bump(120.0, 1100.0, -1300.0)(s) + bump(120.0, 1100.0, 1300.0)(s),
}

SHAPES = {
    "dip 60": _alone(dipping(60.0, LEVEL)),
    "vertical": _alone(lambda z: 0.0 * z),
    "overturned at the horizon": _alone(overturned(60.0, LEVEL, 150.0)),
    "overturned above": _alone(overturned(60.0, LEVEL + 150.0, 200.0)),
    "listric 70 to 25": _alone(listric(70.0, 25.0, -900.0, -2100.0, LEVEL), depth=350.0),
    "arc turning 80": _alone(
        dipping(60.0, LEVEL), half=_HALF_ARC, line=Arc((1200.0, 3000.0), 1800.0, 0.0, 1)
    ),
    "arc turning back 80": _alone(
        dipping(60.0, LEVEL), half=_HALF_ARC, line=Arc((1200.0, 3000.0), 1800.0, 0.0, -1)
    ),
    "scissor": _alone(dipping(60.0, LEVEL), _PROFILES["scissor"], 2200.0),
    "no throw between": _alone(dipping(60.0, LEVEL), _PROFILES["two patches"], 2400.0),
    "thrust 20": _alone(dipping(20.0, LEVEL), bump(-80.0, 2200.0), 2200.0, depth=250.0),
}

_LAMBDA = replace(_branch("F2", 75.0, 1, -60.0), throw=steady(70.0), span=(-6000.0, 5000.0), reach=2500.0)
_REVERSE = replace(_MAIN, throw=steady(-100.0), shift=dipping(50.0, LEVEL), reach=2500.0)

NETWORKS = {
    "T on the hanging side": _two([_MAIN, _branch("F2", 0.0, 1)]),
    "Y of 40 on the foot side": _two([_MAIN, _branch("F2", 130.0, -1)]),
    "Y of 30, dipping towards each other": _two([_MAIN, _branch("F2", -60.0, 1)]),
    "two T's at one place": _two([_MAIN, _branch("F2", 20.0, 1), _branch("F3", 150.0, -1)]),
    "branch on a branch": _two(
        [
            _MAIN,
            replace(_branch("F2", 0.0, 1), throw=steady(100.0), span=(-2600.0, 3800.0)),
            _branch("F3", 80.0, -1, 60.0, 70.0, (4500.0, 3000.0), 1, 2000.0),
        ]
    ),
    "antithetic at 15": _two([replace(_MAIN, throw=steady(100.0)), _LAMBDA], depth=100.0),
    "three through a point": _two(
        [
            _through("F1", 90.0, 60.0, 100.0),
            _through("F2", 30.0, 65.0, 80.0),
            _through("F3", -30.0, 70.0, 60.0),
        ]
    ),
    "star": _star((0.35, 0.2), (90.0, 210.0, 330.0), (40.0, -30.0, 0.0)),
    "cross of 25": _two([_through("F1", 90.0, 60.0, 100.0), _through("F2", 65.0, 65.0, 80.0)]),
    "reverse T": _two([_REVERSE, _branch("F2", 20.0, 1, 55.0, -90.0)]),
    "reverse and normal": _two([_REVERSE, _through("F2", 20.0, 60.0, 80.0)]),
}

_EAST = (6000.0, 3000.0)
OUTLINES = {
    "leaving at 20": _leaving(_EAST, 110.0),
    "leaving at 12": _leaving(_EAST, 102.0),
    "leaving beside a corner": _leaving((6000.0, 6000.0), 225.0, length=3500.0),
    "ragged": replace(_two([_through("F1", 75.0, 60.0, 100.0)]), undefined=_ragged),
    "hole": replace(_alone(dipping(60.0, LEVEL)), undefined=_round_hole),
    "cross beside the boundary": _two(
        [
            _through("F1", 60.0, 60.0, 100.0, (5940.0, 3000.0)),
            _through("F2", 120.0, 65.0, 80.0, (5940.0, 3000.0)),
        ]
    ),
}

ZONES = {
    "relay": _side_by_side(400.0, 90.0, 1600.0, 1600.0),
    "own gammas": _two(
        [
            replace(_through("F1", 90.0, 60.0, 100.0), gamma=250.0),
            replace(_through("F2", 20.0, 65.0, 80.0), gamma=500.0),
        ]
    ),
    "wedge": _two(
        [
            _through("F1", 60.0, 60.0, 100.0, (5500.0, 3000.0)),
            _through("F2", 120.0, 65.0, 80.0, (5500.0, 3000.0)),
        ]
    ),
}

#: Zones that overlap all along the strip between two faults.
STRIPS = {
    "graben of 500 m": _side_by_side(500.0, -90.0),
    "horst of 700 m": _side_by_side(-700.0, -90.0),
    "steps of 900 m": _side_by_side(900.0, 90.0),
}

#: What no answer can be given for.
ILLEGAL = {
    "given twice": _two([SHAPES["dip 60"].faults[0], replace(SHAPES["dip 60"].faults[0], name="F2")]),
    "meeting in the horizon": Answer(
        lambda xy: np.full(xy.shape[:-1], LEVEL),
        [
            Known("F1", Straight(MIDDLE, 90.0), dipping(60.0, LEVEL), bump(80.0, 2000.0), (-2000.0, 2000.0)),
            Known("F2", Straight(MIDDLE, -90.0), dipping(60.0, LEVEL), bump(60.0, 2000.0), (-2000.0, 2000.0)),
        ],
    ),
}
