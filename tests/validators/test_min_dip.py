"""Which part of a fault is flatter than the limit."""

from __future__ import annotations

import re

import numpy as np
import pytest

from graben.finding import Element
from graben.settings import Parameters
from graben.validators.context import CheckContext
from graben.validators.min_dip import CHECK
from tests.strategies import NASTY
from tests.zoo.shapes import STEP, dipping, faults, sheet


def found(surface, **keys):
    return CHECK.run(CheckContext(faults(surface, **keys), frozenset([surface.name])))


def bent(*dips: float):
    """A fault whose rows dip so many degrees, each of one step."""
    turn = np.radians(dips)
    y, z = (np.concatenate([[0], np.cumsum(STEP * f(turn))]) for f in (np.cos, np.sin))
    return sheet(5, len(dips), lambda i, j: (STEP * i, y[j.astype(int)], -z[j.astype(int)]))


@pytest.mark.parametrize(
    ("dips", "share"), [((60, 60, 10, 60), "25 %"), ((20, 20), "100 %"), ((10,) + (60,) * 19, "5 %")]
)
def test_the_share_of_the_area(dips, share):
    (defect,) = found(bent(*dips))
    assert f" {share} of its area" in defect.message
    flat = sum(d < 30 for d in dips)
    assert defect.count == len(defect.elements) == len(defect.places) == 10 * flat
    assert np.isclose(defect.value, min(dips))
    assert defect.element is Element.TRIANGLE


def test_a_share_is_never_told_as_nothing():
    wide = sheet(1, 2, lambda i, j: (STEP * i, 4e5 * (j > 1) + 1.0 * (j > 0), -9e5 * (j > 1) - 0.2 * (j > 0)))
    (defect,) = found(wide)
    assert "less than 0.01 %" in defect.message


def test_the_limit_is_that_of_the_check_before_that_of_the_parameters():
    fault = dipping(40)
    assert found(fault) == []
    assert found(fault, parameters=Parameters(min_dip=45.0)) != []
    assert found(fault, parameters=Parameters(min_dip=45.0), checks={"min-dip": 35.0}) == []


@pytest.mark.parametrize("dip", [30.0, 45.0])
def test_a_fault_at_the_limit_passes_anywhere(dip):
    fault = dipping(dip, 20, 20)
    for surface in (fault, NASTY.surface(fault)):
        assert found(surface, parameters=Parameters(min_dip=dip)) == []
        (defect,) = found(surface, parameters=Parameters(min_dip=dip + 1e-4))
        assert re.search(r"100 % of its area", defect.message)
