"""A thousand damaged models through `graben check`: how they end, how long they take and what memory."""

from __future__ import annotations

import statistics
import tempfile
from collections import Counter
from pathlib import Path

from tests.bench.tables import Table, seconds_table
from tests.damage import examined, ready

COUNT = 1000


def figures() -> Table:
    ready()
    with tempfile.TemporaryDirectory() as folder:
        ends = [examined(seed, Path(folder)) for seed in range(COUNT)]
    for end in ends:
        if end["wrong"]:
            print(f"seed {end['seed']}: {end['wrong']} ({end['done']}): {end['stderr'].strip()}")
    codes = Counter(end["code"] for end in ends)
    seconds = [end["seconds"] for end in ends]
    row: dict[str, float] = {f"exit {code}": codes[code] for code in (0, 1, 2)}
    row |= {"wrong": sum(bool(end["wrong"]) for end in ends)}
    row |= {"median": statistics.median(seconds), "longest": max(seconds)}
    row |= {"peak MiB": max(end["peak_mb"] for end in ends)}
    seconds_table("damaged files: seconds", {f"{COUNT} models": row})
    return {f"{COUNT} damaged models": row}
