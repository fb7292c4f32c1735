"""LoopStructural as a peer: implicit surfaces, displaced by faults whose slip is an input.

It restores the data by the displacement of each fault, interpolates one scalar field through them, and
displaces that again. So a throw is not found but told: the largest slip along dip is here the true one,
largest throw / sin dip. How it dies out is a built-in profile, (1 - r^2)^2 along strike and a cubic across
that vanishes at ``reach``, or, with ``measured``, along strike what a spline shows.

What its version 1.9 does not do: where the data of one fault are restored by another, it stops with an
error, so faults that cross are built without each other; near their crossing, within the slip of one, points
change sides of the other. Its isosurface crosses each fault as a ramp a cell of its grid wide: it has no lips
of its own, and these are read off the scalar field on either side.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas

from graben.arrays import FloatArray, ints
from graben.surface import mean_dip_direction, strong_components
from graben.synthetic import TrueFault
from tests.bench import peer_spline
from tests.bench.peer_task import Task, meeting

#: The model reaches this far above and below the horizon, m: beyond all lips.
DEPTH = 500.0
#: A side of a fault is looked at this far from LoopStructural's own fault surface and twice as far, and led
#: on to it: nearer by, a displacement carries some points through that surface or another's, m.
ASIDE = 50.0
#: Rounds in which a point is brought onto LoopStructural's own fault surface, which lies within metres.
ROUNDS = 4
#: Elevations at which a column is looked at, and how far above and below the input, m.
COLUMN, SPAN = 41, 160.0
#: Only every so many nodes of grid and faults are told, as its unknowns lie further apart.
EVERY, EVERY_FAULT = 2, 3


@dataclass(frozen=True)
class Options:
    """How LoopStructural is set up.

    Parameters
    ----------
    reach : float
        Where the displacement has died out across the fault, m.
    regularisation : float
        Weight of smoothness of the horizon's scalar field.
    elements, fault_elements : int
        Cells of the scalar field of the horizon and of each coordinate of a fault.
    interpolator : str
        "FDI" (regular grid) or "PLI" (tetrahedra).
    measured : bool
        The share of the largest slip along strike is measured on the input, and not the built-in profile.
    """

    reach: float = 3000.0
    regularisation: float = 1.0
    elements: int = 50_000
    fault_elements: int = 20_000
    interpolator: str = "FDI"
    measured: bool = False


@dataclass(frozen=True, eq=False)
class Implicit:
    """A model of LoopStructural."""

    task: Task
    model: Any
    reach: float

    def pieces(self) -> int:
        """Return the number of connected pieces of the isosurface."""
        (surface,) = self.model["horizon"].surfaces(0.0)
        return int(strong_components(ints(surface.triangles)).max()) + 1

    def horizon(self, points: FloatArray) -> FloatArray:
        """Return the scalar field of the horizon at points (k, 3): about the height above it, m."""
        return np.asarray(self.model.evaluate_feature_value("horizon", points - _base(self.task)))

    def coordinate(self, fault: int, points: FloatArray) -> FloatArray:
        """Return the coordinate across a fault at points (k, 3), positive on the hanging side."""
        name = self.task.made.faults[fault].name
        field = self.model[name][0]
        return np.asarray(field.evaluate_value(points - _base(self.task), ignore_regions=True))

    def elevations(self, block: int, xy: FloatArray) -> FloatArray:
        """Return the elevation of a block at plan positions (k, 2), m."""
        signs = self.task.blocks[block]
        z = np.linspace(-SPAN, SPAN, COLUMN)
        level = _input_at(self.task, xy)
        columns = np.empty((len(xy), COLUMN, 3))
        columns[..., :2] = xy[:, None, :]
        columns[..., 2] = level[:, None] + z
        flat = columns.reshape(-1, 3)
        above = self.horizon(flat)
        own = np.isfinite(above)
        for f, sign in enumerate(signs):
            if sign != 0:
                own &= sign * self.coordinate(f, flat) >= 0.0
        above, own = above.reshape(-1, COLUMN), own.reshape(-1, COLUMN)
        return np.array(
            [_zero(c[k, 2], a[k]) for c, a, k in zip(columns, above, own, strict=True)], dtype=np.float64
        )

    def lip(self, fault: int, block: int, sections: list[FloatArray]) -> FloatArray:
        """Return where a block meets LoopStructural's own surface of a fault, near the sections, (k, 3)."""
        level = np.array([_at_input(self.task, s)[2] for s in sections])
        z = level[:, None] + np.linspace(-SPAN, SPAN, COLUMN)
        lines = np.stack(
            [
                np.column_stack([np.interp(at, s[:, 2], s[:, k]) for k in (0, 1)] + [at])
                for s, at in zip(sections, z, strict=True)
            ]
        )
        side = self.task.blocks[block][fault]
        near, far = (self._meeting(fault, side * k * ASIDE, lines) for k in (1, 2))
        return 2.0 * near - far

    def _meeting(self, fault: int, aside: float, lines: FloatArray) -> FloatArray:
        """Return where the horizon meets lines (k, m, 3) brought to a distance from the fault's surface."""
        surface = self.task.made.faults[fault]
        direction, _ = mean_dip_direction(surface.vertices, surface.triangles)
        flat = lines.reshape(-1, 3).copy()
        for _ in range(ROUNDS):
            here = self.coordinate(fault, flat)
            ahead = self.coordinate(fault, flat + np.array([*direction, 0.0]))
            goal = aside / self.reach
            flat[:, :2] += ((goal - here) / (ahead - here))[:, None] * direction
        above = self.horizon(flat).reshape(lines.shape[:2])
        moved = flat.reshape(lines.shape)
        return np.stack([meeting(line, over) for line, over in zip(moved, above, strict=True)])


