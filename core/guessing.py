"""What surfaces some files hold, and whether each is a horizon or a fault: guesses, with their reasons."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from graben.arrays import FloatArray, floats
from graben.errors import InputError
from graben.formats.grids import read_grid
from graben.formats.kinds import GRIDS, MESHES, SURFACES, Kind, kind_of
from graben.formats.meshes import read_surfaces
from graben.formats.points import read_points
from graben.formats.stated import stated_units
from graben.formats.stick_surface import sticks_surface
from graben.formats.sticks import read_sticks
from graben.formats.tsurf import Sign, TSurf
from graben.info import surface_info
from graben.model import UNDEFINED
from graben.nulls import null_marks
from graben.reading import points_step, triangulated_step
from graben.words import listed

Role = Literal["horizon", "fault"]

#: Mean dip, degrees, below which a triangulated surface that does not say what it is counts as a horizon. Of
#: the 146 faults of the tests' real models three are flatter, all called detachments.
FLAT = 20.0
_FAULT_NAME = re.compile(
    r"faults?(?![a-z])|(?<![a-z])flt|thrust|detachment|d[eé]collement|shear", re.IGNORECASE
)
_HORIZON_NAME = re.compile(r"horizon|(?<![a-z])(?:top|base)(?![a-z])", re.IGNORECASE)


@dataclass(frozen=True)
class Guess:
    """One surface of a file.

    Parameters
    ----------
    role : "horizon" or "fault"
        What it is taken for.
    name : str
        The name that the file gives it (``named``), else that of the file.
    file : Path
        The file, and ``count``, how many surfaces it holds.
    reason : str
        Why it is taken for that, as half a sentence.
    z : "elevation", "depth" or None
        How the file says that it counts z.
    extent : (float, float) or None
        Least and greatest z: elevations where ``z`` is stated, else as they stand.
    step : float or None
        Of a horizon: the step that points get by default, or that of the grid or surface; model units.
    points : bool
        Whether it is points, which may be given another step.
    units : tuple of str
        Which of "m" and "ft" the file states.
    """

    role: Role
    name: str
    file: Path
    reason: str
    z: Sign | None = None
    extent: tuple[float, float] | None = None
    count: int = 1
    named: bool = True
    step: float | None = None
    points: bool = False
    units: tuple[str, ...] = ()


@dataclass(frozen=True)
class Guesses:
    """The surfaces of some files, what was left out and why, and the sign of z in files that state none.

    ``unit`` is the one that files state, ``why_unit`` which do, or why there is none.
    """

    surfaces: tuple[Guess, ...]
    left_out: tuple[tuple[str, str], ...]
    z: Sign
    why_z: str
    unit: str | None = None
    why_unit: str = ""

    def of(self, role: Role) -> tuple[Guess, ...]:
        """Return the surfaces of one role, in their order."""
        return tuple(g for g in self.surfaces if g.role == role)


def guesses(paths: Sequence[Path], *, beside: Path | None = None) -> Guesses:
    """Return what files hold, in their order; those of a folder in that of their names.

    Parameters
    ----------
    paths : sequence of Path
        Files and folders. Folders inside folders are not entered; hidden files and .toml are passed over.
    beside : Path, optional
        The file that is to be written, which is passed over too.

    Raises
    ------
    InputError
        When a file that is named cannot be read, or no file holds a surface. Files of a folder that cannot be
        read are left out.
    """
    found: list[Guess] = []
    left: list[tuple[str, str]] = []
    for path, named in _files(paths, beside):
        try:
            found += _surfaces(path)
        except InputError as error:
            if named:
                raise
            left.append((str(path), str(error).removeprefix(f"{path}").lstrip(":, ").rstrip(".")))
    found = _told_apart(found, left)
    if not found:
        what = f"; {left[0][0]}: {left[0][1]}" if left else ""
        raise InputError(
            f"no file holds a surface{what}; give grids, points, triangulated surfaces or sticks."
        )
    return Guesses(tuple(_odd_told(found)), tuple(left), *_sign(found), *_unit(found))


def _files(paths: Sequence[Path], beside: Path | None) -> Iterator[tuple[Path, bool]]:
    """Yield each file once, with whether it was named itself."""
    seen = {beside.resolve()} if beside else set()
    for path in paths:
        if not path.is_dir():
            inside = [path]
        else:
            try:
                inside = sorted(p for p in path.iterdir() if p.is_file() and p.name[0] != ".")
            except OSError as error:
                raise InputError(
                    f"{path} cannot be looked into ({error.strerror}); give its files."
                ) from None
            inside = [p for p in inside if p.suffix.lower() != ".toml"]
        for file in inside:
            if file.resolve() not in seen:
                seen.add(file.resolve())
                yield file, file == path


def _surfaces(path: Path) -> list[Guess]:
    if path.suffix.lower() == ".toml":
        raise InputError(f"{path} is a model already; give the files of surfaces.")
    kind = kind_of(path)
    return [replace(guess, units=stated_units(path, kind)) for guess in _of_kind(path, kind)]


def _of_kind(path: Path, kind: Kind) -> list[Guess]:
    if kind in SURFACES:
        objects = read_surfaces(path, kind)
        return [replace(_of_surface(o, path, kind), count=len(objects)) for o in objects]
    if kind in GRIDS:
        grid, values = read_grid(path, kind)
        reason = f"a regular grid of {grid.columns} x {grid.rows} nodes"
        return [Guess("horizon", path.stem, path, reason, None, _range(values.ravel()), step=grid.step)]
    if kind is Kind.TABLE:
        return [_of_table(path)]
    return [_of_sticks(path, "lines of 999 end its sticks")]


def _of_surface(item: TSurf, path: Path, kind: Kind) -> Guess:
    role, reason = _role(item, kind)
    extent = _range(item.surface.vertices[:, 2])
    step = triangulated_step(item.surface) if role == "horizon" else None
    return Guess(role, item.surface.name, path, reason, item.z, extent, named=item.named, step=step)


def _role(item: TSurf, kind: Kind) -> tuple[Role, str]:
    """Return what a triangulated surface is taken for, and why: its file's word, its name, then its dip."""
    dip = surface_info(item.surface).mean_dip
    told = "" if dip is None else f", mean dip {dip:.0f} degrees"
    if kind in MESHES:
        return "fault", f"an {kind}{told}; horizons are not read from these"
    # Files of faults are found that say "top"; none of a horizon says "fault".
    if "fault" in item.role:
        return "fault", f"its file calls it {item.role!r}{told}"
    for role, pattern in (("fault", _FAULT_NAME), ("horizon", _HORIZON_NAME)):
        word = pattern.search(item.surface.name.replace("_", " "))
        if word:
            return ("fault" if role == "fault" else "horizon"), f"its name has the word {word[0]!r}{told}"
    if dip is not None and dip < FLAT:
        return "horizon", f"a flat triangulated surface{told}, less than {FLAT:g}"
    return "fault", f"a steep triangulated surface{told}" if told else "a triangulated surface without area"


