"""The objects of a RESQML package, made by resqpy; identifiers and dates follow from the input alone."""

from __future__ import annotations

import hashlib
import re
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from uuid import NAMESPACE_URL, UUID, uuid5

import numpy as np
from numpy.typing import NDArray

from graben.arrays import FloatArray
from graben.formats.tsurf import Sign
from graben.formats.tsurf_writer import in_convention
from graben.model import GridGeometry
from graben.surface import Surface

#: Who made the objects; resqpy by itself names the user of the machine.
_ORIGINATOR = "graben"
#: The date of everything, the earliest that a zip holds, so that the same input gives the same bytes.
_DATE = (1980, 1, 1, 0, 0, 0)
#: Letters that the standard allows in a title; a longer name is kept whole in the metadata, under this key.
_LONGEST = 256
_NAME = "name"
_NAMESPACE = uuid5(NAMESPACE_URL, "urn:graben:resqml")


@dataclass(frozen=True)
class Frame:
    """What the coordinates in a package mean: origin in plan, sign of z, unit, name of the system."""

    origin: tuple[int, int]
    z: Sign
    unit: str
    crs: str | None

    def local(self, points: FloatArray) -> FloatArray:
        """Return points (n, 3) in model coordinates and elevations as the package counts them."""
        return np.asarray(in_convention(points, self.z) - [*self.origin, 0.0], dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Boundary:
    """A surface in the local frame: points (n, 3), triangles (m, 3), and what tells it from others."""

    name: str
    points: FloatArray
    triangles: NDArray[np.int32]
    digest: bytes

    @classmethod
    def of(cls, surface: Surface, frame: Frame) -> Boundary:
        """Return a surface in model coordinates and elevations as a package holds it."""
        points, triangles = frame.local(surface.vertices), surface.triangles.astype(np.int32)
        return cls(surface.name, points, triangles, _digest(repr(frame), points, triangles))


class Package:
    """A package that is being written.

    Parameters
    ----------
    path : Path
        The file, ending in ``.epc``; one that is there is replaced, and so is the ``.h5`` beside it.
    frame : Frame
        What its coordinates mean.
    content : sequence of Boundary
        All surfaces that will be added, for the identifier of the file of arrays.
    """

    def __init__(self, path: Path, frame: Frame, content: Sequence[Boundary]) -> None:
        from resqpy.model import Model

        self._path, self._arrays = str(path.absolute()), str(path.absolute().with_suffix(".h5"))
        self._frame = frame
        arrays = _digest(repr(frame), *(part for b in content for part in (b.name, b.digest)))
        self._model = Model(self._path, new_epc=True, create_basics=False, create_hdf5_ext=False)
        self._model.create_root()
        self._model.create_rels_part()
        self._model.create_doc_props(originator=_ORIGINATOR)
        self._model.create_hdf5_ext(
            file_name=self._arrays, uuid=_identifier("arrays", "", arrays), originator=_ORIGINATOR
        )
        self._crs = self._add_crs()

    def add_fault(self, boundary: Boundary) -> None:
        """Add a fault: feature, interpretation and triangles."""
        from resqpy.organize import FaultInterpretation, TectonicBoundaryFeature

        if len(boundary.triangles) == 0:
            return
        feature = TectonicBoundaryFeature(self._model, kind="fault")
        self._add(feature, boundary.name, boundary.digest, reuse=False)
        # The standard asks whether a normal fault is listric; of others, and where nobody knows, nothing.
        fault = FaultInterpretation(
            self._model, tectonic_boundary_feature=feature, is_normal=False, is_listric=None
        )
        self._add(fault, boundary.name, boundary.digest, reuse=False)
        self._add_triangles(boundary, fault.root)

    def add_horizon(self, boundary: Boundary) -> Any:
        """Add a horizon: feature, interpretation and triangles; return the interpretation, None without."""
        from resqpy.organize import GeneticBoundaryFeature, HorizonInterpretation

        if len(boundary.triangles) == 0:
            return None
        feature = GeneticBoundaryFeature(self._model, kind="horizon")
        self._add(feature, boundary.name, boundary.digest, reuse=False)
        top = HorizonInterpretation(self._model, genetic_boundary_feature=feature)
        self._add(top, boundary.name, boundary.digest, reuse=False)
        self._add_triangles(boundary, top.root)
        return top.root

    def close(self) -> None:
        """Write the package; its arrays are in their file already."""
        stamp = "{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z".format(*_DATE)
        trees = [
            entry[-1] for entry in (*self._model.parts_forest.values(), *self._model.other_forest.values())
        ]
        for node in (n for tree in trees for n in tree.iter() if isinstance(n.tag, str)):
            if node.tag.endswith(("}Creation", "}created")):
                node.text = stamp
        self._model.store_epc(self._path, quiet=True)
        _set_dates(Path(self._path))

    def _add_triangles(self, boundary: Boundary, root: Any) -> None:
        from resqpy.surface import Surface as TriangulatedSet

        made = TriangulatedSet(self._model, crs_uuid=self._crs)
        made.set_from_triangles_and_points(boundary.triangles, boundary.points)
        made.represented_interpretation_root = root
        self._add_with_arrays(made, boundary.name, root, boundary.digest)

    def add_grid(self, name: str, grid: GridGeometry, values: FloatArray, root: Any) -> None:
        """Add a regular grid, elevations (columns, rows), of the interpretation ``root``."""
        from resqpy.surface import Mesh

        a = np.radians(grid.rotation)
        along, across = np.array([[np.cos(a), np.sin(a), 0.0], [-np.sin(a), np.cos(a), 0.0]])
        heights = np.ascontiguousarray(values.T) * (1.0 if self._frame.z == "elevation" else -1.0)
        made = Mesh(
            self._model,
            ni=grid.columns,
            nj=grid.rows,
            origin=(*np.subtract(grid.origin, self._frame.origin).tolist(), 0.0),
            dxyz_dij=np.stack([grid.dx * along, grid.dy * across]),
            z_values=heights,
            crs_uuid=self._crs,
        )
        made.set_represented_interpretation_root(root)
        self._add_with_arrays(made, name, root, _digest(repr(grid), heights))

    def add_lines(self, name: str, lines: Sequence[FloatArray], root: Any) -> None:
        """Add lines (k, 3) in model coordinates and elevations as one set of the interpretation ``root``."""
        from resqpy.lines import Polyline, PolylineSet

        local = [self._frame.local(line) for line in lines if len(line) > 1]
        if not local:
            return
        kind = {"set_crs": self._crs, "is_closed": False, "title": _title(name)}
        polylines = [Polyline(self._model, set_coord=line, **kind) for line in local]
        made = PolylineSet(self._model, polylines=polylines, crs_uuid=self._crs)
        made.rep_int_root = root
        self._add_with_arrays(made, name, root, _digest(*local))

    def _add_crs(self) -> UUID:
        """Add the coordinate system and return its identifier."""
        from resqpy.crs import Crs

        frame = self._frame
        code = re.fullmatch(r"\s*EPSG:+(\d+)\s*", frame.crs or "", re.IGNORECASE)
        made = Crs(
            self._model,
            x_offset=float(frame.origin[0]),
            y_offset=float(frame.origin[1]),
            xy_units=frame.unit,
            z_units=frame.unit,
            z_inc_down=frame.z == "depth",
            epsg_code=code.group(1) if code else None,
        )
        self._add(made, frame.crs or "local frame", _digest(repr(frame)), reuse=False)
        for node in made.root:
            if node.tag.endswith("}VerticalCrs"):
                _set_unknown(self._model, node, "Vertical", "Unknown")
            elif node.tag.endswith("}ProjectedCrs") and not code:
                _set_unknown(self._model, node, "Projected", _title(frame.crs or "Unknown"))
        identifier: UUID = made.uuid
        return identifier

    def _add_with_arrays(self, made: Any, name: str, root: Any, content: bytes) -> None:
        """Add a representation of the interpretation ``root``."""
        made.uuid = _identifier(made.resqml_type, name, _digest(root.attrib["uuid"], content))
        made.write_hdf5(file_name=self._arrays, mode="a")
        self._add(made, name)

    def _add(self, made: Any, name: str, content: bytes | None = None, **options: Any) -> None:
        """Add an object under its name and, where ``content`` is given, an identifier of its own."""
        if content is not None:
            made.uuid = _identifier(made.resqml_type, name, content)
        made.title = _title(name)
        made.extra_metadata = {} if made.title == name else {_NAME: printable(name)}
        made.create_xml(originator=_ORIGINATOR, **options)


def _set_unknown(model: Any, node: Any, kind: str, text: str) -> None:
    """Say of a parent system what is known of it; resqpy gives the vertical one the code of the other."""
    for key, value in node.attrib.items():
        node.set(key, re.sub(r"\w+$", f"{kind}UnknownCrs", value))
    for child in list(node):
        node.remove(child)
    model.create_unknown(root=node).text = text


def _set_dates(path: Path) -> None:
    """Write a zip anew with fixed dates."""
    with zipfile.ZipFile(path) as old:
        parts = [(name, old.read(name)) for name in old.namelist()]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as new:
        for name, content in parts:
            new.writestr(zipfile.ZipInfo(name, _DATE), content, zipfile.ZIP_DEFLATED)


def printable(name: str) -> str:
    """Return a name without what XML cannot hold and readers strip."""
    return " ".join("".join(c if c.isprintable() else " " for c in name).split())


def _title(name: str) -> str:
    return printable(name)[:_LONGEST].strip() or "untitled"


def _identifier(kind: str, name: str, content: bytes) -> UUID:
    return uuid5(_NAMESPACE, f"{kind} {content.hex()} {printable(name)}")


def _digest(*content: NDArray[Any] | bytes | str) -> bytes:
    made = hashlib.sha256()
    for part in content:
        if isinstance(part, np.ndarray):
            made.update(np.ascontiguousarray(part).data)
        else:
            made.update(part.encode("utf-8", "surrogatepass") if isinstance(part, str) else part)
    return made.digest()
