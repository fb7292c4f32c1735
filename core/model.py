"""The structural model: horizons, faults and settings as immutable values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

import numpy as np

from graben.arrays import FloatArray, floats
from graben.settings import ContactRule, Parameters, RepairSettings
from graben.surface import Surface
from graben.words import plural

if TYPE_CHECKING:
    import pyvista


#: Coordinates of this size stand for "undefined" in grid formats (1e30, 1e33).
UNDEFINED = 1e20
#: What notes of a horizon call points whose coordinates are no numbers or stand for undefined.
UNFIT = "points are no places"


@dataclass(frozen=True)
class GridGeometry:
    """A regular grid in plan, as in Irap files.

    Node (i, j), i < columns, j < rows, lies at
    ``origin + i * dx * (cos a, sin a) + j * dy * (-sin a, cos a)``, a the rotation in degrees,
    counter-clockwise from east. ``origin`` in model units.
    """

    columns: int
    rows: int
    dx: float
    dy: float
    origin: tuple[float, float]
    rotation: float = 0.0

    @property
    def step(self) -> float:
        """sqrt(dx dy), model units."""
        return float(np.sqrt(self.dx * self.dy))

    def nodes(self) -> FloatArray:
        """Return the plan positions of all nodes, shape (columns, rows, 2)."""
        a = np.radians(self.rotation)
        i, j = np.meshgrid(np.arange(self.columns), np.arange(self.rows), indexing="ij")
        x = self.origin[0] + i * self.dx * np.cos(a) - j * self.dy * np.sin(a)
        y = self.origin[1] + i * self.dx * np.sin(a) + j * self.dy * np.cos(a)
        return floats(np.stack([x, y], axis=-1))

    def moved(self, offset: FloatArray) -> GridGeometry:
        """Return the grid shifted in plan by ``offset[:2]``."""
        return replace(self, origin=(float(self.origin[0] + offset[0]), float(self.origin[1] + offset[1])))


@dataclass(frozen=True, eq=False)
class Horizon:
    """A horizon as the model stage takes it: a surface triangulated in plan.

    Parameters
    ----------
    name : str
        Name.
    surface : Surface
        Triangulated; a node for each defined grid node, or the nodes fitted to points.
    step : float
        Node spacing, model units (``graben.model`` says how it follows from the input).
    grid : GridGeometry or None
        The input's own grid, or the regular grid on which results are written.
    picks : (p, 3) array
        The input points, empty for grids and triangulated surfaces.
    noise : float or None
        Standard deviation of the input, model units; None where it was not given.
    smoothing : float
        Length over which picks were smoothed when the surface was fitted, model units; 0 without picks.
    notes : tuple of str
        What was done on reading (undefined nodes, fitted points), one sentence each.
    """

    name: str
    surface: Surface
    step: float
    grid: GridGeometry | None = None
    picks: FloatArray = field(default_factory=lambda: floats([], 0, 3))
    noise: float | None = None
    smoothing: float = 0.0
    notes: tuple[str, ...] = ()

    def moved(self, offset: FloatArray) -> Horizon:
        """Return the horizon shifted by ``offset``, shape (3,)."""
        return replace(
            self,
            surface=self.surface.moved(offset),
            grid=None if self.grid is None else self.grid.moved(offset),
            picks=floats(self.picks + offset),
        )


@dataclass(frozen=True, eq=False)
class Fault:
    """A fault: its surface and, where they are set for it alone, its gamma and max_move (model units).

    Repair sets max_move from the fault that was given: its median edge changes on the way.
    """

    surface: Surface
    gamma: float | None = None
    max_move: float | None = None

    @property
    def name(self) -> str:
        """The surface's name."""
        return self.surface.name

    def moved(self, offset: FloatArray) -> Fault:
        """Return the fault shifted by ``offset``, shape (3,)."""
        return replace(self, surface=self.surface.moved(offset))


