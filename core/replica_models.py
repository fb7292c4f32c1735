"""Synthetic models with the figures of the paper's Table 2 and a known answer.

A field consists of clusters of faults that meet (one fault, two that cross, one with its branch, one crossed
by several), each the geology of ``graben.synthetic`` on the same regional horizon R. With u_c the horizon of
cluster c alone, seismic shows R + sum_c (u_c - R), each u_c smeared. Beside the faults of one cluster the
others are smooth: seismic shows them as they are there, and the truth of the cluster is its own horizon plus
the sum of u_c - R over the others.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from graben.arrays import FloatArray, floats
from graben.demo import noisy, require_noise
from graben.demo_model import HORIZON, MARGIN, Frame, SyntheticModel
from graben.demo_surfaces import SPACING, joined, sheet
from graben.formats.irap import grid_surface
from graben.model import Fault, GridGeometry, Horizon, Model
from graben.replica_list import Replica
from graben.settings import Parameters
from graben.surface import Surface
from graben.synthetic import SMEAR, Branching, Geology, Regional, TrueFault, Wave

LEVEL = -2500.0  #: mean elevation of the horizon, m
_RELIEF = ((12.0, 6500.0), (8.0, 5000.0))  # amplitudes and wavelengths, m
_TRACE_STEP = 50.0  # as in graben.synthetic, m
_TRACE_ROUNDS = 60  # each gains a digit where the horizon is a tenth as steep as the fault
_TILT = 10.0  # the horizon rises across the rows to within this, so along few faults, degrees
# between faults that cross: flatter ones at sharper angles have no clear traces, degrees
_TURN = (72.0, 88.0)
_BEYOND = 1500.0  # a dividing fault's surface reaches this far beyond the domain, m
_JITTER = 250.0  # of a fault's middle about that of its cell, m
_BRANCH_BACK = 900.0  # a fault with a branch is set back by this to keep the branch in the cell, m
_REACH = 700.0  # faults reach about this far above and below their middle, m
_UNSEEN = 1e-6  # elevation below which a far cluster is left out of another's truth, m
_SMEARS = 3.0  # the zone holds this many widths of the smear, and half the heave


@dataclass(frozen=True, eq=False)
class Cluster(Geology):
    """Faults that meet, in a domain of any width."""

    @cached_property
    def traces(self) -> tuple[CubicSpline, ...]:
        """q of each smooth fault's trace on the regional horizon, as far as the domain is wide."""
        far = float(np.hypot(*self.size)) + max(f.half_length for f in self.faults)
        s = np.arange(-far, far + _TRACE_STEP, _TRACE_STEP)
        return tuple(CubicSpline(s, self._trace(f, s)) for f in self.faults)

    def _trace(self, fault: TrueFault, s: FloatArray) -> FloatArray:
        bend = fault.corrugation(s)
        q = np.zeros_like(s)
        for _ in range(_TRACE_ROUNDS):
            q = bend + (fault.elevation - self.regional(fault.position(s, q))) / fault.grade
        return floats(q)

    def added(self, xy: FloatArray) -> FloatArray:
        """Return what seismic shows of the displacement at plan positions (..., 2), m."""
        return floats(self.seismic(xy) - self.regional(xy))


@dataclass(frozen=True, eq=False)
class Beside(Cluster):
    """The truth of a cluster among others."""

    others: tuple[Cluster, ...] = ()

    def horizon(self, signs: tuple[int, ...], xy: FloatArray) -> FloatArray:
        """Return the true horizon of a block at plan positions (..., 2), m."""
        return floats(super().horizon(signs, xy) + sum(other.added(xy) for other in self.others))


@dataclass(frozen=True)
class Window(Frame):
    """The frame of a part of the domain: ``low`` and ``high`` corners, m."""

    low: tuple[float, float] = (0.0, 0.0)
    high: tuple[float, float] = (0.0, 0.0)

    def grid(self, step: float) -> GridGeometry:
        """Return the grid over the window."""
        columns, rows = (round((b - a) / step) + 1 for a, b in zip(self.low, self.high, strict=True))
        return GridGeometry(columns, rows, step, step, self.low)


