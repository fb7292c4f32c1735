"""Where a finding lies in the files of a model, as SARIF locations."""

from __future__ import annotations

import os
from collections.abc import Sequence
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
#: So many places of a finding are listed beside the first.
MOST_RELATED = 20
#: A line of a file, and the place it stands for.
_Spot = tuple[Surface, int, tuple[float, float, float] | None]


def locations(finding: Finding, model: Model, teller: Teller) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return the location of a finding and up to 20 more.

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
        physical = {} if file is None else {"physicalLocation": _physical(file, 1, model)}
        return {**physical, "logicalLocations": logical}, []
    first, *others = spots
    related = [
        {"id": k, **_located(spot, model, teller)} for k, spot in enumerate(others[:MOST_RELATED], start=1)
    ]
    return {**_located(first, model, teller), "logicalLocations": logical}, related


def uri(file: Path, folder: Path | None) -> tuple[str, bool]:
    """Return a file's URI and whether it is relative to the folder.

    >>> uri(Path("/data/my model/F 1.ts"), Path("/data/my model"))
    ('F%201.ts', True)
    """
    path = os.path.abspath(file)  # noqa: PTH100  Path.absolute keeps "..", Path.resolve follows links
    if folder is not None:
        inside = os.path.relpath(path, os.path.abspath(folder))  # noqa: PTH100
        if inside != os.pardir and not inside.startswith(os.pardir + os.sep):
            return quote(os.fsencode(inside)), True
    return Path(path).as_uri(), False


def _physical(file: Path, line: int, model: Model) -> dict[str, Any]:
    text, relative = uri(file, None if model.file is None else model.file.parent)
    place = {"uri": text, "uriBaseId": BASE} if relative else {"uri": text}
    return {"artifactLocation": place, "region": {"startLine": line}}


def _located(spot: _Spot, model: Model, teller: Teller) -> dict[str, Any]:
    surface, line, place = spot
    assert surface.file is not None, "a line is known only of a file"
    said = {} if place is None else {"message": {"text": f"At {teller.place(place)}."}}
    return {"physicalLocation": _physical(surface.file, line, model), **said}


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
