"""Small models with a known answer, made anew: faults as offsets of lines in plan, blocks as functions.

A fault is ``q(x, y) = shift(z)``: q the signed distance in plan to the right of a line (straight or an arc),
the fault dipping to that side. ``shift`` may be anything, so a fault may be vertical, listric or overturned.
A block is the set of sides on which it lies, 1 to the right, -1 to the left, 0 where a fault does not bound
it. The true horizon of a block is the base moved down by 0.6 T(s) / cosh(q / reach) on the right of a fault
and up by 0.4 of it on the left. Its lip at s is the root of z = u(position(s, shift(z))): no curve is stored.

Seismic is the mean of the blocks, weighted by a ramp across each gap, under a moving average. Metres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.ndimage import uniform_filter
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.formats.irap import grid_surface
from graben.model import Fault, GridGeometry, Horizon, Model
from graben.modeling.results import HorizonResult
from graben.proximity import nearest
from graben.settings import Parameters
from graben.surface import Surface, mean_dip_direction
from tests.models import grid_triangles

HANGING_SHARE = 0.6  #: of the throw that the hanging side goes down; the foot goes up by the rest
LEAST_SHARE = 0.2  #: cut nodes count where the true throw exceeds this share of the largest
_FINE = 5  # samples of the seismic on a step of its grid
_ROOTS = 60  # steps of a fixed point that halve the error at least
_BRANCH = 40  # bisections of the place at which a branch meets its parent

Along = Callable[[FloatArray], FloatArray]
Height = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class Straight:
    """A line through ``start`` whose way goes to ``azimuth``, degrees counter-clockwise from east."""

    start: tuple[float, float]
    azimuth: float

    def coordinates(self, xy: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return s along the line and q to its right."""
        a = np.radians(self.azimuth)
        x, y = xy[..., 0] - self.start[0], xy[..., 1] - self.start[1]
        return x * np.cos(a) + y * np.sin(a), x * np.sin(a) - y * np.cos(a)

    def position(self, s: FloatArray, q: FloatArray) -> FloatArray:
        """Return plan positions (..., 2)."""
        a = np.radians(self.azimuth)
        x = self.start[0] + s * np.cos(a) + q * np.sin(a)
        return np.stack([x, self.start[1] + s * np.sin(a) - q * np.cos(a)], axis=-1)


