"""Runs that were broken off: what is kept, what is done again, what is refused; horizons side by side."""

from __future__ import annotations

import json
import re
import shutil
import signal
import struct
import subprocess
import sys
from collections.abc import Mapping
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graben import horizons, resuming
from graben.cluster import cluster
from graben.errors import GrabenError, ModelingError, OutputError
from graben.formats.writing import write_model
from graben.keeping import NotKeptError, from_bytes, to_bytes
from graben.model import Fault, Model
from graben.output import KEPT, partial_folder, whole_folder
from graben.pipeline import RunResult, build
from graben.reading import read_model
from graben.reports.writing import write_run
from graben.resuming import KeptFolder, manifest, require_resumable
from graben.settings import Parameters
from tests.commands import Done, graben
from tests.models import grid_horizon, plane_fault

NAMES = ("Top A", "Top/B", "Base", "Deep")
DEEP = ("Top/B", "Deep")
#: Ends the process by a signal once so many horizons are kept, and says which are rebuilt.
SCRIPT = """
import os, sys
from graben import cli, horizons, pipeline, resuming
number, count, words = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]
plain, rebuilt, mended = resuming.KeptFolder.__setitem__, horizons.rebuilt, pipeline.mended
def keep(self, key, content):
    plain(self, key, content)
    if key != "repair" and sum(name != "repair" for name in self) == count:
        os.kill(os.getpid(), number)
def repaired(*given):
    print("repaired", flush=True)
    return mended(*given)
def told(model, prepared, network, **options):
    print("rebuilt", prepared.horizon.name, flush=True)
    return rebuilt(model, prepared, network, **options)
resuming.KeptFolder.__setitem__, horizons.rebuilt, pipeline.mended = keep, told, repaired
if __name__ == "__main__":
    cli.main(words)
"""


