"""`make bench` prints all figures and writes build/bench/bench.json; nothing here is asserted.

`python -m tests.bench surfaces network` takes some parts only: runs, surfaces, network, damaged, repairs,
replicas, scheme, growth, whole_run, peers, energies.
"""

from __future__ import annotations

import json
import sys
from importlib import import_module

from tests.bench.tables import OUT, Table

PARTS = (
    "runs",
    "surfaces",
    "network",
    "damaged",
    "repairs",
    "replicas",
    "scheme",
    "growth",
    "whole_run",
    "peers",
    "energies",
)


def main(parts: list[str]) -> None:
    table: Table = {}
    for part in parts or PARTS:
        table |= import_module(f"tests.bench.{part}").figures()
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / "bench.json").write_text(json.dumps(table, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
