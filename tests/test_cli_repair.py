"""`graben repair`: exit codes, what it writes and says, and that the input and all else stay as they are."""

from __future__ import annotations

import html
import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pandas as pd
import pytest

from graben.formats.tsurf import read_tsurf
from graben.formats.writing import write_model
from graben.model import Fault, Model
from graben.pipeline import check
from graben.prism import volume
from graben.reading import read_model
from graben.reports.repair_blocks import blocks_of, blocks_words
from graben.schema import schemas
from graben.settings import RepairSettings
from graben.surface import Surface
from tests.commands import graben, started
from tests.reports.check_models import EVIL
from tests.zoo.cases import Case
from tests.zoo.finite import FAILING as UNFIT
from tests.zoo.oriented import FAILING as TURNED
from tests.zoo.self_intersection import FAILING as CROSSED
from tests.zoo.shapes import F60


def doubled(name: str, north: float = 0.0) -> Surface:
    """A fault with a triangle that stands twice, far from its model's origin."""
    surface = F60.moved(np.array([430_000.0, 6_780_000.0 + north, 0.0]))
    return Surface(name, surface.vertices, np.concatenate([surface.triangles, surface.triangles[:1]]))


def sound(name: str, north: float) -> Surface:
    surface = doubled(name, north)
    return Surface(name, surface.vertices, surface.triangles[:-1])


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The model.toml of a demo that passes."""
    folder = tmp_path_factory.mktemp("good") / "cross"
    assert graben("demo", "cross", "--step", "200", "-o", folder).returncode == 0
    return folder / "model.toml"


@pytest.fixture(scope="module")
def bad(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One that fails and can be repaired: of its three faults the middle one is sound."""
    folder = tmp_path_factory.mktemp("bad")
    faults = (doubled("F1"), sound("F2", 3000.0), doubled("F3", 6000.0))
    return write_model(Model("doubled", (), tuple(map(Fault, faults)), z="depth"), folder)


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_a_model_that_passes_is_copied_and_the_report_says_so(good: Path, tmp_path: Path) -> None:
    before = contents(good.parent)
    done = graben("repair", good, "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("PASSED: nothing was changed.")
    assert str(tmp_path / "out" / "report.html") in done.stdout
    written = contents(tmp_path / "out")
    assert {n: c for n, c in written.items() if n in before} == before
    assert set(written) - set(before) == {"report.html", "report.json"}
    report = json.loads(written["report.json"])
    jsonschema.validate(report, schemas()["report.json"])
    assert (report["repairs"], report["left"]) == ([], [])
    assert [f["changed"] for f in report["faults"]] == [False, False]
    assert b"nothing was changed" in written["report.html"]
    assert contents(good.parent) == before


def test_what_fails_is_repaired_and_told(bad: Path, tmp_path: Path) -> None:
    before = contents(bad.parent)
    done = graben("repair", bad, "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("PASSED after repair: 2 changes on 2 of 3 faults.")
    assert re.search(r"^  F1$\n^    weld \(duplicate\): ", done.stdout, re.M)
    assert contents(bad.parent) == before
    written = contents(tmp_path / "out")
    assert written["F2.ts"] == before["F2.ts"]
    assert written["F1.ts"] != before["F1.ts"]
    report = json.loads(written["report.json"])
    jsonschema.validate(report, schemas()["report.json"])
    assert [r["objects"] for r in report["repairs"]] == [["F1"], ["F3"]]
    first = report["repairs"][0]
    assert first["before"][0]["triangles"] == first["after"][0]["triangles"] + 1
    assert [f["changed"] for f in report["faults"]] == [True, False, True]
    assert report["timings"]["total"] >= report["timings"]["repair"] > 0
    result = check(read_model(tmp_path / "out" / "model.toml"))
    assert [f["status"] for f in report["after"]["findings"]] == [str(f.status) for f in result.findings]


def test_repair_twice_is_repair_once(bad: Path, tmp_path: Path) -> None:
    assert graben("repair", bad, "-q", "-o", tmp_path / "one").returncode == 0
    assert graben("repair", tmp_path / "one" / "model.toml", "-q", "-o", tmp_path / "two").returncode == 0
    one, two = (contents(tmp_path / name) for name in ("one", "two"))
    assert {n: c for n, c in one.items() if "report" not in n} == {
        n: c for n, c in two.items() if "report" not in n
    }


def test_the_same_input_gives_the_same_bytes(bad: Path, tmp_path: Path) -> None:
    assert graben("repair", bad, "-q", "-o", tmp_path / "one").returncode == 0
    # another process, in which sets are in another order
    assert started("repair", bad, "-q", "-o", tmp_path / "two", PYTHONHASHSEED="7").returncode == 0
    one, two = (contents(tmp_path / name) for name in ("one", "two"))
    assert one.keys() == two.keys()
    for written in (one, two):
        report = json.loads(written.pop("report.json"))
        del report["timings"], report["peak_memory_mb"]
        written["json"] = json.dumps(report).encode()
        page = written.pop("report.html")
        written["html"] = re.sub(rb"Repaired in [0-9.]+ s; peak memory [0-9]+ MB", b"", page)
    assert one == two


def test_a_dry_run_prints_the_plan_and_writes_nothing(bad: Path, tmp_path: Path) -> None:
    before = contents(bad.parent)
    done = graben("repair", bad, "--dry-run", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "nothing was written" in done.stdout
    assert "weld (duplicate)" in done.stdout
    planned = graben("repair", bad, "--dry-run", "-o", tmp_path / "out", cwd=tmp_path)
    told = [line for line in done.stdout.splitlines() if line.startswith(" ")]
    assert told == [line for line in planned.stdout.splitlines() if line.startswith(" ")]
    assert list(tmp_path.iterdir()) == []
    assert contents(bad.parent) == before
    real = graben("repair", bad, "-o", tmp_path / "out")
    assert told == [line for line in real.stdout.splitlines() if line.startswith(" ")]


def test_what_cannot_be_repaired_is_left_with_advice(tmp_path: Path) -> None:
    skipping = replace(TURNED[0].model, horizons=(), repair=RepairSettings(skip=("orient",)))
    path = write_model(skipping, tmp_path / "in")
    done = graben("repair", path, "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.startswith("NOT PASSED: 1 finding still fails (oriented)")
    assert "To do: " in done.stdout
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert [(left["check"], left["objects"]) for left in report["left"]] == [("oriented", ["F"])]
    assert report["left"][0]["advice"]
    assert graben("repair", path, "--dry-run", "-q").returncode == 1


def test_quiet_and_verbose(bad: Path, tmp_path: Path) -> None:
    done = graben("repair", bad, "-q", "-o", tmp_path / "quiet")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert (tmp_path / "quiet" / "report.json").is_file()
    done = graben("repair", bad, "-v", "--dry-run")
    assert "[3/3] repair: weld" in done.stderr
    assert re.search(r"; [0-9.]+ s, \d+ MB\.$", done.stdout, re.M)


def test_names_made_to_break_a_terminal_or_a_path(tmp_path: Path) -> None:
    faults = tuple(Fault(doubled(name, 3000.0 * k)) for k, name in enumerate([*EVIL, "../../up"]))
    path = write_model(Model(EVIL[2], (), faults), tmp_path / "in")
    done = graben("repair", path, "-v", "-o", tmp_path / "out")
    assert done.returncode == 0
    assert "\x1b" not in done.stdout + done.stderr
    assert "\u202e" not in done.stdout + done.stderr
    names = [f["name"] for f in json.loads((tmp_path / "out" / "report.json").read_text())["faults"]]
    assert names == [*EVIL, "../../up"]
    assert (
        "<b>x" not in (tmp_path / "out" / "report.html").read_text().split("<main", 1)[1].split("<script")[0]
    )
    assert {p.name for p in tmp_path.iterdir()} == {"in", "out"}
    again = read_model(tmp_path / "out" / "model.toml")
    assert [f.name for f in again.faults] == names


@pytest.fixture(scope="module")
def parted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A demo whose fault parts it from side to side, z counted as depth."""
    folder = tmp_path_factory.mktemp("parted")
    assert graben("demo", "exit-both", "--step", "200", "-o", folder / "up").returncode == 0
    up = read_model(folder / "up" / "model.toml")
    return write_model(replace(up, z="depth", truth=None), folder / "down")


def test_blocks_add_up_and_are_told(parted: Path, tmp_path: Path) -> None:
    done = graben("repair", parted, "--blocks", "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert "2 fault blocks between depth 734 and 2277 m (which every fault reaches)" in done.stdout
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    jsonschema.validate(report, schemas()["report.json"])
    told = report["blocks"]
    assert told["depths"] == "shared"
    assert (round(told["top"]), round(told["bottom"])) == (734, 2277)
    table = pd.read_csv(tmp_path / "out" / "blocks" / "blocks.csv")
    assert [b["volume"] for b in told["files"]] == table["volume"].tolist()
    assert sum(table["volume"]) == pytest.approx(told["prism_volume"], rel=1e-9)
    assert told["sum_error"] <= 1e-9
    fault = read_model(parted).faults[0].surface.vertices
    grid = read_model(parted).horizons[0].surface.vertices
    plan = np.prod(np.ptp(grid[:, :2], axis=0))
    assert told["prism_volume"] == pytest.approx(plan * np.ptp(fault[:, 2]))
    for block in told["files"]:
        (read,) = read_tsurf(tmp_path / "out" / block["file"])
        assert read.z == "depth"
        assert volume(read.surface) == pytest.approx(block["volume"])
    page = (tmp_path / "out" / "report.html").read_text()
    assert all(f'href="{b["file"]}">{b["block"]}</a>' in page for b in told["files"])
    assert 'href="blocks/blocks.csv"' in page


def test_no_blocks_where_none_are_asked_for(parted: Path, tmp_path: Path) -> None:
    assert graben("repair", parted, "-q", "-o", tmp_path / "out").returncode == 0
    written = contents(tmp_path / "out")
    assert "blocks" not in json.loads(written["report.json"])
    assert b'id="blocks"' not in written["report.html"]
    assert not (tmp_path / "out" / "blocks").exists()


def test_a_plan_says_what_blocks_there_would_be(parted: Path, tmp_path: Path) -> None:
    done = graben("repair", parted, "--blocks", "--dry-run", "-o", tmp_path / "out")
    assert "2 fault blocks between" in done.stdout
    assert not (tmp_path / "out").exists()


def test_faults_that_share_no_depth_are_cut_over_the_full_range(tmp_path: Path) -> None:
    faults = (sound("F1", 0.0), sound("F2", 9000.0).moved(np.array([0.0, 0.0, -9000.0])))
    path = write_model(Model("apart", (), tuple(map(Fault, faults))), tmp_path / "in")
    done = graben("repair", path, "--blocks", "-o", tmp_path / "out")
    assert done.returncode == 0
    assert "the full range of the model, whose faults share no depths" in " ".join(done.stdout.split())
    told = json.loads((tmp_path / "out" / "report.json").read_text())["blocks"]
    levels = np.concatenate([f.vertices[:, 2] for f in faults])
    assert (told["depths"], told["top"], told["bottom"]) == ("full", levels.max(), levels.min())


def test_blocks_that_cannot_be_made_are_told_and_change_no_exit_code(tmp_path: Path) -> None:
    model = replace(CROSSED[0].model, horizons=(), repair=RepairSettings(skip=("uncross",)))
    path = write_model(model, tmp_path / "in")
    plain = graben("repair", path, "-o", tmp_path / "plain")
    done = graben("repair", path, "--blocks", "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (plain.returncode, "")
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    jsonschema.validate(report, schemas()["report.json"])
    reason = report["blocks"]["reason"]
    assert "crosses itself" in reason
    assert f"No fault blocks: {reason}" in " ".join(done.stdout.split())
    assert reason in html.unescape((tmp_path / "out" / "report.html").read_text())
    assert not (tmp_path / "out" / "blocks").exists()


@pytest.mark.parametrize("case", [c for c in UNFIT if c.model.faults], ids=lambda case: case.name)
def test_blocks_of_unfit_faults_are_refused_with_the_name(case: Case) -> None:
    made = blocks_of(case.model)
    assert made.blocks == ()
    assert any(s.name in made.reason for s in case.model.surfaces)
    assert blocks_words(made, case.model) == f"No fault blocks: {made.reason}"


def test_a_model_without_faults_is_one_block_or_says_why_not(good: Path, tmp_path: Path) -> None:
    model = replace(read_model(good), faults=(), truth=None)
    path = write_model(model, tmp_path / "in")
    done = graben("repair", path, "--blocks", "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert "1 fault block between" in done.stdout
    assert "(the full range of the model)" in done.stdout


def test_a_file_called_blocks_stays(parted: Path, tmp_path: Path) -> None:
    shutil.copytree(parted.parent, tmp_path / "in")
    text = (tmp_path / "in" / "model.toml").read_text()
    (name,) = re.findall(r'file = "(.*irap.*)"', text)
    (tmp_path / "in" / name).rename(tmp_path / "in" / "blocks")
    (tmp_path / "in" / "model.toml").write_text(text.replace(name, "blocks"))
    done = graben("repair", tmp_path / "in" / "model.toml", "--blocks", "-q", "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "out" / "blocks").is_file()
    told = json.loads((tmp_path / "out" / "report.json").read_text())["blocks"]
    assert all((tmp_path / "out" / b["file"]).is_file() for b in told["files"])


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["nowhere.toml", "-o", "out"], "nowhere.toml"),
        (["nowhere.toml"], "-o"),
        ([], "MODEL"),
        (["nowhere.toml", "--dry-run"], "nowhere.toml"),
        (["nowhere.toml", "-o", "out", "--profile", "mine"], "mine"),
        (["nowhere.toml", "-o"], "-o"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else None,
)
def test_wrong_commands_end_with_one_sentence(words: list[str], says: str, tmp_path: Path) -> None:
    done = graben("repair", *words, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr
    assert says.lower() in done.stderr.lower()
    assert list(tmp_path.iterdir()) == []


def test_damaged_files_end_with_one_sentence(bad: Path, tmp_path: Path) -> None:
    for number, damage in enumerate((b"", b"\x00\xff" * 40, b"GOCAD TSurf 1\nVRTX 1 a b c\nEND\n")):
        folder = tmp_path / f"in{number}"
        folder.mkdir()
        for path in bad.parent.iterdir():
            (folder / path.name).write_bytes(path.read_bytes())
        (folder / "F3.ts").write_bytes(damage)
        done = graben("repair", folder / "model.toml", "-o", tmp_path / "out")
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.count("\n") == 1
        assert "F3.ts" in done.stderr
        assert not (tmp_path / "out").exists()
        assert not (tmp_path / "out.partial").exists()


def test_nothing_is_overwritten(bad: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("all I have")
    done = graben("repair", bad, "-o", tmp_path / "mine")
    assert done.returncode == 2
    assert "not empty" in done.stderr
    assert contents(tmp_path) == {"mine/thesis.txt": b"all I have"}
    done = graben("repair", bad, "-o", bad.parent)
    assert done.returncode == 2
