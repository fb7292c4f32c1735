"""`graben run` on a million nodes and 45 faults, from files to files, in a process of its own.

It is asked to take at most 40 s and 4 GiB on two cores that have nothing else to do.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.bench.large_models import large, write_large
from tests.bench.tables import Table, seconds_table

SECONDS, GIB = 40.0, 4.0  # asked
NODES, FAULTS = "1M", 45
STAGES = ("check", "repair", "triangulate", "solve", "move", "deform", "write")


def measured(model: Path, folder: Path) -> dict[str, float]:
    """Return wall and CPU seconds of a run, its largest memory, GiB, and what it says of its stages."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.perf_counter()
    command = [sys.executable, "-m", "graben.cli", "run", str(model), "-o", str(folder), "-q"]
    subprocess.run(command, check=True)  # exit code 0: the gate passes and all of the horizon converged
    wall = time.perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    said = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    size = sum(f.stat().st_size for f in folder.rglob("*") if f.is_file()) / 1e6
    stages = {stage: said["timings"][stage] for stage in STAGES}
    # of all children so far: the first one that runs graben is the largest
    peak = after.ru_maxrss / 1024.0**2
    return {"seconds": wall, "CPU": cpu, "peak GiB": peak, "MB written": size, **stages}


def figures() -> Table:
    with tempfile.TemporaryDirectory() as folder:
        file = write_large(Path(folder) / "model", large(NODES, FAULTS))
        found = measured(file, Path(folder) / "result")
    table = {
        f"graben run, {NODES} nodes, {FAULTS} faults": found,
        "asked": {"seconds": SECONDS, "peak GiB": GIB},
    }
    seconds_table("whole run", table)
    return table


if __name__ == "__main__":
    figures()
