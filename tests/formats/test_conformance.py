"""The table of formats in the docs is what the tests measure."""

from __future__ import annotations

import pytest

from tests.formats.conformance import NONE, PAGE, Row, filled, rows, table

pytest.importorskip("resqpy")


@pytest.fixture(scope="module")
def measured() -> list[Row]:
    return rows()


def test_the_page_holds_the_table(measured: list[Row]) -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert page == filled(page, table(measured)), "run python -m tests.formats.conformance"


def test_every_dialect_is_read_with_all_its_digits_but_those_of_32_bits(measured: list[Row]) -> None:
    assert len({row.format for row in measured}) == 12
    assert sum(len(row.dialect.split("; ")) for row in measured) > 80
    for row in measured:
        only_written = row.format in ("VTU", "RESQML")
        assert (row.read_as == NONE) == only_written
        narrow = row.format in ("Irap classic binary", "STL") and "ASCII" not in row.dialect
        assert row.numbers == (NONE if only_written else "32 bits" if narrow else "exact"), row
        assert row.written in (NONE, row.numbers if not only_written else "exact"), row
