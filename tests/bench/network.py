"""The gate on the 142 faults of the SCEC Community Fault Model in one model, in processes of their own."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys

from graben.formats.tsurf import read_tsurf
from graben.model import Fault, Model
from graben.pipeline import examine
from tests.bench.tables import DATA, Table, seconds_table

ROUNDS = 3


def model() -> Model:
    files = sorted((DATA / "cfm").glob("*.ts"))
    return Model("cfm", (), tuple(Fault(o.upward("elevation")) for file in files for o in read_tsurf(file)))


def figures() -> Table:
    if not (DATA / "cfm").is_dir():
        print("cfm left out: ../shared/data is missing")
        return {}
    command = [sys.executable, "-m", "tests.bench.network"]
    rounds = [json.loads(subprocess.check_output(command)) for _ in range(ROUNDS)]
    table = {
        "142 faults of the CFM": {
            "triangles": rounds[0]["triangles"],
            "gate": statistics.median(r["seconds"] for r in rounds),
            "peak MiB": max(r["peak_mb"] for r in rounds),
        }
    }
    seconds_table(f"network: seconds, median of {ROUNDS}", table)
    return table


def main() -> None:
    faults = model()
    seen = examine(faults)
    triangles = sum(len(f.surface.triangles) for f in faults.faults)
    print(json.dumps({"triangles": triangles, "seconds": seen.seconds, "peak_mb": seen.peak_memory_mb}))


if __name__ == "__main__":
    main()
