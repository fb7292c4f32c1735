"""Polygon text of RMS and Irap, read back as what it is."""

from __future__ import annotations

import numpy as np
import pytest

from graben.formats.pol import write_pol
from graben.formats.sticks import read_sticks

RINGS = [
    np.array(
        [[432_000.123456789, 6_780_000.5, -1500.25], [432_001.0, 6_780_000.0, -1500.0], [0.1, 1e-9, 3.0]]
    ),
    np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.5], [1.0, 2.0, 3.0]]),
]


@pytest.mark.parametrize(("z", "factor"), [("elevation", 1.0), ("depth", -1.0)])
def test_rings_read_back_to_the_bit(tmp_path, z, factor):
    write_pol(tmp_path / "a.pol", RINGS, z=z)
    again = read_sticks(tmp_path / "a.pol")
    assert len(again) == len(RINGS)
    for ring, told in zip(RINGS, again, strict=True):
        np.testing.assert_array_equal(told, ring * [1.0, 1.0, factor])


def test_each_polygon_ends_in_a_line_of_999s(tmp_path):
    write_pol(tmp_path / "a.pol", RINGS)
    lines = (tmp_path / "a.pol").read_text().splitlines()
    assert [k for k, line in enumerate(lines) if line == "999.0 999.0 999.0"] == [3, 8]
    assert len(lines) == 9


def test_no_polygon_is_an_empty_file(tmp_path):
    write_pol(tmp_path / "a.pol", [])
    assert (tmp_path / "a.pol").read_bytes() == b""
