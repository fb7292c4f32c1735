"""What the twelve clean networks consist of: shapes of faults, and where they end and cross."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from graben.arrays import FloatArray, floats


@dataclass(frozen=True)
class Shape:
    """A smooth fault: s along strike and z give the place in plan; it dips to the right of growing s.

    ``centre``: plan position of s = z = 0. ``azimuth``: of growing s, counter-clockwise from east. ``dip``:
    at z = 0. ``listric``: change of cot(dip) per metre of depth. ``amplitude``, ``wavelength``, ``phase``:
    of the corrugation, which runs parallel to dip.
    """

    centre: tuple[float, float]
    azimuth: float
    dip: float
    listric: float = 0.0
    amplitude: float = 0.0
    wavelength: float = 2000.0
    phase: float = 0.0

    @property
    def axes(self) -> tuple[FloatArray, FloatArray]:
        """Unit vectors in plan along strike and to its right."""
        a = np.radians(self.azimuth)
        return floats([np.cos(a), np.sin(a)]), floats([np.sin(a), -np.cos(a)])

    def corrugation(self, s: FloatArray) -> FloatArray:
        return floats(self.amplitude * np.sin(2.0 * np.pi * s / self.wavelength + np.radians(self.phase)))

    def at(self, s: FloatArray, z: FloatArray) -> FloatArray:
        """Plan positions, shape (..., 2)."""
        along, right = self.axes
        q = self.corrugation(s) - z / np.tan(np.radians(self.dip)) + 0.5 * self.listric * z**2
        return floats(np.asarray(self.centre) + s[..., None] * along + q[..., None] * right)


@dataclass(frozen=True)
class FaultPlan:
    """A fault and where it ends: at s of a tip, or at the fault of that name.

    ``hung``: two faults from whose common branch line it hangs; its start is there. ``taper``: how much
    shorter it is at a tip at its highest and lowest level. ``low``, ``high``: its least and highest level.
    """

    name: str
    shape: Shape
    start: float | str = 0.0
    stop: float | str = 0.0
    taper: float = 0.0
    low: float = -np.inf
    high: float = np.inf
    hung: tuple[str, ...] = ()

    @property
    def tips(self) -> list[tuple[float, float]]:
        """s of the ends that are tips, each with the sign of the way inwards."""
        ends = [] if self.hung else [(self.start, 1.0)]
        ends.append((self.stop, -1.0))
        return [(end, sign) for end, sign in ends if not isinstance(end, str)]


@dataclass(frozen=True)
class Network:
    """The faults of a network, those that cross, and its horizons.

    ``horizons``: their elevations. ``half_height``: faults reach so far above and below 0. ``size``: of the
    domain. ``tilt``: rise of the horizons to the east and to the north. ``shift``: of all, after it is made.
    """

    faults: tuple[FaultPlan, ...]
    crossings: tuple[tuple[str, str], ...] = ()
    horizons: tuple[float, ...] = (0.0,)
    half_height: float = 450.0
    size: float = 7000.0
    tilt: tuple[float, float] = (0.012, -0.008)
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)


def _fault(
    name: str,
    centre: tuple[float, float],
    azimuth: float,
    dip: float,
    start: float | str,
    stop: float | str,
    *,
    taper: float = 0.0,
    low: float = -np.inf,
    high: float = np.inf,
    hung: tuple[str, ...] = (),
    **shape: float,
) -> FaultPlan:
    return FaultPlan(name, Shape(centre, azimuth, dip, **shape), start, stop, taper, low, high, hung)


_ISOLATED = Network(
    (
        _fault("F1", (-1500, 0), 80, 60, -1600, 1600, amplitude=60, wavelength=1900),
        _fault("F2", (1200, 300), 125, 52, -1300, 1400, taper=180, listric=7e-4),
    ),
)
_TEE = Network(
    (
        _fault("F1", (-300, 0), 95, 60, -2000, 2100, amplitude=50, wavelength=2300),
        _fault("F2", (-300, 200), 30, 65, "F1", 1900, amplitude=30, wavelength=1500, taper=120),
    ),
)
_SPLAYS = Network(
    (
        _fault("Main", (0, 0), 70, 55, -2400, 2400, amplitude=70, wavelength=2600, phase=40),
        _fault("East", (-340, -900), 10, 70, "Main", 1700, taper=150),
        _fault("West", (340, 900), 160, 75, "Main", 1600, listric=3e-4),
    ),
)
_CROSS = Network(
    (
        _fault("F1", (0, 0), 60, 65, -2100, 2000, amplitude=40, wavelength=2400),
        _fault("F2", (0, 0), 140, 70, -1900, 2100, taper=100),
    ),
    crossings=(("F1", "F2"),),
)
_WYE = Network(
    (
        _fault("A", (0, 0), 90, 62, -1900, "B", amplitude=40, wavelength=2100),
        _fault("B", (0, 0), 35, 68, "A", 2000, taper=120),
        _fault("C", (0, 0), 145, 60, 0.0, 1900, amplitude=35, wavelength=1800, hung=("A", "B")),
    ),
)
_ON_BRANCH = Network(
    (
        _fault("A", (-1200, 0), 88, 58, -2000, 2000, amplitude=55, wavelength=2200, phase=90),
        _fault("B", (-1200, -600), 20, 66, "A", 2600, amplitude=25, wavelength=1700),
        _fault("C", (100, -120), 85, 72, "B", 1500, taper=100),
        _fault("D", (2500, -1900), 130, 45, -600, 700, listric=4e-4),
    ),
)
_LEAVING = Network(
    (
        _fault("F1", (-600, 0), 85, 63, -3400, 3400, amplitude=60, wavelength=2500),
        _fault("F2", (-600, 700), 25, 58, "F1", 4300, amplitude=30, wavelength=2100),
        _fault("F3", (-1900, -700), 140, 70, -900, 2000, taper=100),
    ),
    size=6000.0,
    shift=(431200.0, 6787000.0, -1800.0),
)
_RELAY = Network(
    (
        _fault("F1", (-600, -600), 75, 64, -1500, 1300, taper=100),
        _fault("F2", (-500, 46), 76, 64, -200, 1900, taper=100),
        _fault("F3", (1500, 0), 100, 50, -1500, 1500, listric=6e-4, amplitude=40, wavelength=2100),
    ),
    horizons=(120.0, -130.0),
    half_height=630.0,
    size=6000.0,
)
_CROSS_AND_SPLAY = Network(
    (
        _fault("F1", (-800, 300), 65, 66, -2300, 2000, amplitude=35, wavelength=2500),
        _fault("F2", (-800, 300), 150, 72, -1200, 1600, taper=100),
        _fault("F3", (-1400, -1100), 5, 60, "F1", 1800, amplitude=30, wavelength=1600),
        _fault("F4", (1600, 900), 80, 70, -1200, 1000),
        _fault("F5", (1690, 1000), 81, 70, -700, 1500, taper=80),
    ),
    crossings=(("F1", "F2"),),
    size=7000.0,
)
_LADDER = Network(
    (
        _fault("Main", (0, 0), 92, 60, -2700, 2700, amplitude=60, wavelength=2700),
        _fault("S1", (0, -1600), 25, 68, "Main", 1500),
        _fault("S2", (0, -100), 20, 65, "Main", 1600, amplitude=20, wavelength=1500),
        _fault("S3", (0, 1400), 30, 74, "Main", 1500, taper=90),
        _fault("R1", (-1800, 0), 100, 67, -1100, 900),
        _fault("R2", (-1745, 100), 99, 67, -600, 1300, taper=80),
    ),
    size=7000.0,
)
_SEVEN = Network(
    (
        _fault("F1", (-1500, 1000), 40, 62, -1600, 1500, amplitude=35, wavelength=2100),
        _fault("F2", (-1500, 1000), 110, 70, -1300, 1500),
        _fault("F3", (1000, -1500), 95, 58, -1300, 1500, listric=4e-4),
        _fault("F4", (1000, -1300), 170, 68, "F3", 1500, taper=90),
        _fault("F5", (2300, 1500), 75, 75, -1100, 900),
        _fault("F6", (2395, 1600), 74, 75, -500, 1400, taper=70),
        _fault("F7", (-2400, -1900), 60, 38, -800, 800, amplitude=40, wavelength=1600),
    ),
    crossings=(("F1", "F2"),),
    size=8000.0,
)
_EIGHT = Network(
    (
        _fault("A", (-1800, 1200), 95, 64, -1300, "B"),
        _fault("B", (-1800, 1200), 40, 70, "A", 1500),
        _fault("C", (-1800, 1200), 150, 62, 0.0, 1300, hung=("A", "B")),
        _fault("D", (900, -1000), 80, 60, -1500, 1500, amplitude=40, wavelength=2200),
        _fault("E", (900, -900), 15, 67, "D", 2000),
        _fault("F", (2200, -540), 80, 72, "E", 1200, taper=80),
        _fault("G", (-1900, -2000), 100, 68, -900, 800),
        _fault("H", (-1845, -1900), 99, 68, -500, 1200, taper=70),
    ),
    size=8000.0,
)

#: By name, in order.
NETWORKS: Mapping[str, Network] = MappingProxyType(
    {
        "isolated": _ISOLATED,
        "tee": _TEE,
        "splays": _SPLAYS,
        "cross": _CROSS,
        "wye": _WYE,
        "on-branch": _ON_BRANCH,
        "leaving": _LEAVING,
        "relay": _RELAY,
        "cross-and-splay": _CROSS_AND_SPLAY,
        "ladder": _LADDER,
        "seven": _SEVEN,
        "eight": _EIGHT,
    }
)
