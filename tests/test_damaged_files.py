"""Damaged files through `graben check`: exit 0, 1 or 2, one sentence, no traceback, bounded memory.

`make bench` does the same with a thousand.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.damage import DAMAGES, MEMORY, checked, complaint, damaged, sound

FIRST, COUNT = 200, 60


@pytest.fixture(scope="module")
def ends(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    """How the check of each damaged model ended."""
    folder = tmp_path_factory.mktemp("damaged")
    command = [sys.executable, "-m", "tests.damage", str(FIRST), str(COUNT), str(folder)]
    done = subprocess.run(command, check=True, capture_output=True, cwd=Path(__file__).parents[1])
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_every_one_ends_as_it_should(ends: list[dict[str, Any]]) -> None:
    assert [end["seed"] for end in ends] == list(range(FIRST, FIRST + COUNT))
    assert [(end["seed"], end["done"], end["wrong"], end["stderr"]) for end in ends if end["wrong"]] == []
    assert max(end["peak_mb"] for end in ends) <= MEMORY


def test_they_end_in_every_way(ends: list[dict[str, Any]]) -> None:
    codes = Counter(end["code"] for end in ends)
    assert set(codes) == {0, 1, 2}
    assert min(codes.values()) >= 5
    said = {end["stderr"] for end in ends if end["code"] == 2}
    assert len(said) >= 20
    assert all(any(name in text for name in sound()) for text in said)


def test_a_sound_model_passes(tmp_path: Path) -> None:
    for name, data in sound().items():
        (tmp_path / name).write_bytes(data)
    assert checked(tmp_path / "model.toml") == (0, "")


def test_every_damage_changes_every_file() -> None:
    for damage in DAMAGES:
        for name, data in sound().items():
            changed = [damage(data, np.random.default_rng(seed)) for seed in range(5)]
            assert any(one != data for one in changed) or (damage.__name__, name) in UNCHANGED


#: Where there is nothing to change: lines of the model file end in no plain number, points in no blank.
UNCHANGED = {("_lines_mixed", "points.csv")}


def test_the_same_seed_gives_the_same_damage() -> None:
    assert damaged(7) == damaged(7)
    assert damaged(7) != damaged(8)


def test_what_is_complained_of() -> None:
    assert complaint(0, "") == complaint(1, "") == complaint(2, "graben: No such file.\n") == ""
    for code, text in (
        (3, ""),
        (2, ""),
        (2, "graben: No.\ngraben: No.\n"),
        (2, "graben: graben met an error of its own (E: e); --debug shows where.\n"),
        (2, "Traceback (most recent call last):\n"),
        (1, "warning\n"),
    ):
        assert complaint(code, text)
