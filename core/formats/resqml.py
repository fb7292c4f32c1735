"""RESQML 2.0.1 packages (.epc, with the arrays in an .h5 beside it), through resqpy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

from graben.arrays import FloatArray
from graben.formats.resqml_package import Boundary, Frame, Package, printable
from graben.formats.tsurf import Sign
from graben.model import GridGeometry
from graben.surface import Surface

#: Units of a model that are lengths.
_UNITS = ("m", "ft")


class Lips(Protocol):
    """A pair of cutoff lines, elevations."""

    @property
    def fault(self) -> str:
        """Name of the fault."""

    @property
    def hanging(self) -> FloatArray:
        """Hanging-wall cutoff, shape (k, 3)."""

    @property
    def foot(self) -> FloatArray:
        """Footwall cutoff, shape (k, 3)."""


@dataclass(frozen=True, eq=False)
class GriddedHorizon:
    """A horizon as a package holds it.

    Parameters
    ----------
    surface : Surface
        The triangulated surface, elevations.
    grid : GridGeometry or None
        Its regular grid, if it has one.
    values : (columns, rows) array or None
        Elevations at the nodes of the grid, NaN where undefined.
    cutoffs : sequence of Lips
        Its cutoff lines.
    """

    surface: Surface
    grid: GridGeometry | None = None
    values: FloatArray | None = None
    cutoffs: Sequence[Lips] = ()


def obstacle(unit: str) -> str | None:
    """Return why no package can be written, in a sentence with the mend; None where one can.

    >>> obstacle("none")
    "RESQML has no lengths without a unit: say in model.toml whether it is 'm' or 'ft'."
    """
    if unit not in _UNITS:
        return "RESQML has no lengths without a unit: say in model.toml whether it is 'm' or 'ft'."
    try:
        import_module("resqpy.model")
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] == "resqpy":
            return "RESQML needs resqpy, which is not here: pip install 'graben[resqml]'."
        return f"RESQML needs resqpy, which cannot be loaded ({error}): pip install 'graben[resqml]'."
    except ImportError as error:
        return f"RESQML needs resqpy, which cannot be loaded ({error}): pip install 'graben[resqml]'."
    return None


def write_epc(
    path: Path,
    horizons: Sequence[GriddedHorizon],
    faults: Sequence[Surface],
    *,
    origin: FloatArray,
    z: Sign = "elevation",
    unit: str = "m",
    crs: str | None = None,
) -> None:
    """Write horizons and faults with their interpretations, features and representations.

    A fault is a tectonic boundary with a triangulated set; a horizon a genetic boundary with a triangulated
    set, a regular grid and, for each fault and side, a set of cutoff lines. Identifiers follow from names and
    content. A surface without a triangle is left out.

    Parameters
    ----------
    path : Path
        The package, ending in ``.epc``. The arrays go to the file of the same name that ends in ``.h5``.
    horizons, faults : sequence of GriddedHorizon, sequence of Surface
        In model coordinates, elevations, triangles that name vertices; written in the convention of ``z``.
    origin : (2,) or (3,) array
        Origin of the local frame in plan, rounded to whole units; z is not shifted.
    z : "elevation" or "depth"
        How the package counts z.
    unit : str
        Of all lengths: "m" or "ft".
    crs : str, optional
        Coordinate system: a code such as "EPSG:23031" is stated as such, any other name as text.
    """
    frame = Frame((round(float(origin[0])), round(float(origin[1]))), z, unit, crs)
    tops = [Boundary.of(h.surface, frame) for h in horizons]
    walls = [Boundary.of(s, frame) for s in faults]
    package = Package(path, frame, [*tops, *walls])
    for wall in walls:
        package.add_fault(wall)
    for horizon, top in zip(horizons, tops, strict=True):
        root = package.add_horizon(top)
        if root is not None:
            _add_details(package, horizon, root)
    package.close()


def _add_details(package: Package, horizon: GriddedHorizon, root: Any) -> None:
    """Add the grid and the cutoffs of the horizon whose interpretation is ``root``."""
    name = horizon.surface.name
    if horizon.grid is not None and horizon.values is not None:
        package.add_grid(name, horizon.grid, horizon.values, root)
    for fault in dict.fromkeys(c.fault for c in horizon.cutoffs):
        own = [c for c in horizon.cutoffs if c.fault == fault]
        where = f"cutoff, {printable(fault)}, {printable(name)}"
        package.add_lines(f"hanging wall {where}", [c.hanging for c in own], root)
        package.add_lines(f"footwall {where}", [c.foot for c in own], root)
