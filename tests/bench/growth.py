"""How time and memory of a whole run in memory grow with the nodes and with the faults.

Every size runs in a process of its own and in that alone, so that the seconds of its stages add up and its
memory is all there is. The exponent of a stage is the slope of the line through the logarithms of its times,
and that between the two largest sizes, where what does not grow is least. Only the number of nodes changes
between sizes (:mod:`tests.bench.large_models`): faults, domain and zones are the same metres.
"""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np

from graben.pipeline import build
from tests.bench.large_models import STEPS, WIDE, large
from tests.bench.tables import Table, seconds_table

NODES, FAULTS = tuple(STEPS), (10, 20, 45)
#: What is asked for: the exponent in the nodes, at most.
EXPONENT = 1.2
_AT = "250k"  # nodes of the models of different numbers of faults
_MOST = 45
STAGES = ("check", "triangulate", "solve", "move", "deform", "total")


def measured(nodes: str, faults: int, gamma: float | None = None) -> dict[str, float]:
    """Return the row of one size: nodes, seconds of each stage, memory."""
    gammas = [] if gamma is None else [str(gamma)]
    command = [sys.executable, "-m", "tests.bench.growth", nodes, str(faults), *gammas]
    row: dict[str, float] = json.loads(subprocess.check_output(command))
    return row


def exponents(table: Table, size: str) -> Table:
    """Return the exponent of each stage in a column of the table, over all rows and between the last two."""
    rows = sorted(table.values(), key=lambda row: row[size])
    logs = {key: np.log([row[key] for row in rows]) for key in (size, *STAGES)}
    whole = {stage: float(np.polyfit(logs[size], logs[stage], 1)[0]) for stage in STAGES}
    last = {
        stage: float((logs[stage][-1] - logs[stage][-2]) / (logs[size][-1] - logs[size][-2]))
        for stage in STAGES
    }
    asked = {"asked": EXPONENT} if size == "nodes" else {}
    return {f"exponent in {size}": whole | asked, f"exponent in {size}, last two": last | asked}


def figures() -> Table:
    by_nodes = {f"growth: {nodes}, {_MOST} faults": measured(nodes, _MOST) for nodes in NODES}
    by_faults = {
        f"growth: {_AT}, {faults} faults": measured(_AT, faults) for faults in FAULTS if faults < _MOST
    }
    by_faults[f"growth: {_AT}, {_MOST} faults"] = by_nodes[f"growth: {_AT}, {_MOST} faults"]
    wide = {f"growth: {_AT}, {_MOST} faults, wide zones": measured(_AT, _MOST, WIDE)}
    in_nodes, in_faults = exponents(by_nodes, "nodes"), exponents(by_faults, "faults")
    seconds_table("growth: seconds of a run in memory", by_nodes | by_faults | wide)
    seconds_table("growth: exponents", in_nodes | in_faults)
    return by_nodes | by_faults | wide | in_nodes | in_faults


def main(nodes: str, faults: str, *gamma: str) -> None:
    model = large(nodes, int(faults), *(float(g) for g in gamma))
    run = build(model, workers=1)
    if not run.passed:
        raise RuntimeError(f"{model.name}: {run!r}")
    count = sum(len(h.first) for h in run.horizons)
    row = {"nodes": count, "faults": len(model.faults), **{s: run.timings[s] for s in STAGES}}
    memory = {"peak MiB": run.peak_memory_mb, "KiB a node": 1024.0 * run.peak_memory_mb / count}
    print(json.dumps(row | memory))


if __name__ == "__main__":
    main(*sys.argv[1:])
