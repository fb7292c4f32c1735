"""From findings to repairs: each acts on what fails, and proves itself by the check it answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from graben.cleaning.ledger import RepairAction
from graben.cleaning.orient import oriented
from graben.cleaning.weld import welded
from graben.finding import CheckResult, Finding, Status
from graben.model import Fault, Model
from graben.surface import Surface


@dataclass(frozen=True)
class Repair:
    """A repair of single fault surfaces: its id, the check it answers, what it does and says."""

    id: str
    check: str
    apply: Callable[[Surface], Surface]
    reason: str


#: In the order in which they are applied.
REPAIRS: Sequence[Repair] = (
    Repair("weld", "duplicate", welded, "Vertices at one place were merged, repeated triangles left out."),
    Repair("orient", "oriented", oriented, "Triangles were turned so that neighbours agree."),
)


def known_repairs() -> tuple[str, ...]:
    """Return the ids that `skip` in [repair] may name."""
    return tuple(r.id for r in REPAIRS)


def repaired(
    model: Model, found: CheckResult, recheck: Callable[[Model], CheckResult]
) -> tuple[Model, tuple[RepairAction, ...]]:
    """Return the model with what fails repaired as far as a repair answers it, and the ledger.

    Parameters
    ----------
    model : Model
        Elevations, the input's own coordinates.
    found : CheckResult
        Its findings.
    recheck : callable
        Checks a model. A repair after which its check still fails on a surface is undone there.
    """
    actions: list[RepairAction] = []
    for repair in REPAIRS:
        if repair.id in model.repair.skip:
            continue
        failing = {n: f for f in found.of(repair.check) if f.status is Status.FAIL for n in f.objects}
        if not any(f.name in failing for f in model.faults):
            continue
        trial = _with(model, {f.name: repair.apply(f.surface) for f in model.faults if f.name in failing})
        after = recheck(trial)
        left = {n for f in after.of(repair.check) if f.status is Status.FAIL for n in f.objects}
        kept = {f.name: f.surface for f in trial.faults if f.name in failing and f.name not in left}
        model = _with(model, kept)
        found = after if not left & set(failing) else recheck(model)
        actions += [_action(repair, failing[name]) for name in kept]
    return model, tuple(actions)


def _with(model: Model, surfaces: dict[str, Surface]) -> Model:
    """Return the model with other surfaces for some of its faults."""
    faults = tuple(Fault(surfaces.get(f.name, f.surface), f.gamma) for f in model.faults)
    return replace(model, faults=faults)


def _action(repair: Repair, finding: Finding) -> RepairAction:
    place = None
    if len(finding.places):
        x, y, z = (float(c) for c in np.asarray(finding.places[0]))
        place = (x, y, z)
    return RepairAction(repair.id, repair.check, finding.objects, finding.count, 0.0, place, repair.reason)
