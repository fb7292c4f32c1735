"""horizon: the horizon is fit to be cut.

Listed, not part of this version.
"""

from __future__ import annotations

from graben.validators.context import Check, Need

CHECK = Check(
    "horizon",
    "3.2",
    "The horizon is defined around its traces and not nearly parallel to a fault.",
    need=Need.GRAPH,
    repairable=False,
)
