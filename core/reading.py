"""A model read from its model.toml and the files it names."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.cleaning.registry import known_repairs
from graben.errors import InputError, ModelingError
from graben.formats.grids import read_grid
from graben.formats.irap import grid_surface
from graben.formats.kinds import GRIDS, MESHES, SURFACES, Kind, kind_of
from graben.formats.meshes import read_surfaces
from graben.formats.model_file import load_model_file
from graben.formats.points import read_table
from graben.formats.stick_surface import sticks_surface
from graben.formats.sticks import read_sticks
from graben.formats.tsurf import Sign, TSurf, mirrored
from graben.model import UNFIT, Fault, GridGeometry, Horizon, Model
from graben.nulls import null_marks
from graben.settings import FaultSection, HorizonSection, ModelFile
from graben.stating import statements
from graben.surface import Surface, triangle_areas
from graben.validators.finite import usable

#: Nodes of the grid on which results of a horizon from points are written; a step that gives more is a slip.
MOST_NODES = 100_000_000
#: Nodes of a surface fitted to points: more need more than 4 GB, and points were never that dense.
MOST_FITTED = 4_000_000


def read_model(path: str | Path) -> Model:
    """Read a model: its model.toml and every file that names.

    Parameters
    ----------
    path : str or Path
        The model.toml.

    Returns
    -------
    Model
        Coordinates as in the files, z as elevation. Data that can be read but are unfit stay as they are.

    Raises
    ------
    InputError
        When something cannot be read; one sentence that names file, key or line and the mend.
    """
    path = Path(path)
    if path.is_dir():
        raise InputError(f"{path} is a folder; give the model.toml in it.")
    settings = load_model_file(path)
    if not settings.horizons and not settings.faults:
        raise InputError(f"{path} names no horizon and no fault; add [[horizons]] or [[faults]].")
    if settings.checks:
        from graben.validators.registry import known_ids

        _reject_unknown(path, "checks", settings.checks, known_ids())
    _reject_unknown(path, "repair", settings.repair.skip, known_repairs())
    z = settings.model.z
    # Names are compared before any file is read, since fitting points takes time; those that fault files
    # give come after.
    names = [s.name for s in settings.horizons]
    _reject_repeated(path, names + [s.name for s in settings.faults if s.name is not None])
    faults = tuple(f for s in settings.faults for f in _faults(s, path, z))
    _reject_repeated(path, names + [f.name for f in faults])
    _reject_unknown_contacts(path, settings, {f.name for f in faults})
    truth = settings.model.truth
    horizons = tuple(_horizon(s, path, z) for s in settings.horizons)
    return Model(
        name=settings.model.name,
        horizons=horizons,
        faults=faults,
        z=z,
        unit=settings.model.unit,
        crs=settings.model.crs,
        truth=None if truth is None else _located(path, truth, "truth", folder=True),
        parameters=settings.parameters,
        repair=settings.repair,
        contacts=settings.contacts,
        checks=MappingProxyType(dict(settings.checks)),
        file=path,
        statements=statements([*(h.surface for h in horizons), *(f.surface for f in faults)]),
        left_out=frozenset(type(settings.model).model_fields) - settings.model.model_fields_set,
    )


def triangulated_step(surface: Surface) -> float:
    """Return the step of a triangulated surface, sqrt(4 A / (sqrt(3) n)), model units.

    A is the area in plan of its n fit triangles (in space where the plan area is zero), so that equilateral
    triangles give the length of their sides. Without any area: the size of the surface, or 1.
    """
    fit = ((surface.triangles >= 0) & (surface.triangles < len(surface.vertices))).all(axis=1)
    triangles = surface.triangles[fit]
    fit_vertices = bools(usable(surface.vertices).all(axis=1))
    triangles = ints(triangles[fit_vertices[triangles].all(axis=1)], -1, 3)
    solid = floats(np.where(fit_vertices[:, None], surface.vertices, 0.0))
    for vertices in (floats(solid * np.array([1.0, 1.0, 0.0])), solid):
        area = float(triangle_areas(vertices, triangles).sum())
        if area > 0:
            return float(np.sqrt(4.0 * area / (np.sqrt(3.0) * len(triangles))))
    finite = surface.vertices[fit_vertices]
    return float(np.linalg.norm(np.ptp(finite, axis=0))) if len(finite) > 1 else 1.0


def points_step(picks: FloatArray) -> float:
    """Return the default step for points, 2 sqrt(area / n), model units; 0 when they have no area in plan.

    The area is that of the convex hull in plan; ``picks`` has shape (n, 3) and is finite.
    """
    from shapely import MultiPoint

    if len(picks) < 3:
        return 0.0
    middle = picks[:, :2].mean(axis=0)
    return float(2.0 * np.sqrt(MultiPoint(picks[:, :2] - middle).convex_hull.area / len(picks)))


def covering_grid(points: FloatArray, step: float) -> GridGeometry | None:
    """Return the axis-aligned grid of a step that covers points, shape (n, >= 2); None above MOST_NODES."""
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    counts = np.ceil((high - low) / step) + 1
    if not counts.prod() <= MOST_NODES:
        return None
    return GridGeometry(int(counts[0]), int(counts[1]), step, step, (float(low[0]), float(low[1])))


def _horizon(section: HorizonSection, path: Path, z: Sign) -> Horizon:
    file = _located(path, section.file, f"horizon {section.name!r}")
    kind = kind_of(file)
    if kind in MESHES:
        raise InputError(
            f"{file} is read for faults alone ({kind}); give horizon {section.name!r} a grid, a GOCAD TSurf "
            "or points."
        )
    if kind is Kind.STICKS:
        raise InputError(
            f"{file} holds fault sticks, which make no horizon; give horizon {section.name!r} a grid, a "
            "triangulated surface or points."
        )
    if kind is Kind.TSURF:
        surface = _chosen(read_surfaces(file, kind), section.name, file).upward(z)
        step = section.step or triangulated_step(surface)
        finite = surface.vertices[usable(surface.vertices).all(axis=1)]
        grid = covering_grid(floats(finite), step) if len(finite) else None
        return Horizon(section.name, _named(surface, section.name), step, grid, noise=section.noise)
    if kind is Kind.TABLE:
        return _horizon_of_points(section, file, z)
    if section.step is not None:
        raise InputError(
            f"{path}: step = {section.step:g} of horizon {section.name!r} is for points, but {file} is a "
            "grid and keeps its own; take the key step out."
        )
    return _horizon_of_grid(section, file, kind, z)


def _horizon_of_grid(section: HorizonSection, file: Path, kind: Kind, z: Sign) -> Horizon:
    grid, values = read_grid(file, kind)
    marks = null_marks(values)
    mark = f"{np.count_nonzero(marks)} grid nodes of {values[marks][0]:g}" if marks.any() else ""
    values = floats(np.where(marks, np.nan, values))
    surface = grid_surface(section.name, grid, values if z == "elevation" else floats(-values))
    surface = replace(surface, file=file)
    if len(surface.triangles) == 0:
        raise InputError(f"{file} has no cell with three defined nodes; export the grid again.")
    undefined = values.size - len(surface.vertices)
    notes = [f"{undefined} of {values.size} grid nodes are undefined."] if undefined else []
    if mark:
        notes.append(f"{mark} are taken as undefined: likely a null value of the program that wrote them.")
    return Horizon(section.name, surface, grid.step, grid, noise=section.noise, notes=tuple(notes))


def _horizon_of_points(section: HorizonSection, file: Path, z: Sign) -> Horizon:
    table, lines = read_table(file, ("x", "y", "z"))
    marks = null_marks(table[:, 2])
    first_mark = float(table[marks, 2][0]) if marks.any() else None
    table = floats(np.column_stack([table[:, :2], np.where(marks, np.nan, table[:, 2])]))
    picks = table if z == "elevation" else mirrored(table)
    finite = usable(picks).all(axis=1)
    default = points_step(floats(picks[finite]))
    if default == 0.0:
        raise InputError(
            f"{file} holds fewer than three points, or all in one line in plan; give more points."
        )
    step = section.step or default
    grid = covering_grid(floats(picks[finite]), step)
    # the default step is that of four points to a node
    nodes = np.count_nonzero(finite) / 4.0 * (default / step) ** 2
    if grid is None or nodes > MOST_FITTED:
        most = f"{MOST_NODES} grid nodes" if grid is None else f"{MOST_FITTED} nodes"
        raise InputError(
            f"{file}: a step of {step:g} gives horizon {section.name!r} more than {most}; set a larger step."
        )
    smoothing = 0.0
    if not finite.all():
        surface = _unfit_surface(section.name, picks)
        note = _unfit_note(file, lines, bools(finite), first_mark)
    else:
        from graben.modeling.fitting import fit_points

        try:
            fitted = fit_points(picks, step, section.noise or 0.0, section.name)
        except ModelingError as error:
            raise InputError(f"{file}: {error}") from error
        surface, note = Surface(section.name, fitted.vertices, fitted.triangles), fitted.note
        smoothing = fitted.smoothing
    surface = replace(surface, file=file)
    return Horizon(
        section.name, surface, step, grid, picks, section.noise, smoothing, (note,) if note else ()
    )


def _unfit_note(file: Path, lines: IntArray, finite: BoolArray, mark: float | None) -> str:
    """Return which points are no places, and which number is likely a mark for undefined."""
    said = f"{file.name}: {np.count_nonzero(~finite)} {UNFIT}, the first in line {lines[~finite][0]}"
    if mark is None:
        return f"{said}."
    return f"{said}; z = {mark:g} is likely a null value of the program that wrote it: take these lines out."


def _unfit_surface(name: str, picks: FloatArray) -> Surface:
    """Return the Delaunay surface of the fit picks, with the others as loose vertices for the checks."""
    from scipy.spatial import Delaunay

    finite = usable(picks).all(axis=1)
    places = picks[finite, :2] - picks[finite, :2].mean(axis=0)
    return Surface(name, np.concatenate([picks[finite], picks[~finite]]), ints(Delaunay(places).simplices))


def _faults(section: FaultSection, path: Path, z: Sign) -> Iterator[Fault]:
    """Yield the faults of one [[faults]]: all that a file names, or the one with the name given."""
    file = _located(path, section.file, f"fault {section.name!r}" if section.name else "a fault")
    kind = kind_of(file)
    if kind in GRIDS:
        raise InputError(
            f"{file} is a grid, which makes no fault; give a triangulated surface or fault sticks."
        )
    if kind in SURFACES:
        objects = read_surfaces(file, kind)
        if section.name is None:
            unnamed = next((o for o in objects if not o.named), None)
            if unnamed is not None:
                raise InputError(
                    f"{file} holds a surface without a name; give its [[faults]] in {path} a name."
                )
            yield from (Fault(o.upward(z), section.gamma) for o in objects)
        else:
            surface = _chosen(objects, section.name, file).upward(z)
            yield Fault(_named(surface, section.name), section.gamma)
        return
    if section.name is None:
        raise InputError(
            f"{file} does not name its fault; give the [[faults]] with this file a name in {path}."
        )
    sticks = read_sticks(file)
    if z == "depth":
        sticks = [mirrored(stick) for stick in sticks]
    try:
        yield Fault(replace(sticks_surface(section.name, sticks), file=file), section.gamma)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None


def _chosen(objects: list[TSurf], name: str, file: Path) -> TSurf:
    """Return the only surface of a file, or the one of that name."""
    if len(objects) == 1:
        return objects[0]
    same = [o for o in objects if o.surface.name == name]
    if len(same) == 1:
        return same[0]
    names = ", ".join(repr(o.surface.name) for o in objects)
    raise InputError(
        f"{file} holds {len(objects)} surfaces ({names}), and none is called {name!r}; give the name of "
        "one of them, or leave the name of a fault out to take all."
    )


def _named(surface: Surface, name: str) -> Surface:
    return replace(surface, name=name)


def _located(path: Path, file: str, what: str, folder: bool = False) -> Path:
    """Return the path of a file that model.toml names; relative ones must stay in the model's folder."""
    if "\0" in file:
        raise InputError(f"{path}: the file of {what} has a zero byte in its name; correct it.")
    if Path(file).is_absolute():
        found = Path(file)
    else:
        inside = os.path.normpath(file)
        if inside == os.pardir or inside.startswith(os.pardir + os.sep):
            raise InputError(
                f"{path}: the file of {what}, {file!r}, lies outside the model's folder; copy it there or "
                "give its absolute path."
            )
        found = path.parent / inside
    if not os.path.lexists(found) and "\\" in file:
        raise InputError(
            f"{path}: the file of {what}, {file}, does not exist; where backslashes part folders, write /."
        )
    if not os.path.lexists(found):
        raise InputError(f"{path}: the file of {what}, {found}, does not exist; correct the path.")
    if folder and not found.is_dir():
        raise InputError(f"{path}: {what} must name a folder, but {found} is a file; correct the path.")
    return found


def _reject_repeated(path: Path, names: list[str]) -> None:
    twice = next((name for name, count in Counter(names).items() if count > 1), None)
    if twice is not None:
        raise InputError(f"{path}: the name {twice!r} is there twice among horizons and faults; rename one.")


def _reject_unknown(path: Path, section: str, ids: Collection[str], known: Collection[str]) -> None:
    unknown = next((name for name in ids if name not in known), None)
    if unknown is not None:
        raise InputError(f"{path}: unknown id {unknown!r} in [{section}]; known are {', '.join(known)}.")


def _reject_unknown_contacts(path: Path, settings: ModelFile, faults: set[str]) -> None:
    for number, contact in enumerate(settings.contacts, start=1):
        for name in contact.faults:
            if name not in faults:
                raise InputError(
                    f"{path}: [[contacts]] number {number} names {name!r}, which is no fault of the model; "
                    f"faults are {', '.join(sorted(faults)) or 'none'}."
                )
        if contact.faults[0] == contact.faults[1]:
            raise InputError(
                f"{path}: [[contacts]] number {number} names {contact.faults[0]!r} twice; name two faults."
            )
