"""Repair on values: a model, what was done to it, and what is left (no files)."""

from __future__ import annotations

import time
from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from os import PathLike
from types import MappingProxyType
from typing import TYPE_CHECKING

from graben.arrays import FloatArray
from graben.cleaning.ledger import Left, RepairAction, left_over
from graben.cleaning.planner import repaired
from graben.cleaning.registry import answered_checks
from graben.cleaning.restoring import restored
from graben.finding import CheckResult, Profile
from graben.given import given
from graben.model import Model
from graben.stages import Progress, Stages, peak_memory_mb, quiet
from graben.validators.context import Evidence, Need
from graben.validators.measuring.contacts import KnownContacts
from graben.validators.runner import run_checks, shifted
from graben.words import plural

if TYPE_CHECKING:
    import pyvista


@dataclass(frozen=True, eq=False)
class RepairResult:
    """A repaired model, what was done and what was left; coordinates are the input's, z is elevation.

    Parameters
    ----------
    input, model : Model
        Before and after. A surface that did not change is the input's own.
    actions : tuple of RepairAction
        The ledger.
    left : tuple of Left
        What is left of what fails, and why.
    before, after : CheckResult
        Findings of both.
    lineage : mapping of str to str
        By the name of each fault of the repaired model: the fault of the input that it came from.
    seconds : float
        How long it took.
    peak_memory_mb : float
        Largest memory of the process so far.
    """

    input: Model
    model: Model
    actions: tuple[RepairAction, ...]
    left: tuple[Left, ...]
    before: CheckResult
    after: CheckResult
    lineage: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    seconds: float = 0.0
    peak_memory_mb: float = 0.0

    @property
    def passed(self) -> bool:
        """Whether the repaired model passes the gate."""
        return self.after.passed

    def __repr__(self) -> str:
        verdict = "passed" if self.passed else "not passed"
        lines = [f"Repair: {plural(len(self.actions), 'action')}, {verdict} after"]
        lines += [f"  {a.action:<8} {', '.join(a.objects)}: {a.reason} ({a.count})" for a in self.actions]
        lines += [f"  left: {note.check} {', '.join(note.objects)}: {note.reason}" for note in self.left]
        return "\n".join(lines)

    def to_pyvista(self) -> pyvista.MultiBlock:
        """Return the surfaces of the repaired model as a named ``pyvista.MultiBlock``."""
        return self.model.to_pyvista()

    def _repr_html_(self) -> str:
        from html import escape

        rows = "".join(
            f"<tr><td>{escape(a.action)}</td><td>{escape(', '.join(a.objects))}</td><td>{a.count}</td>"
            f"<td>{escape(a.reason)}</td></tr>"
            for a in self.actions
        )
        notes = [f"{n.check} {', '.join(n.objects)}: {n.reason} {n.advice}" for n in self.left]
        left = "".join(f"<li>{escape(note)}</li>" for note in notes)
        table = f"<table><tr><th>repair</th><th>objects</th><th>count</th><th>reason</th></tr>{rows}</table>"
        rest = f"<p>Left:</p><ul>{left}</ul>" if left else ""
        return table + rest + self.after._repr_html_()


@dataclass(frozen=True, eq=False)
class Look:
    """The last look at a model by the gate, in the local frame.

    Parameters
    ----------
    origin : (3,) array
        Of that frame, model units.
    evidence : Evidence
        What was computed for the checks.
    stages : Stages
        What the modeling stage made ready for it.
    seconds : float
        How long the checks took, in the first and the last look, without what the modeling uses again.
    """

    origin: FloatArray
    evidence: Evidence
    stages: Stages
    seconds: float


def repair(
    model: Model | str | PathLike[str],
    profile: Profile | str = Profile.EXTENDED,
    progress: Progress | None = None,
) -> RepairResult:
    """Return the model with what fails under the profile repaired, and the ledger of every change.

    Gaps, stubs, holes and faults that end too early only warn; they are repaired as well where there is one
    clear way to, unless [[contacts]] accepts them or `warnings = false` stands in [repair].

    Parameters
    ----------
    model : Model, str or path
        The model, or its model.toml; it is not changed.
    profile : Profile or str
        "paper" or "extended".
    progress : callable, optional
        Called with the stage and what it works on.
    """
    profile = Profile(profile)
    return mended(given(model), profile, progress or quiet)[0]


def mended(model: Model, profile: Profile, progress: Progress) -> tuple[RepairResult, Look]:
    """Return what repair came to, with the last look at the model, for the modeling to go on from."""
    begin = time.perf_counter()
    origin = model.local_origin()

    known = KnownContacts()

    def look(
        trial: Model, through: Need = Need.ANCHORS, warning: Container[str] | None = None
    ) -> tuple[CheckResult, Evidence, Stages, float]:
        start = time.perf_counter()
        stages = Stages(progress)
        result, evidence = run_checks(trial, profile, stages, through, warning, known)
        return result, evidence, stages, time.perf_counter() - start - stages.seconds

    local = model.moved(-origin)
    before, evidence, stages, checking = look(local)
    done = repaired(local, lambda *asked: look(*asked)[:2], progress, (before, evidence))
    after, whole = before, model
    if done.model is not local:
        whole = restored(done.model, model, origin)
        after, evidence, stages, more = look(whole.moved(-origin))
        checking += more
    result = RepairResult(
        model,
        whole,
        tuple(action.moved(origin) for action in done.actions),
        tuple(note.moved(origin) for note in left_over(after, done.left, answered_checks())),
        shifted(before, origin),
        shifted(after, origin),
        done.lineage,
        time.perf_counter() - begin,
        peak_memory_mb(),
    )
    return result, Look(origin, evidence, stages, checking)
