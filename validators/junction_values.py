"""junction-values: two faults agree at a junction (paper Sect. 9, limitation 4).

Listed, not part of this version.
"""

from __future__ import annotations

from graben.validators.context import Check, Need

CHECK = Check(
    "junction-values",
    "9, limitation 4",
    "Two faults have the same elevation at every junction.",
    need=Need.GRAPH,
    repairable=True,
)
