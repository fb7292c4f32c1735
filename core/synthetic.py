"""Analytic geology with a known answer: a regional horizon, faults, and the displacement they carry.

A block is the part of the horizon that lies on one side of each fault. In block ``b`` the true horizon is

    u_b(x, y) = R(x, y) - 1/2 sum_f sign_bf F_f(x, y),    F_f = T_f(s) exp(-(d / 1500 m)^2) taper

with R the regional horizon, sign +1 on the hanging side, -1 on the foot side and 0 where the fault does not
reach, s the coordinate along the fault's strike, d the signed plan distance across strike from the fault's
trace on R (positive on the hanging side), and T_f(s) = T (1 - (s / L)^2)^p the vertical separation. A
branch exists on one side of its parent only; its taper, (1 - (s_parent / L_parent)^2)^1.5, lets it vanish
at the parent's tips, so that the horizon is continuous around them. Faults are not offset by each other.

What seismic shows is u_b with the jump replaced by a ramp from lip to lip (the trace of the fault plane
across the gap), smeared by a Gaussian of 120 m: sign_bf becomes S_f = E[clip((d + 120 Z) / h, -1, 1)], with
h half the heave and Z standard normal.

All functions here work in the model's own upright frame; metres.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import erf

from graben.arrays import BoolArray, FloatArray, floats

REACH = 1500.0  #: length over which displacement dies out, m
SMEAR = 120.0  #: standard width of the seismic smear, m
CURVE_STEP = 10.0  #: spacing of true cutoffs along strike, m
_FAR = 12_000.0  # further than any point of a model lies along strike from a fault's middle, m
_TRACE_STEP = 50.0  # spacing of a trace's spline; its error is below a millimetre
_SECANTS = 10  # 6 reach the last digit
_BISECTIONS = 30  # halve 10 m to 10 nanometres
_LEAST_HALF_HEAVE = 1e-3  # below it the ramp is a jump, m


@dataclass(frozen=True)
class Wave:
    """One cosine of relief: amplitude, wavelength (m), azimuth ccw from east and phase (degrees)."""

    amplitude: float
    wavelength: float
    azimuth: float
    phase: float

    def __call__(self, xy: FloatArray) -> FloatArray:
        """Return the relief at plan positions (..., 2)."""
        a = np.radians(self.azimuth)
        along = xy[..., 0] * np.cos(a) + xy[..., 1] * np.sin(a)
        wave = self.amplitude * np.cos(2.0 * np.pi * along / self.wavelength + np.radians(self.phase))
        return np.asarray(wave, dtype=np.float64)


@dataclass(frozen=True)
class Regional:
    """The undisplaced horizon: a tilted plane with gentle relief.

    Parameters
    ----------
    elevation : float
        Elevation of the plane at ``centre``, m.
    slope : float
        Rise over run.
    azimuth : float
        Plan direction in which the plane rises, degrees counter-clockwise from east.
    centre : pair of float
        Plan position, m.
    relief : tuple of Wave
        Added to the plane.
    """

    elevation: float
    slope: float
    azimuth: float
    centre: tuple[float, float]
    relief: tuple[Wave, ...] = ()

    def __call__(self, xy: FloatArray) -> FloatArray:
        """Return the elevation at plan positions (..., 2)."""
        a = np.radians(self.azimuth)
        rise = (xy[..., 0] - self.centre[0]) * np.cos(a) + (xy[..., 1] - self.centre[1]) * np.sin(a)
        plane = self.elevation + self.slope * rise
        return np.asarray(plane + sum(wave(xy) for wave in self.relief), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class TrueFault:
    """A corrugated fault, z = elevation - tan(dip) (q - c(s)), and its throw.

    s runs along strike and q along the dip direction, both from ``centre``; the fault dips to the right of
    growing s. The corrugation c(s) runs parallel to dip; it is linear between ``columns``, where it takes the
    values of the smooth function :meth:`corrugation`, so that a triangulation with vertices on the columns is
    this very surface.

    Parameters
    ----------
    name : str
        Name.
    centre : pair of float
        Plan position of s = q = 0, m.
    azimuth : float
        Plan direction of dip, degrees counter-clockwise from east.
    dip : float
        Degrees.
    elevation : float
        Elevation at the centre, m.
    throw : float
        Vertical separation at s = 0, m; negative for a reverse fault.
    half_length : float
        Where the throw vanishes, m of s to either side.
    power : float
        p of the throw profile.
    columns : (k,) array
        s of the columns of the surface, m; its first and last are the surface's ends.
    amplitude, wavelength : float
        Of the corrugation, m.
    planar : float
        The corrugation sets in at this s (m); -inf for all of the fault.
    """

    name: str
    centre: tuple[float, float]
    azimuth: float
    dip: float
    elevation: float
    throw: float
    half_length: float
    power: float
    columns: FloatArray
    amplitude: float
    wavelength: float
    planar: float = -np.inf

    def __post_init__(self) -> None:
        object.__setattr__(self, "columns", floats(self.columns))

    @property
    def axes(self) -> tuple[FloatArray, FloatArray]:
        """Unit vectors along strike and along dip, shape (2,) each."""
        a = np.radians(self.azimuth)
        return floats([-np.sin(a), np.cos(a)]), floats([np.cos(a), np.sin(a)])

    @property
    def grade(self) -> float:
        """tan(dip)."""
        return float(np.tan(np.radians(self.dip)))

    def coordinates(self, xy: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return s and q of plan positions (..., 2)."""
        strike, down = self.axes
        dx, dy = xy[..., 0] - self.centre[0], xy[..., 1] - self.centre[1]
        s, q = dx * strike[0] + dy * strike[1], dx * down[0] + dy * down[1]
        return np.asarray(s, dtype=np.float64), np.asarray(q, dtype=np.float64)

    def position(self, s: FloatArray, q: FloatArray) -> FloatArray:
        """Return the plan positions of s and q, shape (..., 2)."""
        strike, down = self.axes
        x = self.centre[0] + s * strike[0] + q * down[0]
        y = self.centre[1] + s * strike[1] + q * down[1]
        return np.asarray(np.stack([x, y], axis=-1), dtype=np.float64)

    def corrugation(self, s: FloatArray) -> FloatArray:
        """Return the smooth corrugation c(s), m."""
        if np.isinf(self.planar):
            return np.asarray(self.amplitude * np.sin(2.0 * np.pi * s / self.wavelength), dtype=np.float64)
        turn = 2.0 * np.pi * np.maximum(s - self.planar, 0.0) / self.wavelength
        return np.asarray(self.amplitude * (1.0 - np.cos(turn)), dtype=np.float64)

    def elevation_at(self, s: FloatArray, q: FloatArray, *, smooth: bool = False) -> FloatArray:
        """Return the elevation of the fault, extended beyond its ends, m."""
        c = self.corrugation(s) if smooth else np.interp(s, self.columns, self.corrugation(self.columns))
        return np.asarray(self.elevation - self.grade * (q - c), dtype=np.float64)

    def separation(self, s: FloatArray) -> FloatArray:
        """Return T(s), m."""
        inside = np.maximum(1.0 - (s / self.half_length) ** 2, 0.0)
        return np.asarray(self.throw * inside**self.power, dtype=np.float64)


