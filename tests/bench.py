"""Figures of whole runs, in memory: `make bench` prints them and writes build/bench/bench.json.

Each case runs three times, the cases in turn; the median is quoted. Nothing here is asserted.
"""

from __future__ import annotations

import json
import statistics
from collections import defaultdict
from pathlib import Path

from graben.demo import build as demo
from graben.model import Model
from graben.pipeline import build
from graben.reading import read_model
from tests.models import model_of_demo

DATA = Path(__file__).parents[2] / "shared" / "data"
OUT = Path(__file__).parents[1] / "build" / "bench"
ROUNDS = 3
STAGES = ("check", "triangulate", "solve", "move", "deform", "total")


def cases() -> dict[str, Model]:
    found = {
        f"single, step {step:g}": model_of_demo(demo("single", step=step)) for step in (100.0, 50.0, 25.0)
    }
    found["cross"] = model_of_demo(demo("cross"))
    for name in ("claudius", "drogon", "hecho"):
        if (DATA / name).is_dir():
            found[name] = read_model(DATA / name / "model.toml")
        else:
            print(f"{name} left out: ../shared/data is missing")
    return found


def main() -> None:
    models = cases()
    seconds: dict[str, dict[str, list[float]]] = {name: defaultdict(list) for name in models}
    nodes: dict[str, int] = {}
    for _ in range(ROUNDS):
        for name, model in models.items():
            result = build(model)
            nodes[name] = sum(len(h.first) for h in result.horizons)
            for stage in STAGES:
                seconds[name][stage].append(result.timings[stage])
    medians = {name: {s: statistics.median(times[s]) for s in STAGES} for name, times in seconds.items()}
    print(f"{'seconds, median of 3':<22}{'nodes':>9}" + "".join(f"{s:>13}" for s in STAGES))
    for name, row in medians.items():
        print(f"{name:<22}{nodes[name]:>9}" + "".join(f"{row[s]:>13.3f}" for s in STAGES))
    OUT.mkdir(parents=True, exist_ok=True)
    table = {name: {"nodes": nodes[name], **row} for name, row in medians.items()}
    (OUT / "bench.json").write_text(json.dumps(table, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