@dataclass(frozen=True)
class Statement:
    """What a file of a model states of its numbers.

    Parameters
    ----------
    file : Path
        The file.
    names : tuple of str
        The surfaces of the model that it holds.
    units : tuple of str
        "m", "ft", both or none.
    signed : bool
        Whether it states the sign of z.
    low, high : float
        Least and greatest z of these surfaces, elevations in model units; NaN where none is usable.
    """

    file: Path
    names: tuple[str, ...]
    units: tuple[str, ...]
    signed: bool
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Model:
    """A structural model. Coordinates are the input's, z is elevation (positive up).

    ``z`` and ``unit`` are the model file's own, for output; ``file`` is that file, None for a model made
    in Python. ``statements`` are what the files say of their numbers, ``left_out`` the keys of [model] that
    have their default, since model.toml does not name them.
    """

    name: str
    horizons: tuple[Horizon, ...] = ()
    faults: tuple[Fault, ...] = ()
    z: Literal["elevation", "depth"] = "elevation"
    unit: Literal["m", "ft", "none"] = "m"
    crs: str | None = None
    truth: Path | None = None
    parameters: Parameters = Parameters()
    repair: RepairSettings = RepairSettings()
    contacts: tuple[ContactRule, ...] = ()
    checks: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    file: Path | None = None
    statements: tuple[Statement, ...] = ()
    left_out: frozenset[str] = frozenset()

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """All surfaces: horizons, then faults."""
        return tuple(h.surface for h in self.horizons) + tuple(f.surface for f in self.faults)

    @property
    def z_factor(self) -> float:
        """1 where the model counts z upwards, -1 where it counts depth."""
        return 1.0 if self.z == "elevation" else -1.0

    @cached_property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest usable coordinates of all surfaces, shape (3,) each; zeros if there are none.

        Not finite, or as large as the marks that formats set for undefined, is not usable.
        """
        points = [s.vertices[(np.abs(s.vertices) < UNDEFINED).all(axis=1)] for s in self.surfaces]
        points = [p for p in points if len(p)]
        if not points:
            return floats(np.zeros(3)), floats(np.zeros(3))
        return (
            floats(np.min([p.min(axis=0) for p in points], axis=0)),
            floats(np.max([p.max(axis=0) for p in points], axis=0)),
        )

    @property
    def size(self) -> float:
        """Diagonal of the model's bounding box, model units."""
        low, high = self.bounds
        return float(np.linalg.norm(high - low))

    @property
    def tolerance(self) -> float:
        """The paper's eps_tol: as given, else 1e-5 of the size, and at most 0.1 m (0.1 / 0.3048 ft).

        The share of the size serves models without unit, and small ones whose unit was not set.
        """
        if self.parameters.tolerance is not None:
            return self.parameters.tolerance
        return min({"m": 0.1, "ft": 0.1 / 0.3048, "none": np.inf}[self.unit], 1e-5 * self.size)

    def gamma(self, fault: Fault, horizon: Horizon) -> float:
        """Return the half-width of the modeling zone of a fault on a horizon, model units."""
        return fault.gamma or self.parameters.gamma or 4.0 * horizon.step

    def max_move(self, fault: Fault) -> float:
        """Return how far a vertex of a fault may be moved by a repair, model units.

        As given in [repair]; else half the least step of the horizons, with no horizon half the median
        edge of the fault.
        """
        if fault.max_move is not None:
            return fault.max_move
        if self.repair.max_move is not None:
            return self.repair.max_move
        if self.horizons:
            return 0.5 * min(h.step for h in self.horizons)
        return 0.5 * fault.surface.median_edge

    def max_extension(self, fault: Fault) -> float:
        """Return how far a fault may be extended or cut back at a contact, model units: 5 max_move."""
        return self.repair.max_extension or 5.0 * self.max_move(fault)

    def moved(self, offset: FloatArray) -> Model:
        """Return the model shifted by ``offset``, shape (3,)."""
        return replace(
            self,
            horizons=tuple(h.moved(offset) for h in self.horizons),
            faults=tuple(f.moved(offset) for f in self.faults),
        )

    def local_origin(self) -> FloatArray:
        """Return the origin of the local frame: the centre of the bounds in whole units, shape (3,).

        Kernels work on ``model.moved(-origin)``, so that large offsets cost no digits there. Whole units
        keep the shift exact for coordinates given with a few decimals.
        """
        low, high = self.bounds
        return floats(np.round((low + high) / 2.0))

    def __repr__(self) -> str:
        sizes = f"{plural(len(self.horizons), 'horizon')}, {plural(len(self.faults), 'fault')}"
        return f"Model {self.name!r}: {sizes}, unit {self.unit}"

    def _repr_html_(self) -> str:
        from html import escape

        rows = "".join(
            f"<tr><td>{kind}</td><td>{escape(s.name)}</td><td>{len(s.vertices)}</td><td>{len(s.triangles)}</td></tr>"
            for kind, group in (("horizon", self.horizons), ("fault", self.faults))
            for s in (item.surface for item in group)
        )
        head = "<tr><th></th><th>name</th><th>vertices</th><th>triangles</th></tr>"
        return f"<p>Model <b>{escape(self.name)}</b></p><table>{head}{rows}</table>"

    def to_pyvista(self) -> pyvista.MultiBlock:
        """Return all surfaces as a named ``pyvista.MultiBlock``."""
        import pyvista

        return pyvista.MultiBlock({s.name: s.to_pyvista() for s in self.surfaces})