def watched(number: int, count: int, *words: object) -> Done:
    """Run with SCRIPT: signal ``number`` after ``count`` horizons, never with a count of 0."""
    command = [sys.executable, "-c", SCRIPT, str(int(number)), str(count), *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


def layers(*names: str, damaged: bool = True) -> Model:
    """Horizons across one fault or, those of DEEP, below it; a damaged fault has triangles twice."""

    def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return -40.0 * np.tanh(x / 100.0) * np.maximum(1 - (y / 1500) ** 2, 0) ** 1.5

    tops = tuple(
        grid_horizon(
            lambda x, y, k=k, name=name: height(x, y) - 90.0 * k - 2000.0 * (name in DEEP),
            step=125.0,
            name=name,
        )
        for k, name in enumerate(names)
    )
    surface = plane_fault((0, -1500), (60, 1500), depth=700.0).surface
    if damaged:
        surface = replace(surface, triangles=np.concatenate([surface.triangles, surface.triangles[:2]]))
    return Model("four", tops, (Fault(surface),), parameters=Parameters(gamma=500.0))


def contents(folder: Path) -> dict[str, bytes]:
    """Every file of a finished run but for timings and peak memory."""
    found = {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    report = json.loads(found["report.json"])
    del report["timings"], report["peak_memory_mb"]
    found["report.json"] = json.dumps(report).encode()
    page, cuts = re.subn(
        rb'<section aria-labelledby="settings">.*?</section>', b"", found["report.html"], flags=re.S
    )
    assert cuts == 1
    found["report.html"] = page
    return found


def same(one: Any, other: Any) -> bool:
    """Whether two values are the same to the bit, their types as well, but for those of mappings."""
    if isinstance(one, Mapping):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    alike = type(one) is type(other)
    if isinstance(one, np.ndarray):
        alike = alike and (one.dtype, one.shape, one.tobytes()) == (other.dtype, other.shape, other.tobytes())
    elif isinstance(one, float):
        alike = alike and struct.pack("d", one) == struct.pack("d", other)
    elif is_dataclass(one) and not isinstance(one, type):
        alike = alike and all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    elif isinstance(one, tuple | list):
        alike = alike and len(one) == len(other) and all(map(same, one, other))
    else:
        alike = alike and bool(one == other)
    return alike


def outcome(result: RunResult) -> tuple[Any, ...]:
    """All that a run gives but its timings."""
    plain = [
        replace(h, seconds={}, subdomains=tuple(replace(s, seconds={}) for s in h.subdomains))
        for h in result.horizons
    ]
    return (plain, result.repaired.faults, result.before, result.after, result.repairs, result.left)


@pytest.fixture(scope="module")
def four(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_model(layers(*NAMES), tmp_path_factory.mktemp("four"))


@pytest.fixture(scope="module")
def four_result(four: Path) -> RunResult:
    return build(read_model(four))


@pytest.fixture(scope="module")
def unbroken(four_result: RunResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The DIR of a run that nothing broke off."""
    folder = tmp_path_factory.mktemp("unbroken")
    write_run(four_result, folder)
    return folder


@pytest.fixture(scope="module")
def killed(four: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The DIR of a run that was killed after two of four horizons."""
    folder = tmp_path_factory.mktemp("killed")
    done = watched(signal.SIGKILL, 2, "run", four, "-o", folder / "out")
    assert done.returncode == -signal.SIGKILL, done.stderr
    return folder / "out"


@pytest.fixture(scope="module")
def result() -> RunResult:
    return build(layers("A", "B"))


def copied(out: Path, folder: Path) -> Path:
    shutil.copytree(out.with_name("out.partial"), folder / "out.partial")
    return folder / "out"


def test_a_killed_run_goes_on_where_it_was(four: Path, unbroken: Path, killed: Path, tmp_path: Path) -> None:
    out = copied(killed, tmp_path / "a")
    kept = sorted(p.name for p in (tmp_path / "a" / "out.partial" / KEPT).iterdir())
    assert kept == ["horizon-1.npz", "horizon-2.npz", "manifest.json", "repair.npz"]
    assert not killed.exists()
    done = watched(signal.SIGKILL, 0, "run", four, "-o", out, "--resume")
    assert (done.returncode, done.stderr) == (0, "")
    assert sorted(re.findall("^(repaired|rebuilt .*)$", done.stdout, re.M)) == [
        "rebuilt Base",
        "rebuilt Deep",
    ]
    assert contents(out) == contents(unbroken)
    assert len(json.loads((out / "report.json").read_text())["repairs"]) == 1
    assert [p.name for p in out.parent.iterdir()] == ["out"]


def test_an_interrupted_run_can_be_resumed(four: Path, four_result: RunResult, tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    out = tmp_path / "a" / "out"
    done = watched(signal.SIGINT, 1, "run", four, "-o", out)
    assert done.returncode == 130
    assert done.stderr == "graben: interrupted; --resume goes on from what is finished.\n"
    assert [p.name for p in out.parent.iterdir()] == ["out.partial"]
    now = manifest(four, "extended", True)
    require_resumable(out, now)
    with partial_folder(out, resume=True) as partial:
        kept = KeptFolder(partial, now)
        assert len(kept) == 2
        assert same(outcome(build(read_model(four), kept=kept)), outcome(four_result))


def test_an_old_partial_folder_is_replaced_without_resume(killed: Path, tmp_path: Path) -> None:
    out = copied(killed, tmp_path)
    with partial_folder(out) as partial:
        assert [p.name for p in partial.iterdir()] == [".graben-partial"]


def test_what_cannot_be_resumed_ends_with_one_sentence(four: Path, killed: Path, tmp_path: Path) -> None:
    changed = tmp_path / "model" / "model.toml"
    shutil.copytree(four.parent, changed.parent)
    (changed.parent / "Base.irap").write_bytes(b"no grid")
    copied(killed, tmp_path / "b")
    copied(killed, tmp_path / "c")
    (tmp_path / "c" / "out").mkdir()
    (tmp_path / "c" / "out" / "thesis.txt").touch()
    for name, model, says in (
        ("a", four, "a/out.partial does not exist"),
        ("b", changed, "Base.irap has changed"),
        ("c", four, "not empty"),
    ):
        before = sorted(str(p) for p in tmp_path.rglob("*"))
        done = graben("run", model, "-o", tmp_path / name / "out", "--resume")
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
        assert says in done.stderr
        assert sorted(str(p) for p in tmp_path.rglob("*")) == before


def test_whatever_matters_must_be_the_same(
    four: Path, killed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    require_resumable(killed, manifest(four, "extended", True))
    with pytest.raises(OutputError, match=r"The option --profile has changed \(from extended to paper\)"):
        require_resumable(killed, manifest(four, "paper", True))
    with pytest.raises(OutputError, match="The option --no-repair was added since"):
        require_resumable(killed, manifest(four, "extended", False))
    monkeypatch.setattr(resuming, "version", lambda name: "9.9")
    with pytest.raises(OutputError, match="version graben has changed"):
        require_resumable(killed, manifest(four, "extended", True))
    monkeypatch.undo()
    shutil.copytree(four.parent, tmp_path / "model")
    model = tmp_path / "model" / "model.toml"
    require_resumable(killed, manifest(model, "extended", True))
    (tmp_path / "model" / "F1.ts").unlink()
    with pytest.raises(OutputError, match=r"F1\.ts has changed"):
        require_resumable(killed, manifest(model, "extended", True))
    model.write_text(model.read_text() + "\n")
    with pytest.raises(OutputError, match=r"model\.toml has changed"):
        require_resumable(killed, manifest(model, "extended", True))


def test_the_truth_of_a_demo_model_matters(four: Path, tmp_path: Path) -> None:
    shutil.copytree(four.parent, tmp_path / "model")
    model = tmp_path / "model" / "model.toml"
    (tmp_path / "model" / "truth").mkdir()
    (tmp_path / "model" / "truth" / "truth.json").write_text("{}")
    model.write_text(model.read_text().replace("[model]\n", '[model]\ntruth = "truth"\n'))
    with partial_folder(tmp_path / "out"):
        KeptFolder(tmp_path / "out.partial", manifest(model, "paper", True))
        require_resumable(tmp_path / "out", manifest(model, "paper", True))
        (tmp_path / "model" / "truth" / "truth.json").write_text("[]")
        with pytest.raises(OutputError, match=r"truth/truth\.json has changed"):
            require_resumable(tmp_path / "out", manifest(model, "paper", True))


def test_a_partial_folder_of_another_kind_is_not_resumed(four: Path, tmp_path: Path) -> None:
    now = manifest(four, "extended", True)
    (tmp_path / "a.partial").mkdir()
    (tmp_path / "a.partial" / "thesis.txt").touch()
    with pytest.raises(OutputError, match="holds nothing of a run"):
        require_resumable(tmp_path / "a", now)
    with partial_folder(tmp_path / "b"):
        with pytest.raises(OutputError, match="holds nothing of a run"):
            require_resumable(tmp_path / "b", now)
        (tmp_path / "b.partial" / KEPT).mkdir()
        for text in ("no JSON", "[]"):
            (tmp_path / "b.partial" / KEPT / "manifest.json").write_text(text)
            with pytest.raises(OutputError, match="holds nothing of a run"):
                require_resumable(tmp_path / "b", now)


def test_two_runs_do_not_work_in_the_same_folder(tmp_path: Path) -> None:
    with partial_folder(tmp_path / "out") as partial:
        (partial / "report.html").write_text("half")
        for resume in (False, True):
            with (
                pytest.raises(OutputError, match="Another graben works in"),
                partial_folder(tmp_path / "out", resume=resume),
            ):
                pass
        assert (partial / "report.html").read_text() == "half"
    assert (tmp_path / "out" / "report.html").read_text() == "half"


def test_an_error_leaves_finished_work_and_nothing_else(tmp_path: Path) -> None:
    for keep in (False, True):
        with pytest.raises(ZeroDivisionError), partial_folder(tmp_path / "out") as partial:
            kept = KeptFolder(partial, {})
            if keep:
                kept["horizon-1"] = b"work"
            raise ZeroDivisionError
        assert [p.name for p in tmp_path.iterdir()] == ["out.partial"] * keep
    with partial_folder(tmp_path / "out", resume=True) as partial:
        kept = KeptFolder(partial, {})
        assert dict(kept) == {"horizon-1": b"work"}
        del kept["horizon-1"]
        with pytest.raises(KeyError):
            del kept["horizon-1"]
        assert len(kept) == 0 and "horizon-1" not in kept
    assert [p.name for p in tmp_path.rglob("*")] == ["out"]


def test_the_system_says_why_a_file_could_not_be_written(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="choose another -o"), whole_folder(tmp_path / "out") as partial:
        (partial / "missing" / "file").touch()
    assert list(tmp_path.iterdir()) == []


def test_kept_work_gives_the_same_result(result: RunResult) -> None:
    kept: dict[str, bytes] = {}
    model = layers("A", "B")
    first = build(model, kept=kept)
    assert sorted(kept) == ["horizon-1", "horizon-2", "repair"]
    again = build(model, kept=kept)
    assert same(outcome(first), outcome(result)) and same(outcome(again), outcome(result))
    assert same(first["B"].seconds, again["B"].seconds)


def test_damaged_work_is_done_again(result: RunResult) -> None:
    kept = {"repair": b"", "horizon-1": to_bytes({"surface": None}), "horizon-2": to_bytes("x")[:-1]}
    assert same(outcome(build(layers("A", "B"), kept=kept)), outcome(result))
    assert from_bytes(kept["horizon-2"])["surface"].name == "B"
    assert from_bytes(kept["repair"])["repairs"] == result.repairs


def test_a_model_of_one_horizon_without_repair_keeps_nothing() -> None:
    kept: dict[str, bytes] = {}
    assert build(layers("A", damaged=False), kept=kept).passed
    assert kept == {}


def test_horizons_side_by_side_give_the_same_result(result: RunResult) -> None:
    with ProcessPoolExecutor(2, get_context("spawn")) as executor:
        assert same(outcome(build(layers("A", "B"), executor=executor)), outcome(result))


def test_a_worker_that_dies_is_told_in_a_sentence() -> None:
    class Dying(ThreadPoolExecutor):
        def submit(self, *given: Any, **keys: Any) -> Future[Any]:
            future: Future[Any] = Future()
            future.set_exception(BrokenExecutor("ended abruptly"))
            return future

    with Dying() as executor, pytest.raises(GrabenError, match="for want of memory"):
        build(layers("A", "B", damaged=False), executor=executor)


def test_a_horizon_that_cannot_be_rebuilt_is_kept_with_the_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    plain, calls = horizons.rebuilt, []

    def failing(model: Model, prepared: Any, network: Any, **options: Any) -> Any:
        calls.append(prepared.horizon.name)
        if prepared.horizon.name == "B":
            raise ModelingError("It has no bottom.")
        return plain(model, prepared, network, **options)

    monkeypatch.setattr(horizons, "rebuilt", failing)
    kept: dict[str, bytes] = {}
    first, again = (build(layers("A", "B", damaged=False), kept=kept) for _ in range(2))
    assert calls == ["A", "B"]
    assert first.not_modeled == again.not_modeled == {"B": "It has no bottom."}
    assert [h.name for h in again.horizons] == ["A"]


def test_values_read_back_to_the_bit(result: RunResult) -> None:
    one = (0.1, float("nan"), -0.0, np.float64(1 / 3), np.int64(-(2**62)), "é\n", None, True, Path("a/b"))
    arrays = (np.array([[0.1, np.nan, -0.0]]), np.zeros((0, 3)), np.array([True, False]), np.array(3))
    for value in (one, arrays, [1, (2, [])], {1: {"a": ()}}, *result.horizons, result.before, result.repairs):
        assert same(from_bytes(to_bytes(value)), value)
    assert not from_bytes(to_bytes(result.horizons[0])).surface.vertices.flags.writeable


def test_what_is_not_graben_s_is_neither_kept_nor_read() -> None:
    class Own(Enum):
        A = 1

    for value in (object(), {1, 2}, np.array([object()]), Own.A, 1j):
        with pytest.raises(TypeError, match="cannot be kept"):
            to_bytes(value)
    good = to_bytes("graben.surface:Surface")
    for bad in (b"", b"PK", good[:-30], good.replace(b'"format": 1', b'"format": 9')):
        with pytest.raises(NotKeptError):
            from_bytes(bad)
    for kind in ("dataclass", "enum"):
        for name in (
            "subprocess:Popen",
            "graben.reading:read_model",
            "graben.nothing:X",
            "graben.model:Nothing",
        ):
            with pytest.raises(NotKeptError):
                from_bytes(told([kind, name, {}]))
    with pytest.raises(NotKeptError):
        from_bytes(told(["pickle", "x"]))


def told(value: object) -> bytes:
    """Bytes as of to_bytes that tell whatever is asked."""
    from io import BytesIO

    stream = BytesIO()
    np.savez(stream, value=np.frombuffer(json.dumps({"format": 1, "value": value}).encode(), dtype=np.uint8))
    return stream.getvalue()


@pytest.mark.skipif(find_spec("distributed") is not None, reason="dask is here")
def test_a_cluster_needs_dask() -> None:
    with pytest.raises(GrabenError, match="dask"), cluster("tcp://localhost:1"):
        pass
