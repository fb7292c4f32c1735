"""What a check is, what it sees and what it says: the small vocabulary of the gate."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from types import MappingProxyType
from typing import Protocol

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.complexes import Complex
from graben.cutgraph import CutGraph
from graben.finding import Element, Finding, Part
from graben.model import Fault, Horizon, Model
from graben.surface import Surface
from graben.validators.measuring.contacts import Contact

#: Distance over the model's size at which two surfaces touch, and two elevations at a junction agree.
CONTACT = 1e-6


class Need(IntEnum):
    """What a check works on; later kinds are asked for only where all earlier ones are at hand."""

    SURFACES = 0  #: the surfaces themselves
    COMPLEX = 1  #: the common refinement of all faults
    GRAPH = 2  #: the cut graph of a horizon
    ANCHORS = 3  #: the subdomains of a horizon and their fixed nodes


class Severity(Enum):
    """What a defect means under the two profiles."""

    FAIL = "fail"  #: fails under both
    RELAXED = "relaxed"  #: fails under `paper`, warns under `extended`
    WARN = "warn"  #: warns under both


class Scope(Enum):
    """What a failure of a check keeps from being modeled."""

    NOTHING = "nothing"
    HORIZON = "the horizon"
    MODEL = "every horizon"


@dataclass(frozen=True)
class Tolerance:
    """The one number of a check that a model may set in [checks].

    Parameters
    ----------
    meaning : str
        What it limits, as in "least angle of a fault's triangle".
    unit : str
        "degrees", "model units" or another.
    default : str
        Its value where [checks] does not name it, in words.
    values : callable
        Returns that value in numbers for a model: one, or one for each fault.
    """

    meaning: str
    unit: str
    default: str
    values: Callable[[Model], Sequence[float]]


@dataclass(frozen=True, eq=False)
class Defect:
    """One defect, as a check states it: the runner makes a Finding of it.

    Parameters
    ----------
    objects : tuple of str
        Names of the surfaces concerned; a horizon comes first.
    message, remedy : str
        One sentence each, without coordinates: those stand in the arrays and follow the model's frame.
    count : int
        How many elements are concerned.
    value, unit : float or None, str
        The worst value and its unit; None where there is no value to name.
    place : (3,) array or None
        Where the worst is, model units.
    elements, element, places, paths, parts
        As in :class:`graben.finding.Finding`.
    severity : Severity or None
        What it means under each profile; None for the severity of its check.
    blocks : bool
        Whether modeling cannot live with it. With a horizon among the objects it blocks that horizon,
        else every horizon.
    """

    objects: tuple[str, ...]
    message: str
    remedy: str
    count: int = 1
    value: float | None = None
    unit: str = ""
    place: FloatArray | None = None
    elements: IntArray = field(default_factory=lambda: ints([]))
    places: FloatArray = field(default_factory=lambda: floats([], 0, 3))
    element: Element = Element.NONE
    paths: tuple[FloatArray, ...] = ()
    parts: tuple[Part, ...] = ()
    severity: Severity | None = None
    blocks: bool = False


@dataclass(frozen=True, eq=False)
class Anchoring:
    """How one subdomain of a cut horizon is held.

    Parameters
    ----------
    subdomain : int
        Its id.
    faults : tuple of str
        Names of the faults that bound it.
    fixed : int
        Number of its fixed nodes.
    spread : bool
        Whether three of them are not in one line.
    place : (3,) array
        A point in it, model units.
    gamma : float
        Below this gamma three of its present nodes that are not in one line would be fixed, model units; 0
        where it holds, and where it has no such three.
    """

    subdomain: int
    faults: tuple[str, ...]
    fixed: int
    spread: bool
    place: FloatArray
    gamma: float = 0.0

    @property
    def holds(self) -> bool:
        """Whether the energy has one minimum there: three fixed nodes not in one line."""
        return self.fixed >= 3 and self.spread


class Providers(Protocol):
    """What the modeling stage computes for the checks; each may raise ModelingError."""

    def complex(self, model: Model) -> Complex:
        """Return the common refinement of all faults; ``owner`` is the index in ``model.faults``."""

    def graph(self, model: Model, horizon: Horizon, complex: Complex) -> CutGraph:
        """Return the cut graph of a horizon."""

    def anchoring(self, model: Model, horizon: Horizon, graph: CutGraph) -> tuple[Anchoring, ...]:
        """Return how each subdomain of the horizon is held, after the cut."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """What was computed for the checks, for the modeling stage to use again, and what blocks it.

    Parameters
    ----------
    complex : Complex or None
        None where a fault is unfit or the refinement failed.
    graphs, anchors : mappings
        By the horizon's name; a horizon is missing where a check it waits for failed.
    contacts : tuple of Contact
        Where faults of the complex meet.
    errors : mapping
        Why something is missing, as the provider put it: by the horizon's name, "" for the complex.
    places : mapping
        Where, (x, y, z) in the model's frame, by the same names; missing where that is not known.
    blocking : tuple of Finding
        The failures that modeling cannot live with.
    horizons : tuple of str
        Names of the model's horizons.
    """

    complex: Complex | None = None
    graphs: Mapping[str, CutGraph] = field(default_factory=lambda: MappingProxyType({}))
    anchors: Mapping[str, tuple[Anchoring, ...]] = field(default_factory=lambda: MappingProxyType({}))
    contacts: tuple[Contact, ...] = ()
    errors: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    places: Mapping[str, tuple[float, float, float]] = field(default_factory=lambda: MappingProxyType({}))
    blocking: tuple[Finding, ...] = ()
    horizons: tuple[str, ...] = ()

    def blocked(self, horizon: str) -> tuple[Finding, ...]:
        """Return the failures that forbid to model this horizon; empty where it can be modeled."""
        others = set(self.horizons) - {horizon}
        return tuple(f for f in self.blocking if not others.intersection(f.objects))


@dataclass(frozen=True, eq=False)
class CheckContext:
    """What a check sees.

    Parameters
    ----------
    model : Model
        In its local frame.
    sound : frozenset of str
        Names of the surfaces with finite coordinates and indices in range: others are not looked at.
    evidence : Evidence
        What was computed so far.
    asked : frozenset of str or None
        Names of the surfaces that a check of single surfaces shall look at; None for all.
    """

    model: Model
    sound: frozenset[str] = frozenset()
    evidence: Evidence = Evidence()
    asked: frozenset[str] | None = None

    @property
    def contact(self) -> float:
        """How far apart two surfaces may be that touch, model units.

        [checks] simplicial-complex, else 1e-6 of the model's size: above the rounding of coordinates written
        with few decimals or turned about an axis, far below any gap that matters.
        """
        return self.tolerance("simplicial-complex", CONTACT * self.model.size)

    @property
    def unit(self) -> str:
        """The unit of length for findings; empty for a model without one."""
        return "" if self.model.unit == "none" else self.model.unit

    @property
    def horizons(self) -> tuple[Horizon, ...]:
        """The sound horizons that are asked for."""
        return tuple(h for h in self.model.horizons if self._is_asked(h.name))

    @property
    def faults(self) -> tuple[Fault, ...]:
        """The sound faults that are asked for."""
        return tuple(f for f in self.model.faults if self._is_asked(f.name))

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """All sound surfaces that are asked for: horizons, then faults."""
        return tuple(s for s in self.model.surfaces if self._is_asked(s.name))

    @property
    def sound_faults(self) -> tuple[Fault, ...]:
        """The sound faults, those that are not asked for as well."""
        return tuple(f for f in self.model.faults if f.name in self.sound)

    def _is_asked(self, name: str) -> bool:
        return name in self.sound and (self.asked is None or name in self.asked)

    def traced(self) -> Sequence[tuple[Horizon, CutGraph]]:
        """Return the horizons that have a cut graph, with it."""
        graphs = self.evidence.graphs
        return [(h, graphs[h.name]) for h in self.model.horizons if h.name in graphs]

    def is_fault(self, name: str) -> bool:
        """Return whether a surface is a fault."""
        return any(f.name == name for f in self.model.faults)

    def tolerance(self, check: str, default: float) -> float:
        """Return the tolerance of a check: the model's own in [checks], else ``default``."""
        return float(self.model.checks.get(check, default))