def _zero(z: FloatArray, above: FloatArray) -> float:
    """Return the elevation at which a scalar field that grows upwards is zero, led on beyond the samples."""
    if len(z) < 2:
        return float("nan")
    k = int(np.clip(np.searchsorted(above, 0.0), 1, len(z) - 1))
    return float(z[k - 1] - above[k - 1] * (z[k] - z[k - 1]) / (above[k] - above[k - 1]))


def _input_at(task: Task, xy: FloatArray) -> FloatArray:
    """Return the elevation of the input's nearest node."""
    grid = task.made.grid
    i, j = (np.clip(np.rint((xy - grid.origin) / grid.step), 0, [grid.columns - 1, grid.rows - 1])).T
    return np.asarray(task.made.values[i.astype(int), j.astype(int)])


def fitted(task: Task, options: Options) -> Implicit:
    """Return the model that LoopStructural makes of the reliable nodes, the faults and their slips."""
    import LoopStructural

    made, step = task.made, task.made.grid.step
    size = [(made.grid.columns - 1) * step, (made.grid.rows - 1) * step, 2.0 * DEPTH + np.ptp(made.values)]
    model = LoopStructural.GeologicalModel([0.0, 0.0, 0.0], size)
    faults = [_fault_data(task, f) for f in range(len(made.faults))]
    model.data = pandas.concat([_horizon_data(task), *faults], ignore_index=True)
    for f in range(len(made.faults)):
        _add_fault(task, model, f, options)
    model.create_and_add_foliation(
        "horizon",
        nelements=options.elements,
        interpolatortype=options.interpolator,
        regularisation=options.regularisation,
    )
    return Implicit(task, model, options.reach)


def _base(task: Task) -> FloatArray:
    """Return where LoopStructural's coordinates begin: it takes the centre of a fault alone from there."""
    return np.array([*task.made.grid.origin, task.made.values.min() - DEPTH])


def slip(task: Task, fault: int) -> float:
    """Return the largest true slip of a fault along dip, m: throw / sin dip, negative for a reverse fault.

    The throw is the one it would have alone: beside a branch there is less or more of it.
    """
    geology = task.made.geology
    own = geology.faults[fault]
    throw = 2.0 * float(geology.half_heaves[fault][1].max()) * own.grade
    return float(np.copysign(throw / np.sin(np.radians(own.dip)), own.throw))