def _of_table(path: Path) -> Guess:
    """Return points as a horizon, but as sticks where a column tells which points belong together."""
    points = read_points(path)
    try:
        counts = [len(stick) for stick in read_sticks(path)]
    except InputError:
        counts = []
    # An attribute of points, such as an amplitude, has a value of its own at nearly every point.
    if len(counts) > 1 and min(counts) > 1:
        return _of_sticks(path, "numbers that points have in common tell its sticks")
    marks = null_marks(points[:, 2])
    nulls = ""
    if marks.any():
        nulls = f", {np.count_nonzero(marks)} of them with z = {points[marks, 2][0]:g}, a likely null value"
    told, points = len(points), points[~marks]
    step = points_step(floats(points[(np.abs(points) < UNDEFINED).all(axis=1)]))
    if step == 0.0:
        raise InputError(
            f"{path} holds fewer than three points, or all in one line in plan; give more points."
        )
    reason = f"{told} points without anything that makes them sticks{nulls}"
    return Guess("horizon", path.stem, path, reason, None, _range(points[:, 2]), step=step, points=True)


def _of_sticks(path: Path, how: str) -> Guess:
    sticks = read_sticks(path)
    try:
        sticks_surface(path.stem, sticks)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    reason = f"{len(sticks)} fault sticks: {how}"
    return Guess("fault", path.stem, path, reason, None, _range(np.concatenate(sticks)[:, 2]))


