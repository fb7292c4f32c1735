"""Ready synthetic models with a known answer: the catalogue, building and writing.

Every model lies in a domain of 8.8 x 8 km. Its truth is written beside it:

- ``truth/truth.json``: {"schema": 1, "faults": {name: file}, "horizons": {name: {"cutoffs": file,
  "blocks": [{"sides": {fault: 1 | -1 | 0}, "file": file}]}}}. A side is 1 where the block hangs on the
  fault, -1 where it is the foot, 0 where the fault does not reach the block. Files are relative to truth/.
- ``truth/cutoffs/<horizon>.csv``: fault, side, block (its place in the list), s, x, y, z, throw. Every
  10 m along strike and at the ends; s is the straight distance along strike from the fault's end, throw the
  elevation of foot minus hanging at the same s.
- ``truth/blocks/<horizon>-<block>.irap``: the true horizon of a block over the whole domain, beyond its
  faults too, at half the model's step.
- ``truth/faults/<fault>.irap``: the elevation of the fault on the same grid, extended beyond its ends.

z is elevation throughout. How the geology is made: :mod:`graben.synthetic`.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray, floats
from graben.demo_catalogue import CATALOGUE, SIZE
from graben.demo_surfaces import joined, sheet
from graben.errors import InputError
from graben.formats.irap import write_irap_ascii
from graben.formats.tsurf_writer import write_tsurf
from graben.model import GridGeometry
from graben.surface import Surface
from graben.synthetic import Geology, Regional, TrueFault

HORIZON = "Top"  #: name of the horizon of every model
MARGIN = 300.0  #: faults reach this far above and below the horizon, m


@dataclass(frozen=True)
class Frame:
    """The plan movement from a model's upright frame to its coordinates: mirrored, rotated, shifted.

    ``rotation`` in degrees counter-clockwise about the domain's middle, ``mirrored`` turns x round there
    first, ``shift`` in m.
    """

    rotation: float = 0.0
    mirrored: bool = False
    shift: tuple[float, float] = (0.0, 0.0)

    def outward(self, xy: FloatArray) -> FloatArray:
        """Return model coordinates of upright plan positions (..., 2)."""
        c, s = self._turn
        x, y = self._flip * (xy[..., 0] - 0.5 * SIZE[0]), xy[..., 1] - 0.5 * SIZE[1]
        return floats(
            np.stack(
                [
                    x * c - y * s + 0.5 * SIZE[0] + self.shift[0],
                    x * s + y * c + 0.5 * SIZE[1] + self.shift[1],
                ],
                axis=-1,
            )
        )

    def inward(self, xy: FloatArray) -> FloatArray:
        """Return upright plan positions of model coordinates (..., 2)."""
        c, s = self._turn
        x, y = xy[..., 0] - self.shift[0] - 0.5 * SIZE[0], xy[..., 1] - self.shift[1] - 0.5 * SIZE[1]
        upright = [self._flip * (x * c + y * s) + 0.5 * SIZE[0], y * c - x * s + 0.5 * SIZE[1]]
        return floats(np.stack(upright, axis=-1))

    def grid(self, step: float) -> GridGeometry:
        """Return the grid over the domain."""
        corner = np.array([SIZE[0] if self.mirrored else 0.0, 0.0])
        x, y = self.outward(corner).tolist()
        columns, rows = (round(extent / step) + 1 for extent in SIZE)
        return GridGeometry(columns, rows, step, step, (x, y), self.rotation)

    @property
    def _turn(self) -> tuple[float, float]:
        a = np.radians(self.rotation)
        return float(np.cos(a)), float(np.sin(a))

    @property
    def _flip(self) -> float:
        return -1.0 if self.mirrored else 1.0


@dataclass(frozen=True, eq=False)
class TrueCutoff:
    """A true cutoff line in the model's coordinates.

    Parameters
    ----------
    fault, side, block : int
        Index of the fault; 1 hanging, -1 foot; index of the block.
    s : (k,) array
        Straight distance along strike from the end at which the fault dips to the right of the way, m.
    points : (k, 3) array
        On the triangulated fault, m.
    throw : (k,) array
        Elevation of foot minus hanging at the same s, m.
    """

    fault: int
    side: int
    block: int
    s: FloatArray
    points: FloatArray
    throw: FloatArray


@dataclass(frozen=True, eq=False)
class SyntheticModel:
    """A synthetic model and its truth.

    Parameters
    ----------
    name : str
        Name in the catalogue.
    grid : GridGeometry
        Of the horizon.
    values : (columns, rows) array
        Elevation of the smeared horizon, m.
    faults : tuple of Surface
        The faults.
    gamma : float
        Half-width of the zone that the smear makes unreliable, m.
    noise : float
        Standard deviation of the noise in the values, m.
    geology : Geology
        What is true, in the upright frame.
    frame : Frame
        From there to the model's coordinates.
    """

    name: str
    grid: GridGeometry
    values: FloatArray
    faults: tuple[Surface, ...]
    gamma: float
    noise: float
    geology: Geology
    frame: Frame

    def horizon(self, block: int, xy: FloatArray) -> FloatArray:
        """Return the true horizon of a block at plan positions (..., 2) of the model, m."""
        return self.geology.horizon(self.geology.blocks[block], self.frame.inward(xy))

    @cached_property
    def cutoffs(self) -> tuple[TrueCutoff, ...]:
        """The true cutoff lines, fault by fault, block by block."""
        result = []
        for f, fault in enumerate(self.geology.faults):
            for b, signs in enumerate(self.geology.blocks):
                if signs[f] == 0:
                    continue
                for s, upright in self.geology.cutoffs(f, signs):
                    points = np.column_stack([self.frame.outward(upright[:, :2]), upright[:, 2]])
                    from_end = s - fault.columns[0]
                    if self.frame.mirrored:  # the fault dips to the right of the opposite way
                        from_end, points = (fault.columns[-1] - s)[::-1], points[::-1]
                    result.append(TrueCutoff(f, signs[f], b, floats(from_end), floats(points), floats([])))
        return tuple(replace(c, throw=_throw(c, result, self.geology.blocks)) for c in result)


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
        One of :func:`names`.
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
        When the name is not in the catalogue, the step does not divide the domain, or the noise or its seed
        is negative or no number.
    """
    if name not in CATALOGUE:
        raise InputError(f"There is no demo {name!r}; choose one of {', '.join(CATALOGUE)}.")
    if step <= 0 or any(extent % step != 0 for extent in SIZE):
        domain = f"{SIZE[0]:g} m by {SIZE[1]:g} m"
        raise InputError(f"The step {step:g} does not divide the domain of {domain}; take 50, 100 or 200.")
    if not 0 <= noise <= SIZE[0] or seed < 0:
        raise InputError(f"Noise of {noise:g} m from seed {seed} cannot be made; take numbers from 0 on.")
    frame = Frame(rotation, mirrored, shift)
    recipe = CATALOGUE[name]
    geology, surfaces = _triangulated(recipe.geology())
    grid = frame.grid(step)
    values = geology.seismic(frame.inward(grid.nodes()))
    values = values + noise * np.random.default_rng(seed).standard_normal(values.shape)
    faults = tuple(_placed(s, frame, shuffle) for s in surfaces)
    return SyntheticModel(name, grid, floats(values), faults, recipe.gamma, noise, geology, frame)


