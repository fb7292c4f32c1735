"""Tasks as the planner would make them, and the checks of what a repair makes of a model."""

from __future__ import annotations

from dataclasses import replace

from graben.cleaning.repairing import Change, Refusal, Repair, Task
from graben.finding import CheckResult, Finding, Profile
from graben.model import Fault, Model
from graben.stages import Stages, quiet
from graben.validators.runner import run_checks


def task_of(model: Model, repair: Repair) -> Task:
    """The task of a repair on a model in its local frame."""
    local = model.moved(-model.local_origin())
    result, evidence = run_checks(local, Profile.EXTENDED, Stages(quiet), repair.need)
    findings = tuple(f for f in result.findings if f.check in repair.checks and repair.answers(f, local))
    return Task(local, findings, evidence, {f.name: f.surface for f in local.faults})


def proposed(model: Model, repair: Repair) -> tuple[Task, list[Change], list[Refusal]]:
    """The task, and the changes and refusals that a repair makes of it."""
    task = task_of(model, repair)
    made = repair.propose(task) if task.findings else []
    changes = [c for c in made if isinstance(c, Change)]
    return task, changes, [r for r in made if isinstance(r, Refusal)]


def applied(model: Model, change: Change) -> Model:
    """The model with one change made."""
    faults: list[Fault] = []
    for fault in model.faults:
        made = change.surfaces.get(fault.name)
        faults += [fault] if made is None else [Fault(s, fault.gamma) for s in made]
    return replace(model, faults=tuple(faults))


def found(model: Model, check: str, repair: Repair) -> tuple[Finding, ...]:
    """The findings of one check that ask for repair."""
    return tuple(
        f for f in result_of(model, repair).findings if f.check == check and repair.answers(f, model)
    )


def result_of(model: Model, repair: Repair) -> CheckResult:
    return run_checks(model, Profile.EXTENDED, Stages(quiet), repair.need)[0]
