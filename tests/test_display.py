"""Progress: which stage of how many, what is in work, the time; nothing when piped, lines with -v."""

from __future__ import annotations

import io
import os
import pickle
import pty
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csc_array, eye_array

from graben.counting import Counted
from graben.display import Course
from graben.modeling.algebra import Cholmod
from graben.pipeline import build
from graben.stages import Work
from tests.commands import graben
from tests.test_resume import layers

PLAN = ("read", "check", "repair", "model", "write")


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def test_a_stage_of_another_name_is_work_of_the_present_one() -> None:
    course = Course(PLAN, 0.0, clock=Clock())
    assert course.line() == "[1/5] read, 0:00"
    course("read", "model.toml")
    assert course.line() == "[1/5] read: model.toml, 0:00"
    course("trace", "Top A")
    assert course.line().startswith("[1/5] read: trace Top A")
    # repair may be left out, and no stage comes again
    course("model", "Top A")
    assert course.line().startswith("[4/5] model: Top A")
    course("check", "again")
    assert course.line().startswith("[4/5] model: check again")


def test_the_time_left_is_told_where_a_share_is_known() -> None:
    clock = Clock()
    course = Course(PLAN, 0.0, clock=clock)
    course("model", Work("A", 0.0))
    clock.now = 30.0
    assert course.left() is None
    course("model", Work("B", 0.25))
    assert course.left() == pytest.approx(90.0)
    clock.now = 60.0
    assert course.left() == pytest.approx(60.0)
    assert course.line() == "[4/5] model: B, 1:00, about 1:00 left of this stage"
    # what takes longer than it should has no end that can be told
    clock.now = 121.0
    assert course.left() is None
    course("write", "out")
    assert course.left() is None


def test_lines_leave_out_what_passes_and_what_would_steer_a_terminal() -> None:
    stream, clock = io.StringIO(), Clock()
    course = Course(PLAN, 0.0, stream, clock)
    course("model", "A\x1b[31m")
    clock.now = 12.34
    course("model", Work("A, solve 3", 0.5, passing=True))
    course("write", "out")
    course("write", "out")
    assert stream.getvalue().splitlines() == [
        "     0.0 s  [4/5] model: A\\x1b[31m",
        "    12.3 s  [5/5] write: out",
    ]
    assert "solve 3" not in stream.getvalue()


def test_work_is_text() -> None:
    work = Work("Top A", 0.5)
    assert (work, f"{work}", work.share) == ("Top A", "Top A", 0.5)
    assert pickle.loads(pickle.dumps(work)) == "Top A"


def test_the_model_stage_tells_horizon_size_and_solves() -> None:
    told: list[tuple[str, str]] = []
    build(layers("A", "B"), progress=lambda stage, what: told.append((stage, what)), workers=1)
    modeled = [what for stage, what in told if stage == "model"]
    assert re.fullmatch(r"A, horizon 1 of 2, \d+ unknowns", modeled[0])
    solves = [what for what in modeled if "solve" in what]
    assert any(what.startswith("A, horizon 1 of 2") for what in solves)
    assert any(what.startswith("B, horizon 2 of 2") for what in solves)
    shares = [what.share for what in modeled if isinstance(what, Work) and what.share is not None]
    assert shares[0] == 0.0 and shares == sorted(shares) and 0.0 < shares[-1] < 1.0


def test_counting_changes_no_solution() -> None:
    told: list[int] = []
    matrix = csc_array(eye_array(3) * 4.0)
    counted = Counted(Cholmod(), told.append)
    analysis = counted.analyse(matrix)
    for _ in range(2):
        x = analysis.factor(matrix).solve(np.array([4.0, 8.0, 12.0]))
        assert np.array_equal(x, [1.0, 2.0, 3.0])
    assert told == [1, 2]


@pytest.fixture(scope="module")
def single(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("display") / "single"
    assert graben("demo", "single", "--step", "200", "-o", folder).returncode == 0
    return folder / "model.toml"


def test_piped_it_says_nothing_and_with_v_every_step(single: Path, tmp_path: Path) -> None:
    assert graben("run", single, "-o", tmp_path / "a").stderr == ""
    lines = graben("run", single, "-o", tmp_path / "b", "-v").stderr.splitlines()
    assert all(
        re.match(r" *\d+\.\d s  \[[1-5]/5\] (read|check|repair|model|write): ", line) for line in lines
    )
    seconds = [float(line.split()[0]) for line in lines]
    assert seconds == sorted(seconds)
    assert any("[4/5] model: Top, horizon 1 of 1" in line for line in lines)
    assert graben("check", single, "-q", "-v").stderr == ""


def test_on_a_terminal_one_line_says_where_it_is(single: Path) -> None:
    host, terminal = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "200"}
    command = [sys.executable, "-m", "graben.cli", "check", str(single)]
    done = subprocess.run(command, stderr=terminal, stdout=subprocess.PIPE, env=environment, check=False)
    os.close(terminal)
    shown = b""
    try:
        while more := os.read(host, 65536):
            shown += more
    except OSError:  # the other end is closed
        pass
    os.close(host)
    assert done.returncode == 0
    assert re.search(rb"\[[12]/2\] (read|check): .*, 0:\d\d", shown)
    # it is taken away again, and leaves the answer alone
    assert b"[2/2]" not in done.stdout