def _range(z: FloatArray) -> tuple[float, float] | None:
    usable = z[np.abs(z) < UNDEFINED]
    return (float(usable.min()), float(usable.max())) if len(usable) else None


def _told_apart(found: list[Guess], left: list[tuple[str, str]]) -> list[Guess]:
    """Return the surfaces under names that differ; one of several in a file is found by its own alone."""
    own = Counter(g.name for g in found if g.count > 1)
    taken = set(own)
    result = []
    for guess in found:
        name, count = guess.name, 1
        if guess.count > 1 and own[name] > 1:
            left.append((str(guess.file), f"several surfaces are called {name!r}; rename them"))
            continue
        while guess.count == 1 and name in taken:
            count += 1
            name = f"{guess.name} {count}"
        taken.add(name)
        result.append(replace(guess, name=name))
    return result


def _odd_told(found: list[Guess]) -> list[Guess]:
    """Return the surfaces, with a word for those whose z has another sign than most that state none."""
    silent = [g for g in found if g.z is None and g.extent is not None]
    signs = Counter(_side(g.extent) for g in silent)
    most = 1 if signs[1] > signs[-1] else -1
    if not signs[most] > signs[-most] > 0:
        return found
    return [
        replace(
            g,
            reason=f"{g.reason}. Look: its z runs from {g.extent[0]:g} to {g.extent[1]:g}, of the other sign "
            "than in the other files; turn it, or its horizon lies on the other side of zero",
        )
        if g.z is None and g.extent is not None and _side(g.extent) == -most
        else g
        for g in found
    ]


def _side(extent: tuple[float, float] | None) -> int:
    """Return the sign of a range of z; 0 where it has both."""
    if extent is None or extent[0] < 0 < extent[1]:
        return 0
    return 1 if extent[0] + extent[1] > 0 else -1


def _sign(found: list[Guess]) -> tuple[Sign, str]:
    """Return how files that do not say so count z, and why."""
    silent = [g.extent for g in found if g.z is None and g.extent is not None]
    stated = [g.extent for g in found if g.z is not None and g.extent is not None]
    if not silent:
        signs = Counter(g.z for g in found if g.z is not None)
        most: Sign = "depth" if signs["depth"] > signs["elevation"] else "elevation"
        return most, "every file states its own"
    low, high = min(r[0] for r in silent), max(r[1] for r in silent)
    told = f"z runs from {low:g} to {high:g} in files that do not state its sign"
    if stated:
        known = (min(r[0] for r in stated), max(r[1] for r in stated))
        up, down = _gap((low, high), known), _gap((-high, -low), known)
        if up != down:
            return ("elevation" if up < down else "depth"), f"{told}; so they lie next to those that do"
    middle = float(np.median([np.mean(r) for r in silent]))
    return ("depth", f"{told}, mostly positive") if middle > 0 else ("elevation", f"{told}, mostly negative")


def _unit(found: list[Guess]) -> tuple[str | None, str]:
    """Return the unit that files state where they agree, and which do; else none, and why."""
    files = {u: list(dict.fromkeys(g.file.name for g in found if u in g.units)) for u in ("m", "ft")}
    stated = {unit: listed(names) for unit, names in files.items() if names}
    if not stated:
        return None, "the files do not say"
    if len(stated) > 1:
        told = "; ".join(f"{unit} in {names}" for unit, names in stated.items())
        return None, f"the files do not agree, {told}: convert some"
    ((unit, names),) = stated.items()
    return unit, f"stated by {names}"


def _gap(one: tuple[float, float], other: tuple[float, float]) -> float:
    """Return the distance of two ranges, or less than zero: by how much they overlap."""
    return max(one[0], other[0]) - min(one[1], other[1])
