"""What every method is given to rebuild a model with a known answer, and how its answer is judged.

All get the same: the grid nodes further than gamma in plan from the traces of the faults, which side of each
fault they lie on, and the triangulated faults. All are scored by ``graben.modeling.scoring``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Protocol

import numpy as np
import shapely
import trimesh

from graben import demo
from graben.arrays import BoolArray, FloatArray, IntArray
from graben.model import Model
from graben.modeling.results import Cutoff, HorizonResult, Score
from graben.modeling.scoring import score
from graben.surface import Surface, mean_dip_direction
from tests.models import model_of_demo

#: Places along strike lie a step of the grid apart, as the nodes of a cut do.
STEP = 100.0
#: A true lip that ends with less throw ends at a tip, m; one that leaves the domain has tens of metres there.
CLOSED = 1.0
#: A tip is judged this far inside it, where the section of the fault is one line, m.
INSIDE = 1.0


class Rebuilt(Protocol):
    """A horizon rebuilt by some method."""

    def elevations(self, block: int, xy: FloatArray) -> FloatArray:
        """Return the elevation of a block at plan positions (k, 2), m."""
        ...

    def lip(self, fault: int, block: int, sections: list[FloatArray]) -> FloatArray:
        """Return where a block meets a fault, (k, 3), one point on each section (m, 3) of the fault."""
        ...

    def pieces(self) -> int:
        """Return the number of connected pieces of its surface as it comes."""
        ...


@dataclass(frozen=True, eq=False)
class Task:
    """A model to rebuild.

    Parameters
    ----------
    made : SyntheticModel
        The model.
    truth : Path
        Folder of its known answer.
    result : HorizonResult
        What graben made of it; of this only the traces on the input are used.
    """

    made: demo.SyntheticModel
    truth: Path
    result: HorizonResult

    @cached_property
    def model(self) -> Model:
        return model_of_demo(self.made)

    @cached_property
    def nodes(self) -> FloatArray:
        """The nodes of the grid, (n, 3)."""
        return np.column_stack([self.made.grid.nodes().reshape(-1, 2), self.made.values.reshape(-1)])

    @cached_property
    def away(self) -> FloatArray:
        """Plan distance of each node from the nearest trace, m."""
        graph = self.result.graph
        lines = shapely.multilinestrings(shapely.linestrings(graph.nodes[graph.edges][:, :, :2]))
        return np.asarray(shapely.distance(shapely.points(self.nodes[:, :2]), lines))

    @cached_property
    def reliable(self) -> BoolArray:
        return self.away > self.made.gamma

    @cached_property
    def sides(self) -> IntArray:
        """1 hanging, -1 foot of each fault, extended beyond its ends; (n, faults)."""
        xy = self.made.frame.inward(self.nodes[:, :2])
        geology = self.made.geology
        return np.stack(
            [np.where(geology.distance(f, xy) >= 0.0, 1, -1) for f in range(len(geology.faults))], axis=1
        )

    @cached_property
    def beyond(self) -> BoolArray:
        """Whether each node lies beyond the ends of each fault along its strike; (n, faults)."""
        xy = self.made.frame.inward(self.nodes[:, :2])
        along = [fault.coordinates(xy)[0] for fault in self.made.geology.faults]
        ends = [(max(f.columns[0], -f.half_length), f.columns[-1]) for f in self.made.geology.faults]
        return np.stack([(s < a) | (s > b) for s, (a, b) in zip(along, ends, strict=True)], axis=1)

    @property
    def blocks(self) -> tuple[tuple[int, ...], ...]:
        return self.made.geology.blocks

    def strike(self, fault: int) -> FloatArray:
        """Return the plan direction along which places on a fault are compared, as the score takes it."""
        surface = self.made.faults[fault]
        direction, _ = mean_dip_direction(surface.vertices, surface.triangles)
        return np.array([-direction[1], direction[0]])

    def section(self, fault: int, place: float) -> FloatArray:
        """Return the line (m, 3) of a fault in the vertical plane across strike at a place, from below up."""
        surface, strike = self.made.faults[fault], self.strike(fault)
        mesh = trimesh.Trimesh(surface.vertices, surface.triangles, process=False)
        normal = [*strike, 0.0]
        lines = trimesh.intersections.mesh_plane(mesh, normal, [*(place * strike), 0.0])
        points = np.asarray(lines).reshape(-1, 3)
        return points[np.unique(points[:, 2], return_index=True)[1]]

    def facing(self) -> Iterator[tuple[int, int, int, FloatArray]]:
        """Yield fault, hanging block, foot block and places along strike where their true lips face."""
        for h, f in self._pairs():
            along = [line.points[:, :2] @ self.strike(h.fault) for line in (h, f)]
            first, last = max(a.min() for a in along), min(a.max() for a in along)
            if last - first > STEP:
                inner = np.linspace(first, last, round((last - first) / STEP) + 1)[1:-1]
                yield h.fault, h.block, f.block, inner

    def tips(self) -> Iterator[tuple[int, int, int, float]]:
        """Yield fault, hanging block, foot block and place along strike of each tip in the domain."""
        for h, f in self._pairs():
            along = h.points[:, :2] @ self.strike(h.fault)
            for end, inward in ((int(along.argmin()), 1.0), (int(along.argmax()), -1.0)):
                if abs(h.throw[end]) < CLOSED:
                    yield h.fault, h.block, f.block, float(along[end] + inward * INSIDE)

    def _pairs(self) -> Iterator[tuple[demo.TrueCutoff, demo.TrueCutoff]]:
        """Yield true lips, hanging and foot, that face each other across a fault."""
        lips = self.made.cutoffs
        for h in (c for c in lips if c.side > 0):
            for f in (c for c in lips if c.side < 0 and c.fault == h.fault):
                pair = np.array([self.blocks[h.block], self.blocks[f.block]])
                if (np.delete(pair[0] * pair[1], h.fault) < 0).any():
                    continue
                yield h, f


def cutoffs_of(task: Task, rebuilt: Rebuilt) -> tuple[Cutoff, ...]:
    """Return the lips of a rebuilt horizon, pair by pair at the same places along strike."""
    found = []
    for fault, hanging, foot, places in task.facing():
        sections = [task.section(fault, place) for place in places]
        upper, lower = (rebuilt.lip(fault, block, sections) for block in (hanging, foot))
        heave = np.linalg.norm((upper - lower)[:, :2], axis=1)
        name = task.made.faults[fault].name
        found.append(Cutoff(name, places - places[0], upper, lower, lower[:, 2] - upper[:, 2], heave))
    return tuple(found)


def scored(task: Task, rebuilt: Rebuilt) -> tuple[Score, tuple[Cutoff, ...]]:
    """Return the score of a rebuilt horizon, as that of a run is made, and its lips.

    Zone nodes are the nodes of the grid within gamma, and the lips.
    """
    made, zone = task.made, ~task.reliable
    z = task.nodes[:, 2].copy()
    done = np.zeros(len(z), dtype=bool)
    for b, signs in enumerate(task.blocks):
        mine = zone & ~done & (task.sides * np.array(signs) >= 0).all(axis=1)
        z[mine] = rebuilt.elevations(b, task.nodes[mine, :2])
        done |= mine
    cutoffs = cutoffs_of(task, rebuilt)
    names = tuple(s.name for s in made.faults)
    lips, of_lips, on = _lip_nodes(task, cutoffs, names)
    points = np.concatenate([np.column_stack([task.nodes[:, :2], z]), lips])
    first = np.concatenate([task.nodes, lips])
    result = HorizonResult(
        horizon=task.model.horizons[0],
        surface=Surface(demo.HORIZON, points, np.zeros((0, 3), dtype=np.int64)),
        first=first,
        subdomain=np.zeros(len(points), dtype=np.int64),
        fixed=np.concatenate([~zone, np.zeros(len(lips), dtype=bool)]),
        side=np.concatenate([np.zeros(len(z), dtype=np.int64), on]),
        block=np.concatenate([np.where(zone[:, None], task.sides, 0), of_lips]),
        graph_faults=names,
        smears=np.zeros(len(names)),
        graph=task.result.graph,
        cutoffs=cutoffs,
        subdomains=(),
    )
    errors = score(task.truth, result, task.model.faults)
    assert errors is not None
    return errors, cutoffs


def _lip_nodes(
    task: Task, cutoffs: tuple[Cutoff, ...], names: tuple[str, ...]
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the points of all lips, the side of each fault they lie on, and which lip they are of."""
    points, signs, on = [], [], []
    for cutoff, (_, hanging, foot, _places) in zip(cutoffs, task.facing(), strict=True):
        for side, block, line in ((1, hanging, cutoff.hanging), (-1, foot, cutoff.foot)):
            own = np.array(task.blocks[block])
            points.append(line)
            signs.append(np.broadcast_to(own, (len(line), len(names))))
            on.append(np.full(len(line), side))
    return np.concatenate(points), np.concatenate(signs), np.concatenate(on)


def meeting(section: FloatArray, above: FloatArray) -> FloatArray:
    """Return the point of a line (m, 3) where ``above`` (m,) is zero, which grows; an end where it is not."""
    share = np.interp(0.0, above, np.arange(len(above), dtype=np.float64))
    k = min(int(share), len(section) - 2)
    return np.asarray(section[k] + (share - k) * (section[k + 1] - section[k]))