@dataclass(frozen=True, eq=False)
class Field:
    """A replica: its clusters, their surfaces, gamma of each fault (m), the horizon's grid, values and noise.

    ``values`` hold the noise, of which ``noise`` is the standard deviation, m.
    """

    replica: Replica
    clusters: tuple[Cluster, ...]
    surfaces: tuple[tuple[Surface, ...], ...]
    gammas: tuple[tuple[float, ...], ...]
    grid: GridGeometry
    values: FloatArray
    noise: float = 0.0

    @property
    def faults(self) -> tuple[Fault, ...]:
        """The faults of all clusters, each with its gamma."""
        return tuple(
            Fault(s, gamma)
            for surfaces, gammas in zip(self.surfaces, self.gammas, strict=True)
            for s, gamma in zip(surfaces, gammas, strict=True)
        )

    def model(self, **parameters: object) -> Model:
        """Return the model."""
        surface = grid_surface(HORIZON, self.grid, self.values)
        horizon = Horizon(HORIZON, surface, self.grid.step, self.grid)
        settings = Parameters.model_validate(parameters)
        return Model(self.replica.name, (horizon,), self.faults, parameters=settings)

    def parts(self) -> Iterator[SyntheticModel]:
        """Yield each cluster, with its truth and its window of the horizon."""
        for number, cluster in enumerate(self.clusters):
            gamma = max(self.gammas[number])
            lines = [f.position(f.columns, trace(f.columns)) for f, trace in _traced(cluster)]
            points = np.concatenate(lines)
            step, size = self.grid.step, np.array(self.replica.size)
            low = np.clip(step * np.floor((points.min(axis=0) - 3.0 * gamma) / step), 0.0, size)
            high = np.clip(step * np.ceil((points.max(axis=0) + 3.0 * gamma) / step), 0.0, size)
            frame = Window(low=(low[0], low[1]), high=(high[0], high[1]))
            i, j = np.round(low / step).astype(int)
            grid = frame.grid(step)
            nodes = grid.nodes()
            others = tuple(
                c for c in self.clusters if c is not cluster and np.abs(c.added(nodes)).max() > _UNSEEN
            )
            truth = Beside(cluster.regional, cluster.faults, cluster.branching, cluster.size, others)
            values = self.values[i : i + grid.columns, j : j + grid.rows]
            yield SyntheticModel(
                f"{self.replica.name}-{number}",
                grid,
                floats(values),
                self.surfaces[number],
                gamma,
                self.noise,
                truth,
                frame,
            )


def field(replica: Replica, seed: int, noise: float = 0.0) -> Field:
    """Return a replica; the seed decides on places, strikes, dips, throws and the noise.

    ``noise``: standard deviation, m; raises InputError where it or the seed is negative or no number.
    """
    require_noise(noise, seed)
    random = np.random.default_rng(seed)
    made = [triangulated(c) for c in Draft(replica, random).clusters()]
    clusters = tuple(c for c, _ in made)
    step = replica.step
    columns, rows = (round(extent / step) + 1 for extent in replica.size)
    grid = GridGeometry(columns, rows, step, step, (0.0, 0.0))
    nodes = grid.nodes()
    values = floats(clusters[0].regional(nodes) + sum(c.added(nodes) for c in clusters))
    gammas = tuple(tuple(_gamma(replica, f) for f in c.faults) for c in clusters)
    surfaces = tuple(s for _, s in made)
    return Field(replica, clusters, surfaces, gammas, grid, noisy(values, noise, seed), noise)


