"""What files state of their units and of the sign of z, and what is said where a model says otherwise."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from graben.drafting import draft_model
from graben.finding import Finding, Status
from graben.formats.kinds import kind_of
from graben.formats.stated import stated_units, states_sign
from graben.formats.tsurf_writer import write_tsurf
from graben.info import describe
from graben.pipeline import check
from graben.reading import read_model
from graben.surface import Surface

FAULT = Surface("F", [[0, 0, -100], [900, 0, -100], [0, 90, -200], [900, 90, -200]], [[0, 1, 2], [1, 3, 2]])
TSURF = "GOCAD TSurf 1\n{}TFACE\nVRTX 1 0 0 -9\nVRTX 2 9 0 -9\nVRTX 3 0 9 -20\nTRGL 1 2 3\nEND\n"


def units(path: Path) -> tuple[str, ...]:
    return stated_units(path, kind_of(path))


@pytest.mark.parametrize(
    ("line", "stated"),
    [
        ('AXIS_UNIT "m" "m" "m"', ("m",)),
        ("AXIS_UNIT ft ft ft", ("ft",)),
        ('AXIS_UNIT " m " "Metres" "feet"', ("m", "ft")),
        ('AXIS_UNIT "ftUS" "ftUS" "ftUS"', ("ft",)),
        ('AXIS_UNIT "m" "m" "ms"', ("m",)),
        ('AXIS_UNIT "unitless" "unitless" "s"', ()),
        ("", ()),
    ],
)
def test_units_of_a_tsurf(tmp_path: Path, line: str, stated: tuple[str, ...]) -> None:
    file = tmp_path / "f.ts"
    file.write_text(TSURF.format(f"{line}\n" if line else ""))
    assert units(file) == stated
    assert not states_sign(file, kind_of(file))
    file.write_text(TSURF.format("ZPOSITIVE Depth\n"))
    assert states_sign(file, kind_of(file))


@pytest.mark.parametrize(
    ("header", "stated"),
    [
        ("X,Y,TVDSS (ft)", ("ft",)),
        ("\ufeffX [m];Y [m];Z [ft]", ("m", "ft")),
        ("# picks in ft\nEasting_m,Northing_m,Depth_m", ("m",)),
        ("X,Y,TWT (ms)", ()),
        ("X,Y,Z,Thickness (ft)", ()),
        ("X,Y,Z", ()),
        ("1,2,3", ()),
    ],
)
def test_units_of_a_table(tmp_path: Path, header: str, stated: tuple[str, ...]) -> None:
    file = tmp_path / "p.csv"
    mark = ";" if ";" in header else ","
    file.write_text(f"{header}\n{mark.join('123')}\n", encoding="utf-8")
    assert units(file) == stated


def model(folder: Path, head: str, header: str = "X,Y,Z", depth: float = 1.0) -> list[Finding]:
    """Findings of the check trace that warn of a model of one horizon of points and a fault in m."""
    rows = [(x, y, depth * (150 + 0.01 * x)) for x in range(-500, 1500, 50) for y in range(-500, 600, 50)]
    (folder / "p.csv").write_text(header + "\n" + "".join(f"{x},{y},{z}\n" for x, y, z in rows))
    write_tsurf(folder / "f.ts", [FAULT])
    surfaces = '[[horizons]]\nname = "P"\nfile = "p.csv"\n[[faults]]\nfile = "f.ts"\n'
    (folder / "model.toml").write_text(f'[model]\nname = "m"\n{head}\n{surfaces}')
    return [f for f in check(read_model(folder / "model.toml")).of("trace") if f.status is Status.WARN]


def test_a_file_in_another_unit_is_named_once(tmp_path: Path) -> None:
    assert model(tmp_path, 'z = "depth"') == []
    (said,) = model(tmp_path, 'z = "depth"', "X,Y,TVDSS (ft)")
    assert said.objects == ("P",)
    assert said.message == "p.csv (P) states the unit ft, but that of the model is m (the default)."
    assert 'unit = "ft"' in said.remedy
    (said,) = model(tmp_path, 'z = "depth"\nunit = "ft"', "X,Y,TVDSS (ft)")
    assert said.message == "f.ts (F) states the unit m, but that of the model is ft."
    assert model(tmp_path, 'z = "depth"\nunit = "none"', "X,Y,TVDSS (ft)") == []


def test_depths_that_are_taken_for_elevations_are_told(tmp_path: Path) -> None:
    said = {f.objects: f for f in model(tmp_path, "")}
    assert set(said) == {("P",), ("F",)}
    assert "z is left out under [model], so P counts as elevation" in said[("P",)].message
    assert 'z = "depth"' in said[("P",)].remedy
    # the fault states that it lies below zero
    assert all(word in said[("F",)].remedy for word in ("sign of z", "F", "P"))
    assert model(tmp_path, "", depth=-1.0) == []
    assert not any("left out" in f.message for f in model(tmp_path, 'z = "elevation"'))


def test_a_draft_takes_the_unit_that_files_state(tmp_path: Path) -> None:
    write_tsurf(tmp_path / "f.ts", [FAULT], unit="ft")
    made = draft_model([tmp_path / "f.ts"], tmp_path / "model.toml")
    text = (tmp_path / "model.toml").read_text(encoding="utf-8")
    assert tomllib.loads(text)["model"]["unit"] == made.unit == "ft"
    assert "# guess: stated by f.ts" in text
    write_tsurf(tmp_path / "g.ts", [Surface("G", FAULT.vertices, FAULT.triangles)], unit="m")
    made = draft_model([tmp_path / "f.ts", tmp_path / "g.ts"], tmp_path / "both.toml")
    text = (tmp_path / "both.toml").read_text(encoding="utf-8")
    assert "unit" not in tomllib.loads(text)["model"]
    assert "m in g.ts; ft in f.ts" in text


def test_info_tells_the_unit(tmp_path: Path) -> None:
    write_tsurf(tmp_path / "f.ts", [FAULT], unit="ft")
    assert str(describe(tmp_path / "f.ts")).endswith("unit: ft, as stated")
    (tmp_path / "p.csv").write_text("0,0,1\n9,0,1\n0,9,1\n")
    assert "unit: not stated" in str(describe(tmp_path / "p.csv"))
