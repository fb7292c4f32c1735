"""Tiny models, each with one known defect, and ones that come close and have none.

A module for each check, named as the check's own, with FAILING and PASSING.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module

from graben.finding import CheckResult, Profile
from graben.stages import examined, quiet
from graben.validators.context import Evidence
from graben.validators.registry import known_ids
from tests.zoo.cases import Case

_MODULES = tuple(import_module(f"tests.zoo.{check.replace('-', '_')}") for check in known_ids())

FAILING: tuple[Case, ...] = tuple(case for module in _MODULES for case in module.FAILING)
PASSING: tuple[Case, ...] = tuple(case for module in _MODULES for case in module.PASSING)


@cache
def said(case: Case, profile: Profile) -> tuple[CheckResult, Evidence]:
    """What the gate says of a case, and what it saw in the model's local frame; run once."""
    result, evidence, _ = examined(case.model, profile, quiet)
    return result, evidence