def _add_fault(task: Task, model: Any, f: int, options: Options) -> None:
    geology = task.made.geology
    fault, name = geology.faults[f], task.made.faults[f].name
    dip = np.radians(fault.dip)
    up_dip = np.array([*(-np.cos(dip) * fault.axes[1]), np.sin(dip)])
    model.create_and_add_fault(
        name,
        slip(task, f),
        nelements=options.fault_elements,
        interpolatortype=options.interpolator,
        fault_slip_vector=up_dip,
        fault_normal_vector=_normal(fault),
        fault_center=np.array([*fault.centre, fault.elevation]) - _base(task),
        major_axis=fault.half_length,
        minor_axis=2.0 * options.reach,  # its coordinate is 1 at half of it,
        intermediate_axis=fault.half_length,
        faultfunction=_profile(task, f, options),
        faults=[],
        force_mesh_geometry=True,
        fault_buffer=0.3,
    )
    branching = geology.branching
    if branching is not None and branching.fault == f:
        parent = model[task.made.faults[branching.parent].name]
        model[name].add_abutting_fault(parent, positive=branching.side > 0)


def _profile(task: Task, f: int, options: Options) -> Any:
    if not options.measured:
        return "BaseFault"
    from LoopStructural.modelling.features.fault._fault_function import BaseFault, FaultDisplacement

    return FaultDisplacement(gx=BaseFault.gxf, gz=_measured(task, f))


def _horizon_data(task: Task) -> pandas.DataFrame:
    i, j = np.indices((task.made.grid.columns, task.made.grid.rows)).reshape(2, -1)
    kept = task.reliable & (((i % EVERY == 0) & (j % EVERY == 0)) | (task.away < 1.5 * task.made.gamma))
    points = task.nodes[kept] - _base(task)
    frame = pandas.DataFrame(points, columns=["X", "Y", "Z"])
    frame["val"] = 0.0
    normals = _normals(task)[kept]
    for k, key in enumerate(("nx", "ny", "nz")):
        frame[key] = normals[:, k]
    thin = np.arange(len(frame)) % EVERY_FAULT != 0
    frame.loc[thin, ["nx", "ny", "nz"]] = np.nan
    frame["feature_name"] = "horizon"
    return frame


def _normals(task: Task) -> FloatArray:
    """Return gradients (slope, slope, 1) of the height above the horizon at its nodes, (n, 3)."""
    along = np.gradient(task.made.values, task.made.grid.step)
    return np.column_stack([-along[0].reshape(-1), -along[1].reshape(-1), np.ones(along[0].size)])


def _fault_data(task: Task, f: int) -> pandas.DataFrame:
    surface = task.made.faults[f]
    points = surface.vertices[::EVERY_FAULT] - _base(task)
    frame = pandas.DataFrame(points, columns=["X", "Y", "Z"])
    frame["val"], frame["coord"], frame["feature_name"] = 0.0, 0, surface.name
    up = _normal(task.made.geology.faults[f])
    for k, key in enumerate(("nx", "ny", "nz")):
        frame[key] = up[k]
    frame.loc[np.arange(len(frame)) % EVERY_FAULT != 0, ["nx", "ny", "nz"]] = np.nan
    return frame


def _normal(fault: TrueFault) -> FloatArray:
    """Return the mean unit normal of a fault, towards its hanging wall."""
    dip = np.radians(fault.dip)
    return np.array([*(np.sin(dip) * fault.axes[1]), np.cos(dip)])


def _measured(task: Task, f: int) -> Callable[[FloatArray], FloatArray]:
    """Return the share of the largest slip along strike that splines through the nodes show."""
    fault, splines = task.made.geology.faults[f], peer_spline.fitted(task, peer_spline.Options(around=False))
    along, jumps = [], []
    for _, hanging, foot, places in (pair for pair in task.facing() if pair[0] == f):
        xy = np.stack([_at_input(task, task.section(f, place))[:2] for place in places])
        along.append(-fault.coordinates(xy)[0] / fault.half_length)
        jumps.append(np.abs(splines.elevations(foot, xy) - splines.elevations(hanging, xy)))
    where, jump = np.concatenate(along), np.concatenate(jumps)
    order = np.argsort(where)
    ends = [[-1.0], [1.0]] if fault.columns[0] <= -fault.half_length else [[], [0.0]]
    where = np.concatenate([ends[0], where[order], ends[1]])
    jump = np.concatenate([np.zeros(len(ends[0])), jump[order], [0.0]])
    return lambda v: np.interp(v, where, jump / jump.max())


def _at_input(task: Task, section: FloatArray) -> FloatArray:
    """Return the point of a section of a fault where the input meets it."""
    return meeting(section, section[:, 2] - _input_at(task, section[:, :2]))
