"""graben beside two other ways to rebuild a horizon at its faults, on the models with a known answer.

- spline: a thin-plate spline through the reliable nodes of each block, led on to the faults
  (``tests.bench.peer_spline``). It gives sheets that know nothing of each other.
- LoopStructural: told the true largest slip of each fault, which the others have to find
  (``tests.bench.peer_loop``); left out where it is not installed (extra ``bench``).

Of several set-ups of a peer the one with the least cutoff error counts, a choice that only a known answer
allows; graben runs with its defaults. Columns: errors as ``graben.modeling.scoring`` has them; pieces, the
connected pieces of the surface; off fault, the largest distance of a lip from the given fault; open tip, the
largest distance between the two lips where a fault ends inside. Such places do not count in the errors.
"""

from __future__ import annotations

import contextlib
import logging
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path

import igl
import numpy as np

from graben import demo
from graben.modeling.results import Cutoff, HorizonResult, Score
from graben.modeling.scoring import score
from graben.pipeline import build
from graben.surface import strong_components
from tests.bench import peer_loop, peer_spline
from tests.bench.peer_task import Rebuilt, Task, scored
from tests.bench.tables import Table, seconds_table
from tests.models import model_of_demo

MODELS = ("single", "exit", "exit-both", "cross", "tee", "reverse", "low-dip", "low-dip-12")
SPLINES = (
    peer_spline.Options(around=False),
    peer_spline.Options(around=True),
    peer_spline.Options(around=True, neighbors=100),
)
LOOPS = (peer_loop.Options(), peer_loop.Options(measured=True), peer_loop.Options(regularisation=0.1))
#: Errors that differ by less than this share are called the same: half of what the frame may change.
SAME = 0.05


def figures() -> Table:
    table: Table = {}
    loop = find_spec("LoopStructural") is not None
    if not loop:
        print('LoopStructural left out: it is not installed (pip install ".[bench]")')
    for name in MODELS:
        made = demo.build(name)
        with tempfile.TemporaryDirectory() as folder, _quiet():
            demo.write(made, Path(folder))
            begin = time.perf_counter()
            (result,) = build(model_of_demo(made), mend=False).horizons
            seconds = time.perf_counter() - begin
            task = Task(made, Path(folder) / "truth", result)
            table[f"{name}: graben"] = _own(task, result) | {"seconds": seconds}
            table[f"{name}: spline"] = _best(task, peer_spline.fitted, SPLINES)
            if loop:
                table[f"{name}: LoopStructural"] = _best(task, peer_loop.fitted, LOOPS)
    seconds_table("peers", table)
    _say_who_wins(table)
    return table


def _own(task: Task, result: HorizonResult) -> dict[str, float]:
    """Return the figures of graben's result, scored as a run scores itself."""
    errors = score(task.truth, result, task.model.faults)
    assert errors is not None
    gaps = [0.0]
    for fault, _, _, place in task.tips():
        strike, name = task.strike(fault), task.made.faults[fault].name
        rows = [(c.hanging, c.foot) for c in result.cutoffs if c.fault == name]
        hanging, foot = (np.concatenate(lines) for lines in zip(*rows, strict=True))
        end = int(np.argmin(np.abs(hanging[:, :2] @ strike - place)))
        gaps.append(float(np.linalg.norm(hanging[end] - foot[end])))
    pieces = int(strong_components(result.surface.triangles).max()) + 1
    return _row(errors, pieces, _off_fault(task, result.cutoffs), max(gaps))


def _best(task: Task, fitted: Callable[..., Rebuilt], options: Iterable[object]) -> dict[str, float]:
    """Return the figures of the set-up with the least cutoff error."""
    rows = []
    for option in options:
        begin = time.perf_counter()
        rebuilt = fitted(task, option)
        errors, cutoffs = scored(task, rebuilt)
        seconds = time.perf_counter() - begin
        gaps = [0.0]
        for fault, hanging, foot, place in task.tips():
            section = [task.section(fault, place)]
            upper, lower = (rebuilt.lip(fault, block, section)[0] for block in (hanging, foot))
            gaps.append(float(np.linalg.norm(upper - lower)))
        row = _row(errors, rebuilt.pieces(), _off_fault(task, cutoffs), max(gaps))
        rows.append(row | {"seconds": seconds})
        print(f"{task.made.name} {option}: cutoffs {errors.cutoff.percent:.2f} %")
    return min(rows, key=lambda row: row["cutoff m"])


def _row(errors: Score, pieces: int, off: float, gap: float) -> dict[str, float]:
    row: dict[str, float] = {}
    for what in ("cutoff", "throw", "zone"):
        error = getattr(errors, what)
        row |= {f"{what} m": error.value, f"{what} %": error.percent}
    return row | {"pieces": pieces, "off fault m": off, "open tip m": gap}


def _off_fault(task: Task, cutoffs: tuple[Cutoff, ...]) -> float:
    """Return the largest distance of a lip from the given fault, m."""
    surfaces = {surface.name: surface for surface in task.made.faults}
    furthest = 0.0
    for cutoff in cutoffs:
        surface = surfaces[cutoff.fault]
        lips = np.concatenate([cutoff.hanging, cutoff.foot])
        squared = igl.point_mesh_squared_distance(lips, surface.vertices.copy(), surface.triangles.copy())[0]
        furthest = max(furthest, float(np.sqrt(squared.max())))
    return furthest


def _say_who_wins(table: Table) -> None:
    """Print where graben's cutoffs are less accurate than the better peer's."""
    for name in MODELS:
        own = table[f"{name}: graben"]["cutoff m"]
        peers = {key: row["cutoff m"] for key, row in table.items() if key.startswith(f"{name}: ")}
        best = min(peers, key=lambda key: peers[key])
        if own > (1.0 + SAME) * peers[best]:
            print(f"{best} is more accurate than graben: {peers[best]:.2f} m against {own:.2f} m")


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Hold back what LoopStructural logs."""
    logging.disable(logging.WARNING)
    try:
        yield
    finally:
        logging.disable(logging.NOTSET)
