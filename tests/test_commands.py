"""A command given in this process ends and speaks as one in a process of its own, and leaves nothing."""

from __future__ import annotations

import os
import signal
import sys
import warnings
from pathlib import Path

import pytest

from tests import commands
from tests.commands import graben, started


@pytest.mark.parametrize(
    "words",
    [["demo", "--list"], ["check", "nowhere.toml"], ["run", "--help"], []],
    ids=lambda words: " ".join(words) or "none",
)
def test_it_ends_and_speaks_as_in_a_process_of_its_own(words: list[str], tmp_path: Path) -> None:
    here, there = graben(*words, cwd=tmp_path), started(*words, cwd=tmp_path)
    assert (here.returncode, here.stdout, here.stderr) == (there.returncode, there.stdout, there.stderr)
    assert graben(*words, cwd=tmp_path, merged=True).stdout == there.stderr + there.stdout


def state() -> tuple[object, ...]:
    streams = [os.fstat(number)[:2] for number in (1, 2)]
    return Path.cwd(), sys.stdout, sys.stderr, streams, signal.getsignal(signal.SIGINT), warnings.filters[:]


def test_it_leaves_everything_as_it_was(tmp_path: Path) -> None:
    before = state()
    assert graben("demo", "single", "-o", "out", cwd=tmp_path).returncode == 0
    assert graben("fold", cwd=tmp_path).returncode == 2
    assert state() == before
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_what_is_written_past_python_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    def main(words: list[str]) -> None:
        os.write(1, b"told\n")
        os.write(2, b"warned\n")
        print("said")
        sys.exit(3)

    monkeypatch.setattr(commands, "main", main)
    done = graben("any")
    assert (done.returncode, sorted(done.stdout.split()), done.stderr) == (3, ["said", "told"], "warned\n")


def test_an_error_of_its_own_is_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(commands, "main", lambda words: None)
    before = state()
    with pytest.raises(AssertionError, match="ends with an exit code"):
        graben("any")
    assert state() == before