def names() -> dict[str, str]:
    """Return the names of the catalogue, each with one sentence."""
    return {name: recipe.about for name, recipe in CATALOGUE.items()}


def write(synthetic: SyntheticModel, folder: Path) -> None:
    """Write model.toml, the horizon, the faults and the truth into a folder, which is made where missing."""
    folder.mkdir(parents=True, exist_ok=True)
    write_irap_ascii(folder / "top.irap", synthetic.grid, synthetic.values)
    for surface in synthetic.faults:
        write_tsurf(folder / f"{surface.name}.ts", [surface])
    (folder / "model.toml").write_text(_model_toml(synthetic), encoding="utf-8")
    _write_truth(synthetic, folder / "truth")


def _model_toml(synthetic: SyntheticModel) -> str:
    head = f'[model]\nname = "{synthetic.name}"\nz = "elevation"\nunit = "m"\ntruth = "truth"\n\n'
    noise = f"noise = {synthetic.noise}\n" if synthetic.noise else ""
    horizon = f'[[horizons]]\nname = "{HORIZON}"\nfile = "top.irap"\n{noise}\n'
    faults = "".join(f'[[faults]]\nname = "{s.name}"\nfile = "{s.name}.ts"\n\n' for s in synthetic.faults)
    return f"{head}{horizon}{faults}[parameters]\ngamma = {synthetic.gamma}\n"


def _write_truth(synthetic: SyntheticModel, folder: Path) -> None:
    for part in ("cutoffs", "blocks", "faults"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    grid = synthetic.frame.grid(0.5 * synthetic.grid.step)
    xy = synthetic.frame.inward(grid.nodes())
    geology = synthetic.geology
    fault_names = [f.name for f in geology.faults]
    for f in geology.faults:
        write_irap_ascii(folder / f"faults/{f.name}.irap", grid, f.elevation_at(*f.coordinates(xy)))
    blocks = []
    for b, signs in enumerate(geology.blocks):
        file = f"blocks/{HORIZON}-{b}.irap"
        write_irap_ascii(folder / file, grid, geology.horizon(signs, xy))
        blocks.append({"sides": dict(zip(fault_names, signs, strict=True)), "file": file})
    rows = ["fault,side,block,s,x,y,z,throw"]
    for c in synthetic.cutoffs:
        label = f"{fault_names[c.fault]},{'hanging' if c.side > 0 else 'foot'},{c.block}"
        table = np.column_stack([c.s, c.points, c.throw]).tolist()
        rows += [f"{label},{s:.6f},{x:.6f},{y:.6f},{z:.6f},{t:.6f}" for s, x, y, z, t in table]
    (folder / f"cutoffs/{HORIZON}.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    index = {
        "schema": 1,
        "faults": {name: f"faults/{name}.irap" for name in fault_names},
        "horizons": {HORIZON: {"cutoffs": f"cutoffs/{HORIZON}.csv", "blocks": blocks}},
    }
    (folder / "truth.json").write_text(json.dumps(index, indent=1) + "\n", encoding="utf-8")


def _throw(cutoff: TrueCutoff, others: list[TrueCutoff], blocks: tuple[tuple[int, ...], ...]) -> FloatArray:
    """Return foot minus hanging at each s of a lip, against the nearest lip across the fault."""
    signs = blocks[cutoff.block]
    best = np.full(cutoff.s.shape, np.inf)
    facing = np.full(cutoff.s.shape, np.nan)
    for other in others:
        theirs = blocks[other.block]
        pairs = [a * b != -1 for g, (a, b) in enumerate(zip(signs, theirs, strict=True)) if g != cutoff.fault]
        if other.fault != cutoff.fault or other.side == cutoff.side or not all(pairs):
            continue
        s, z = other.s, other.points[:, 2]
        beyond = np.maximum(np.maximum(s[0] - cutoff.s, cutoff.s - s[-1]), 0.0)
        facing = np.where(beyond < best, np.interp(cutoff.s, s, z), facing)
        best = np.minimum(best, beyond)
    return floats(cutoff.side * (facing - cutoff.points[:, 2]))


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