@dataclass(frozen=True)
class Arc:
    """A circle; s = 0 at the angle ``middle`` (degrees), ``turn`` 1 counter-clockwise, -1 clockwise."""

    centre: tuple[float, float]
    radius: float
    middle: float
    turn: int = 1

    def coordinates(self, xy: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return s along the arc and q to its right."""
        x, y = xy[..., 0] - self.centre[0], xy[..., 1] - self.centre[1]
        angle = np.angle(np.exp(1j * (np.arctan2(y, x) - np.radians(self.middle))))
        return self.turn * self.radius * angle, self.turn * (np.hypot(x, y) - self.radius)

    def position(self, s: FloatArray, q: FloatArray) -> FloatArray:
        """Return plan positions (..., 2)."""
        angle = np.radians(self.middle) + self.turn * s / self.radius
        r = self.radius + self.turn * q
        return np.stack([self.centre[0] + r * np.cos(angle), self.centre[1] + r * np.sin(angle)], axis=-1)


def dipping(dip: float, level: float = 0.0) -> Along:
    """A plane of this dip that passes under its line at ``level``."""
    return lambda z: (level - z) / np.tan(np.radians(dip))


def listric(top: float, bottom: float, high: float, low: float, level: float) -> Along:
    """A dip that goes linearly from ``top`` degrees at elevation ``high`` to ``bottom`` at ``low``.

    The fault passes under its line at ``level``.
    """
    rate = np.radians(top - bottom) / (high - low)

    def cotangents(z: FloatArray | float) -> FloatArray:
        return np.asarray(np.log(np.sin(np.radians(top) + rate * (z - high))) / rate)

    return lambda z: cotangents(level) - cotangents(z)


def overturned(dip: float, level: float, height: float) -> Along:
    """A fault that is vertical at ``level`` and dips to the right below it, to the left above.

    ``dip`` is that ``height`` away from there, degrees.
    """
    return lambda z: (z - level) ** 2 / (2.0 * height * np.tan(np.radians(dip)))


def bump(throw: float, half: float, middle: float = 0.0) -> Along:
    """A throw that dies out smoothly at ``half`` to either side."""
    return lambda s: throw * np.maximum(1.0 - ((s - middle) / half) ** 2, 0.0) ** 1.5


def steady(throw: float) -> Along:
    """A throw that is the same all along."""
    return lambda s: np.full(np.shape(s), throw)


@dataclass(frozen=True)
class Parent:
    """Where a branch ends: the fault, its side with the branch, which end that is, and m gone beyond."""

    fault: int
    side: int
    at_start: bool = True
    beyond: float = 0.0


@dataclass(frozen=True)
class Known:
    """A fault: see the module.

    Parameters
    ----------
    name, line, shift, throw
        What it is.
    span : pair of float
        s of its ends; that at a parent is only where the search for the parent starts.
    parents : tuple of Parent
        What it ends on.
    spacing : float
        Of its triangulation along strike, m.
    reach : float
        Over which displacement dies out, m.
    gamma : float, optional
        Its own.
    start : callable, optional
        s of its first end at each elevation, where that is not the same for all.
    """

    name: str
    line: Straight | Arc
    shift: Along
    throw: Along
    span: tuple[float, float]
    parents: tuple[Parent, ...] = ()
    spacing: float = 150.0
    reach: float = 1500.0
    gamma: float | None = None
    start: Along | None = None

    def side(self, points: FloatArray) -> FloatArray:
        """Return how far points (n, 3) lie to the right of the fault in plan."""
        return self.line.coordinates(points[..., :2])[1] - self.shift(points[..., 2])

    def place(self, s: FloatArray, z: FloatArray) -> FloatArray:
        """Return the points of the fault, (..., 3)."""
        return np.concatenate([self.line.position(s, self.shift(z)), z[..., None]], axis=-1)

    def displacement(self, sign: int, xy: FloatArray) -> FloatArray:
        """Return by how much the fault lifts the horizon on one of its sides."""
        if sign == 0:
            return np.zeros(xy.shape[:-1])
        s, q = self.line.coordinates(xy)
        share = -HANGING_SHARE if sign > 0 else 1.0 - HANGING_SHARE
        return np.asarray(share * self.throw(s) / np.cosh(q / self.reach))


@dataclass(frozen=True)
class Answer:
    """A model with a known answer.

    Parameters
    ----------
    base : callable
        The horizon without faults.
    faults : sequence of Known
        In the model's order; a parent before its branches.
    size : pair of float
        Of the domain, from (0, 0), m.
    gamma, step, smear : float
        Of the model; the smear is the width of the moving average, m.
    blocks : dict of signs to callable, optional
        Heights of the blocks relative to the base, where displacement fields do not make them.
    depth : float
        How far the faults reach above and below the base in the domain, m.
    undefined : callable, optional
        Which plan positions are undefined in the grid.
    """

    base: Height
    faults: Sequence[Known]
    size: tuple[float, float] = (6000.0, 6000.0)
    gamma: float = 400.0
    step: float = 120.0
    smear: float = 120.0
    blocks: dict[tuple[int, ...], Height] | None = None
    depth: float = 500.0
    undefined: Callable[[FloatArray], BoolArray] | None = None

    def signs(self) -> list[tuple[int, ...]]:
        """Return the sides of every block."""
        if self.blocks is not None:
            return list(self.blocks)
        found: list[tuple[int, ...]] = []
        for whole in product((1, -1), repeat=len(self.faults)):
            sides = list(whole)
            for k, fault in enumerate(self.faults):
                if any(sides[p.fault] != p.side for p in fault.parents):
                    sides[k] = 0
            found.append(tuple(sides))
        return list(dict.fromkeys(found))

    def height(self, signs: tuple[int, ...], xy: FloatArray) -> FloatArray:
        """Return the true horizon of a block, beyond its faults too."""
        if self.blocks is not None:
            return np.asarray(self.base(xy) + self.blocks[signs](xy))
        return np.asarray(
            self.base(xy) + sum(f.displacement(s, xy) for f, s in zip(self.faults, signs, strict=True))
        )

    def lip(self, fault: int, signs: tuple[int, ...], s: FloatArray) -> FloatArray:
        """Return the elevation at which a block meets a fault, for each s."""
        known = self.faults[fault]
        z = self.base(known.line.position(s, np.zeros(s.shape)))
        for _ in range(_ROOTS):
            z = 0.5 * (z + self.height(signs, known.place(s, z)[..., :2]))
        return np.asarray(z)

    def seismic(self, xy: FloatArray) -> FloatArray:
        """Return the blocks joined by ramps, without the moving average."""
        level = self.base(xy)
        weights, total = np.zeros(level.shape), np.zeros(level.shape)
        soft = [self._soft(f, xy, level) for f in self.faults]
        for signs in self.signs():
            weight = np.ones(level.shape)
            for side, sign in zip(soft, signs, strict=True):
                weight *= 1.0 if sign == 0 else 0.5 * (1.0 + sign * side)
            weights += weight
            total += weight * self.height(signs, xy)
        return np.asarray(total / weights)

    def _soft(self, fault: Known, xy: FloatArray, level: FloatArray) -> FloatArray:
        throw = fault.throw(fault.line.coordinates(xy)[0])
        foot = fault.shift(level + (1 - HANGING_SHARE) * throw)
        hanging = fault.shift(level - HANGING_SHARE * throw)
        half = np.maximum(0.5 * np.abs(hanging - foot), 1.0)
        off = fault.line.coordinates(xy)[1] - 0.5 * (foot + hanging)
        return np.asarray(np.clip(off / half, -1.0, 1.0))

    def grid(self) -> tuple[GridGeometry, FloatArray]:
        """Return the grid of the smeared horizon and its values."""
        fine, pad = self.step / _FINE, 2 * _FINE
        count = [round(extent / self.step) + 1 for extent in self.size]
        axes = [(np.arange((n - 1) * _FINE + 1 + 2 * pad) - pad) * fine for n in count]
        values = self.seismic(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1))
        window = max(1, round(self.smear / fine))
        smooth = uniform_filter(values, window + 1 - window % 2)
        grid = GridGeometry(count[0], count[1], self.step, self.step, (0.0, 0.0))
        values = smooth[pad:-pad:_FINE, pad:-pad:_FINE].copy()
        if self.undefined is not None:
            values[self.undefined(grid.nodes())] = np.nan
        return grid, values

    def surfaces(self) -> list[Surface]:
        """Return the faults triangulated: columns along strike, rows of one elevation."""
        corner = np.array([[x, y] for x in (0.0, self.size[0]) for y in (0.0, self.size[1])])
        levels = self.base(np.concatenate([corner, [np.divide(self.size, 2)]]))
        z = np.arange(levels.min() - self.depth, levels.max() + self.depth + 50.0, 100.0)
        return [self._surface(fault, z) for fault in self.faults]

    def _surface(self, fault: Known, z: FloatArray) -> Surface:
        first, last = (np.full(len(z), end) for end in fault.span)
        first = first if fault.start is None else fault.start(z)
        for parent in fault.parents:
            near, far = (first, last) if parent.at_start else (last, first)
            end = self._on_parent(fault, parent, z, near, far)
            first, last = (end, last) if parent.at_start else (first, end)
        columns = round(float(np.max(last - first)) / fault.spacing) + 1
        share = np.linspace(0.0, 1.0, columns)[:, None]
        s = (1 - share) * first + share * last
        points = fault.place(s, np.broadcast_to(z, s.shape)).reshape(-1, 3)
        return Surface(fault.name, points, grid_triangles(columns, len(z)))

    def _on_parent(
        self, fault: Known, parent: Parent, z: FloatArray, near: FloatArray, far: FloatArray
    ) -> FloatArray:
        """Return the s at which a branch meets its parent at each elevation, gone ``beyond`` it."""
        other = self.faults[parent.fault]
        inside, out = far.copy(), near.copy()
        assert (parent.side * other.side(fault.place(out, z)) <= 0).all(), fault.name
        assert (parent.side * other.side(fault.place(inside, z)) >= 0).all(), fault.name
        for _ in range(_BRANCH):
            middle = 0.5 * (inside + out)
            on = parent.side * other.side(fault.place(middle, z)) >= 0
            inside, out = np.where(on, middle, inside), np.where(on, out, middle)
        return np.asarray(0.5 * (inside + out) + parent.beyond * np.sign(near - far))

    def model(self, name: str = "known", **parameters: object) -> Model:
        """Return the model in memory."""
        grid, values = self.grid()
        horizon = Horizon("Top", grid_surface("Top", grid, values), self.step, grid)
        faults = tuple(Fault(s, k.gamma) for s, k in zip(self.surfaces(), self.faults, strict=True))
        settings = Parameters.model_validate({"gamma": self.gamma, **parameters})
        return Model(name, (horizon,), faults, parameters=settings)


@dataclass(frozen=True)
class Figures:
    """How far a rebuilt horizon is from the known answer.

    Root mean squares and the worst of the cutoffs and throws, m; ``off`` the largest distance of a cut node
    from its fault, m; ``turned`` triangles, of each subdomain its type and iterations; ``nodes`` compared.
    """

    cutoff: float
    worst: float
    throw: float
    largest: float
    off: float
    turned: int
    types: tuple[int, ...]
    iterations: tuple[int, ...]
    nodes: int
    place: tuple[float, ...] = ()

    def __str__(self) -> str:
        share = 100.0 / self.largest
        return (
            f"cutoffs {self.cutoff:.2f} m ({self.cutoff * share:.1f} %, worst {self.worst:.1f} m at "
            f"{self.place}), throw {self.throw:.2f} m ({self.throw * share:.1f} %), off {self.off:.1e} m, "
            f"{self.turned} turned, types {self.types} in {self.iterations}, {self.nodes} nodes"
        )


def figures(answer: Answer, result: HorizonResult, faults: Sequence[Fault]) -> Figures:
    """Compare a result, in the frame of the answer, node by node of its cutoffs."""
    names = [f.name for f in answer.faults]
    turned = _turned(answer, faults)
    lips: dict[int, list[FloatArray]] = {1: [], -1: []}
    truth: dict[int, list[FloatArray]] = {1: [], -1: []}
    off = 0.0
    for cutoff in result.cutoffs:
        fault = names.index(cutoff.fault)
        surface = faults[[f.name for f in faults].index(cutoff.fault)].surface
        for side, points in ((1, cutoff.hanging), (-1, cutoff.foot)):
            off = max(off, float(nearest(points, surface.vertices, surface.triangles).distance.max()))
            lips[side].append(points)
            truth[side].append(_true(answer, result, turned, fault, side, points))
    whole = {side: np.concatenate(lips[side]) for side in lips}
    true = {side: np.concatenate(truth[side]) for side in truth}
    thrown = np.abs(true[-1] - true[1])
    largest = float(thrown.max())
    counted = thrown > LEAST_SHARE * largest
    wrong = {side: (whole[side][:, 2] - true[side])[counted] for side in (1, -1)}
    both = np.concatenate([wrong[1], wrong[-1]])
    where = np.concatenate([whole[1][counted], whole[-1][counted]])[np.argmax(np.abs(both))]
    v = result.surface.vertices[result.surface.triangles]
    a, b = v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]
    return Figures(
        float(np.sqrt((both**2).mean())),
        float(np.abs(both).max()),
        float(np.sqrt(((wrong[-1] - wrong[1]) ** 2).mean())),
        largest,
        off,
        int((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] <= 0).sum()),
        tuple(int(s.termination.type) for s in result.subdomains),
        tuple(s.iterations for s in result.subdomains),
        int(counted.sum()),
        tuple(np.round(where).tolist()),
    )


def _turned(answer: Answer, faults: Sequence[Fault]) -> IntArray:
    """Return 1 for each fault whose mean dip is to the right of its line, -1 for the others."""
    told = []
    for known, fault in zip(answer.faults, faults, strict=True):
        middle = 0.5 * np.array([sum(known.span)])
        right = known.line.position(middle, np.array([1.0])) - known.line.position(middle, np.zeros(1))
        dip = mean_dip_direction(fault.surface.vertices, fault.surface.triangles)[0]
        told.append(1 if float(right[0] @ dip) > 0 else -1)
    return np.array(told, dtype=np.int64)


def _true(
    answer: Answer, result: HorizonResult, turned: IntArray, fault: int, side: int, points: FloatArray
) -> FloatArray:
    """Return the true elevation of each node of a lip, (k,), at its own place along the fault."""
    names = [f.name for f in answer.faults]
    column = result.graph_faults.index(names[fault])
    mine = np.flatnonzero(result.block[:, column] == side)
    if len(mine) == 0:
        mine = np.arange(len(result.block))
    copies = mine[cKDTree(result.surface.vertices[mine]).query(points)[1]]
    middle = _middles(result)[copies]
    sides = np.stack([np.sign(known.side(middle)) for known in answer.faults], axis=1).astype(np.int64)
    side *= int(turned[fault])
    sides[:, fault] = side
    s = answer.faults[fault].line.coordinates(points[:, :2])[0]
    z = np.full(len(points), np.nan)
    for signs in answer.signs():
        if signs[fault] != side:
            continue
        fits = _fit(sides, signs)
        z[fits] = answer.lip(fault, signs, s[fits])
    return z


def _middles(result: HorizonResult) -> FloatArray:
    """Return the middle of the triangles around each node before the cut moved: in its own sector, (n, 3)."""
    faces = result.surface.triangles
    total = np.zeros((len(result.first), 3))
    np.add.at(total, faces.ravel(), np.repeat(result.first[faces].mean(axis=1), 3, axis=0))
    return np.asarray(total / np.bincount(faces.ravel(), minlength=len(total))[:, None])


def _fit(sides: IntArray, signs: tuple[int, ...]) -> BoolArray:
    """Return which rows of sides (k, f) belong to a block."""
    told = np.array(signs)
    return np.asarray(((told == 0) | (sides == told)).all(axis=1))
