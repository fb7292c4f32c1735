"""The catalogue of synthetic models: what makes the geology of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from graben.arrays import FloatArray, floats
from graben.demo_surfaces import SPACING
from graben.synthetic import Branching, Geology, Regional, TrueFault, Wave

SIZE = (8800.0, 8000.0)  #: extent of the domain before rotation, m; an even number of cells at any step
THROW = 138.0  #: largest vertical separation of a fault, m
_RELIEF = (Wave(12.0, 6500.0, 25.0, 40.0), Wave(8.0, 5000.0, 110.0, 200.0))
_LEVEL = -1500.0  # of the regional horizon, m


@dataclass(frozen=True)
class Recipe:
    """How a model of the catalogue comes about: its geology and gamma (m), with one sentence."""

    about: str
    geology: Callable[[], Geology]
    gamma: float = 400.0


def _columns(first: float, last: float) -> FloatArray:
    return floats(np.linspace(first, last, round((last - first) / SPACING) + 1))


def _fault(
    name: str,
    regional: Regional,
    centre: tuple[float, float],
    azimuth: float,
    *,
    dip: float = 60.0,
    throw: float = THROW,
    half_length: float = 2500.0,
    power: float = 1.5,
) -> TrueFault:
    """Return a corrugated fault whose trace on the regional horizon passes near ``centre``."""
    return TrueFault(
        name=name,
        centre=centre,
        azimuth=azimuth,
        dip=dip,
        elevation=float(regional(np.array(centre))),
        throw=throw,
        half_length=half_length,
        power=power,
        columns=_columns(-half_length, half_length),
        amplitude=30.0,
        wavelength=2000.0,
    )


def _regional(azimuth: float) -> Regional:
    return Regional(_LEVEL, 0.1, azimuth, (0.5 * SIZE[0], 0.5 * SIZE[1]), _RELIEF)


_AZIMUTH = 12.0  # of the main fault's dip, so that no fault follows a grid line


def _alone(
    *,
    centre: tuple[float, float] = (4400.0, 4000.0),
    rise: float = 47.0,
    dip: float = 60.0,
    throw: float = THROW,
    half_length: float = 2500.0,
    power: float = 1.5,
) -> Callable[[], Geology]:
    """Return what makes a geology with one fault; ``rise`` is the azimuth in which the horizon rises."""

    def made() -> Geology:
        regional = _regional(rise)
        fault = _fault(
            "F1", regional, centre, _AZIMUTH, dip=dip, throw=throw, half_length=half_length, power=power
        )
        return Geology(regional, (fault,), None, SIZE)

    return made


def _crossing() -> Geology:
    regional = _regional(47.0)
    first = _fault("F1", regional, (4400.0, 4000.0), _AZIMUTH)
    second = _fault("F2", regional, (4800.0, 4200.0), _AZIMUTH + 70.0)
    return Geology(regional, (first, second), None, SIZE)


def _branching() -> Geology:
    regional = _regional(47.0)
    main = _fault("F1", regional, (2600.0, 3800.0), _AZIMUTH)
    branch = _fault("F2", regional, main.centre, _AZIMUTH + 20.0 - 90.0, half_length=3000.0)
    branch = replace(branch, columns=floats([-1000.0, *_columns(planar := 750.0, 3000.0)]), planar=planar)
    return Geology(regional, (main, branch), Branching(1, 0, 1), SIZE)


CATALOGUE = {
    "single": Recipe("one normal fault that ends inside, dip 60", _alone()),
    "exit": Recipe("a normal fault that leaves the domain at one end", _alone(centre=(4400.0, 7000.0))),
    "exit-both": Recipe("a normal fault that leaves the domain at both ends", _alone(half_length=7000.0)),
    "cross": Recipe("two normal faults that cross", _crossing),
    "tee": Recipe("a normal fault and a branch that ends on it", _branching),
    "reverse": Recipe("a reverse fault, dip 50, whose lips overlap", _alone(dip=50.0, throw=-THROW)),
    "low-dip": Recipe(
        "a normal fault of dip 20, the horizon dipping against it", _alone(dip=20.0, rise=_AZIMUTH)
    ),
    "low-dip-12": Recipe(
        "a normal fault of dip 12, the horizon dipping against it", _alone(dip=12.0, rise=_AZIMUTH), 500.0
    ),
    "elliptic": Recipe("single with an elliptic throw profile, steep at the tips", _alone(power=0.5)),
    "short": Recipe("single with a fault of 2 km", _alone(half_length=1000.0)),
}
