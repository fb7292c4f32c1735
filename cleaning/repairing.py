"""What a repair is, what it sees and what it gives: the small vocabulary of cleaning."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from graben.arrays import FloatArray
from graben.finding import Finding, Status
from graben.model import Fault, Model
from graben.surface import Surface
from graben.validators.context import CONTACT, Evidence, Need


@dataclass(frozen=True, eq=False)
class Step:
    """One thing done to one or several faults, for the ledger.

    Parameters
    ----------
    check : str
        Id of the check whose finding it answers.
    objects : tuple of str
        Names of the faults changed.
    count : int
        How many elements were changed.
    place : (3,) array or None
        One place of the change, model units.
    reason : str
        One sentence: what was done and why so.
    size, unit : float or None, str
        How much, where that is not a move of vertices: the length of an extension or of a trim, an area.
    """

    check: str
    objects: tuple[str, ...]
    count: int
    place: FloatArray | None
    reason: str
    size: float | None = None
    unit: str = ""


@dataclass(frozen=True, eq=False)
class Change:
    """What a repair proposes: kept or undone as a whole.

    Parameters
    ----------
    surfaces : mapping of str to tuple of Surface
        What takes the place of a fault, by its name: one surface of that name; several, the first of which
        keeps the name; or none.
    steps : tuple of Step
        What was done: at least one.
    declared : mapping of str to Surface
        By the name of a resulting fault: surfaces added on purpose, such as an extension. The moves of
        vertices are measured from the input surface and these.
    """

    surfaces: Mapping[str, tuple[Surface, ...]]
    steps: tuple[Step, ...]
    declared: Mapping[str, Surface] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True, eq=False)
class Refusal:
    """Why a finding, or a part of one, is left.

    Parameters
    ----------
    check : str
        Id of its check.
    objects : tuple of str
        Its objects.
    reason : str
        One sentence: why it is left, in numbers.
    advice : str
        One sentence: what a person should do.
    place : (3,) array or None
        Where, model units.
    needed : float or None
        How much more of a limit it would take, in ``unit``.
    unit : str
        Unit of ``needed``.
    """

    check: str
    objects: tuple[str, ...]
    reason: str
    advice: str = ""
    place: FloatArray | None = None
    needed: float | None = None
    unit: str = ""


@dataclass(frozen=True, eq=False)
class Task:
    """What a repair sees.

    Parameters
    ----------
    model : Model
        As repaired so far, in its local frame.
    findings : tuple of Finding
        Those that the repair is to answer, in that frame.
    evidence : Evidence
        What the checks computed of the model, as far as the repair's ``need``: the complex and the contacts
        of its faults, the cut graphs.
    references : mapping of str to Surface
        By the fault's name: what moves are measured from, see :class:`Change`.
    vetoed : frozenset of frozenset of str
        Groups of faults that the repair must leave alone, since what it did to them did not help.
    """

    model: Model
    findings: tuple[Finding, ...]
    evidence: Evidence
    references: Mapping[str, Surface]
    vetoed: frozenset[frozenset[str]] = frozenset()

    @property
    def contact(self) -> float:
        """The distance at which two surfaces touch, model units."""
        return float(self.model.checks.get("simplicial-complex", CONTACT * self.model.size))

    @property
    def unit(self) -> str:
        """The unit of length in sentences; empty for a model without one."""
        return "" if self.model.unit == "none" else self.model.unit

    def fault(self, name: str) -> Fault:
        """Return the fault of this name."""
        return next(f for f in self.model.faults if f.name == name)

    def index(self, name: str) -> int:
        """Return the position of a fault in the model: its owner number in the complex."""
        return [f.name for f in self.model.faults].index(name)

    def max_move(self, name: str) -> float:
        """Return how far a vertex of a fault may lie from its reference, model units."""
        return self.model.max_move(self.fault(name))

    def max_extension(self, name: str) -> float:
        """Return how far a fault may be extended or cut back, model units."""
        return self.model.max_extension(self.fault(name))

    def rule(self, first: str, second: str) -> str | None:
        """Return what [[contacts]] says of two faults: "accept", "forbid", "force" or nothing."""
        pair = {first, second}
        return next((c.rule for c in self.model.contacts if set(c.faults) == pair), None)


def fails(finding: Finding, model: Model) -> bool:
    """Return whether a finding fails under the profile it was made with."""
    return finding.status is Status.FAIL


@dataclass(frozen=True)
class Repair:
    """One repair of the registry.

    Parameters
    ----------
    id : str
        Its name in the ledger and in `skip`.
    checks : tuple of str
        Ids of the checks whose findings it answers.
    sentence : str
        What it does.
    propose : callable
        Returns the changes it proposes, and what it leaves and why.
    need : Need
        What it must see, and how far the checks must go to judge it.
    answers : callable
        Whether a finding of its checks asks for it; by default where it fails.
    """

    id: str
    checks: tuple[str, ...]
    sentence: str
    propose: Callable[[Task], Sequence[Change | Refusal]]
    need: Need = Need.SURFACES
    answers: Callable[[Finding, Model], bool] = fails


def of_one_fault(
    check: str, apply: Callable[[Surface], Surface], reason: str
) -> Callable[[Task], list[Change]]:
    """Return what proposes to replace each fault with a finding by a function of its surface alone.

    Parameters
    ----------
    check : str
        Id of the check that is answered.
    apply : callable
        Returns the repaired surface.
    reason : str
        One sentence for the ledger.
    """

    def propose(task: Task) -> list[Change]:
        faults = {f.name: f.surface for f in task.model.faults}
        changes = []
        for finding in task.findings:
            for name in (n for n in finding.objects if n in faults):
                place = finding.places[0] if len(finding.places) else None
                step = Step(check, (name,), finding.count, place, reason)
                changes.append(Change({name: (apply(faults[name]),)}, (step,)))
        return changes

    return propose
