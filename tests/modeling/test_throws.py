"""What stands along cutoffs, against the geometry of a fault with known lips."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graben.arrays import floats
from graben.cutgraph import NodeKind
from graben.modeling.results import HorizonResult
from graben.modeling.throws import Sense, along, fault_throws, sign_changes, stretches, told_from
from tests.reports import sample

FAULTS = [sample.fault().surface]
FAR = floats([500_000.0, -300_000.0, 0.0])


def with_throw(result: HorizonResult, throw: np.ndarray) -> HorizonResult:
    """The same cutoff with another throw and the heave of a dip of 60 degrees, its places kept."""
    (line,) = result.cutoffs
    return replace(result, cutoffs=(replace(line, throw=throw, heave=throw / sample.TAN_DIP),))


@pytest.mark.parametrize("throw", [138.0, -138.0])
def test_rows_of_a_fault_that_dips_60_degrees_east(throw):
    (line,) = along(sample.cut_result(throw=throw), FAULTS)
    # The fault dips 60 degrees along x, a little more square to its bending trace.
    assert ((line.dip >= 60.0) & (line.dip < 61.0)).all()
    assert (np.abs(line.azimuth - 90.0) < 8.0).all()
    assert line.kinds[[0, -1]].tolist() == [NodeKind.TIP, NodeKind.TIP]
    assert (line.kinds[1:-1] == NodeKind.INTERIOR).all()
    sense = Sense.NORMAL if throw > 0 else Sense.REVERSE
    assert line.senses(0.1) == [Sense.NONE, *[sense] * (len(line.kinds) - 2), Sense.NONE]
    c = line.cutoff
    inner = slice(1, -1)
    np.testing.assert_allclose(c.throw[inner] / c.heave[inner], np.tan(np.radians(60.0)), rtol=1e-6)


def test_junctions_part_the_rows():
    (line,) = sample.cut_result().cutoffs
    twice = np.sort(np.append(np.arange(len(line.s)), 20))
    doubled = replace(
        line, **{k: getattr(line, k)[twice] for k in ("s", "hanging", "foot", "throw", "heave")}
    )
    assert stretches(line) == [slice(0, 41)]
    assert stretches(doubled) == [slice(0, 21), slice(21, 42)]
    result = replace(sample.cut_result(), cutoffs=(doubled,))
    (told,) = along(result, FAULTS)
    assert len(told.kinds) == 42  # both rows stand for the same node
    assert told.kinds[[0, -1]].tolist() == [NodeKind.TIP, NodeKind.TIP]


def test_a_fault_in_numbers():
    result = sample.cut_result()
    (told,) = fault_throws(result, FAULTS, 0.1)
    path = result.graph.nodes[:, :2]
    assert told.ends == ("tip", "tip")
    assert told.length == pytest.approx(np.hypot(*np.diff(path, axis=0).T).sum())
    assert told.throw == pytest.approx(138.0)
    assert told.heave == pytest.approx(138.0 / np.tan(np.radians(60.0)))
    assert told.ratio == pytest.approx(138.0 / told.length)
    assert told.sense is Sense.NORMAL
    assert len(told.changes) == 0
    # The mean of (1 - r^2)^1.5 is 3 pi / 16.
    assert told.mean == pytest.approx(138.0 * 3.0 * np.pi / 16.0, rel=2e-3)


def test_a_scissor_fault_is_both_and_says_where():
    result = sample.cut_result()
    (line,) = result.cutoffs
    middle = len(line.s) // 2
    throw = line.throw * np.sign(np.arange(len(line.s)) - middle)
    (told,) = fault_throws(with_throw(result, throw), FAULTS, 0.1)
    assert told.sense is Sense.BOTH
    (place,) = told.changes
    at = (line.hanging + line.foot)[middle - 1 : middle + 2] / 2.0
    assert at[0, 1] <= place[1] <= at[-1, 1]


def test_nothing_depends_on_where_the_model_lies():
    result = sample.cut_result()
    (here,), (there,) = along(result, FAULTS), along(result.moved(FAR), [FAULTS[0].moved(FAR)])
    np.testing.assert_allclose(there.dip, here.dip, atol=1e-6)
    np.testing.assert_allclose(there.azimuth, here.azimuth, atol=1e-6)
    (a,), (b,) = (
        fault_throws(result, FAULTS, 0.1),
        fault_throws(result.moved(FAR), [FAULTS[0].moved(FAR)], 0.1),
    )
    assert (b.throw, b.ends) == (a.throw, a.ends)
    np.testing.assert_allclose(a.moved(FAR).place, b.place)


def test_small_throws_have_no_sign():
    throw = floats([5.0, 1.0, -1.0, 1.0, 6.0, -7.0, -0.5, -8.0, 0.0, 9.0])
    assert sign_changes(throw, 2.0).tolist() == [4, 7]
    assert sign_changes(-throw, 2.0).tolist() == [4, 7]
    assert sign_changes(throw, 10.0).tolist() == []
    assert sign_changes(floats([]), 0.0).tolist() == []


def test_what_cannot_be_told_is_the_most_of_share_tolerance_and_noise():
    assert told_from(100.0, 0.1) == pytest.approx(5.0)
    assert told_from(1.0, 0.1) == pytest.approx(0.1)
    assert told_from(100.0, 0.1, 8.0) == pytest.approx(8.0)


def test_an_uncut_horizon_has_no_rows():
    assert along(sample.uncut_result(), FAULTS) == ()
    assert fault_throws(sample.uncut_result(), FAULTS, 0.1) == ()