@dataclass(frozen=True)
class Check:
    """One criterion of the gate.

    Parameters
    ----------
    id : str
        Its name in findings and in [checks].
    section : str
        Where the paper states it, or the page of this project that does.
    sentence : str
        What it asks for.
    why : str
        Why a model needs it: what goes wrong without it, one sentence.
    run : callable
        Returns the defects found.
    need : Need
        What it works on: where that is missing it is skipped.
    stage : Need or None
        After what it runs, where that is more than it needs.
    long : bool
        Whether it takes so long on a large horizon that the next stage is made ready beside it.
    faults_only : bool
        Whether it looks at faults alone.
    severity : Severity
        What a defect means under the profiles, unless the defect says otherwise.
    leniency : str
        Where `severity` does not hold for every defect: which are milder or graver.
    scope : Scope
        What a blocking defect keeps from being modeled.
    blocks_when : str
        Which of its defects block, where not all do; empty for all, or where the scope is nothing.
    repairable : bool
        Whether a repair answers it.
    tolerance : Tolerance or None
        What [checks] may set.
    """

    id: str
    section: str
    sentence: str
    why: str
    run: Callable[[CheckContext], list[Defect]]
    need: Need = Need.SURFACES
    stage: Need | None = None
    long: bool = False
    faults_only: bool = False
    severity: Severity = Severity.FAIL
    leniency: str = ""
    scope: Scope = Scope.NOTHING
    blocks_when: str = ""
    repairable: bool = False
    tolerance: Tolerance | None = None
