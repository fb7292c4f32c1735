"""Where a finding lies in the files of a model, as SARIF locations."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.finding import Element, Finding
from graben.proximity import nearest
from graben.reports.check_words import Teller
from graben.surface import Surface

if TYPE_CHECKING:
    from graben.model import Model

#: The base of relative paths, by the name that readers know for the root of what was looked at.
BASE = "%SRCROOT%"
#: What the root of a repository holds: a folder, or a file in a worktree or submodule.
_REPOSITORY = ".git"
#: So many places of a finding are listed beside the first.
MOST_RELATED = 20
#: A line of a file, and the place it stands for.
_Spot = tuple[Surface, int, tuple[float, float, float] | None]


@dataclass(frozen=True)
class Root:
    """The folder that paths are relative to, None where no file is known, and what it is in words."""

    folder: Path | None
    words: str

    @classmethod
    def of(cls, model: Model) -> Root:
        """Return the root for a model: that which readers of SARIF take relative paths from.

        Code hosts take them from the root of the repository whatever the file says of its base, and editors
        from the folder that is open. So it is the root of the repository around model.toml; outside any, the
        working directory where model.toml lies in it, else the folder of model.toml.
        """
        if model.file is None:
            return cls(None, "No file is known.")
        folder = _absolute(model.file).parent
        for above in (folder, *folder.parents):
            if os.path.lexists(above / _REPOSITORY):
                return cls(above, "The root of the repository that holds model.toml.")
        if folder.is_relative_to(Path.cwd()):
            return cls(Path.cwd(), "The working directory of the check.")
        return cls(folder, "The folder of model.toml.")

    def uri(self, file: Path) -> dict[str, str]:
        """Return a file as an artifactLocation: relative to the root where it lies in it, else absolute.

        >>> Root(Path("/data/my model"), "").uri(Path("/data/my model/F 1.ts"))["uri"]
        'F%201.ts'
        """
        path = _absolute(file)
        if self.folder is not None and path.is_relative_to(self.folder):
            inside = path.relative_to(self.folder).as_posix()
            return {"uri": quote(os.fsencode(inside)), "uriBaseId": BASE}
        return {"uri": path.as_uri()}


def _absolute(file: Path) -> Path:
    """Return the path without ".."; Path.absolute keeps these, Path.resolve follows links."""
    return Path(os.path.abspath(file))  # noqa: PTH100


def locations(
    finding: Finding, model: Model, teller: Teller, root: Root
) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return the location of a finding and up to 20 more, with paths from a root.

    The first has the line of the worst triangle; for a finding of vertices, of a triangle that uses the worst
    one; for any other, of the triangle of its first surface with known lines that is nearest to its worst
    place. The others are the other triangles, or those nearest to the other places and on the other surfaces.
    """
    surfaces = {s.name: s for s in model.surfaces}
    objects = [surfaces[name] for name in finding.objects if name in surfaces]
    found = [_own(finding, s) or _near(finding, s) for s in objects if _has_lines(s)]
    spots = [own[0] for own in found if own] + [spot for own in found for spot in own[1:]]
    logical = [_logical(name, model) for name in finding.objects]
    if not spots:
        with_file = [s for s in objects if s.file is not None]
        file = with_file[0].file if with_file else model.file
        physical = {} if file is None else {"physicalLocation": _physical(file, 1, root)}
        return {**physical, "logicalLocations": logical}, []
    first, *others = spots
    related = [
        {"id": k, **_located(spot, teller, root)} for k, spot in enumerate(others[:MOST_RELATED], start=1)
    ]
    return {**_located(first, teller, root), "logicalLocations": logical}, related


def _physical(file: Path, line: int, root: Root) -> dict[str, Any]:
    return {"artifactLocation": root.uri(file), "region": {"startLine": line}}


def _located(spot: _Spot, teller: Teller, root: Root) -> dict[str, Any]:
    surface, line, place = spot
    assert surface.file is not None, "a line is known only of a file"
    said = {} if place is None else {"message": {"text": f"At {teller.place(place)}."}}
    return {"physicalLocation": _physical(surface.file, line, root), **said}


def _logical(name: str, model: Model) -> dict[str, str]:
    kind = "fault" if any(f.name == name for f in model.faults) else "horizon"
    return {"name": name, "fullyQualifiedName": f"{model.name}/{name}", "kind": kind}


def _has_lines(surface: Surface) -> bool:
    return surface.file is not None and 0 < len(surface.lines) == len(surface.triangles)


def _own(finding: Finding, surface: Surface) -> list[_Spot]:
    """Return the lines of the triangles that the finding numbers, if they are the surface's, worst first."""
    if finding.element not in (Element.TRIANGLE, Element.VERTEX) or finding.objects[0] != surface.name:
        return []
    triangles = ints(finding.elements)
    if finding.element is Element.VERTEX:
        # the first triangle of each vertex, in the order of the vertices
        corner, first = np.unique(surface.triangles, return_index=True)
        at = np.searchsorted(corner, triangles)
        used = (at < len(corner)) & (corner[np.minimum(at, len(corner) - 1)] == triangles)
        triangles = ints(first[at[used]] // 3)
    if not len(triangles):
        return []
    middles = _middles(surface, triangles)
    order = list(range(len(triangles)))
    if finding.worst is not None:
        away = np.linalg.norm(middles - [finding.worst.x, finding.worst.y, finding.worst.z], axis=1)
        order.insert(0, order.pop(int(np.argmin(np.where(np.isfinite(away), away, np.inf)))))
    picked = order[: MOST_RELATED + 1]
    return _spots(surface, triangles[picked], middles[picked])


def _near(finding: Finding, surface: Surface) -> list[_Spot]:
    """Return the lines of the triangles nearest to the places of a finding, the worst first."""
    worst = finding.worst
    places = [] if worst is None else [(worst.x, worst.y, worst.z)]
    places += [tuple(p) for p in finding.places.tolist() if tuple(p) not in places]
    points = floats(places[: MOST_RELATED + 1], -1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    inside = ((surface.triangles >= 0) & (surface.triangles < len(surface.vertices))).all(axis=1)
    fit = np.flatnonzero(inside)
    fit = fit[np.isfinite(surface.vertices[surface.triangles[fit]]).all(axis=(1, 2))]
    if not len(points) or not len(fit):
        return []
    found = nearest(points, surface.vertices, surface.triangles[fit])
    return _spots(surface, ints(fit[found.simplex]), points)


def _spots(surface: Surface, triangles: IntArray, places: FloatArray) -> list[_Spot]:
    """Return the lines of triangles with a place for each; a line occurs once."""
    once: dict[int, _Spot] = {}
    for line, place in zip(surface.lines[triangles].tolist(), places.tolist(), strict=True):
        x, y, z = place
        once.setdefault(line, (surface, line, (x, y, z) if np.isfinite(place).all() else None))
    return list(once.values())


def _middles(surface: Surface, triangles: Sequence[int] | IntArray) -> FloatArray:
    """Return the centroids of triangles, shape (k, 3); NaN where an index is out of range."""
    corners = surface.triangles[np.asarray(triangles)]
    fit = ((corners >= 0) & (corners < len(surface.vertices))).all(axis=1)
    middles = np.full((len(corners), 3), np.nan)
    middles[fit] = surface.vertices[corners[fit]].mean(axis=1)
    return floats(middles, -1, 3)
