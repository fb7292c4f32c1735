"""Inputs that cannot be read: one sentence that names file or key, exit code 2 and no output folder."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from graben.errors import InputError
from graben.reading import read_model

HEAD = '[model]\nname = "M"\n'
HORIZON = '[[horizons]]\nname = "H"\nfile = "h"\n'
FAULT = '[[faults]]\nname = "F"\nfile = "f"\n'
MODEL = HEAD + HORIZON + FAULT

TSURF = (
    "GOCAD TSurf 1\nHEADER {\nname:F\n}\nTFACE\nVRTX 1 0 0 -1\nVRTX 2 9 0 -1\nVRTX 3 0 9 -5\nVRTX 4 9 9 -5\n"
    "TRGL 1 2 3\nTRGL 2 4 3\nEND\n"
)
POINTS = "X,Y,Z\n" + "".join(f"{i},{j},{-3 - 0.1 * i}\n" for i in range(10) for j in range(10))
GRID = "-996 3 5 5\n0 10 0 10\n3 0 0 0\n0 0 0 0 0 0 0\n" + "-3 " * 9 + "\n"
STICKS = "0 0 -1\n0 5 -9\n999 999 999\n9 0 -1\n9 5 -9\n999 999 999\n"
NOISE = bytes(np.random.default_rng(0).integers(0, 256, 3000, dtype=np.uint8))


@dataclass(frozen=True)
class Case:
    """A model file and the files beside it: ``h`` of the horizon, ``f`` of the fault."""

    words: tuple[str, ...]
    model: str | bytes | None = MODEL
    h: str | bytes | None = GRID
    f: str | bytes | None = TSURF
    prepare: Callable[[Path], object] = field(default=lambda folder: None)


def without(text: str, part: str) -> str:
    assert part in text
    return text.replace(part, "", 1)


def changed(text: str, part: str, other: str) -> str:
    assert part in text
    return text.replace(part, other, 1)


CASES = {
    # model.toml
    "no model file": Case(("model.toml", "does not exist"), model=None),
    "empty model file": Case(("model.toml", "empty"), model=""),
    "model file of binary noise": Case(("model.toml", "UTF-8"), model=NOISE),
    "model file in UTF-16": Case(("model.toml", "UTF-8"), model=MODEL.encode("utf-16")),
    "model file cut short": Case(("model.toml", "TOML", "line 3"), model=MODEL[:30]),
    "a key twice": Case(("TOML",), model=MODEL + 'name = "G"\n'),
    "no equals sign": Case(("TOML", "line 3"), model=HEAD + "z depth\n" + HORIZON),
    "no table [model]": Case(("'model'", "missing"), model=HORIZON),
    "no name": Case(("'name'", "[model]"), model=without(MODEL, 'name = "M"\n')),
    "an empty name": Case(("name", "[model]"), model=changed(MODEL, '"M"', '""')),
    "nothing but a head": Case(("no horizon and no fault",), model=HEAD),
    "an unknown table": Case(
        ("'horizon'", "'horizons'"), model=changed(MODEL, "[[horizons]]", "[[horizon]]")
    ),
    "an unknown key": Case(("'stepp'", "'step'", "'H'"), model=HEAD + HORIZON + "stepp = 3\n"),
    "an unknown parameter": Case(("'gama'", "[parameters]"), model=MODEL + "[parameters]\ngama = 3\n"),
    "a table for a list": Case(("horizons",), model=HEAD + '[horizons]\nname = "H"\n'),
    "letters for a number": Case(("step = 'ten'", "'H'"), model=HEAD + HORIZON + 'step = "ten"\n'),
    "a number for a name": Case(("name = 3", "[model]"), model=changed(MODEL, '"M"', "3")),
    "an unknown sign of z": Case(("z = 'down'", "depth"), model=HEAD + 'z = "down"\n' + HORIZON),
    "an unknown unit": Case(("unit = 'km'",), model=HEAD + 'unit = "km"\n' + HORIZON),
    "a step of NaN": Case(("step = nan", "'H'"), model=HEAD + HORIZON + "step = nan\n"),
    "a negative step": Case(("step = -5", "greater than 0"), model=HEAD + HORIZON + "step = -5.0\n"),
    "a negative noise": Case(("noise = -1",), model=HEAD + HORIZON + "noise = -1\n"),
    "an infinite gamma": Case(("gamma = inf", "'F'"), model=HEAD + FAULT + "gamma = inf\n"),
    "theta above 1": Case(("theta = 1.5",), model=MODEL + "[parameters]\ntheta = 1.5\n"),
    "a fraction of an iteration": Case(
        ("max_iterations = 1.5",), model=MODEL + "[parameters]\nmax_iterations = 1.5\n"
    ),
    "a word for true": Case(("acceleration = 'yes'",), model=MODEL + '[parameters]\nacceleration = "yes"\n'),
    "a dip of 90": Case(("min_dip = 90",), model=MODEL + "[parameters]\nmin_dip = 90\n"),
    "a negative move": Case(("max_move = -1", "[repair]"), model=MODEL + "[repair]\nmax_move = -1\n"),
    "an unknown rule": Case(
        ("rule = 'ask'", "[[contacts]]"),
        model=MODEL + '[[contacts]]\nfaults = ["F", "G"]\nrule = "ask"\n',
    ),
    "a contact of one": Case(
        ("[[contacts]]",), model=MODEL + '[[contacts]]\nfaults = ["F"]\nrule = "force"\n'
    ),
    "a contact with an unknown fault": Case(
        ("[[contacts]]", "'G'"), model=MODEL + '[[contacts]]\nfaults = ["F", "G"]\nrule = "force"\n'
    ),
    "a contact with itself": Case(
        ("[[contacts]]", "twice"), model=MODEL + '[[contacts]]\nfaults = ["F", "F"]\nrule = "force"\n'
    ),
    "an unknown check": Case(("'near-mis'", "near-miss"), model=MODEL + "[checks]\nnear-mis = 3\n"),
    "a tolerance of NaN": Case(("near-miss = nan",), model=MODEL + "[checks]\nnear-miss = nan\n"),
    "a name twice": Case(("'F'", "twice"), model=MODEL + FAULT),
    "a horizon named as a fault": Case(("'H'", "twice"), model=changed(MODEL, '"F"', '"H"')),
    "a name that a file gives again": Case(("'F'", "twice"), model=MODEL + '[[faults]]\nfile = "f"\n'),
    "no truth": Case(("truth", "does not exist"), model=HEAD + 'truth = "truth"\n' + HORIZON),
    # files
    "no file of a horizon": Case(("'H'", "does not exist"), h=None),
    "no file of a fault": Case(("'F'", "does not exist"), f=None),
    "a folder for a file": Case(("folder",), f=None, prepare=lambda folder: (folder / "f").mkdir()),
    "a link to nothing": Case(
        ("does not exist",), f=None, prepare=lambda folder: (folder / "f").symlink_to(folder / "nothing")
    ),
    "a file outside the folder": Case(("'../f'", "outside"), model=changed(MODEL, '"f"', '"../f"')),
    "a file outside by a detour": Case(("outside",), model=changed(MODEL, '"f"', '"a/../../f"')),
    "a zero byte in a file's name": Case(("zero byte",), model=changed(MODEL, '"f"', '"f\\u0000"')),
    "an empty horizon": Case(("empty",), h=""),
    "an empty fault": Case(("empty",), f=" \n"),
    "a horizon of binary noise": Case(("not a text file",), h=NOISE),
    "a fault of binary noise": Case(("not a text file",), f=NOISE),
    "a fault in UTF-16": Case(("not a text file",), f=TSURF.encode("utf-16")),
    "a TSurf cut short": Case(("cut short",), f=TSURF[:-30]),
    "a TSurf with letters for a number": Case(("line 7", "'b'"), f=changed(TSURF, "2 9 0", "2 b 0")),
    "a TSurf without triangles": Case(("no triangle",), f=TSURF[: TSURF.index("TRGL")] + "END\n"),
    "several surfaces for one name": Case(
        ("2 surfaces", "'A'", "'B'"),
        f=changed(TSURF, "name:F", "name:A") + changed(TSURF, "name:F", "name:B"),
    ),
    "a fault without any name": Case(
        ("name",), model=HEAD + '[[faults]]\nfile = "f"\n', f=without(TSURF, "name:F\n")
    ),
    "sticks without a name": Case(("name",), model=HEAD + '[[faults]]\nfile = "f"\n', f=STICKS),
    "sticks with letters": Case(("line 4", "'x'"), f=changed(STICKS, "9 0 -1", "9 x -1")),
    "one stick": Case(("'F'", "sticks"), f=STICKS[:26]),
    "sticks for a horizon": Case(("fault sticks", "'H'"), h=STICKS),
    "points for a fault": Case(("999s",), f=POINTS),
    "a grid for a fault": Case(("grid",), f=GRID),
    "a grid cut short": Case(("values",), h=GRID[:-5]),
    "a grid with letters": Case(("line 5", "'x'"), h=changed(GRID, "-3 -3 ", "-3 x ")),
    "a grid without a defined node": Case(("defined",), h=GRID.replace("-3 ", "9999900.0 ")),
    "a binary grid cut short": Case(
        ("binary grid",), h=bytes.fromhex("00000020fffffc1c00000003") + b"\0" * 60
    ),
    "points with letters": Case(("line 3", "'x'"), h=changed(POINTS, "0,1,", "0,x,")),
    "points cut short": Case(("line 101",), h=POINTS[: POINTS.rindex(",")]),
    "points without the column Z": Case(("line 1", "Z"), h=changed(POINTS, "Z", "amplitude")),
    "points with a header alone": Case(("no points",), h="X,Y,Z\n"),
    "points in one line": Case(("one line",), h="1 1 1\n2 2 2\n3 3 3\n4 4 4\n"),
    "two points": Case(("three points",), h="1 1 1\n2 5 2\n"),
    "points with a step of an atom": Case(("step",), model=HEAD + HORIZON + "step = 1e-9\n", h=POINTS),
    "prose for a horizon": Case(("line 1",), h="Dear colleague,\nplease find the horizon enclosed.\n"),
}


def prepared(case: Case, folder: Path) -> Path:
    for name, content in (("model.toml", case.model), ("h", case.h), ("f", case.f)):
        if content is not None:
            (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    case.prepare(folder)
    return folder / "model.toml"


def assert_is_one_sentence(text: str, case: Case) -> None:
    assert "\n" not in text.strip() and text.strip().endswith(".")
    assert all(word in text for word in case.words), text
    assert "Error" not in text and "Traceback" not in text


def test_there_are_enough_and_the_sound_model_reads(tmp_path: Path) -> None:
    assert len(CASES) >= 40
    model = read_model(prepared(Case(()), tmp_path))
    assert len(model.horizons) == len(model.faults) == 1


@pytest.mark.parametrize("name", CASES)
def test_reading_says_it_in_one_sentence(tmp_path: Path, name: str) -> None:
    model = prepared(CASES[name], tmp_path)
    with pytest.raises(InputError) as caught:
        read_model(model)
    assert_is_one_sentence(str(caught.value), CASES[name])


@pytest.mark.parametrize("name", CASES)
def test_the_command_line_ends_with_2_and_writes_nothing(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    from graben.cli import main

    model = prepared(CASES[name], tmp_path)
    before = {path.name for path in tmp_path.iterdir()}
    with pytest.raises(SystemExit) as caught:
        main(["run", str(model), "-o", str(tmp_path / "out")])
    assert caught.value.code == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert_is_one_sentence(err, CASES[name])
    assert {path.name for path in tmp_path.iterdir()} == before


UNFIT = {
    "a TSurf with NaN": Case((), f=changed(TSURF, "2 9 0", "2 nan 0")),
    "a TSurf with infinity": Case((), f=changed(TSURF, "2 9 0", "2 inf 0")),
    "a TSurf with an index out of range": Case((), f=changed(TSURF, "TRGL 2 4 3", "TRGL 2 77 3")),
    "a TSurf without area": Case((), f=changed(TSURF, "0 9 -5", "0 0 -1").replace("9 9 -5", "9 0 -1")),
    "points with NaN": Case((), h=changed(POINTS, "0,1,", "0,nan,")),
    "points far beyond any place": Case((), h=changed(POINTS, "0,1,", "0,1e30,")),
    "a TSurf horizon with NaN": Case((), h=changed(TSURF, "2 9 0", "2 nan 0")),
    "a TSurf horizon without area": Case(
        (), h=changed(TSURF, "0 9 -5", "0 0 -1").replace("9 9 -5", "9 0 -1")
    ),
    "sticks with NaN": Case((), f=changed(STICKS, "9 0 -1", "9 nan -1") + "5 5 -2\n5 6 -4\n"),
}


@pytest.mark.parametrize("name", UNFIT)
def test_what_can_be_read_but_is_unfit_is_read(tmp_path: Path, name: str) -> None:
    model = read_model(prepared(UNFIT[name], tmp_path))
    assert model.horizons[0].step > 0
    if "area" not in name:
        surfaces = [*model.surfaces]
        loose = [not (np.isfinite(s.vertices) & (np.abs(s.vertices) < 1e20)).all() for s in surfaces]
        outside = [((s.triangles < 0) | (s.triangles >= len(s.vertices))).any() for s in surfaces]
        assert any(loose) or any(outside)
