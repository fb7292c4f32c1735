"""What theta and the length l of the energy do to the errors, on the models with a known answer.

(1 - theta) E_D + theta l^2 E_H has the minimizer of E_D + L^2 E_H with one length L = l sqrt(theta /
(1 - theta)). Each model is prepared once for each noise and then solved with every energy, both with the
noise estimated (the zone is fitted to the nodes around it) and with noise 0 (it is tied to them). Models made
otherwise show whether what is best is so by the way in which the models were made. `python -m tests.bench
energies`.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
import pandas

from graben.arrays import FloatArray, floats
from graben.complexes import Complex
from graben.demo import HORIZON, SyntheticModel, write
from graben.demo import build as demo
from graben.demo_surfaces import sheet
from graben.finding import Profile
from graben.model import Model
from graben.modeling.building import rebuilt
from graben.modeling.preparation import CutHorizon
from graben.modeling.results import HorizonResult, TerminationType
from graben.modeling.scoring import score
from graben.settings import Parameters
from graben.stages import examined, quiet
from graben.synthetic import REACH, Geology
from tests.bench.tables import Table, seconds_table
from tests.models import model_of_demo

THETAS = (0.0, 1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0)
MODELS = ("single", "exit", "cross", "tee", "reverse", "low-dip")
#: Hard for any extrapolation: shown, and not counted in the means.
HARD = ("elliptic", "short")
NOISES, SEEDS = (0.0, 2.0, 5.0), (1, 2, 3)
#: Of the models made otherwise, and of the finer step (m).
OTHERS, FEW_NOISES, FEW_SEEDS, FINE = ("single", "exit", "reverse", "cross"), (0.0, 2.0), (1, 2), 50.0
ERRORS = ("cutoff", "throw", "zone")
#: How far the faults of a model made otherwise reach above and below its horizon, m.
_MARGIN = 300.0


@dataclass(frozen=True)
class Energy:
    """A pair of theta and l; l and the one length L that it means in gammas."""

    theta: float
    length: float = 10.0

    @property
    def one_length(self) -> float:
        return np.inf if self.theta == 1 else self.length * float(np.sqrt(self.theta / (1 - self.theta)))

    def __str__(self) -> str:
        return f"theta {self.theta:g}, l {self.length:g} gamma"


#: All that are tried, and those that matter, by the one length.
ENERGIES = sorted(
    [Energy(t) for t in THETAS] + [Energy(0.5, m) for m in (1.0, 2.0, 3.0, 5.0, 30.0)],
    key=lambda e: e.one_length,
)
#: What holds where nothing is given.
DEFAULT = Energy(Parameters().theta, 10.0)
LENGTHS = (*(Energy(0.5, m) for m in (1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0)), Energy(1.0))


@dataclass(frozen=True, eq=False)
class Altered(Geology):
    """A geology whose displacement dies out over ``reach`` (m), as a Gaussian or exponentially.

    The Gaussian is level at the fault; the exponential falls from the fault on.
    """

    reach: float = REACH
    exponential: bool = False

    def displacement(self, fault: int, xy: FloatArray) -> FloatArray:
        return self._field(fault, xy, np.abs(self.distance(fault, xy)))

    def horizon(self, signs: tuple[int, ...], xy: FloatArray) -> FloatArray:
        moved = sum(s * self._field(f, xy, s * self.distance(f, xy)) for f, s in enumerate(signs))
        return np.asarray(self.regional(xy) - 0.5 * moved, dtype=np.float64)

    def _field(self, fault: int, xy: FloatArray, away: FloatArray) -> FloatArray:
        along, _ = self.faults[fault].coordinates(xy)
        share = away / self.reach
        fall = np.exp(-share if self.exponential else -(share**2))
        return np.asarray(self.faults[fault].separation(along) * fall, dtype=np.float64)


@dataclass(frozen=True)
class Alteration:
    """How a model without a branch is made otherwise: gamma, slope of its horizon, what dies out how."""

    gamma: float = 400.0
    slope: float = 0.1
    reach: float = REACH
    exponential: bool = False

    def of(self, name: str) -> SyntheticModel:
        base = demo(name)
        old = base.geology
        xy = base.frame.inward(base.grid.nodes())
        regional = replace(old.regional, slope=self.slope)
        faults = tuple(replace(f, elevation=float(regional(np.array(f.centre)))) for f in old.faults)
        given = {f.name: getattr(old, f.name) for f in fields(Geology)}
        given |= {"regional": regional, "faults": faults}
        geology = Altered(**given, reach=self.reach, exponential=self.exponential)
        low, high = float(regional(xy).min()) - _MARGIN, float(regional(xy).max()) + _MARGIN
        return replace(
            base,
            geology=geology,
            faults=tuple(sheet(f, low, high) for f in faults),
            gamma=self.gamma,
            values=floats(geology.seismic(xy)),
        )


ALTERATIONS = {
    "as they are": Alteration(),
    "gamma 300 m": Alteration(gamma=300.0),
    "gamma 600 m": Alteration(gamma=600.0),
    "slope 0": Alteration(slope=0.0),
    "slope 0.25": Alteration(slope=0.25),
    "reach 900 m": Alteration(reach=900.0),
    "reach 3000 m": Alteration(reach=3000.0),
    "exponential": Alteration(exponential=True),
}


@dataclass(frozen=True, eq=False)
class Ready:
    """A model prepared once, to be solved with any energy."""

    model: Model
    origin: FloatArray
    network: Complex
    cut: CutHorizon

    @staticmethod
    def of(made: SyntheticModel, noise: float = 0.0, seed: int = 0) -> Ready:
        """Prepare a model without noise of its own, this noise added."""
        random = np.random.default_rng(seed)
        values = made.values + noise * random.standard_normal(made.values.shape)
        model = model_of_demo(replace(made, values=floats(values)))
        _, evidence, stages = examined(model, Profile.EXTENDED, quiet)
        assert evidence.complex is not None
        return Ready(model, model.local_origin(), evidence.complex, stages.ready[HORIZON])

    def solved(self, energy: Energy, fit: bool) -> HorizonResult:
        """Return the rebuilt horizon; without ``fit`` or with theta 0 the nodes around are fixed."""
        gamma = self.model.parameters.gamma
        assert gamma is not None
        chosen = {"theta": energy.theta, "length": energy.length * gamma}
        parameters = self.model.parameters.model_copy(update=chosen)
        cut = self.cut
        if not fit or energy.theta == 0:
            cut = replace(cut, smoothing=0.0, fitted=np.zeros_like(cut.fitted))
        local = replace(self.model, parameters=parameters).moved(-self.origin)
        return rebuilt(local, cut, self.network).moved(self.origin)


def runs(
    made: SyntheticModel,
    energies: Sequence[Energy] = tuple(ENERGIES),
    noises: Sequence[float] = NOISES,
    seeds: Sequence[int] = SEEDS,
    ways: Sequence[bool] = (True, False),
) -> Iterator[dict[str, object]]:
    """Yield the errors (m and % of the largest throw) and the course of each run."""
    with tempfile.TemporaryDirectory() as folder:
        write(made, Path(folder))
        for noise, seed in [(n, s) for n in noises for s in (seeds if n else seeds[:1])]:
            ready = Ready.of(made, noise, seed)
            for fit in ways:
                for energy in energies:
                    result = ready.solved(energy, fit)
                    known = {"model": made.name, "noise": noise, "seed": seed, "fit": fit, "energy": energy}
                    yield known | _row(result, Path(folder) / "truth", ready.model)


def _row(result: HorizonResult, truth: Path, model: Model) -> dict[str, object]:
    scored = score(truth, result, model.faults)
    assert scored is not None
    cut = [s for s in result.subdomains if s.faults]
    row: dict[str, object] = {f"{key}, m": getattr(scored, key).value for key in ERRORS}
    row |= {f"{key}, %": getattr(scored, key).percent for key in ERRORS}
    return row | {
        "iterations": max(s.iterations for s in cut),
        "not type 0": sum(s.termination.type is not TerminationType.CONVERGED for s in cut),
    }


def study(models: Sequence[str] = (*MODELS, *HARD)) -> pandas.DataFrame:
    """Return all runs of these models at their own step."""
    return pandas.DataFrame([row for name in models for row in runs(demo(name))])


def mean_by(rows: pandas.DataFrame, *keys: str) -> pandas.DataFrame:
    """Return means over seeds, then over models (or of each, where that is a key), and sums of not type 0."""
    apart = list(dict.fromkeys([*keys, "model"]))
    numbers = [c for c in rows.columns if c.endswith((", m", ", %")) or c == "iterations"]
    means = rows.groupby(apart, sort=False)[numbers].mean().groupby(list(keys), sort=False).mean()
    return means.join(rows.groupby(list(keys), sort=False)["not type 0"].sum())


def matrix(title: str, rows: pandas.DataFrame, key: str, value: str = "cutoff, m") -> Table:
    """Print and return one kind of error: a row for each energy, a column for each value of ``key``."""
    wide = mean_by(rows, "energy", key)[value].unstack(sort=False)
    table: Table = {str(e): {str(k): float(v) for k, v in row.items()} for e, row in wide.iterrows()}
    seconds_table(f"{title}: {value}", table)
    return {f"{title}: {name}": row for name, row in table.items()}


def against_default(title: str, rows: pandas.DataFrame, *keys: str) -> Table:
    """Print and return cutoff errors over those of the default: geometric mean, least and largest by keys."""
    wide = mean_by(rows, "energy", *keys)["cutoff, m"].unstack("energy", sort=False)
    ratio = wide.div(wide[DEFAULT], axis=0)
    table: Table = {
        str(energy): {
            "mean": float(np.exp(np.log(ratio[energy]).mean())),
            "least": float(ratio[energy].min()),
            "largest": float(ratio[energy].max()),
        }
        for energy in ratio
    }
    title = f"{title}: cutoff errors over those of {DEFAULT}"
    seconds_table(title, table)
    return {f"{title}: {name}": row for name, row in table.items()}


def figures() -> Table:
    begin = time.process_time()
    table: Table = {}
    rows = study()
    counted = rows[rows["model"].isin(MODELS)]
    for (noise, fit), some in counted.groupby(["noise", "fit"], sort=False):
        title = f"energies: noise {noise:g} m, {'estimated' if fit else 'taken as 0'}"
        found: Table = {}
        for energy, row in mean_by(some, "energy").iterrows():
            one = {} if np.isinf(energy.one_length) else {"L, gammas": energy.one_length}
            found[str(energy)] = one | {k: float(v) for k, v in row.items()}
        seconds_table(f"{title}, means of {len(MODELS)} models", found)
        table |= {f"{title}: {name}": row for name, row in found.items()}
    for noise in NOISES:
        some = rows[(rows["noise"] == noise) & rows["fit"]]
        table |= matrix(f"energies: each model, noise {noise:g} m", some, "model")
    table["energies: all runs"] = {"runs": len(rows), "not type 0": int(rows["not type 0"].sum())}
    seconds_table("", {"energies: all runs": table["energies: all runs"]})
    fitted = counted[counted["fit"]]
    table |= against_default(f"energies: {len(MODELS)} models, 3 noises", fitted, "model", "noise")
    table |= _fine() | _altered()
    print(f"{time.process_time() - begin:.0f} s of CPU")
    return table


def _fine() -> Table:
    found = []
    for step in (2 * FINE, FINE):
        for name in OTHERS[:3]:
            found += [r | {"step": step} for r in runs(demo(name, step=step), LENGTHS, (2.0,), (1,), (True,))]
    return matrix("energies: step (m), noise 2 m", pandas.DataFrame(found), "step")


def _altered() -> Table:
    found = []
    for how, alteration in ALTERATIONS.items():
        for name in OTHERS:
            made = alteration.of(name)
            found += [r | {"how": how} for r in runs(made, LENGTHS, FEW_NOISES, FEW_SEEDS, (True,))]
    rows = pandas.DataFrame(found)
    table = against_default("energies: models made otherwise", rows, "how", "noise")
    for noise in FEW_NOISES:
        some = rows[rows["noise"] == noise]
        table |= matrix(f"energies: models made otherwise, noise {noise:g} m", some, "how")
    return table
