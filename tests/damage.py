"""Damaged models: the files of a small model, changed at random, and what `graben check` makes of them.

`python -m tests.damage FIRST COUNT FOLDER` checks the models of COUNT seeds, each through the command line in
a process of its own with bounded memory. It prints a line of JSON for each: the seed, what was done to which
file, the exit code, what is wrong with the end, what stderr says, seconds, and peak memory in MiB.
"""

from __future__ import annotations

import contextlib
import importlib
import io
import json
import os
import re
import resource
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

#: Address space that the process may take, and the memory that it may really use, both in MiB.
ADDRESSES, MEMORY = 6144, 1024
#: Seconds after which a check hangs.
PATIENCE = 60

#: What any number could be, and what none should be.
PLAIN = ("0", "-1", "1", "0.5", "-0.0", "12345.678", "1e6", "-99999", "1e-9", "7", "40")
NUMBERS = (
    *(
        "nan",
        "inf",
        "-inf",
        "1e308",
        "-1e308",
        "1e-308",
        "1e30",
        "-1",
        "0",
        "-0.0",
        "1e19",
        "99999.0",
        "1e400",
    ),
    *("1", "2147483648", "99999999999999999999", "0x10", "1,5", "--3", "", "x", "\u0660", "9999900.0", "999"),
)
_NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w.])")

MODEL = """[model]
name = "damage"
z = "elevation"
unit = "m"

[[horizons]]
name = "Grid"
file = "grid.irap"

[[horizons]]
name = "Points"
file = "points.csv"
step = 100.0
noise = 0.5

[[horizons]]
name = "Sheet"
file = "sheet.ts"

[[faults]]
file = "faults.ts"

[[faults]]
name = "Sticks"
file = "sticks.pol"
gamma = 120.0

[parameters]
theta = 0.5
gamma = 150.0
min_dip = 30.0

[repair]
max_move = 20.0

[[contacts]]
faults = ["F1", "F2"]
rule = "accept"

[checks]
near-miss = 50.0
"""


def _height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return 0.05 * x - 0.02 * y + 20.0 * np.tanh((x - 700.0) / 60.0)


def _plane(name: str, x: float, lean: float, columns: int, rows: int) -> str:
    """A TSurf of a fault that strikes north at ``x``."""
    j, i = np.meshgrid(np.arange(rows + 1), np.arange(columns + 1))
    y, z = 100.0 + i * 800.0 / columns, 200.0 - j * 400.0 / rows
    points = np.stack([x - lean * z + 0.1 * y, y, z], axis=-1).reshape(-1, 3)
    a = (i[:-1, :-1] * (rows + 1) + j[:-1, :-1]).ravel() + 1
    triangles = np.concatenate([np.c_[a, a + rows + 1, a + rows + 2], np.c_[a, a + rows + 2, a + 1]])
    lines = [f"VRTX {k} {p[0]:.3f} {p[1]:.3f} {p[2]:.3f}" for k, p in enumerate(points, start=1)]
    lines += [f"TRGL {t[0]} {t[1]} {t[2]}" for t in triangles]
    head = f"GOCAD TSurf 1\nHEADER {{\nname:{name}\n}}\nTFACE\n"
    return head + "\n".join(lines) + "\nEND\n"


def sound() -> dict[str, bytes]:
    """The files of the model before they are damaged."""
    x, y = np.meshgrid(np.arange(0, 1500, 100.0), np.arange(0, 1100, 100.0))
    values = _height(x, y).ravel()
    grid = f"-996 {x.shape[0]} 100.0 100.0\n0.0 1400.0 0.0 1000.0\n{x.shape[1]} 0.0 0.0 0.0\n0 0 0 0 0 0 0\n"
    grid += "\n".join(" ".join(f"{v:.4f}" for v in row) for row in np.array_split(values, 40)) + "\n"
    rng = np.random.default_rng(0)
    picks = rng.uniform([0, 0], [1400, 1000], size=(250, 2))
    points = "X,Y,Z\n" + "".join(
        f"{a:.2f},{b:.2f},{c:.2f}\n" for a, b, c in np.c_[picks, _height(*picks.T) - 80]
    )
    sheet = _plane("Sheet", 700.0, 3.5, 8, 8)
    sticks = ""
    for y in range(100, 1000, 200):
        for x, z in ((1100, 150), (1160, 0), (1230, -150), (999, 999)):
            sticks += f"{x + 0.1 * y:.1f} {y:.1f} {z:.1f}\n" if x != z else "999.0 999.0 999.0\n"
    faults = _plane("F1", 600.0, 0.5, 8, 6) + _plane("F2", 200.0, -0.3, 6, 5)
    texts = {
        "model.toml": MODEL,
        "grid.irap": grid,
        "points.csv": points,
        "sheet.ts": sheet,
        "faults.ts": faults,
        "sticks.pol": sticks,
    }
    return {name: text.encode() for name, text in texts.items()}


