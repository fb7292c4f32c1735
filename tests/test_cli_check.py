"""`graben check`: exit codes, what goes where, and that nothing of the user's is overwritten."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import jsonschema
import pytest
from junitparser import Error, JUnitXml
from sarif_kit.validate import validation_errors

from graben import output
from graben.cli import main
from graben.errors import OutputError
from graben.formats.writing import write_model
from graben.reports.check_files import REPORTS, STDOUT, require_targets
from graben.schema import schemas
from tests.commands import graben
from tests.reports.check_models import EVIL, evil_model, with_sliver
from tests.zoo import FAILING
from tests.zoo.shapes import F60, faults

#: Those that need no maps, and so little time.
KINDS = ("json", "junit", "sarif", "geojson")


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The model.toml of a demo that passes."""
    folder = tmp_path_factory.mktemp("good") / "single"
    assert graben("demo", "single", "--step", "200", "-o", folder).returncode == 0
    return folder / "model.toml"


@pytest.fixture(scope="module")
def bad(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The model.toml of a model that fails, with names that formats trip over."""
    return write_model(evil_model(), tmp_path_factory.mktemp("bad"))


@dataclass(frozen=True)
class Done:
    """How a command ended and what it said."""

    returncode: int
    stdout: str
    stderr: str


Check = Callable[..., Done]


@pytest.fixture
def check(capfd: pytest.CaptureFixture[str]) -> Iterator[Check]:
    """Runs `graben check` in this process, which saves the time to start one."""
    before = signal.getsignal(signal.SIGINT)

    def run(*words: object) -> Done:
        with pytest.raises(SystemExit) as ended:
            main(["check", *map(str, words)])
        out, err = capfd.readouterr()
        return Done(int(ended.value.code or 0), out, err)

    yield run
    signal.signal(signal.SIGINT, before)


def options(folder: Path, kinds: tuple[str, ...] = KINDS) -> list[str]:
    return [word for kind in kinds for word in (f"--{kind}", str(folder / f"found.{kind}"))]


def content(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_a_model_that_passes(check: Check, good: Path, tmp_path: Path) -> None:
    before = content(good.parent)
    done = check(good, *options(tmp_path))
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("PASSED: no check fails")
    assert "0 fail" in done.stdout
    assert {p.name for p in tmp_path.iterdir()} == {f"found.{kind}" for kind in KINDS}
    assert json.loads((tmp_path / "found.json").read_text())["passed"] is True
    assert content(good.parent) == before


def test_a_model_that_fails(check: Check, bad: Path, tmp_path: Path) -> None:
    done = check(bad, *options(tmp_path))
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.startswith("NOT PASSED: 1 check fails (degenerate)")
    for name in EVIL[:2]:
        assert name in done.stdout
    assert "\x1b" not in done.stdout
    found = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))
    jsonschema.validate(found, schemas()["check"])
    assert {f["objects"][0] for f in found["findings"] if f["status"] == "fail"} == set(EVIL)


def test_the_same_input_gives_the_same_bytes(check: Check, bad: Path, tmp_path: Path) -> None:
    assert check(bad, "-q", *options(tmp_path)) == Done(1, "", "")
    first = content(tmp_path)
    command = [sys.executable, "-m", "graben.cli", "check", str(bad), "-q", *options(tmp_path)]
    # another process, in which sets are in another order
    done = subprocess.run(
        command, env={**os.environ, "PYTHONHASHSEED": "7"}, capture_output=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (1, b"", b"")
    assert without_seconds(content(tmp_path)) == without_seconds(first)


def without_seconds(files: dict[str, bytes]) -> dict[str, bytes]:
    return {name: re.sub(rb'(<testsuites [^>]* time=)"[0-9.]+"', rb"\1", own) for name, own in files.items()}


def test_one_file_may_go_to_stdout(check: Check, bad: Path, tmp_path: Path) -> None:
    assert check(bad, "--sarif", tmp_path / "found.sarif").returncode == 1
    done = check(bad, "--sarif", "-")
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.encode() == (tmp_path / "found.sarif").read_bytes()
    loud = check(bad, "--json", "-", "-v")
    assert json.loads(loud.stdout)["passed"] is False
    assert "\nNOT PASSED: " in loud.stderr


def test_a_reader_that_closes_the_pipe_changes_no_verdict(bad: Path) -> None:
    command = [sys.executable, "-m", "graben.cli", "check", str(bad), "--geojson", "-"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    said = process.stderr.read()
    process.stderr.close()
    assert (process.wait(timeout=60), said) == (1, b"")


def test_plain_ascii_is_enough(bad: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "graben.cli", "check", str(bad)],
        capture_output=True,
        env={**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"},
        check=False,
    )
    assert (done.returncode, done.stderr) == (1, b"")
    assert b"\\U0001f52c" in done.stdout
    done = subprocess.run(
        [sys.executable, "-m", "graben.cli", "check", str(bad), "--json", "-"],
        capture_output=True,
        env={**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"},
        check=False,
    )
    assert EVIL[2] in done.stdout.decode("utf-8")


@pytest.mark.parametrize("kind", REPORTS)
def test_a_foreign_file_is_not_touched(kind: str, bad: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    for text in ("my thesis", "", '{"schema": 1}'):
        mine.write_text(text)
        with pytest.raises(OutputError, match=f"^--{kind}: .*overwrites nothing"):
            require_targets({kind: mine}, bad)
        assert mine.read_text() == text


def test_a_foreign_file_ends_it_before_any_check(check: Check, tmp_path: Path) -> None:
    (tmp_path / "mine.json").write_text("[]")
    # the model is not even read: it does not exist
    done = check("nowhere.toml", "--json", tmp_path / "mine.json", "--junit", tmp_path / "new.xml")
    assert done.returncode == 2
    assert "mine.json exists" in done.stderr
    assert content(tmp_path) == {"mine.json": b"[]"}


def test_a_report_of_its_own_is_replaced(check: Check, good: Path, bad: Path, tmp_path: Path) -> None:
    assert check(bad, *options(tmp_path)).returncode == 1
    first = content(tmp_path)
    assert check(good, *options(tmp_path)).returncode == 0
    assert all(first[name] != now for name, now in content(tmp_path).items())
    # as the kind that it is, and no other
    done = check(good, "--sarif", tmp_path / "found.json")
    assert (done.returncode, done.stdout) == (2, "")


def test_the_html_page_says_whose_it_is(check: Check, tmp_path: Path) -> None:
    model = write_model(faults(with_sliver(F60, "<b>x")), tmp_path / "model")
    page = tmp_path / "found.html"
    done = check(model, "--html", page)
    assert (done.returncode, done.stderr) == (1, "")
    assert "<b>x" in done.stdout
    assert "<b>x" not in page.read_text(encoding="utf-8")
    require_targets({"html": page}, model)


@pytest.mark.parametrize(
    ("targets", "says"),
    [
        ({"json": "model.toml/x"}, "model.toml is a file"),
        ({"json": "."}, "is a folder"),
        ({"json": ""}, "is a folder"),
        ({"json": "model.toml"}, "is the model itself"),
        ({"json": "folder/../model.toml"}, "is the model itself"),
        ({"sarif": "linked"}, "is the model itself"),
        ({"sarif": "dangling"}, "--sarif: .*is a link"),
        ({"html": "a", "junit": "folder/../a"}, "--html and --junit both go to"),
        ({"json": "-", "junit": "-"}, "both go to stdout"),
        ({"json": "n" * 300}, "too long"),
        ({"json": os.devnull}, "is a link, a device or a pipe"),
        ({"geojson": "1.ts"}, "overwrites nothing"),
    ],
    ids=lambda value: str(value)[:30] if isinstance(value, dict) else None,
)
def test_targets_that_cannot_be_written(
    targets: dict[str, str], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("model.toml").write_text("[model]")
    Path("1.ts").write_text("GOCAD TSurf 1")
    Path("folder").mkdir()
    Path("linked").symlink_to("model.toml")
    Path("dangling").symlink_to("nothing")
    before = content(tmp_path)
    with pytest.raises(OutputError, match=says) as error:
        require_targets({kind: Path(target) for kind, target in targets.items()}, Path("model.toml"))
    assert "\n" not in str(error.value)
    assert content(tmp_path) == before
    require_targets({"json": Path("new"), "html": Path("folder/new"), "sarif": STDOUT}, Path("model.toml"))


@pytest.mark.parametrize(
    ("words", "says"),
    [(["--json"], "argument"), (["--xml", "a"], "--xml"), (["--profile", "mine"], "mine")],
    ids=lambda value: " ".join(value) if isinstance(value, list) else None,
)
def test_wrong_commands_end_with_one_sentence(
    check: Check, words: list[str], says: str, tmp_path: Path
) -> None:
    done = check(tmp_path / "model.toml", *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert says in done.stderr


def test_what_cannot_be_read_ends_with_2(check: Check, tmp_path: Path) -> None:
    (tmp_path / "model.toml").write_text('[model]\nname = "M"\n[[faults]]\nname = "F"\nfile = "1.ts"\n')
    for words in ([tmp_path / "model.toml"], [tmp_path / "nowhere.toml"], []):
        done = check(*words)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.count("\n") == 1


def test_no_old_verdict_stays_where_the_model_cannot_be_read(
    check: Check, good: Path, tmp_path: Path
) -> None:
    kinds = (*KINDS, "html")
    assert check(good, *options(tmp_path, kinds)).returncode == 0
    done = check(tmp_path / "nowhere.toml", *options(tmp_path, kinds))
    assert (done.returncode, done.stdout) == (2, "")
    sentence = done.stderr.removeprefix("graben: ").strip()
    assert "nowhere.toml" in sentence
    # what has no word for an error is removed
    assert {p.name for p in tmp_path.iterdir()} == {"found.json", "found.junit", "found.sarif"}
    told = json.loads((tmp_path / "found.json").read_text())
    jsonschema.validate(told, schemas()["check"])
    assert (told["passed"], told["findings"], told["error"]) == (False, [], sentence)
    suites = JUnitXml.fromstring((tmp_path / "found.junit").read_bytes())
    (case,) = next(iter(suites))
    assert (suites.errors, suites.failures, suites.tests) == (1, 0, 1)
    assert isinstance(case.result[0], Error)
    assert case.result[0].message == sentence
    log = json.loads((tmp_path / "found.sarif").read_text())
    assert not validation_errors(log)
    (run,) = log["runs"]
    (invocation,) = run["invocations"]
    assert (invocation["executionSuccessful"], run["results"]) == (False, [])
    (told,) = invocation["toolExecutionNotifications"]
    assert (told["level"], told["message"]["text"]) == ("error", sentence)
    # they are graben's own, and give way to the next check
    assert check(good, *options(tmp_path, kinds)).returncode == 0
    assert json.loads((tmp_path / "found.json").read_text())["passed"] is True


def test_an_error_goes_to_stdout_where_the_report_would(check: Check, tmp_path: Path) -> None:
    done = check(tmp_path / "nowhere.toml", "--json", "-")
    assert done.returncode == 2
    assert json.loads(done.stdout)["error"] in done.stderr
    assert check(tmp_path / "nowhere.toml", "--geojson", "-").stdout == ""


def test_a_foreign_file_stays_when_the_model_cannot_be_read(check: Check, tmp_path: Path) -> None:
    (tmp_path / "mine.html").write_text("my thesis")
    assert check(tmp_path / "nowhere.toml", "--html", tmp_path / "mine.html").returncode == 2
    assert content(tmp_path) == {"mine.html": b"my thesis"}


def test_folders_of_reports_are_made(check: Check, good: Path, tmp_path: Path) -> None:
    assert check(good, "-q", "--junit", tmp_path / "sub" / "dir" / "x.xml").returncode == 0
    assert (tmp_path / "sub" / "dir" / "x.xml").is_file()
    # not before the check has begun
    assert check(good, "-q", "--junit", tmp_path / "new" / "x.xml", "--json", good).returncode == 2
    assert not (tmp_path / "new").exists()


def test_warnings_may_end_with_1(check: Check, good: Path, tmp_path: Path) -> None:
    warning = next(case for case in FAILING if case.extended == "warn")
    model = write_model(warning.model, tmp_path)
    assert check(model, "-q").returncode == 0
    assert check(model, "-q", "--fail-on", "fail").returncode == 0
    assert check(model, "-q", "--fail-on", "warn").returncode == 1
    assert check(good, "-q", "--fail-on", "warn").returncode == 0


def test_profiles(check: Check, tmp_path: Path) -> None:
    relaxed = next(case for case in FAILING if case.extended == "warn" and case.paper == "fail")
    model = write_model(relaxed.model, tmp_path)
    codes = [check(model, "-q", "--profile", name).returncode for name in ("paper", "extended")]
    assert codes == [1, 0]


def test_verbose_lists_what_passed_and_how_long_it_took(check: Check, good: Path) -> None:
    quiet, loud = check(good).stdout, check(good, "-v").stdout
    assert "Coordinates are finite numbers" not in quiet
    assert "Coordinates are finite numbers" in loud
    assert re.search(r"^\d+\.\d s, largest memory \d+ MiB\.$", loud, re.MULTILINE)


def test_files_appear_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept, new = tmp_path / "kept", tmp_path / "new"
    kept.write_bytes(b"before")
    # an error at the second of two
    with pytest.raises(OutputError, match="nowhere"):
        output.write_whole({kept: b"after", tmp_path / "kept" / "nowhere": b""})
    assert content(tmp_path) == {"kept": b"before"}

    def interrupted(self: Path, target: Path) -> Path:
        assert len(list(tmp_path.glob(".graben-*.partial"))) == 2
        output.drop_partial()
        raise OSError(5, "interrupted")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", interrupted)
        with pytest.raises(OutputError, match="interrupted"):
            output.write_whole({kept: b"after", new: b"new"})
    assert content(tmp_path) == {"kept": b"before"}
    output.write_whole({kept: b"after", new: b"new"})
    assert content(tmp_path) == {"kept": b"after", "new": b"new"}


@pytest.mark.skipif(
    not Path("/proc/self/maps").exists(), reason="needs /proc to see what a process has loaded"
)
def test_interrupt_leaves_nothing(bad: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "graben.cli", "check", str(bad), *options(tmp_path)]
    for pause in (0.0, 0.6, 1.2):
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        maps = Path(f"/proc/{process.pid}/maps")
        while process.poll() is None and "numpy" not in maps.read_text():
            time.sleep(0.02)
        time.sleep(pause)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
        if process.returncode in (1, -signal.SIGINT):
            break  # it had ended, or Python was on its way out, where the signal is its own again
        assert (process.returncode, said) == (130, b"graben: interrupted.\n")
        # between two renames, those already whole may be there
        assert not list(tmp_path.glob("*.partial"))
        assert all(REPORTS[p.suffix[1:]].ours(p.read_bytes()) for p in tmp_path.iterdir())
