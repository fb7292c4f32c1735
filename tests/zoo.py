"""Tiny surfaces and models, each with one known defect, and ones that come close and have none."""

from __future__ import annotations

from tests.zoo_near import surfaces_that_pass
from tests.zoo_networks import networks_that_fail, networks_that_pass
from tests.zoo_shapes import Case, Fakes
from tests.zoo_surfaces import surfaces_that_fail

__all__ = ["FAILING", "PASSING", "Case", "Fakes"]

FAILING: tuple[Case, ...] = (*surfaces_that_fail(), *networks_that_fail())
PASSING: tuple[Case, ...] = (*surfaces_that_pass(), *networks_that_pass())