def _flipped(data: bytes, rng: np.random.Generator) -> bytes:
    array = np.frombuffer(data, dtype=np.uint8).copy()
    where = rng.integers(len(array), size=int(rng.integers(1, 30)))
    array[where] ^= (1 << rng.integers(0, 8, size=len(where))).astype(np.uint8)
    return array.tobytes()


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: int(rng.integers(len(data)))]


def _noise_put_in(data: bytes, rng: np.random.Generator) -> bytes:
    at = int(rng.integers(len(data)))
    noise = rng.integers(0, 256, size=int(rng.integers(1, 200)), dtype=np.uint8)
    return data[:at] + noise.tobytes() + data[at:]


def _numbers_replaced(data: bytes, rng: np.random.Generator) -> bytes:
    found = list(_NUMBER.finditer(data))
    if not found:
        return data
    for k in sorted(rng.integers(len(found), size=int(rng.integers(1, 6))).tolist(), reverse=True):
        start, end = found[k].span()
        data = data[:start] + str(rng.choice(PLAIN if rng.random() < 0.5 else NUMBERS)).encode() + data[end:]
    return data


def _ends_replaced(data: bytes, rng: np.random.Generator) -> bytes:
    """The last number of some lines replaced by a plain one: a vertex of a triangle, an elevation."""
    lines = data.splitlines()
    for k in rng.integers(len(lines), size=int(rng.choice([1, 3, 30]))):
        found = list(_NUMBER.finditer(lines[k]))
        if found:
            lines[k] = lines[k][: found[-1].start()] + str(rng.choice(PLAIN)).encode()
    return b"\n".join(lines) + b"\n"


def _numbers_scaled(data: bytes, rng: np.random.Generator) -> bytes:
    """Every number of some lines a thousand times as large, or with its sign turned."""
    factor = float(rng.choice([1000.0, 0.001, -1.0, 1e9]))
    lines = data.splitlines(keepends=True)
    for k in rng.integers(len(lines), size=int(rng.integers(1, 20))):
        lines[k] = _NUMBER.sub(lambda m: f"{float(m.group()) * factor:g}".encode(), lines[k])
    return b"".join(lines)


def _lines_dropped(data: bytes, rng: np.random.Generator) -> bytes:
    lines = data.splitlines(keepends=True)
    kept = rng.random(len(lines)) > rng.choice([0.02, 0.2, 0.7])
    return b"".join(line for line, keep in zip(lines, kept, strict=True) if keep)


def _lines_doubled(data: bytes, rng: np.random.Generator) -> bytes:
    return b"".join(line * int(rng.choice([1, 1, 1, 2, 3])) for line in data.splitlines(keepends=True))


def _lines_swapped(data: bytes, rng: np.random.Generator) -> bytes:
    lines = data.splitlines(keepends=True)
    for _ in range(int(rng.integers(1, 10))):
        a, b = rng.integers(len(lines), size=2)
        lines[a], lines[b] = lines[b], lines[a]
    return b"".join(lines)


def _lines_mixed(data: bytes, rng: np.random.Generator) -> bytes:
    """The last numbers of all lines in another order: ids in triangles, elevations of points."""
    lines = [line.rsplit(None, 1) for line in data.splitlines()]
    ends = [line[1] for line in lines if len(line) == 2 and _NUMBER.fullmatch(line[1])]
    mixed = iter(rng.permutation(np.array(ends, dtype=object)).tolist()) if ends else iter(())
    changed = [
        line[0] + b" " + next(mixed) if len(line) == 2 and _NUMBER.fullmatch(line[1]) else b" ".join(line)
        for line in lines
    ]
    return b"\n".join(changed) + b"\n"


