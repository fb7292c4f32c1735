"""`graben init`: a model.toml that reads, guesses right on real models, refusals in one sentence."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from graben.demo import build, write
from graben.drafting import draft_model
from graben.errors import GrabenError, InputError, OutputError
from graben.formats.irap import write_irap_ascii
from graben.formats.tsurf_writer import write_tsurf
from graben.guessing import guesses
from graben.reading import read_model
from graben.surface import Surface
from tests.formats.zmap_samples import GRID, PLAIN, VALUES
from tests.test_reading import STICKS, folder_of

DATA = Path(__file__).parents[2] / "shared" / "data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason="shared data are not here")

FLAT = Surface("A", [[0, 0, -100], [900, 0, -100], [0, 900, -200]], [[0, 1, 2]])
STEEP = Surface("B", [[0, 0, -100], [900, 0, -100], [0, 90, -200]], [[0, 1, 2]])


def roles(paths: list[Path]) -> dict[str, str]:
    return {g.name: g.role for g in guesses(paths).surfaces}


def test_a_folder_of_every_kind_gives_a_model_that_reads(tmp_path: Path) -> None:
    folder_of(tmp_path, "")
    (tmp_path / "zmap.dat").write_text(PLAIN)
    (tmp_path / "notes.txt").write_text("Dear colleague,\nplease find the horizons enclosed.\n")
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "top.irap").write_text("not even looked at")
    (tmp_path / ".hidden").write_text("nor this")
    made = draft_model([tmp_path], tmp_path / "new.toml")
    assert sorted(g.name for g in made.of("horizon")) == ["p", "top", "top 2", "zmap"]
    # f1.ts and two.ts both have an F1, and that of two.ts is found by its name alone
    assert [g.name for g in made.of("fault")] == ["F1 2", "s", "F1", "F 2", "unstated"]
    assert [Path(file).name for file, _ in made.left_out] == ["notes.txt"]
    text = (tmp_path / "new.toml").read_text(encoding="utf-8")
    model = read_model(tmp_path / "new.toml")
    assert {s.name for s in model.surfaces} == {g.name for g in made.surfaces}
    # beside the surfaces, the sign of z and the unit are guessed
    assert text.count("# guess: ") == len(made.surfaces) + 2
    assert "# - " in text and "notes.txt: line 1" in text
    assert model.name == tmp_path.name
    # a file that names its faults stands there once
    assert text.count('"two.ts"') == 1
    # every line that is taken out of comment is valid too, but for the words of the comments
    keys = [
        line[2:] for line in text.splitlines() if line.startswith("# ") and " = " in line.partition("#")[2]
    ]
    assert all(tomllib.loads(key) for key in keys) and len(keys) > 5


def test_what_a_triangulated_surface_is_taken_for(tmp_path: Path) -> None:
    def called(surface: Surface, name: str) -> Surface:
        return Surface(name, surface.vertices, surface.triangles)

    def only(surface: Surface, kind: str = "top") -> tuple[str, str]:
        write_tsurf(tmp_path / "f.ts", [surface], feature="fault" if kind == "fault" else "top")
        (guess,) = guesses([tmp_path / "f.ts"]).surfaces
        return guess.role, guess.reason

    assert only(FLAT) == ("horizon", "a flat triangulated surface, mean dip 6 degrees, less than 20")
    assert only(STEEP) == ("fault", "a steep triangulated surface, mean dip 48 degrees")
    assert only(FLAT, "fault") == ("fault", "its file calls it 'fault', mean dip 6 degrees")
    assert only(called(FLAT, "North_Fault_2"))[0] == "fault"
    assert only(called(FLAT, "Deep detachment"))[0] == "fault"
    assert only(called(STEEP, "Top Reservoir"))[0] == "horizon"
    assert only(called(STEEP, "Faulty"))[1].startswith("a steep")
    assert only(called(FLAT, "Topmost"))[1].startswith("a flat")


def test_numbers_tell_sticks_and_attributes_do_not(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    rows = np.column_stack([rng.uniform(0, 900, (60, 2)), rng.uniform(-200, -100, 60)])

    def table(name: str, column: np.ndarray) -> None:
        np.savetxt(tmp_path / name, np.column_stack([rows, column]), "%.10g")

    table("sticks", np.arange(60) // 6)
    table("amplitude", rng.normal(size=60))
    table("constant", np.ones(60))
    assert roles([tmp_path]) == {"sticks": "fault", "amplitude": "horizon", "constant": "horizon"}


@pytest.mark.parametrize(
    ("stated", "silent", "z"),
    [
        (None, (1500.0, 1900.0), "depth"),
        (None, (-1900.0, -1500.0), "elevation"),
        # an outcrop above the sea: positive as the fault beside it, which says elevation
        ((0.0, 400.0), (50.0, 300.0), "elevation"),
        ((-2000.0, -1400.0), (1500.0, 1900.0), "depth"),
    ],
)
def test_the_sign_of_z(
    tmp_path: Path, stated: tuple[float, float] | None, silent: tuple[float, float], z: str
) -> None:
    def surface(low: float, high: float) -> Surface:
        return Surface("F", [[0, 0, low], [9, 0, low], [0, 9, high]], [[0, 1, 2]])

    if stated:
        write_tsurf(tmp_path / "f.ts", [surface(*stated)])
    rows = [(0, 0, silent[0]), (9, 0, silent[1]), (0, 9, silent[0])]
    (tmp_path / "p.csv").write_text("X,Y,Z\n" + "".join(f"{x},{y},{v}\n" for x, y, v in rows))
    made = draft_model([tmp_path], tmp_path / "model.toml")
    assert made.z == z and f"{silent[0]:g} to {silent[1]:g}" in made.why_z
    picks = read_model(tmp_path / "model.toml").horizons[0].picks
    assert (picks[:, 2] == np.array([v for *_, v in rows]) * (1 if z == "elevation" else -1)).all()


def test_paths_are_relative_where_they_can_be(tmp_path: Path) -> None:
    (tmp_path / "model" / "data").mkdir(parents=True)
    write_irap_ascii(tmp_path / "model" / "data" / "in.irap", GRID, VALUES)
    write_irap_ascii(tmp_path / "out.irap", GRID, VALUES)
    target = tmp_path / "model" / "model.toml"
    draft_model([tmp_path / "model" / "data" / "in.irap", tmp_path / "model" / ".." / "out.irap"], target)
    files = [h["file"] for h in tomllib.loads(target.read_text(encoding="utf-8"))["horizons"]]
    assert files == ["data/in.irap", (tmp_path / "out.irap").resolve().as_posix()]
    assert len(read_model(target).horizons) == 2


def test_names_that_are_hard_to_write(tmp_path: Path) -> None:
    name = 'a "b" \\ ü\x7f # [x]'
    (tmp_path / "s.pol").write_text(STICKS)
    (tmp_path / "s.pol").rename(tmp_path / f"{name}.pol")
    draft_model([tmp_path], tmp_path / "model.toml")
    assert read_model(tmp_path / "model.toml").faults[0].name == name


def test_a_demo_model_is_guessed_right(tmp_path: Path) -> None:
    write(build("cross", step=200.0), tmp_path)
    given = read_model(tmp_path / "model.toml")
    made = draft_model([tmp_path], tmp_path / "guessed.toml")
    assert [g.name for g in made.of("fault")] == [f.name for f in given.faults]
    assert len(made.of("horizon")) == len(given.horizons) and made.z == given.z


def refused(kind: type[GrabenError], words: str, paths: list[Path], target: Path) -> None:
    before = set(target.parent.iterdir()) if target.parent.is_dir() else None
    with pytest.raises(kind, match=words) as caught:
        draft_model(paths, target)
    assert "\n" not in str(caught.value) and str(caught.value).endswith(".")
    assert (set(target.parent.iterdir()) if target.parent.is_dir() else None) == before


def test_what_cannot_be_done_is_one_sentence(tmp_path: Path) -> None:
    target = tmp_path / "model.toml"
    (tmp_path / "s.pol").write_text(STICKS)
    (tmp_path / "cut.ts").write_text("GOCAD TSurf 1\nTFACE\nVRTX 1 0 0 0\n")
    (tmp_path / "empty").mkdir()
    refused(InputError, "nowhere does not exist", [tmp_path / "nowhere"], target)
    refused(InputError, "cut short", [tmp_path / "s.pol", tmp_path / "cut.ts"], target)
    refused(InputError, "no file holds a surface", [tmp_path / "empty"], target)
    (tmp_path / "empty" / "cut.ts").write_text("GOCAD TSurf 1\n")
    refused(InputError, r"no file holds a surface; .*cut\.ts: the object", [tmp_path / "empty"], target)
    refused(OutputError, "does not exist", [tmp_path / "s.pol"], tmp_path / "no" / "model.toml")
    refused(OutputError, "overwrites nothing", [tmp_path / "s.pol"], tmp_path / "cut.ts")
    target.symlink_to(tmp_path / "nothing")
    refused(OutputError, "overwrites nothing", [tmp_path / "s.pol"], target)
    (tmp_path / "other.toml").write_text("[model]\n")
    refused(InputError, "model already", [tmp_path / "other.toml"], tmp_path / "new.toml")


def test_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from graben.cli import main

    def run(*words: str) -> tuple[object, str, str]:
        with pytest.raises(SystemExit) as caught:
            main(["init", *words])
        out, err = capsys.readouterr()
        return caught.value.code, out, err

    (tmp_path / "s.pol").write_text(STICKS)
    target = str(tmp_path / "model.toml")
    code, out, err = run(str(tmp_path), "-o", target)
    assert (code, err) == (0, "") and "horizons 0, faults 1, not taken 0" in out and target in out
    code, out, err = run(str(tmp_path), "-o", target)
    assert (code, out) == (2, "") and err.count("\n") == 1 and "exists" in err
    Path(target).unlink()
    assert run(str(tmp_path), "-o", target, "-q") == (0, "", "")
    code, out, err = run(str(tmp_path / "nowhere"), "-o", target + "2")
    assert (code, out, err.count("\n")) == (2, "", 1)


@needs_data
@pytest.mark.parametrize("name", ["claudius", "hecho", "drogon"])
def test_real_models_are_guessed_right(tmp_path: Path, name: str) -> None:
    settings = tomllib.loads((DATA / name / "model.toml").read_text(encoding="utf-8"))
    folders = {DATA / name / Path(s["file"]).parent for s in settings["horizons"] + settings["faults"]}
    made = draft_model(sorted(folders), tmp_path / "model.toml")
    horizons = {Path(h["file"]).name for h in settings["horizons"]}
    faults = {Path(f["file"]).name for f in settings["faults"]}
    assert {g.file.name for g in made.of("horizon")} == horizons
    assert {g.file.name for g in made.of("fault")} == faults
    assert made.z == settings["model"]["z"]


@needs_data
def test_real_faults_are_faults() -> None:
    made = guesses([DATA / "cfm"])
    assert (len(made.of("fault")), len(made.of("horizon"))) == (142, 0)
