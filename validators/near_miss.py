"""near-miss: no fault stops just short of another.

Listed, not part of this version.
"""

from __future__ import annotations

from graben.validators.context import Check, Need

CHECK = Check(
    "near-miss",
    "3.2",
    "No fault stops just short of another or passes it by a stub.",
    need=Need.COMPLEX,
    repairable=True,
    tolerance="distance, model units",
)