class Draft:
    """The faults of a replica, drawn cell by cell."""

    def __init__(self, replica: Replica, random: np.random.Generator) -> None:
        self._replica, self._random = replica, random
        self._made = 0
        self._dips = _dips(replica, random)
        self._regional = Regional(
            LEVEL,
            replica.slope,
            self._azimuth(_TILT),
            (0.5 * replica.size[0], 0.5 * replica.size[1]),
            tuple(Wave(a, w, *random.uniform(0.0, 360.0, 2).tolist()) for a, w in _RELIEF),
        )

    def clusters(self) -> list[Cluster]:
        """Return the clusters in a random order of rows and cells."""
        r, random = self._replica, self._random
        rows = random.permutation(r.rows)
        dividing, rest = rows[: len(r.crossed)], rows[len(r.crossed) :]
        cells = random.permutation([(column, row) for row in rest for column in range(r.across)])
        kinds = [self._branching] * r.branchings + [self._crossing] * r.crossings
        meeting = r.branchings + r.crossings
        made = [
            make(self._middle(*cell)) for make, cell in zip(kinds, cells[:meeting].tolist(), strict=False)
        ]
        made += [self._dividing(float(row), count) for row, count in zip(dividing, r.crossed, strict=True)]
        return made + [
            self._alone(self._middle(*cell)) for cell in cells[meeting : meeting + r.alone].tolist()
        ]

    def _middle(self, column: float, row: float) -> FloatArray:
        middle = (np.array([column, row]) + 0.5) * self._replica.cell
        return floats(middle + self._random.uniform(-_JITTER, _JITTER, 2))

    def _cluster(self, *faults: TrueFault, branching: Branching | None = None) -> Cluster:
        return Cluster(self._regional, faults, branching, self._replica.size)

    def _fault(
        self, middle: FloatArray, azimuth: float, half_length: float, *, meets: bool = False
    ) -> TrueFault:
        """Return a fault; one that meets others has the steepest of the dips left, and a throw to suit."""
        self._made += 1
        r = self._replica
        return TrueFault(
            name=f"F{self._made}",
            centre=(float(middle[0]), float(middle[1])),
            azimuth=azimuth,
            dip=self._dips.pop(-1 if meets else int(self._random.integers(len(self._dips)))),
            elevation=float(self._regional(middle)),
            throw=float(self._random.uniform(*(r.meeting_throws if meets else r.throws))),
            half_length=half_length,
            power=1.5,
            columns=_columns(-half_length, half_length),
            amplitude=30.0,
            wavelength=2000.0,
        )

    def _azimuth(self, spread: float) -> float:
        """Return the azimuth of the dip of a fault that strikes along the rows, and dips to either side."""
        return float(self._random.choice([90.0, 270.0]) + self._random.uniform(-spread, spread))

    def _alone(self, middle: FloatArray) -> Cluster:
        return self._cluster(self._fault(middle, self._azimuth(25.0), self._random.uniform(1400.0, 1900.0)))

    def _crossing(self, middle: FloatArray) -> Cluster:
        azimuth = self._azimuth(10.0)
        first = self._fault(middle, azimuth, self._random.uniform(1600.0, 1900.0), meets=True)
        turn = self._random.uniform(*_TURN) * self._random.choice([-1.0, 1.0])
        offset = self._random.uniform(-_JITTER, _JITTER, 2)
        length = self._random.uniform(1500.0, 1800.0)
        second = self._fault(floats(middle + offset), azimuth + turn, length, meets=True)
        return self._cluster(first, second)

    def _branching(self, middle: FloatArray) -> Cluster:
        side = int(self._random.choice([-1, 1]))
        azimuth = self._azimuth(10.0)
        way = side * np.array([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth))])
        centre = floats(middle - _BRANCH_BACK * way)
        main = self._fault(centre, azimuth, self._random.uniform(1700.0, 2000.0), meets=True)
        turn = self._random.uniform(10.0, 25.0) * self._random.choice([-1.0, 1.0])
        half_length = self._random.uniform(2200.0, 2600.0)
        branch = self._fault(centre, azimuth + turn - 90.0 * side, half_length, meets=True)
        planar = 2.0 * SPACING + _REACH / main.grade
        columns = floats([-planar, *_columns(planar, half_length)])
        branch = replace(branch, columns=columns, planar=planar)
        return self._cluster(main, branch, branching=Branching(1, 0, side))

    def _dividing(self, row: float, count: int) -> Cluster:
        width, random = self._replica.size[0], self._random
        middle = self._middle(0.5 * self._replica.across - 0.5, row)
        main = self._fault(middle, self._azimuth(2.5), 0.8 * width, meets=count > 0)
        end = 0.5 * width + _BEYOND
        main = replace(main, columns=_columns(-end, end))
        trace = self._cluster(main).traces[0]
        faults = [main]
        for place in range(count):
            s = width * ((place + 0.5) / count - 0.5) + random.uniform(-_JITTER, _JITTER)
            middle = main.position(np.array(s), trace(s))
            turn = random.uniform(*_TURN) * random.choice([-1.0, 1.0])
            faults.append(
                self._fault(middle, main.azimuth + turn, random.uniform(1500.0, 1800.0), meets=True)
            )
        return self._cluster(*faults)


def _columns(first: float, last: float) -> FloatArray:
    return floats(np.linspace(first, last, round((last - first) / SPACING) + 1))


def _dips(replica: Replica, random: np.random.Generator) -> list[float]:
    """Return dips in rising order whose least and mean are those of the replica, degrees."""
    count = replica.faults - 1
    shares = (np.arange(count) + random.uniform(0.0, 1.0, count)) / count
    mean = (replica.faults * replica.mean_dip - replica.least_dip) / count
    above = shares / shares.mean() * (mean - replica.least_dip)
    return [replica.least_dip, *(replica.least_dip + above).tolist()]


def _gamma(replica: Replica, fault: TrueFault) -> float:
    """Return the half-width of a fault's zone: what the smear and the heave ask for, within the range, m."""
    needed = _SMEARS * SMEAR + 0.5 * fault.throw / fault.grade
    least, most = replica.gamma
    return replica.step * float(np.clip(needed / replica.step, least, most))


def _traced(cluster: Cluster) -> Iterator[tuple[TrueFault, CubicSpline]]:
    return zip(cluster.faults, cluster.traces, strict=True)


def triangulated(cluster: Cluster) -> tuple[Cluster, tuple[Surface, ...]]:
    """Return a cluster whose faults are the given triangulations, and these."""
    separation = 0.5 * sum(abs(f.throw) for f in cluster.faults)
    spans = [_span(cluster, f, trace, separation) for f, trace in _traced(cluster)]
    if cluster.branching is None:
        return cluster, tuple(sheet(f, *span) for f, span in zip(cluster.faults, spans, strict=True))
    low, high = min(s[0] for s in spans), max(s[1] for s in spans)
    main, branch = cluster.faults
    pair = joined(main, branch, low, high)
    return replace(cluster, faults=(pair.main, pair.branch)), (pair.main_surface, pair.branch_surface)


def _span(cluster: Cluster, fault: TrueFault, trace: CubicSpline, separation: float) -> tuple[float, float]:
    """Return the least and greatest elevation of a fault's surface: beyond either lip by the margin, m."""
    z = fault.elevation_at(fault.columns, trace(fault.columns))
    return float(z.min()) - separation - MARGIN, float(z.max()) + separation + MARGIN
