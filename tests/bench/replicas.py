"""The seven models of the paper's Table 2 as replicas: how they end, and how far from the truth.

Each with several seeds, by the plain iteration of the paper and by the accelerated one; the columns are those
of the paper's Table 3. `python -m tests.bench.replicas fang bohai` takes some models only.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray, floats
from graben.demo import write
from graben.model import Fault, Model
from graben.modeling.results import HorizonResult, TerminationType
from graben.modeling.scoring import LEAST_SHARE, score, true_throws
from graben.pipeline import build
from graben.replica_list import REPLICAS, Replica
from graben.replica_models import Field, field
from graben.surface import triangle_areas, triangle_dips
from tests.bench.tables import Table, seconds_table

SEEDS = range(5)
SCHEMES = {"plain": False, "accelerated": True}


@dataclass(frozen=True)
class Reported:
    """A row of the paper's Table 3.

    ``iterations``, ``most``: mean and largest over the subdomains. ``displacement``, ``deviation``: mean
    move in plan and mean change of elevation of the cut, m. ``remeshings``: all. ``termination``: type.
    """

    iterations: int
    most: int
    displacement: float
    deviation: float
    remeshings: int
    termination: int

    def row(self) -> dict[str, float]:
        return {
            "mean iter": self.iterations,
            "max iter": self.most,
            "d, m": self.displacement,
            "eps, m": self.deviation,
            "remeshings": self.remeshings,
            "type": self.termination,
        }


TABLE_3 = {
    "Fang": Reported(10, 15, 0.06, 0.07, 0, 0),
    "Bohai": Reported(12, 19, 0.05, 0.06, 2, 0),
    "KrSloboda": Reported(16, 22, 0.07, 0.08, 5, 2),
    "Ashtart": Reported(13, 18, 0.05, 0.07, 3, 2),
    "Chicontepec": Reported(14, 20, 0.06, 0.07, 4, 0),
    "Chesapeake": Reported(15, 21, 0.06, 0.08, 4, 3),
    "OGX": Reported(9, 14, 0.04, 0.05, 0, 0),
}


@dataclass(frozen=True, eq=False)
class Truth:
    """The known answer of one cluster: its folder, its faults, and its largest true throw (m)."""

    folder: Path
    faults: tuple[Fault, ...]
    largest: float


@dataclass(frozen=True)
class Ended:
    """How one replica ended by one scheme.

    ``iterations``, ``displacement``, ``deviation``, ``types``: of each subdomain that has a cut; m.
    ``cutoff``, ``throw``: root mean square errors, m; ``percent``: of the cutoff, of the largest throw.
    """

    iterations: tuple[int, ...]
    displacement: tuple[float, ...]
    deviation: tuple[float, ...]
    types: tuple[int, ...]
    cutoff: float
    throw: float
    percent: float
    seconds: float

    def row(self) -> dict[str, float]:
        counts = Counter(self.types)
        row: dict[str, float] = {"subdomains": len(self.types)}
        row |= {f"type {int(t)}": counts[int(t)] for t in TerminationType}
        return row | {
            "mean iter": float(np.mean(self.iterations)),
            "max iter": max(self.iterations),
            "d, m": float(np.mean(self.displacement)),
            "eps, m": float(np.mean(self.deviation)),
            "cutoff, m": self.cutoff,
            "throw, m": self.throw,
            "cutoff, %": self.percent,
            "s an iter": self.seconds,
        }


def dips(model: Model) -> FloatArray:
    """Return the mean dip of each fault by area, degrees."""
    surfaces = [f.surface for f in model.faults]
    return floats(
        [
            np.average(
                triangle_dips(s.vertices, s.triangles), weights=triangle_areas(s.vertices, s.triangles)
            )
            for s in surfaces
        ]
    )


def truths(made: Field, folder: Path) -> list[Truth]:
    """Return the known answers of the clusters, written into folders of their own."""
    found = []
    for number, part in enumerate(made.parts()):
        write(part, folder / str(number))
        largest = max(float(np.abs(c.throw).max()) for c in part.cutoffs)
        faults = tuple(Fault(s) for s in part.faults)
        found.append(Truth(folder / str(number) / "truth", faults, largest))
    return found


def ended(model: Model, known: list[Truth]) -> Ended:
    """Return how a replica ends; its gate must pass, and its faults are taken as they are."""
    run = build(model, mend=False)
    if not run.after.passed or run.not_modeled:
        raise RuntimeError(f"{model.name} is no model of the paper's conditions: {run.after}")
    horizon = run.horizons[0]
    cut = [s for s in horizon.subdomains if s.faults]
    for s in cut:
        if s.termination.type is not TerminationType.CONVERGED:
            print(f"{model.name}, acceleration {model.parameters.acceleration}: {s.termination}")
    cutoff, throw = errors(horizon, known)
    return Ended(
        tuple(s.iterations for s in cut),
        tuple(s.mean_displacement for s in cut),
        tuple(s.mean_deviation for s in cut),
        tuple(int(s.termination.type) for s in cut),
        cutoff,
        throw,
        100.0 * cutoff / max(t.largest for t in known),
        run.timings["per_iteration"],
    )


def errors(result: HorizonResult, known: list[Truth]) -> tuple[float, float]:
    """Return the root mean square errors of cutoffs and throws over all clusters, m."""
    squares, weights = [], []
    for truth in known:
        part = restricted(result, truth.faults)
        scored = score(truth.folder, part, truth.faults)
        if scored is None:
            raise RuntimeError(f"{truth.folder}: nothing to score")
        throws = np.concatenate(true_throws(truth.folder, part, truth.faults))
        squares.append((scored.cutoff.value**2, scored.throw.value**2))
        weights.append(np.count_nonzero(np.abs(throws) > LEAST_SHARE * truth.largest))
    cutoff, throw = np.sqrt(np.average(squares, axis=0, weights=weights)).tolist()
    return cutoff, throw


def restricted(result: HorizonResult, faults: tuple[Fault, ...]) -> HorizonResult:
    """Return a result with the cuts of some faults alone, all nodes beyond their zones fixed."""
    names = tuple(f.name for f in faults)
    block = result.block[:, [result.graph_faults.index(n) for n in names]]
    return replace(
        result,
        graph_faults=names,
        smears=np.zeros(len(names)),
        block=block,
        fixed=result.fixed | (block == 0).all(axis=1),
        cutoffs=tuple(c for c in result.cutoffs if c.fault in names),
    )


def measured(replica: Replica, seed: int) -> dict[str, Ended]:
    """Return how a replica ends by each scheme."""
    made = field(replica, seed)
    with tempfile.TemporaryDirectory() as folder:
        known = truths(made, Path(folder))
        return {s: ended(made.model(acceleration=fast), known) for s, fast in SCHEMES.items()}


def together(ends: list[Ended]) -> dict[str, float]:
    """Return the row of several seeds: sums of counts, the largest of the largest, means of all else."""
    rows = [end.row() for end in ends]
    summed = {"subdomains", *(f"type {int(t)}" for t in TerminationType)}
    row: dict[str, float] = {}
    for key in rows[0]:
        values = [r[key] for r in rows]
        row[key] = (
            sum(values) if key in summed else max(values) if key == "max iter" else float(np.mean(values))
        )
    return row


def figures(names: tuple[str, ...] = tuple(REPLICAS), seeds: range = SEEDS) -> Table:
    single: Table = {}
    table: Table = {}
    for name in names:
        begin = time.perf_counter()
        replica = REPLICAS[name]
        ends = [measured(replica, seed) for seed in seeds]
        table[f"replica {replica.name}, paper"] = TABLE_3[replica.name].row()
        for scheme in SCHEMES:
            single |= {
                f"{replica.name} {seed}, {scheme}": e[scheme].row()
                for seed, e in zip(seeds, ends, strict=True)
            }
            table[f"replica {replica.name}, {scheme}"] = together([e[scheme] for e in ends])
        print(f"{name}: {time.perf_counter() - begin:.0f} s", file=sys.stderr)
    seconds_table("replicas, seed by seed", single)
    seconds_table(f"replicas, {len(seeds)} seeds", table)
    return table


if __name__ == "__main__":
    figures(tuple(sys.argv[1:]) or tuple(REPLICAS))
