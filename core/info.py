"""What a surface file holds, for ``graben info``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.errors import InputError
from graben.formats.grids import read_grid
from graben.formats.irap import grid_surface
from graben.formats.kinds import SURFACES, Kind, kind_of
from graben.formats.meshes import read_surfaces
from graben.formats.points import read_points
from graben.formats.stated import stated_units
from graben.formats.stick_surface import sticks_surface
from graben.formats.sticks import read_sticks
from graben.model import GridGeometry
from graben.reading import points_step
from graben.surface import (
    Surface,
    boundary_loops,
    mean_dip_direction,
    strong_components,
    triangle_areas,
    triangle_dips,
    triangle_normals,
)
from graben.words import plural


@dataclass(frozen=True)
class Extents:
    """Least and greatest finite x, y and z, model units; None where nothing is finite."""

    low: tuple[float, float, float] | None
    high: tuple[float, float, float] | None

    def __str__(self) -> str:
        if self.low is None or self.high is None:
            return "no finite coordinate"
        pairs = zip("xyz", self.low, self.high, strict=True)
        return ", ".join(f"{axis} {low:.10g} to {high:.10g}" for axis, low, high in pairs)


@dataclass(frozen=True)
class SurfaceInfo:
    """A triangulated surface: counts, extents, orientation (degrees, from its fit triangles) and topology.

    ``mean_dip`` is the area-weighted mean of the triangles' dips. ``strike`` lies in [0, 180), clockwise from
    the y-axis, ``dip_direction`` in [0, 360), down the mean dip; dips and both are None without area.
    ``unfit`` counts triangles that name no vertex or touch one that is not finite.
    """

    name: str
    vertices: int
    triangles: int
    unfit: int
    extents: Extents
    mean_dip: float | None
    least_dip: float | None
    greatest_dip: float | None
    strike: float | None
    loops: int
    components: int
    dip_direction: float | None = None

    def __str__(self) -> str:
        lines = [
            f"surface {self.name!r}: vertices {self.vertices}, triangles {self.triangles}",
            f"  {self.extents}",
        ]
        if self.mean_dip is None or self.strike is None:
            lines.append("  no area, so neither dip nor strike")
        else:
            dips = f"dip {self.mean_dip:.1f} (triangles {self.least_dip:.1f} to {self.greatest_dip:.1f})"
            towards = f"dip direction {self.dip_direction:.1f} where z counts upwards"
            lines.append(f"  {dips}, {towards}, strike {self.strike:.1f} degrees")
        lines.append(f"  boundary loops {self.loops}, components {self.components}")
        if self.unfit:
            lines.append(f"  unfit triangles {self.unfit}")
        return "\n".join(lines)


@dataclass(frozen=True)
class GridInfo:
    """A regular grid and how many of its nodes are undefined."""

    geometry: GridGeometry
    undefined: int
    extents: Extents

    def __str__(self) -> str:
        g = self.geometry
        return (
            f"grid of {g.columns} x {g.rows} nodes, {self.undefined} of {g.columns * g.rows} undefined\n"
            f"  steps {g.dx:g} and {g.dy:g}, origin ({g.origin[0]:.10g}, {g.origin[1]:.10g}), "
            f"rotation {g.rotation:g} degrees\n  {self.extents}"
        )


@dataclass(frozen=True)
class PointsInfo:
    """Points: ``spacing`` is the median distance in plan to the nearest other, ``step`` the default step."""

    count: int
    unfit: int
    extents: Extents
    spacing: float
    step: float

    def __str__(self) -> str:
        text = f"{plural(self.count, 'point')}\n  {self.extents}\n"
        text += f"  spacing {self.spacing:g}, default step {self.step:g}"
        return text + (f"\n  points that are not finite {self.unfit}" if self.unfit else "")


@dataclass(frozen=True)
class SticksInfo:
    """Fault sticks and the surface through them."""

    sticks: int
    points: int
    least: int
    greatest: int
    surface: SurfaceInfo

    def __str__(self) -> str:
        each = f"{self.least}" if self.least == self.greatest else f"{self.least} to {self.greatest}"
        head = f"{self.sticks} fault sticks of {each} points, {self.points} in all; the surface through them:"
        return f"{head}\n{self.surface}"


@dataclass(frozen=True)
class FileInfo:
    """What a file holds, and what it states of its numbers.

    ``signs`` says for each part how z is counted, ``units`` which of "m" and "ft" the file states.
    """

    path: Path
    kind: Kind
    parts: tuple[SurfaceInfo | GridInfo | PointsInfo | SticksInfo, ...]
    signs: tuple[str, ...]
    units: tuple[str, ...] = ()

    def __str__(self) -> str:
        lines = [f"{self.path}: {self.kind}"]
        for part, sign in zip(self.parts, self.signs, strict=True):
            lines += [str(part), f"  z: {sign}"]
        told = f"{' and '.join(self.units)}, as stated" if self.units else _NO_UNIT
        lines.append(f"unit: {told}")
        return "\n".join(lines)


_NOT_STATED = "sign not stated, shown as it stands (model.toml says which with the key z)"
_NO_UNIT = "not stated (model.toml says it with the key unit)"


def describe(path: str | Path) -> FileInfo:
    """Return what a surface file holds.

    Raises
    ------
    InputError
        When the file cannot be read.
    """
    path = Path(path)
    if path.suffix == ".toml":
        raise InputError(f"{path} is a model, not a surface file; use graben run.")
    kind = kind_of(path)
    if kind in SURFACES:
        objects = read_surfaces(path, kind)
        signs = {
            None: _NOT_STATED,
            "elevation": "elevation, as stated",
            "depth": "depth, as stated; shown as elevation",
        }
        parts = tuple(surface_info(o.surface) for o in objects)
        return FileInfo(path, kind, parts, tuple(signs[o.z] for o in objects), stated_units(path, kind))
    part: GridInfo | PointsInfo | SticksInfo
    if kind is Kind.STICKS:
        part = _sticks_info(path)
    elif kind is Kind.TABLE:
        part = _points_info(read_points(path))
    else:
        grid, values = read_grid(path, kind)
        vertices = grid_surface(path.stem, grid, values).vertices
        part = GridInfo(grid, int(values.size - len(vertices)), _extents(vertices))
    return FileInfo(path, kind, (part,), (_NOT_STATED,), stated_units(path, kind))


def surface_info(surface: Surface) -> SurfaceInfo:
    """Return counts, extents, orientation and topology of a surface, the latter two of its fit triangles."""
    inside = ((surface.triangles >= 0) & (surface.triangles < len(surface.vertices))).all(axis=1)
    triangles = surface.triangles[inside]
    triangles = ints(triangles[np.isfinite(surface.vertices[triangles]).all(axis=(1, 2))], -1, 3)
    extents = _extents(surface.vertices)
    # A shifted copy: large coordinates would cost digits of the areas.
    vertices = floats(np.nan_to_num(surface.vertices - (extents.low or (0.0, 0.0, 0.0))))
    areas = triangle_areas(vertices, triangles)
    solid = ints(triangles[areas > 0], -1, 3)
    mean = least = greatest = strike = towards = None
    if len(solid):
        dips = triangle_dips(vertices, solid)
        mean, least, greatest = float(np.average(dips, weights=areas[areas > 0])), dips.min(), dips.max()
        strike = _strike(vertices, solid)
        down = mean_dip_direction(vertices, solid)[0]
        towards = float(np.degrees(np.arctan2(down[0], down[1]))) % 360.0
    return SurfaceInfo(
        surface.name,
        len(surface.vertices),
        len(surface.triangles),
        len(surface.triangles) - len(triangles),
        extents,
        mean,
        None if least is None else float(least),
        None if greatest is None else float(greatest),
        strike,
        len(boundary_loops(triangles)),
        int(strong_components(triangles).max(initial=-1)) + 1,
        towards,
    )


def _strike(vertices: FloatArray, triangles: IntArray) -> float:
    """Return the area-weighted mean strike in [0, 180) degrees, clockwise from the y-axis.

    The main axis of the horizontal parts of the normals points across it; unlike their sum it does not
    cancel where a fault passes through the vertical.
    """
    across = triangle_normals(vertices, triangles)[:, :2]
    axis = np.linalg.eigh(across.T @ across)[1][:, -1]
    return float(np.degrees(np.arctan2(axis[0], axis[1])) - 90.0) % 180.0


def _extents(points: FloatArray) -> Extents:
    finite = points[np.isfinite(points).all(axis=1)]
    if len(finite) == 0:
        return Extents(None, None)
    (x, y, z), (u, v, w) = (finite.min(axis=0) + 0.0).tolist(), (finite.max(axis=0) + 0.0).tolist()
    return Extents((x, y, z), (u, v, w))


def _points_info(points: FloatArray) -> PointsInfo:
    from scipy.spatial import KDTree

    finite = floats(points[np.isfinite(points).all(axis=1)], -1, 3)
    spacing = 0.0
    if len(finite) > 1:
        spacing = float(np.median(KDTree(finite[:, :2]).query(finite[:, :2], k=2)[0][:, 1]))
    return PointsInfo(len(points), len(points) - len(finite), _extents(points), spacing, points_step(finite))


def _sticks_info(path: Path) -> SticksInfo:
    sticks = read_sticks(path)
    counts = [len(stick) for stick in sticks]
    surface = surface_info(sticks_surface(path.stem, sticks))
    return SticksInfo(len(sticks), sum(counts), min(counts), max(counts), surface)
