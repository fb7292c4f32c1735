"""The command line: exit codes, one sentence on stderr, whole folders or none, the same bytes twice."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import pyvista
import surfio

from graben.schema import schemas
from tests.commands import graben, started


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("demo") / "single"
    assert graben("demo", "single", "-o", folder).returncode == 0
    return folder


@dataclass(frozen=True)
class Run:
    """A run in a process of its own: its folder, what it said, and the seconds that it took in all."""

    folder: Path
    stdout: str
    wall: float


@pytest.fixture(scope="module")
def alone(demo: Path) -> Run:
    out = demo.parent / "out"
    begin = time.perf_counter()
    done = started("run", demo / "model.toml", "-o", out)
    wall = time.perf_counter() - begin
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert str(out / "report.html") in done.stdout
    return Run(out, done.stdout, wall)


@pytest.fixture(scope="module")
def ran(alone: Run) -> Path:
    return alone.folder


def test_a_run_writes_what_it_says(ran: Path) -> None:
    report = json.loads((ran / "report.json").read_text())
    jsonschema.validate(report, schemas()["report.json"])
    (horizon,) = report["horizons"]
    assert horizon["score"]["cutoff"]["percent"] < 4.0
    files = horizon["files"]
    assert all((ran / f).is_file() for f in files.values())
    mesh = pyvista.read(ran / "horizons" / "Top.vtp")
    assert {"subdomain", "fixed", "side"} <= set(mesh.point_data)
    assert mesh.n_points == horizon["nodes"]
    grid = surfio.IrapSurface.from_ascii_file(ran / "horizons" / "Top.irap")
    assert np.isfinite(grid.values).mean() > 0.9
    lines = (ran / "cutoffs" / "Top.csv").read_text().splitlines()
    assert lines[0].startswith("fault,side,s,x,y,z,throw,heave")
    assert [line.split(",")[1] for line in lines[1:5]] == ["hanging", "foot", "hanging", "foot"]
    assert not (ran / ".graben-partial").exists()
    assert not ran.with_name("out.partial").exists()


def test_the_repaired_model_is_a_valid_input(ran: Path, tmp_path: Path) -> None:
    again = graben("run", ran / "model" / "model.toml", "-o", tmp_path / "again")
    assert again.returncode == 0, again.stderr
    first, second = ((folder / "cutoffs" / "Top.csv").read_bytes() for folder in (ran, tmp_path / "again"))
    assert first == second


def test_the_same_input_gives_the_same_bytes(demo: Path, ran: Path, tmp_path: Path) -> None:
    assert graben("run", demo / "model.toml", "-o", tmp_path / "twice").returncode == 0
    for file in sorted(p.relative_to(ran) for p in ran.rglob("*") if p.is_file()):
        first, second = (ran / file).read_bytes(), (tmp_path / "twice" / file).read_bytes()
        if file.name == "report.json":
            reports = [json.loads(text) for text in (first, second)]
            for report in reports:
                del report["timings"], report["peak_memory_mb"]
            assert reports[0] == reports[1]
        elif file.name != "report.html":  # it shows the timings
            assert first == second, file


def test_nothing_is_overwritten(demo: Path, tmp_path: Path) -> None:
    kept = tmp_path / "mine"
    kept.mkdir()
    (kept / "thesis.txt").write_text("all I have")
    done = graben("run", demo / "model.toml", "-o", kept)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "not empty" in done.stderr
    assert [p.name for p in kept.iterdir()] == ["thesis.txt"]
    partial = tmp_path / "out.partial"
    partial.mkdir()
    (partial / "thesis.txt").write_text("all I have")
    done = graben("run", demo / "model.toml", "-o", tmp_path / "out")
    assert done.returncode == 2
    assert (partial / "thesis.txt").read_text() == "all I have"


def test_an_empty_folder_may_be_used(demo: Path, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    assert graben("demo", "exit", "-o", tmp_path / "out").returncode == 0
    assert (tmp_path / "out" / "model.toml").is_file()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["run", "nowhere.toml", "-o", "out"], "nowhere.toml"),
        (["run"], "MODEL"),
        (["run", "x.toml"], "output"),
        (["demo", "single"], "-o"),
        (["demo", "nothing", "-o", "out"], "nothing"),
        (["demo", "single", "--step", "-3", "-o", "out"], "step"),
        (["info", "nowhere.ts"], "nowhere.ts"),
        (["fold"], "fold"),
        (["run", "--profile", "mine", "x", "-o", "out"], "mine"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else None,
)
def test_wrong_commands_end_with_one_sentence(words: list[str], says: str, tmp_path: Path) -> None:
    done = graben(*words, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr
    assert says.lower() in done.stderr.lower()
    assert list(tmp_path.iterdir()) == []


def test_debug_shows_where(tmp_path: Path) -> None:
    done = started("run", "nowhere.toml", "-o", "out", "--debug", cwd=tmp_path)
    assert done.returncode == 2
    assert "Traceback" in done.stderr


def test_unfit_data_are_repaired_or_end_with_a_finding(demo: Path, tmp_path: Path) -> None:
    for name in ("model.toml", "top.irap"):
        (tmp_path / name).write_bytes((demo / name).read_bytes())
    text = (demo / "F1.ts").read_text()
    broken = re.sub(r"^(VRTX 7) \S+", r"\1 NaN", text, flags=re.M)
    assert broken != text
    (tmp_path / "F1.ts").write_text(broken)
    model = (tmp_path / "model.toml").read_text()
    (tmp_path / "model.toml").write_text(re.sub(r"^truth.*\n", "", model, flags=re.M))
    done = graben("run", tmp_path / "model.toml", "-o", tmp_path / "left", "--no-repair")
    assert done.returncode == 1, done.stderr
    report = json.loads((tmp_path / "left" / "report.json").read_text())
    assert [f["objects"] for f in report["after"]["findings"] if f["status"] == "fail"] == [["F1"]]
    done = graben("run", tmp_path / "model.toml", "-o", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert [action["check"] for action in report["repairs"]] == ["finite"]


@pytest.mark.skipif(
    not Path("/proc/self/maps").exists(), reason="needs /proc to see what a process has loaded"
)
def test_interrupt_leaves_nothing(demo: Path, tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "graben.cli",
        "run",
        str(demo / "model.toml"),
        "-o",
        str(tmp_path / "out"),
    ]
    for pause in (0.0, 0.7, 1.4, 2.1):
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        # Before the program itself runs, Python answers the signal: numpy is loaded by the program.
        maps = Path(f"/proc/{process.pid}/maps")
        while process.poll() is None and "numpy" not in maps.read_text():
            time.sleep(0.02)
        time.sleep(pause)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
        if process.returncode == 0:
            break
        assert process.returncode == 130
        assert said in (b"graben: interrupted.\n", NOTHING_KEPT)
        assert list(tmp_path.iterdir()) == []


NOTHING_KEPT = b"graben: interrupted before anything was finished that --resume could go on from"
NOTHING_KEPT += b": start again without --resume.\n"


def interrupt(words: list[str], output: Path, code: str) -> tuple[int, str]:
    """Run a command in which SIGINT comes when ``code`` says, and return how it ended and what it said."""
    script = (
        "import os, signal, graben.pipeline, graben.cli\n"
        "stop = lambda *args, **more: os.kill(os.getpid(), signal.SIGINT)\n"
        f"{code}\n"
        f"graben.cli.main({[*words, '-o', str(output)]!r})\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    return done.returncode, done.stderr


def test_an_interrupt_says_whether_there_is_something_to_resume(demo: Path, tmp_path: Path) -> None:
    out, words = tmp_path / "out", ["run", str(demo / "model.toml")]
    early = "graben.pipeline.build = stop"
    assert interrupt(words, out, early) == (130, NOTHING_KEPT.decode())
    assert not (tmp_path / "out.partial").exists()
    # what the message says is so
    assert "nothing to resume" in graben("run", demo / "model.toml", "-o", out, "--resume").stderr
    late = (
        "def build(*args, kept, **more):\n"
        "    kept['horizon-1'] = b'work'\n"
        "    stop()\n"
        "graben.pipeline.build = build"
    )
    said = (130, "graben: interrupted; --resume goes on from what is finished.\n")
    assert interrupt(words, out, late) == said
    # before the folder is taken up again as well
    assert (
        interrupt([*words, "--resume"], out, "import graben.reading; graben.reading.read_model = stop")
        == said
    )
    assert graben("run", demo / "model.toml", "-o", out, "--resume").returncode == 0


def test_an_interrupt_of_another_command_speaks_of_no_resume(demo: Path, tmp_path: Path) -> None:
    code = "import graben.reading; graben.reading.read_model = stop"
    assert interrupt(["repair", str(demo / "model.toml")], tmp_path / "out", code) == (
        130,
        "graben: interrupted.\n",
    )


def test_the_seconds_are_those_of_the_whole_command(alone: Run) -> None:
    found = re.search(r"; ([0-9.]+) s, \d+ MB\.", alone.stdout)
    assert found is not None
    timings = json.loads((alone.folder / "report.json").read_text())["timings"]
    # reading and loading count, and the parts of the total are in it
    assert timings["read"] > 0
    assert timings["total"] <= float(found[1]) + 0.01 <= alone.wall + 0.02
    assert timings["total"] >= timings["read"] + timings["check"] + timings["write"]


def test_common_options_stand_before_the_command_as_well(demo: Path, tmp_path: Path) -> None:
    assert graben("-q", "check", demo / "model.toml").stdout == ""
    assert "Traceback" in graben("--debug", "check", tmp_path / "nowhere.toml").stderr
    assert "Traceback" in graben("-v", "--debug", "info", tmp_path / "nowhere.ts").stderr
    for words in ((), ("--debug",)):
        done = graben(*words)
        assert (done.returncode, done.stderr) == (2, "graben: Missing command.\n")


def test_demo_list_info_and_schema(demo: Path) -> None:
    listed = graben("demo", "--list")
    assert listed.returncode == 0
    names = {line.split()[0] for line in listed.stdout.splitlines()}
    assert {"single", "exit", "cross", "tee", "reverse", "low-dip"} <= names
    said = graben("info", demo / "F1.ts")
    assert said.returncode == 0
    assert "dip" in said.stdout.lower()
    assert set(json.loads(graben("schema").stdout)) >= {"model.toml", "report.json"}
    assert started("--help").returncode == 0
    assert graben("run", "--help").returncode == 0


def test_quiet_says_nothing(demo: Path, tmp_path: Path) -> None:
    done = graben("demo", "single", "-q", "-o", tmp_path / "out")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_read_only_folder_is_an_error(demo: Path, tmp_path: Path) -> None:
    if os.geteuid() == 0:
        target = Path("/proc/graben-out")
    else:
        tmp_path.chmod(0o500)
        target = tmp_path / "out"
    done = graben("demo", "single", "-o", target)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