DAMAGES: tuple[Callable[[bytes, np.random.Generator], bytes], ...] = (
    *(_flipped, _cut, _noise_put_in, _lines_dropped, _lines_doubled, _lines_swapped),
    *(_numbers_replaced, _numbers_replaced, _numbers_scaled, _lines_mixed, _ends_replaced, _ends_replaced),
)
#: How often each file is drawn, in their order.
SHARES = (1, 2, 2, 2, 4, 2)


def damaged(seed: int) -> tuple[dict[str, bytes], str]:
    """The files of the model with one or two of them damaged, and what was done."""
    rng = np.random.default_rng(seed)
    files, done = sound(), []
    for _ in range(int(rng.choice([1, 1, 1, 2]))):
        name = str(rng.choice(list(files), p=np.array(SHARES) / sum(SHARES)))
        damage = DAMAGES[int(rng.integers(len(DAMAGES)))]
        if files[name]:
            files[name] = damage(files[name], rng)
            done.append(f"{name} {damage.__name__.strip('_')}")
    return files, ", ".join(done)


def checked(model: Path) -> tuple[int, str]:
    """The exit code of `graben check` on a model and what it says on stderr; nothing is kept of stdout."""
    from graben.cli import main

    out, err = io.TextIOWrapper(io.BytesIO(), "utf-8"), io.TextIOWrapper(io.BytesIO(), "utf-8")
    code: object = None
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main(["check", str(model)])
        except SystemExit as end:
            code = end.code
    err.seek(0)
    return int(str(code)), err.read()


def complaint(code: int, stderr: str) -> str:
    """What is wrong with the end of a check; empty where it is as it should be."""
    if code not in (0, 1, 2):
        return f"exit code {code}"
    if "Traceback" in stderr or "an error of its own" in stderr or "MemoryError" in stderr:
        return "an error of graben's own"
    if code == 2 and not (
        stderr.startswith("graben: ") and stderr.endswith(".\n") and stderr.count("\n") == 1
    ):
        return "not one sentence"
    return "" if code == 2 or not stderr else "something on stderr"


def examined(seed: int, folder: Path) -> dict[str, Any]:
    """What `graben check` makes of the model of a seed, in a process of its own made by a fork."""
    files, done = damaged(seed)
    for name, data in files.items():
        (folder / name).write_bytes(data)
    start = time.perf_counter()
    child = os.fork()
    if not child:
        resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES * 2**20, ADDRESSES * 2**20))
        code, stderr = checked(folder / "model.toml")
        (folder / "stderr").write_text(stderr, encoding="utf-8", errors="replace")
        os._exit(code)
    status, usage = _waited(child, start + PATIENCE)
    seconds = round(time.perf_counter() - start, 3)
    if status is None:
        code, wrong, stderr = -1, f"no end in {PATIENCE} s", ""
    elif os.WIFSIGNALED(status):
        code, wrong, stderr = -1, f"ended by signal {os.WTERMSIG(status)}", ""
    else:
        code, stderr = os.WEXITSTATUS(status), (folder / "stderr").read_text(encoding="utf-8")
        wrong = complaint(code, stderr)
    peak = round(usage / (2**20 if sys.platform == "darwin" else 2**10))
    if peak > MEMORY:
        wrong = wrong or f"{peak} MiB"
    found = {"seed": seed, "done": done, "code": code, "wrong": wrong, "stderr": stderr}
    return {**found, "seconds": seconds, "peak_mb": peak}


def _waited(child: int, until: float) -> tuple[int | None, int]:
    """The status of a child and its peak memory in the system's unit; None where it had to be ended."""
    late = False
    while True:
        pid, status, usage = os.wait4(child, 0 if late else os.WNOHANG)
        if pid:
            return (None if late else status), usage.ru_maxrss
        if time.perf_counter() > until:
            late = True
            os.kill(child, signal.SIGKILL)
        time.sleep(0.005)


def ready() -> None:
    """Load what every check loads; a child inherits it."""
    for module in ("pipeline", "reports.check_table", "reports.check_files", "modeling.fitting"):
        importlib.import_module(f"graben.{module}")


def main(first: int, count: int, folder: Path) -> None:
    ready()
    for seed in range(first, first + count):
        print(json.dumps(examined(seed, folder)), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]))
