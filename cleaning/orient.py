"""orient: triangles turned so that neighbours agree (answers `oriented`)."""

from __future__ import annotations

from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.turning import disagreeing, reconciled, same_turn
from graben.words import plural


def propose(task: Task) -> list[Change | Refusal]:
    """Return each fault whose triangles disagree with them turned, and which faults have one side only."""
    faults = {f.name: f.surface for f in task.model.faults}
    made: list[Change | Refusal] = []
    for finding in task.findings:
        for name in (n for n in finding.objects if n in faults):
            turned = reconciled(faults[name])
            left = disagreeing(turned)
            place = finding.places[0] if len(finding.places) else None
            if left:
                reason = (
                    f"{name} has one side only: however its triangles are turned, {plural(left, 'edge')} or "
                    "more stay between triangles that face different ways."
                )
                made.append(Refusal("oriented", (name,), reason, "Cut it open where it twists.", place))
            if left < disagreeing(faults[name]):
                count = int((~same_turn(faults[name].triangles, turned.triangles)).sum())
                verb = "was" if count == 1 else "were"
                reason = f"{plural(count, 'triangle')} of {name} {verb} turned so that neighbours agree."
                made.append(Change({name: (turned,)}, (Step("oriented", (name,), count, place, reason),)))
    return made


REPAIR = Repair(
    "orient",
    ("oriented",),
    "Turns triangles so that neighbours agree.",
    propose,
)
