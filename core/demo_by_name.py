"""The synthetic models by name: those of the catalogue, and the replicas of the paper's seven."""

from __future__ import annotations

from pathlib import Path

from graben import demo
from graben.demo_files import write_input, write_truth
from graben.demo_model import SyntheticModel
from graben.errors import InputError
from graben.replica_list import REPLICAS
from graben.replica_models import Field, field

STEP = 100.0  #: grid step of the horizon where none is asked for, m


def names() -> dict[str, str]:
    """Return all names, each with one sentence."""
    return demo.names() | {name: replica.about for name, replica in REPLICAS.items()}


def build(
    name: str, *, step: float | None = None, noise: float = 0.0, seed: int = 0
) -> SyntheticModel | Field:
    """Return a model of the catalogue, or a replica.

    Parameters
    ----------
    name : str
        One of :func:`names`.
    step : float, optional
        Grid step of the horizon, m; a replica has that of the paper's Table 2.
    noise : float
        Standard deviation of noise added to the horizon, m.
    seed : int
        Of the noise; of a replica also of its places, strikes, dips, throws and relief.

    Raises
    ------
    InputError
        When there is no such name, a replica is to have another step, or :func:`graben.demo.build` does.
    """
    if name in REPLICAS:
        replica = REPLICAS[name]
        if step not in (None, replica.step):
            raise InputError(
                f"The replica {name} has the step of the paper, {replica.step:g} m; leave out --step."
            )
        return field(replica, seed, noise)
    if name not in demo.names():
        raise InputError(f"There is no demo {name!r}; choose one of {', '.join(names())}.")
    return demo.build(name, step=STEP if step is None else step, noise=noise, seed=seed)


def write(made: SyntheticModel | Field, folder: Path) -> None:
    """Write model.toml, the horizon, the faults and the truth into a folder, which is made where missing."""
    if isinstance(made, Field):
        write_input(folder, made.replica.name, made.grid, made.values, made.faults, noise=made.noise)
        write_truth(folder / "truth", made.parts())
    else:
        demo.write(made, folder)