@dataclass(frozen=True)
class Branching:
    """A fault that exists on one side of another only: indices, and the side (+1 hanging, -1 foot)."""

    fault: int
    parent: int
    side: int


@dataclass(frozen=True, eq=False)
class Geology:
    """A regional horizon displaced by faults.

    Parameters
    ----------
    regional : Regional
        R.
    faults : tuple of TrueFault
        At most one may branch from another.
    branching : Branching or None
        Which one, and where.
    size : pair of float
        The domain is [0, size[0]] x [0, size[1]], m.
    """

    regional: Regional
    faults: tuple[TrueFault, ...]
    branching: Branching | None
    size: tuple[float, float]

    @cached_property
    def blocks(self) -> tuple[tuple[int, ...], ...]:
        """The signs of each block, one per fault: 1 hanging, -1 foot, 0 the fault does not reach it."""
        signs = [
            tuple(s) for s in 1 - 2 * np.indices((2,) * len(self.faults)).reshape(len(self.faults), -1).T
        ]
        b = self.branching
        if b is None:
            return tuple(tuple(int(v) for v in s) for s in signs)
        cut = [
            tuple(0 if f == b.fault and s[b.parent] != b.side else int(v) for f, v in enumerate(s))
            for s in signs
        ]
        return tuple(dict.fromkeys(cut))

    @cached_property
    def traces(self) -> tuple[CubicSpline, ...]:
        """q of each smooth fault's trace on the regional horizon, as a function of s."""
        s = np.arange(-_FAR, _FAR + _TRACE_STEP, _TRACE_STEP)
        return tuple(CubicSpline(s, _meeting(f, s, self.regional, smooth=True)) for f in self.faults)

    @cached_property
    def half_heaves(self) -> tuple[tuple[FloatArray, FloatArray], ...]:
        """s and half the heave (without sign) of each fault, were it alone."""
        result = []
        for i, f in enumerate(self.faults):
            s = np.arange(-f.half_length, f.half_length + CURVE_STEP, CURVE_STEP)
            lips = [
                self.lip(i, tuple(sign if g == i else 0 for g in range(len(self.faults))), s, smooth=True)
                for sign in (1, -1)
            ]
            result.append((s, 0.5 * np.abs(lips[0] - lips[1])))
        return tuple(result)

    def distance(self, fault: int, xy: FloatArray) -> FloatArray:
        """Return d, the signed distance across strike from the trace on the regional horizon, m."""
        s, q = self.faults[fault].coordinates(xy)
        return np.asarray(q - self.traces[fault](s), dtype=np.float64)

    def displacement(self, fault: int, xy: FloatArray) -> FloatArray:
        """Return F of a fault at plan positions (..., 2), m."""
        s, _ = self.faults[fault].coordinates(xy)
        field = self.faults[fault].separation(s) * np.exp(-((self.distance(fault, xy) / REACH) ** 2))
        if self.branching is not None and self.branching.fault == fault:
            parent = self.faults[self.branching.parent]
            along = parent.coordinates(xy)[0] / parent.half_length
            field = field * np.maximum(1.0 - along**2, 0.0) ** 1.5
        return np.asarray(field, dtype=np.float64)

    def horizon(self, signs: tuple[int, ...], xy: FloatArray) -> FloatArray:
        """Return the true horizon of a block, beyond its faults too, at plan positions (..., 2), m."""
        moved = sum(sign * self.displacement(f, xy) for f, sign in enumerate(signs))
        return np.asarray(self.regional(xy) - 0.5 * moved, dtype=np.float64)

    def seismic(self, xy: FloatArray) -> FloatArray:
        """Return the smeared horizon at plan positions (..., 2), m."""
        sides = [self._smeared_side(f, xy) for f in range(len(self.faults))]
        value = self.regional(xy)
        for f, side in enumerate(sides):
            share: FloatArray | float = 1.0
            if self.branching is not None and self.branching.fault == f:
                share = 0.5 * (1.0 + self.branching.side * sides[self.branching.parent])
            value = value - 0.5 * share * side * self.displacement(f, xy)
        return np.asarray(value, dtype=np.float64)

    def lip(self, fault: int, signs: tuple[int, ...], s: FloatArray, *, smooth: bool = False) -> FloatArray:
        """Return q at which the horizon of a block meets a fault, for each s, m."""
        f = self.faults[fault]
        return _meeting(f, s, lambda xy: self.horizon(signs, xy), smooth=smooth)

    def cutoffs(self, fault: int, signs: tuple[int, ...]) -> list[tuple[FloatArray, FloatArray]]:
        """Return the true cutoff lines of a block on a fault inside the domain.

        Returns
        -------
        list of (s, points)
            s (k,), every 10 m and at the ends, and points (k, 3), on the triangulated fault surface.
        """
        f = self.faults[fault]
        first, last = float(f.columns[0]), float(f.columns[-1])
        s = np.linspace(first, last, max(2, int(np.ceil((last - first) / CURVE_STEP)) + 1))
        belongs = self._belongs(fault, signs, s)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], belongs, [False]]).astype(np.int64)))
        curves = []
        for start, stop in edges.reshape(-1, 2):
            run = s[start:stop]
            if start > 0:
                run = np.concatenate([[self._end(fault, signs, s[start], s[start - 1])], run])
            if stop < len(s):
                run = np.concatenate([run, [self._end(fault, signs, s[stop - 1], s[stop])]])
            xy = f.position(run, self.lip(fault, signs, run))
            curves.append((floats(run), floats(np.column_stack([xy, self.horizon(signs, xy)]))))
        return curves

    def _belongs(self, fault: int, signs: tuple[int, ...], s: FloatArray) -> BoolArray:
        """Return whether the lip at each s lies in the domain and on the block's side of the other faults."""
        xy = self.faults[fault].position(s, self.lip(fault, signs, s))
        z = self.horizon(signs, xy)
        inside = ((xy >= 0.0) & (xy <= np.array(self.size))).all(axis=-1)
        for g, other in enumerate(self.faults):
            if g != fault and signs[g] != 0:
                inside &= signs[g] * (z - other.elevation_at(*other.coordinates(xy))) >= 0.0
        return np.asarray(inside, dtype=np.bool_)

    def _end(self, fault: int, signs: tuple[int, ...], inside: float, outside: float) -> float:
        """Return the s at which a lip leaves its block, between a place inside and one outside."""
        for _ in range(_BISECTIONS):
            middle = 0.5 * (inside + outside)
            if self._belongs(fault, signs, np.array([middle]))[0]:
                inside = middle
            else:
                outside = middle
        return inside

    def _smeared_side(self, fault: int, xy: FloatArray) -> FloatArray:
        """Return S of a fault: 1 far on the hanging side, -1 far on the foot side."""
        s, _ = self.faults[fault].coordinates(xy)
        half = np.maximum(np.interp(s, *self.half_heaves[fault]), _LEAST_HALF_HEAVE)
        d = self.distance(fault, xy)
        return np.asarray(
            (_mean_absolute(d + half) - _mean_absolute(d - half)) / (2.0 * half), dtype=np.float64
        )


def _meeting(
    fault: TrueFault, s: FloatArray, horizon: Callable[[FloatArray], FloatArray], *, smooth: bool
) -> FloatArray:
    """Return q where a horizon less steep than the fault meets it, for each s, by secants."""
    before = np.zeros(s.shape)
    above = horizon(fault.position(s, before)) - fault.elevation_at(s, before, smooth=smooth)
    q = before - above / fault.grade
    for _ in range(_SECANTS):
        now = horizon(fault.position(s, q)) - fault.elevation_at(s, q, smooth=smooth)
        rise = np.divide(now - above, q - before, out=np.full(s.shape, fault.grade), where=q != before)
        before, above, q = q, now, q - now / np.where(rise > 0.0, rise, fault.grade)
    return np.asarray(q, dtype=np.float64)


def _mean_absolute(x: FloatArray) -> FloatArray:
    """Return E|x + SMEAR Z|, Z standard normal."""
    t = x / (np.sqrt(2.0) * SMEAR)
    return np.asarray(x * erf(t) + SMEAR * np.sqrt(2.0 / np.pi) * np.exp(-(t**2)), dtype=np.float64)
