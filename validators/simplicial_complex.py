"""simplicial-complex: the faults form one complex (paper Sect. 3.2, condition 1).

What is asked so far is that the common refinement of the faults can be made.
"""

from __future__ import annotations

from graben.validators.context import Check, CheckContext, Defect, Need


def _run(context: CheckContext) -> list[Defect]:
    reason = context.evidence.errors.get("")
    if reason is None:
        return []
    return [
        Defect(
            tuple(f.name for f in context.model.faults),
            f"The faults could not be refined to one complex: {reason}",
            "Check the faults two by two, and take the one out with which it fails.",
            blocks=True,
        )
    ]


CHECK = Check(
    "simplicial-complex",
    "3.2, condition 1",
    "The faults form one simplicial complex.",
    need=Need.COMPLEX,
    repairable=True,
    run=_run,
)
