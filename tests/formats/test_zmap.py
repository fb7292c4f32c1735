"""ZMAP+ grids: every dialect gives the same grid, every damage one sentence."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graben.arrays import floats
from graben.errors import InputError
from graben.formats.irap import write_irap_ascii
from graben.formats.kinds import Kind, kind_of
from graben.formats.zmap import read_zmap
from graben.model import GridGeometry
from graben.reading import read_model
from tests.damage import DAMAGES
from tests.formats.zmap_samples import GRID, PLAIN, SAME, VALUES, zmap_text

Damage = Callable[[bytes, np.random.Generator], bytes]


def stored(folder: Path, text: str, name: str = "file") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8", newline="")
    return path


@pytest.mark.parametrize("dialect", SAME)
def test_every_dialect_gives_the_same_grid(tmp_path: Path, dialect: str) -> None:
    path = stored(tmp_path, SAME[dialect])
    assert kind_of(path) is Kind.ZMAP
    geometry, values = read_zmap(path)
    assert geometry == GRID
    assert np.array_equal(values, VALUES, equal_nan=True)


def test_the_first_value_lies_in_the_north_west_and_a_column_runs_south(tmp_path: Path) -> None:
    text = "@A, GRID, 9\n9, 1e30, , 0, 1\n3, 2, 100, 110, 0, 40\n0, 0, 0\n@\n1 2 3\n4 5 6\n"
    geometry, values = read_zmap(stored(tmp_path, text))
    places = dict(zip(values.ravel(), geometry.nodes().reshape(-1, 2).tolist(), strict=True))
    assert places == {1: [100, 40], 2: [100, 20], 3: [100, 0], 4: [110, 40], 5: [110, 20], 6: [110, 0]}


@settings(max_examples=25, deadline=None)
@given(st.integers(2, 7), st.integers(2, 7), st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_what_the_writer_writes_reads_back_to_the_bit(
    columns: int, rows: int, per_line: int, seed: int
) -> None:
    import tempfile

    rng = np.random.default_rng(seed)
    values = rng.normal(size=(columns, rows)) * 10.0 ** rng.integers(-5, 5)
    values[rng.random(values.shape) < 0.3] = np.nan
    grid = GridGeometry(
        columns, rows, *rng.uniform(1, 99, 2).tolist(), tuple(rng.uniform(-1e6, 1e7, 2).tolist())
    )
    with tempfile.TemporaryDirectory() as folder:
        text = zmap_text(grid, floats(values), per_line=per_line, width=26, digits=True)
        geometry, back = read_zmap(stored(Path(folder), text))
    assert np.array_equal(back, values, equal_nan=True)
    # the header states the far corner, not the step, so that a step may differ by a few last digits
    assert np.allclose(geometry.nodes(), grid.nodes(), rtol=1e-14, atol=0)
    assert geometry.nodes()[0, 0].tolist() == list(grid.origin)


@pytest.mark.parametrize("z", ["elevation", "depth"])
def test_a_horizon_is_the_same_as_from_an_irap_grid(tmp_path: Path, z: str) -> None:
    stored(tmp_path, PLAIN, "zmap")
    write_irap_ascii(tmp_path / "irap", GRID, VALUES)
    tables = "".join(f'[[horizons]]\nname = "{name}"\nfile = "{name}"\n' for name in ("zmap", "irap"))
    model = read_model(stored(tmp_path, f'[model]\nname = "M"\nz = "{z}"\n{tables}', "model.toml"))
    ours, irap = model.horizons
    assert np.array_equal(ours.surface.vertices, irap.surface.vertices)
    assert np.array_equal(ours.surface.triangles, irap.surface.triangles)
    assert (ours.grid, ours.step, ours.notes) == (irap.grid, irap.step, irap.notes)
    assert "1 of 12" in ours.notes[0]


def test_a_value_that_is_not_finite_is_kept_for_the_checks(tmp_path: Path) -> None:
    text = PLAIN.replace("-1721.0000", "       inf")
    assert read_zmap(stored(tmp_path, text))[1][2, 1] == np.inf


def test_a_grid_makes_no_fault_and_a_damaged_one_ends_with_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from graben.cli import main

    for kind, content, words in (
        ("faults", PLAIN, "grid, which makes no fault"),
        ("horizons", PLAIN[:300], "12"),
    ):
        stored(tmp_path, content, "grid")
        model = stored(
            tmp_path, f'[model]\nname = "M"\n[[{kind}]]\nname = "A"\nfile = "grid"\n', "model.toml"
        )
        with pytest.raises(SystemExit) as caught:
            main(["check", str(model)])
        out, err = capsys.readouterr()
        assert (caught.value.code, out, err.count("\n")) == (2, "", 1)
        assert str(tmp_path / "grid") in err and words in err


@pytest.mark.parametrize("damage", DAMAGES, ids=lambda damage: damage.__name__)
def test_damage_is_refused_in_one_sentence_or_read(tmp_path: Path, damage: Damage) -> None:
    ends = set()
    for seed, text in enumerate(SAME.values()):
        path = tmp_path / str(seed)
        path.write_bytes(damage(text.encode(), np.random.default_rng(seed)))
        try:
            grid, values = read_zmap(path)
        except InputError as error:
            ends.add(str(error))
            assert str(error).startswith(str(path)) and "\n" not in str(error)
        else:
            assert values.shape == (grid.columns, grid.rows)
    assert ends


ROWS = PLAIN.index("\n@\n") + 3
LAST = PLAIN.rindex("-1.5000")
#: Content and words of the complaint.
BROKEN = {
    "no header": ("! only a comment\n", ("begins with a line '@name, GRID, 5'",)),
    "cut in the header": (PLAIN[: ROWS - 15], ("no second line with @",)),
    "cut in the values": (PLAIN[:LAST], ("4 x 3 = 12 nodes but 11 values",)),
    "cut between lines": (PLAIN[: PLAIN.rindex("\n", 0, LAST) + 1], ("but 9 values",)),
    "too long": (PLAIN + "-1.0\n", ("but 13 values",)),
    "letters for a value": (PLAIN.replace("-1721.0000", "seven"), ("line 10", "'seven'")),
    "points": (PLAIN.replace(" GRID,", " POINT,"), ("line 3", "GRID, not 'POINT'")),
    "a header line short": (PLAIN.replace("15, 0.1000000E+31, , 4, 1\n", ""), ("3 lines, not 4|fields",)),
    "a field short": (PLAIN.replace(", , 4, 1", ", 4, 1"), ("line 4", "4 fields here, not 5")),
    "a fraction of rows": (PLAIN.replace("\n3, 4,", "\n3.5, 4,"), ("line 5", "rows", "'3.5'")),
    "one column": (PLAIN.replace("\n3, 4,", "\n3, 1,"), ("line 5", "columns", "at least 2")),
    "letters for an extent": (PLAIN.replace("465000.5", "west"), ("west", "line 5")),
    "extents turned round": (PLAIN.replace("465000.5", "465900.5"), ("line 5", "lesser first")),
    "an infinite extent": (PLAIN.replace("465000.5", "-inf"), ("line 5", "finite")),
    "letters for null": (PLAIN.replace("15, 0.1000000E+31", "15, none"), ("none", "line 4")),
    "letters for a width": (PLAIN.replace("15, 0.1", "wide, 0.1"), ("line 4", "'wide'")),
    "one value without its point": (
        PLAIN.replace("-1721.0000", "     -1721"),
        ("line 10", "'-1721'", "10 to the 4"),
    ),
    "a decimal comma": (PLAIN.replace("-1721.0000", "-1721,0000"), ("line 10", "'-1721,0000'")),
}


@pytest.mark.parametrize("case", BROKEN)
def test_what_cannot_be_read_is_one_sentence(tmp_path: Path, case: str) -> None:
    text, words = BROKEN[case]
    path = stored(tmp_path, text)
    with pytest.raises(InputError) as caught:
        read_zmap(path)
    message = str(caught.value)
    assert message.startswith(str(path)) and message.endswith(".") and "\n" not in message
    assert all(any(part in message for part in word.split("|")) for word in words), message
