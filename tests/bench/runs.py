"""Figures of whole runs, in memory: each case three times, the cases in turn."""

from __future__ import annotations

import statistics
from collections import defaultdict

from graben.demo import build as demo
from graben.model import Model
from graben.pipeline import build
from graben.reading import read_model
from tests.bench.tables import DATA, Table, seconds_table
from tests.models import model_of_demo

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


def figures() -> Table:
    models = cases()
    seconds: dict[str, dict[str, list[float]]] = {name: defaultdict(list) for name in models}
    nodes: dict[str, float] = {}
    for _ in range(ROUNDS):
        for name, model in models.items():
            result = build(model)
            nodes[name] = sum(len(h.first) for h in result.horizons)
            for stage in STAGES:
                seconds[name][stage].append(result.timings[stage])
    table = {
        name: {"nodes": nodes[name], **{s: statistics.median(times[s]) for s in STAGES}}
        for name, times in seconds.items()
    }
    seconds_table(f"runs: seconds, median of {ROUNDS}", table)
    return table
