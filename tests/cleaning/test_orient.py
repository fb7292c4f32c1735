"""Triangles that face another way than the rest are turned, the rest stays to the bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.cleaning.orient import REPAIR
from graben.cleaning.shaping.turning import oriented, reconciled
from tests.cleaning.tasks import applied, found, proposed
from tests.zoo.oriented import FAILING, PASSING
from tests.zoo.shapes import F60

OF_FAULTS = [case for case in FAILING if case.objects == ("F",) and case.name != "one-sided band"]


@pytest.mark.parametrize("case", OF_FAULTS, ids=lambda case: case.name)
def test_what_faces_another_way_is_turned(case):
    task, (change,), _ = proposed(case.model, REPAIR)
    assert not found(applied(task.model, change), "oriented", REPAIR)
    (made,) = change.surfaces["F"]
    old = task.references["F"]
    assert made.vertices is old.vertices or np.array_equal(made.vertices, old.vertices)
    assert np.array_equal(np.sort(made.triangles, axis=1), np.sort(old.triangles, axis=1))
    assert reconciled(made) is made


@pytest.mark.parametrize("case", PASSING, ids=lambda case: case.name)
def test_what_agrees_is_the_same_surface(case):
    for surface in case.model.surfaces:
        assert reconciled(surface) is surface


@pytest.mark.parametrize("down", [False, True])
def test_most_of_the_area_stays(down):
    base = replace(F60, triangles=F60.triangles[:, ::-1]) if down else F60
    mixed = base.triangles.copy()
    mixed[[3, 17, 30]] = mixed[[3, 17, 30]][:, ::-1]
    made = reconciled(replace(base, triangles=mixed))
    rest = np.setdiff1d(np.arange(48), [3, 17, 30])
    assert np.array_equal(made.triangles[rest], mixed[rest])
    assert np.array_equal(oriented(base).triangles, oriented(made).triangles) or down


def test_a_one_sided_band_is_refused():
    (case,) = (c for c in FAILING if c.name == "one-sided band")
    _, changes, (refusal,) = proposed(case.model, REPAIR)
    assert changes == []
    assert "one side only" in refusal.reason
    assert refusal.place is not None
