"""What graben reads and writes, measured on a small file of every dialect: the table in docs/formats.md.

`python -m tests.formats.conformance` writes the table into the page anew.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyvista

from graben.arrays import floats
from graben.errors import InputError
from graben.formats.irap import grid_surface, write_irap_ascii, write_irap_binary
from graben.formats.resqml import GriddedHorizon, write_epc
from graben.formats.tsurf_writer import write_tsurf
from graben.formats.vtp import write_vtp
from graben.formats.vtu import write_vtu
from graben.formats.writing import write_model
from graben.model import Fault, GridGeometry, Horizon, Model
from graben.modeling.results import Cutoff
from graben.reading import read_model
from graben.surface import Surface
from tests.formats import dialects, test_meshes, zmap_samples

PAGE = Path(__file__).parents[2] / "docs" / "formats.md"
BEGIN, END = "<!-- measured by tests/formats/conformance.py -->\n", "<!-- end of what was measured -->"
NONE = "–"

#: More digits than 32 bits hold; two triangles.
FAR = Surface("A", test_meshes.FAR[:4], test_meshes.FACES)
ROTATED = GridGeometry(4, 3, 25.0, 50.0, (465_000.5, 5_932_000.25), 30.0)
POINTS = np.column_stack(
    [*(k.ravel() * 100.125 for k in np.meshgrid(np.arange(5), np.arange(4))), -np.arange(20) / 3]
)
STICKS = np.array([[[0, 0, -1], [0, 5, -9]], [[9, 0, -1], [9, 5, -9]]]) / 3


@dataclass(frozen=True)
class Sample:
    """A file, and the places that it holds: corners (m, 3, 3) of a surface, or points (n, 3).

    ``put`` writes the file; ``written`` says that graben's own writer does, ``back`` how it is read where
    graben does not read it.
    """

    format: str
    dialect: str
    put: Callable[[Path], object]
    places: np.ndarray
    suffix: str = ""
    properties: bool = False
    undefined: bool = False
    written: bool = False
    back: Callable[[Path], np.ndarray] | None = None


@dataclass(frozen=True)
class Row:
    """A row of the table, measured; rows that differ in the dialect alone are joined."""

    format: str
    dialect: str
    read_as: str
    numbers: str
    written: str
    names: str
    properties: str
    z: str
    undefined: str


HEAD = Row(
    "format",
    "dialects",
    "read as",
    "numbers",
    "written",
    "names",
    "properties",
    "sign of z",
    "undefined nodes",
)


def corners(surface: Surface) -> np.ndarray:
    return surface.vertices[surface.triangles]


def ordered(places: np.ndarray) -> np.ndarray:
    """The same places in one order: triangles may begin at any corner, sticks and points may be mixed."""
    if places.ndim == 3:
        first = [min(range(3), key=lambda k, t=t: tuple(t[k])) for t in places.tolist()]
        places = np.array([np.roll(t, -k, axis=0) for t, k in zip(places, first, strict=True)])
    rows = places.reshape(len(places), -1)
    return rows[np.lexsort(rows.T[::-1])]


def digits(found: np.ndarray, wanted: np.ndarray) -> str:
    """How well places agree: exact, 32 bits, or not at all."""
    if found.shape != wanted.shape:
        return NONE
    if np.array_equal(ordered(found), ordered(wanted)):
        return "exact"
    # The origin of a grid and the place in it may both be off by half a last digit.
    spacing = np.spacing(np.abs(wanted).max(axis=(0, 1)).astype(np.float32))
    return "32 bits" if (np.abs(found - wanted) <= spacing).all() else NONE


def samples() -> Iterator[Sample]:
    """Every dialect, in the order of the table."""
    yield from tsurfs()
    yield from grids()
    yield from tables()
    yield from meshes()


def text(content: str | bytes) -> Callable[[Path], object]:
    return lambda path: path.write_bytes(content.encode() if isinstance(content, str) else content)


def tsurfs() -> Iterator[Sample]:
    tiny = np.array([[[0, 0, 1], [1, 0, 2], [0, 1, 3]], [[1, 0, 2], [1, 1, 4], [0, 1, 3]]], dtype=float)
    for dialect, content in dialects.SAME.items():
        yield Sample("GOCAD TSurf", dialect, text(content), tiny, properties="PVRTX" in content)
    other = Surface("B", FAR.vertices + 9, FAR.triangles)
    values = {"u": np.arange(4)}
    own = Sample("GOCAD TSurf", "", lambda path: None, corners(FAR), written=True)
    yield replace(own, dialect="several surfaces", put=lambda path: write_tsurf(path, [other, FAR]))
    yield replace(own, dialect="ZPOSITIVE Elevation", put=lambda path: write_tsurf(path, [FAR]))
    yield replace(own, dialect="ZPOSITIVE Depth", put=lambda path: write_tsurf(path, [FAR], z="depth"))
    yield replace(
        own,
        dialect="point values (PVRTX)",
        properties=True,
        put=lambda path: write_tsurf(path, [FAR], properties=values),
    )


def grids() -> Iterator[Sample]:
    values = zmap_samples.VALUES
    hands = {
        "along the axes": replace(ROTATED, rotation=0.0),
        "rotated": ROTATED,
        "flipped (negative step in y)": replace(ROTATED, dy=-50.0),
        "negative step in x": replace(ROTATED, dx=-25.0),
    }
    for form, write in (("ASCII", write_irap_ascii), ("binary", write_irap_binary)):
        for dialect, grid in hands.items():
            # a grid that counts backwards has its diagonals where the same grid counted forwards has them
            forward = replace(grid, dx=abs(grid.dx), dy=abs(grid.dy), origin=begin(grid))
            u = values[:: 1 if grid.dx > 0 else -1, :: 1 if grid.dy > 0 else -1]
            places = corners(grid_surface("A", forward, floats(u)))
            yield Sample(
                f"Irap classic {form}",
                dialect,
                lambda path, write=write, grid=grid: write(path, grid, values),
                places,
                undefined=True,
                written=grid.dx > 0 and grid.dy > 0,
            )
    places = corners(grid_surface("A", zmap_samples.GRID, values))
    for dialect, content in zmap_samples.SAME.items():
        yield Sample("ZMAP+", dialect, text(content), places, undefined=True)


def begin(grid: GridGeometry) -> tuple[float, float]:
    """The first node once a grid counts forwards."""
    x, y = grid.nodes()[0 if grid.dx > 0 else -1, 0 if grid.dy > 0 else -1].tolist()
    return x, y


def tables() -> Iterator[Sample]:
    def lines(rows: Iterable[Iterable[float]], mark: str, head: str = "") -> str:
        return head + "".join(mark.join(map(repr, row)) + "\n" for row in rows)

    rows = POINTS.tolist()
    points = Sample("points", "", lambda path: None, POINTS)
    yield replace(points, dialect="CSV with `,`", put=own_points, written=True)
    yield replace(points, dialect="CSV with `;`", put=text(lines(rows, ";", "x;y;z\n")))
    yield replace(
        points,
        dialect="more columns, other order",
        put=text(lines(([1.5, z, y, x] for x, y, z in rows), ",", '"amp","Z","Y","X"\n')),
        properties=True,
    )
    yield replace(points, dialect="bare columns", put=text("# picks\n" + lines(rows, "\t")))
    numbered = [[*p, float(k)] for k, stick in enumerate(STICKS.tolist()) for p in stick]
    ended = "".join(lines(stick, " ") + "999 999 999\n" for stick in STICKS.tolist())
    sticks = Sample("fault sticks", "", lambda path: None, STICKS.reshape(-1, 3))
    yield replace(sticks, dialect="ended by 999s (RMS)", put=text(ended))
    yield replace(sticks, dialect="a column `stick`", put=text(lines(numbered, ",", "X,Y,Z,stick\n")))
    yield replace(sticks, dialect="a fourth column", put=text(lines(numbered, " ")))


def own_points(path: Path) -> None:
    """Points as graben writes them with a model."""
    surface = Surface("A", POINTS, [[0, 1, 2]])
    model = Model("M", horizons=(Horizon("A", surface, 100.0, None, floats(POINTS)),))
    with tempfile.TemporaryDirectory() as folder:
        write_model(model, Path(folder))
        path.write_bytes((Path(folder) / "A.csv").read_bytes())


def meshes() -> Iterator[Sample]:
    for key, content in test_meshes.SAME.items():
        form, _, dialect = key.partition(", ")
        dialect = dialect or "plain"
        values = any(word in dialect for word in ("textures", "colours", "normals"))
        yield Sample(form.upper(), dialect, text(content), corners(FAR), properties=values)
    yield Sample(
        "OBJ", "objects (o)", text(test_meshes.V + "o A\nf 1 2 3\nf 1 3 4\no B\nf 1 2 4\n"), corners(FAR)
    )
    yield Sample("OBJ", "groups (g)", text(test_meshes.V + "g A\n" + test_meshes.TWO), corners(FAR))
    solid = test_meshes.solid("A", FAR.vertices, test_meshes.FACES)
    other = test_meshes.solid("B", FAR.vertices + 9, test_meshes.FACES)
    yield Sample("STL", "ASCII, several solids", text(solid + other), corners(FAR))
    yield Sample(
        "STL",
        "binary",
        lambda path: test_meshes.fault_files(path.parent, FAR)["stl"].rename(path),
        corners(FAR),
    )
    yield Sample("VTP", "binary", lambda path: write_vtp(path, FAR), corners(FAR), ".vtp", written=True)
    yield Sample(
        "VTP",
        "point values",
        lambda path: write_vtp(path, FAR, arrays={"u": np.arange(4)}),
        corners(FAR),
        ".vtp",
        properties=True,
        written=True,
    )
    yield Sample("VTP", "ASCII", lambda path: FAR.to_pyvista().save(path, binary=False), corners(FAR), ".vtp")
    yield Sample(
        "VTU",
        "several surfaces in one file",
        lambda path: write_vtu(path, [Surface("B", FAR.vertices + 9, FAR.triangles), FAR]),
        corners(FAR),
        ".vtu",
        written=True,
        back=vtu_corners,
    )
    package = Sample("RESQML", "", own_package, corners(FAR), ".epc", written=True, back=epc_corners)
    yield replace(package, dialect="triangulated sets")
    yield replace(package, dialect="sets of lines", places=FAR.vertices, back=epc_lines)


def own_package(path: Path) -> None:
    """A package with FAR as a fault and its vertices as a cutoff line, in a local frame."""
    other = Surface("B", FAR.vertices + 9, FAR.triangles)
    lips = Cutoff("A", range(4), FAR.vertices, FAR.vertices, range(4), range(4))
    write_epc(path, [GriddedHorizon(other, cutoffs=[lips])], [FAR], origin=floats(FAR.vertices[0]))


def epc_corners(path: Path) -> np.ndarray:
    from resqpy.model import Model as Package
    from resqpy.surface import Surface as TriangulatedSet

    package = Package(str(path))
    uuid = package.uuid(obj_type="TriangulatedSetRepresentation", title="A")
    triangles, points = TriangulatedSet(package, uuid=uuid).triangles_and_points()
    return np.asarray(upward(package, points)[triangles])


def epc_lines(path: Path) -> np.ndarray:
    from resqpy.lines import PolylineSet
    from resqpy.model import Model as Package

    package = Package(str(path))
    uuid = package.uuids(obj_type="PolylineSetRepresentation")[0]
    return upward(package, PolylineSet(package, uuid=uuid).polys[0].coordinates)


def upward(package: Any, points: np.ndarray) -> np.ndarray:
    """Places in the coordinates of the model, elevations."""
    from resqpy.crs import Crs

    found = points.copy()
    crs = Crs(package, uuid=package.uuid(obj_type="LocalDepth3dCrs"))
    crs.local_to_global_array(found, global_z_inc_down=False)
    return found


def vtu_corners(path: Path) -> np.ndarray:
    mesh = pyvista.read(path)
    kept = mesh.cell_data["surface"] == list(mesh.field_data["names"]).index("A")
    return np.asarray(mesh.points)[mesh.cells.reshape(-1, 4)[kept][:, 1:]]


def measured(sample: Sample, folder: Path) -> Row:
    """Write a sample, read it in every way there is, and say what came of it."""
    path = folder / f"file{sample.suffix}"
    sample.put(path)
    as_horizon, as_fault = (found(path, kind, "A", "elevation") for kind in ("horizons", "faults"))
    read = {kind: item for kind, item in (("horizon", as_horizon), ("fault", as_fault)) if item is not None}
    numbers = {kind: digits(held(item, sample.places), sample.places) for kind, item in read.items()}
    (how,) = set(numbers.values()) or {NONE}
    own = found(path, "faults", None, "elevation")
    written = NONE
    if sample.written:
        written = how if sample.back is None else digits(sample.back(path), sample.places)
    return Row(
        sample.format,
        sample.dialect,
        ", ".join(read) or NONE,
        how,
        written,
        "kept" if own is not None and own.surface.name == "A" else NONE,
        ("written, " if sample.written else "") + "not read" if sample.properties else NONE,
        sign(path, read),
        "stay undefined" if sample.undefined and how != NONE else NONE,
    )


def found(path: Path, kind: str, name: str | None, z: str) -> Horizon | Fault | None:
    """The horizon or fault that a file gives; None where it is refused."""
    keys = f'[[{kind}]]\nfile = "{path.name}"\n' + (f'name = "{name}"\n' if name else "")
    (path.parent / "model.toml").write_text(f'[model]\nname = "M"\nz = "{z}"\n{keys}', encoding="utf-8")
    try:
        model = read_model(path.parent / "model.toml")
    except InputError:
        return None
    wanted = [item for item in (*model.horizons, *model.faults) if item.surface.name == "A"]
    return wanted[0] if wanted else (*model.horizons, *model.faults)[0]


def held(item: Horizon | Fault, places: np.ndarray) -> np.ndarray:
    """What a horizon or fault has of the kind of places."""
    if places.ndim == 3:
        return corners(item.surface)
    if isinstance(item, Horizon):
        return np.asarray(item.picks)
    # a surface through sticks has nodes between the picks too
    there = (item.surface.vertices[:, None] == places).all(axis=2).any(axis=1)
    return np.asarray(item.surface.vertices[there])


def sign(path: Path, read: dict[str, Horizon | Fault]) -> str:
    """Whether the file states the sign of z: then that of model.toml changes nothing."""
    if not read:
        return NONE
    kind, up = next(iter(read.items()))
    down = found(path, f"{kind}s", "A", "depth")
    assert down is not None
    return "stated" if np.array_equal(up.surface.vertices, down.surface.vertices) else "model.toml"


def rows() -> list[Row]:
    """The table, with dialects that do not differ in anything else in one row."""
    joined: dict[Row, list[str]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for k, sample in enumerate(samples()):
            place = Path(folder) / str(k)
            place.mkdir()
            row = measured(sample, place)
            joined.setdefault(replace(row, dialect=""), []).append(row.dialect)
    formats = list(dict.fromkeys(row.format for row in joined))
    found_rows = [replace(row, dialect="; ".join(names)) for row, names in joined.items()]
    return sorted(found_rows, key=lambda row: formats.index(row.format))


def table(found_rows: list[Row]) -> str:
    lines = [" | ".join(vars(row).values()) for row in (HEAD, *found_rows)]
    lines.insert(1, "|".join(["---"] * len(vars(HEAD))))
    return "".join(f"| {line} |\n" if "---" not in line else f"|{line}|\n" for line in lines)


def filled(page: str, content: str) -> str:
    pattern = re.escape(BEGIN) + ".*?" + re.escape(END)
    return re.sub(pattern, lambda _: BEGIN + content + END, page, flags=re.DOTALL)


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), table(rows())), encoding="utf-8")
