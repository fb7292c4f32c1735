"""What the modeling stage returns for each horizon, as immutable values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum, StrEnum
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, SignArray, bools, floats, ints, signs
from graben.cutgraph import CutGraph
from graben.model import Horizon
from graben.notebook import html_table
from graben.surface import Surface
from graben.words import plural

if TYPE_CHECKING:
    import pyvista

    from graben.modeling.misfit import Misfit
    from graben.modeling.quality import ThrowDoubt

#: Columns of the tables that notebooks show.
_SUBDOMAIN = ("subdomain", "faults", "unknowns", "iterations", "type", "ended", "advice")
_CUTOFF = ("fault", "pairs", "s", "throw", "heave")
#: Points closer than this share of an extent are the same.
_SAME_PLACE = 1e-9


class TerminationType(IntEnum):
    """How a subdomain ended (paper Sect. 7)."""

    CONVERGED = 0
    STAGNATION = 1
    PROJECTION_FAILURE = 2
    VERTEX_REACHED = 3


class Side(StrEnum):
    """The two sides of a fault."""

    HANGING = "hanging"
    FOOT = "foot"


@dataclass(frozen=True)
class Termination:
    """How a subdomain ended, and for types 1-3 where, on which fault and side, and by how much short.

    ``short_by`` in model units, for types 2 and 3: how far in elevation the fault or guide ends before the
    horizon. The place is the end of the guide; for type 1 it is the node that moved most at the end.
    """

    type: TerminationType
    name: str
    advice: str = ""
    fault: str | None = None
    side: Side | None = None
    short_by: float | None = None
    x: float | None = None
    y: float | None = None
    z: float | None = None

    def moved(self, offset: FloatArray) -> Termination:
        """Return the termination with its place shifted by ``offset``, shape (3,)."""
        if self.x is None or self.y is None or self.z is None:
            return self
        x, y, z = (float(c) for c in np.array([self.x, self.y, self.z]) + offset)
        return replace(self, x=x, y=y, z=z)


@dataclass(frozen=True, eq=False)
class Subdomain:
    """One strongly connected part of the cut horizon and the course of its iteration.

    ``history`` holds eps_k of formula (7), model units; ``mean_displacement`` is the mean plan length of
    the last move of the cut nodes, ``mean_deviation`` the mean |u_k - u_(k-1)| there (paper Table 3).
    """

    id: int
    faults: tuple[str, ...]
    nodes: int
    unknowns: int
    iterations: int
    termination: Termination
    mean_displacement: float = 0.0
    mean_deviation: float = 0.0
    history: tuple[float, ...] = ()
    remeshings: int = 0
    seconds: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))

    def __repr__(self) -> str:
        t = self.termination
        size = f"{plural(self.unknowns, 'unknown')}, {plural(self.iterations, 'iteration')}"
        return f"Subdomain {self.id} ({', '.join(self.faults)}): {size}, type {int(t.type)}, {t.name}"

    def _repr_html_(self) -> str:
        return html_table(_SUBDOMAIN, [self._row()])

    def _row(self) -> tuple[object, ...]:
        t = self.termination
        faults = ", ".join(self.faults)
        return self.id, faults, self.unknowns, self.iterations, int(t.type), t.name, t.advice


@dataclass(frozen=True, eq=False)
class Cutoff:
    """The pair of cutoff lines of one piece of one fault on one horizon.

    Parameters
    ----------
    fault : str
        Name of the fault.
    s : (k,) array
        Distance along the first trace in plan, from the end at which the fault dips to the right.
    hanging, foot : (k, 3) arrays
        x, y, elevation of the two lips; equal at a tip.
    throw : (k,) array
        Elevation of foot minus elevation of hanging: positive normal, negative reverse.
    heave : (k,) array
        (P_hanging - P_foot) . d in plan, d the local dip direction: positive gap, negative overlap.
    """

    fault: str
    s: FloatArray
    hanging: FloatArray
    foot: FloatArray
    throw: FloatArray
    heave: FloatArray

    def __post_init__(self) -> None:
        for key, shape in (("s", ()), ("hanging", (-1, 3)), ("foot", (-1, 3)), ("throw", ()), ("heave", ())):
            object.__setattr__(self, key, floats(getattr(self, key), *shape))

    def __repr__(self) -> str:
        ranges = (f"{name} {_range(getattr(self, name))}" for name in ("throw", "heave"))
        size = f"{plural(len(self.s), 'pair')}, s {_range(self.s)}"
        return f"Cutoff of {self.fault!r}: {size}, {', '.join(ranges)}"

    def _repr_html_(self) -> str:
        return html_table(_CUTOFF, [self._row()])

    def _row(self) -> tuple[object, ...]:
        return self.fault, len(self.s), _range(self.s), _range(self.throw), _range(self.heave)


@dataclass(frozen=True)
class Error:
    """An error in model units and in percent of the largest true throw."""

    value: float
    percent: float


@dataclass(frozen=True)
class Score:
    """Errors of a rebuilt horizon against the known answer (``truth`` in model.toml)."""

    cutoff: Error
    throw: Error
    zone: Error
    zone_input: Error

    def as_dict(self) -> dict[str, Any]:
        """Return the score for report.json."""
        return {
            k: {"value": e.value, "percent": e.percent}
            for k, e in (
                ("cutoff", self.cutoff),
                ("throw", self.throw),
                ("zone", self.zone),
                ("zone_input", self.zone_input),
            )
        }


@dataclass(frozen=True, eq=False)
class HorizonResult:
    """A rebuilt horizon.

    Parameters
    ----------
    horizon : Horizon
        The input.
    surface : Surface
        The cut triangulation in space.
    first : (n, 3) array
        Where each node lay on the input horizon, before the cut moved.
    subdomain : (n,) array
        Id of the subdomain of each node.
    fixed : (n,) bool array
        Nodes further than gamma from every cut, values as in the input.
    side : (n,) array
        0 off the cut, 1 hanging, -1 foot, 2 at a junction; tips are 0.
    block : (n, f) int8 array
        1 on the hanging side, -1 on the foot side of the nearest cut of that fault, 0 outside its zone.
    graph_faults : tuple of str
        The faults that cut this horizon, in the model's order.
    smears : (f,) array
        Standard width of the smear of the input along each of them, 0 where none is seen, model units.
    graph : CutGraph
        The cut graph on the input horizon.
    cutoffs : tuple of Cutoff
        Cutoff lines, fault by fault, piece by piece.
    subdomains : tuple of Subdomain
        The course of the iteration in each.
    warnings : tuple of str
        What a person should look at.
    score : Score or None
        Where the model has a truth.
    misfit : Misfit or None
        How it lies to the input, once that is asked.
    doubts : tuple of ThrowDoubt
        Where its throw is doubtful; the warnings tell them too.
    seconds : mapping
        Wall time of the stages: triangulate, solve, move, deform.
    """

    horizon: Horizon
    surface: Surface
    first: FloatArray
    subdomain: IntArray
    fixed: BoolArray
    side: IntArray
    block: SignArray
    graph_faults: tuple[str, ...]
    smears: FloatArray
    graph: CutGraph
    cutoffs: tuple[Cutoff, ...]
    subdomains: tuple[Subdomain, ...]
    warnings: tuple[str, ...] = ()
    score: Score | None = None
    misfit: Misfit | None = None
    doubts: tuple[ThrowDoubt, ...] = ()
    seconds: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        object.__setattr__(self, "first", floats(self.first, -1, 3))
        object.__setattr__(self, "subdomain", ints(self.subdomain))
        object.__setattr__(self, "fixed", bools(self.fixed))
        object.__setattr__(self, "side", ints(self.side))
        object.__setattr__(self, "block", signs(self.block, len(self.first), len(self.graph_faults)))

    @property
    def name(self) -> str:
        """The horizon's name."""
        return self.horizon.name

    def moved(self, offset: FloatArray) -> HorizonResult:
        """Return the result shifted by ``offset``, shape (3,)."""
        return replace(
            self,
            horizon=self.horizon.moved(offset),
            surface=self.surface.moved(offset),
            first=self.first + offset,
            graph=self.graph.moved(offset),
            cutoffs=tuple(replace(c, hanging=c.hanging + offset, foot=c.foot + offset) for c in self.cutoffs),
            subdomains=tuple(replace(s, termination=s.termination.moved(offset)) for s in self.subdomains),
            doubts=tuple(replace(d, place=d.place + offset) for d in self.doubts),
        )

    @property
    def converged(self) -> bool:
        """Whether every subdomain ended with type 0."""
        return all(s.termination.type is TerminationType.CONVERGED for s in self.subdomains)

    @property
    def largest_throw(self) -> float:
        """The throw of largest magnitude, model units; 0 without a cut."""
        return float(max((np.abs(c.throw).max() for c in self.cutoffs if len(c.throw)), default=0.0))

    def __repr__(self) -> str:
        types = ", ".join(str(int(s.termination.type)) for s in self.subdomains)
        return (
            f"Horizon {self.name!r}: {plural(len(self.first), 'node')}, "
            f"{plural(len(self.subdomains), 'subdomain')}, "
            f"type {types or '-'}, largest throw {self.largest_throw:.4g}"
        )

    def _repr_html_(self) -> str:
        cutoffs = html_table(_CUTOFF, [c._row() for c in self.cutoffs], repr(self))
        return cutoffs + html_table(_SUBDOMAIN, [s._row() for s in self.subdomains])

    def node_throws(self) -> FloatArray:
        """Return the throw at each node of the cut, NaN elsewhere, shape (n,), model units.

        A junction has the largest of its throws.
        """
        found = np.full(len(self.first), np.nan)
        nodes = np.flatnonzero(self.side != 0)
        if len(nodes) == 0 or not self.cutoffs:
            return floats(found)
        lips = np.concatenate([lip for c in self.cutoffs for lip in (c.hanging, c.foot)])
        throws = np.concatenate([c.throw for c in self.cutoffs for _ in range(2)])
        # by magnitude, so that of several at one place the largest is the last to be set
        order = np.argsort(np.abs(throws), kind="stable")
        away, nearest = cKDTree(self.surface.vertices[nodes]).query(lips[order])
        here = away <= _SAME_PLACE * np.ptp(lips, axis=0).max(initial=1.0)
        found[nodes[nearest[here]]] = throws[order][here]
        return floats(found)

    def to_pyvista(self) -> pyvista.PolyData:
        """Return the cut triangulation with point arrays subdomain, fixed, side and throw.

        ``side`` is 1 hanging, -1 foot, 2 at a junction, 0 off the cut; ``throw`` is NaN there.
        """
        mesh = self.surface.to_pyvista()
        mesh.point_data["subdomain"] = self.subdomain
        mesh.point_data["fixed"] = self.fixed.astype(np.int64)
        mesh.point_data["side"] = self.side
        mesh.point_data["throw"] = self.node_throws()
        return mesh


def _range(values: FloatArray) -> str:
    """Return the least and the largest of some values in words."""
    if len(values) == 0:
        return "-"
    return f"{values.min():.4g} to {values.max():.4g}"
