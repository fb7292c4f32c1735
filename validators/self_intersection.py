"""self-intersection: a surface does not cross itself.

Listed, not part of this version.
"""

from __future__ import annotations

from graben.validators.context import Check, Need

CHECK = Check(
    "self-intersection", "3", "A surface does not cross itself.", need=Need.SURFACES, repairable=True
)
