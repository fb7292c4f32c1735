"""Ready synthetic models with a known answer: building and writing those of the catalogue.

Each lies in a domain of 8.8 x 8 km. What is written: :mod:`graben.demo_files`. How the geology is made:
:mod:`graben.synthetic`.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray, floats
from graben.demo_catalogue import CATALOGUE, SIZE
from graben.demo_files import write_input, write_truth
from graben.demo_model import HORIZON, MARGIN, Frame, SyntheticModel, TrueCutoff
from graben.demo_surfaces import joined, sheet
from graben.errors import InputError
from graben.model import Fault
from graben.surface import Surface
from graben.synthetic import Geology, Regional, TrueFault

__all__ = [
    "HORIZON",
    "MARGIN",
    "SIZE",
    "Frame",
    "SyntheticModel",
    "TrueCutoff",
    "build",
    "names",
    "noisy",
    "require_noise",
    "write",
]


def build(
    name: str,
    *,
    step: float = 100.0,
    noise: float = 0.0,
    seed: int = 0,
    rotation: float = 0.0,
    mirrored: bool = False,
    shift: tuple[float, float] = (0.0, 0.0),
    shuffle: int | None = None,
) -> SyntheticModel:
    """Return a model of the catalogue.

    Parameters
    ----------
    name : str
        One of :func:`names`; a KeyError otherwise.
    step : float
        Grid step of the horizon, m; must divide the domain.
    noise : float
        Standard deviation of noise added to the horizon, m.
    seed : int
        Of the noise.
    rotation, mirrored, shift
        See :class:`Frame`.
    shuffle : int, optional
        Seed of a random order of the faults' vertices and triangles.

    Raises
    ------
    InputError
        When the step does not divide the domain, or the noise or its seed is negative or no number.
    """
    recipe = CATALOGUE[name]
    if step <= 0 or any(extent % step != 0 for extent in SIZE):
        domain = f"{SIZE[0]:g} m by {SIZE[1]:g} m"
        raise InputError(f"The step {step:g} does not divide the domain of {domain}; take 50, 100 or 200.")
    require_noise(noise, seed)
    frame = Frame(rotation, mirrored, shift)
    geology, surfaces = _triangulated(recipe.geology())
    grid = frame.grid(step)
    values = noisy(geology.seismic(frame.inward(grid.nodes())), noise, seed)
    faults = tuple(_placed(s, frame, shuffle) for s in surfaces)
    return SyntheticModel(name, grid, values, faults, recipe.gamma, noise, geology, frame)


def require_noise(noise: float, seed: int) -> None:
    """Raise InputError where noise or its seed is negative or no number."""
    if not 0 <= noise <= SIZE[0] or seed < 0:
        raise InputError(f"Noise of {noise:g} m from seed {seed} cannot be made; take numbers from 0 on.")


def noisy(values: FloatArray, noise: float, seed: int) -> FloatArray:
    """Return elevations with noise of a standard deviation, m."""
    return floats(values + noise * np.random.default_rng(seed).standard_normal(values.shape))


def names() -> dict[str, str]:
    """Return the names of the catalogue, each with one sentence."""
    return {name: recipe.about for name, recipe in CATALOGUE.items()}


def write(synthetic: SyntheticModel, folder: Path) -> None:
    """Write model.toml, the horizon, the faults and the truth into a folder, which is made where missing."""
    s = synthetic
    faults = [Fault(surface) for surface in s.faults]
    write_input(folder, s.name, s.grid, s.values, faults, noise=s.noise, gamma=s.gamma)
    write_truth(folder / "truth", [synthetic])


def _triangulated(geology: Geology) -> tuple[Geology, list[Surface]]:
    """Return the geology whose faults are the given triangulations, and these."""
    separation = 0.5 * sum(abs(f.throw) for f in geology.faults)
    levels = np.concatenate([_trace_elevations(geology.regional, f) for f in geology.faults])
    low = float(levels.min()) - separation - MARGIN
    high = float(levels.max()) + separation + MARGIN
    b = geology.branching
    if b is None:
        return geology, [sheet(f, low, high) for f in geology.faults]
    pair = joined(geology.faults[b.parent], geology.faults[b.fault], low, high)
    faults = {b.parent: pair.main, b.fault: pair.branch}
    surfaces = {b.parent: pair.main_surface, b.fault: pair.branch_surface}
    order = range(len(geology.faults))
    return replace(geology, faults=tuple(faults[i] for i in order)), [surfaces[i] for i in order]


def _trace_elevations(regional: Regional, fault: TrueFault) -> FloatArray:
    s = np.linspace(fault.columns[0], fault.columns[-1], 101)
    return floats(regional(fault.position(s, np.zeros_like(s))))


def _placed(surface: Surface, frame: Frame, shuffle: int | None) -> Surface:
    """Return a surface in the model's coordinates, in random order of vertices and triangles if asked for."""
    vertices = np.column_stack([frame.outward(surface.vertices[:, :2]), surface.vertices[:, 2]])
    triangles = surface.triangles[:, ::-1] if frame.mirrored else surface.triangles
    if shuffle is not None:
        random = np.random.default_rng(shuffle)
        order = random.permutation(len(vertices))
        place = np.argsort(order)
        vertices, triangles = vertices[order], random.permutation(place[triangles])
    return Surface(surface.name, vertices, triangles)
