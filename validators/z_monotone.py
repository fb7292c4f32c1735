"""z-monotone: no stationary point inside a fault (paper Sect. 3.1, requirement 2).

Listed, not part of this version.
"""

from __future__ import annotations

from graben.validators.context import Check, Need

CHECK = Check(
    "z-monotone",
    "3.1, requirement 2",
    "No stationary point lies inside a fault.",
    need=Need.SURFACES,
    faults_only=True,
    repairable=True,
)
