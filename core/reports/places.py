"""The places of findings as GeoJSON, for a GIS."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from graben.finding import Finding, Status
from graben.formats.geojson import geojson_text
from graben.reports.check_json import parsed
from graben.reports.json_report import strict

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from graben.pipeline import Examination

#: So many points, and so many lines, are written of a finding.
MOST = 500
_Place = tuple[float, float, float]


def check_places(examination: Examination) -> str:
    """Return the places of all findings that fail or warn as a GeoJSON FeatureCollection.

    A point for the worst place, each part and each further place; a line for each path. At most 500 of
    either for a finding: the property ``left_out`` says how many more there are.

    Parameters
    ----------
    examination : Examination
        Of :func:`graben.pipeline.examine`.

    Returns
    -------
    str
        The text of the file. Coordinates are the model's own, z counts as in the model file, ``crs`` names
        the model's coordinate system where it has one; the member ``graben`` says what wrote it.
    """
    model, result = examination.model, examination.result
    about = {
        "schema": 1,
        "model": model.name,
        "profile": str(result.profile),
        "passed": result.passed,
        "z": model.z,
        "unit": model.unit,
    }
    features = (
        feature
        for finding in result.findings
        if finding.status in (Status.FAIL, Status.WARN)
        for feature in _features(finding)
    )
    return geojson_text(features, z=model.z, crs=model.crs, members={"graben": about})


def is_check_places(content: bytes) -> bool:
    """Return whether a file's content is a collection that :func:`check_places` wrote."""
    found = parsed(content)
    return isinstance(found, dict) and found.get("type") == "FeatureCollection" and "graben" in found


def _features(finding: Finding) -> Iterator[tuple[BaseGeometry, dict[str, Any]]]:
    """Yield the geometries of a finding with their properties."""
    from shapely import LineString, Point

    points = [(place, known) for place, known in _points(finding) if np.isfinite(place).all()]
    paths = [path for path in finding.paths if len(path) > 1 and np.isfinite(path).all()]
    left_out = max(len(points) - MOST, 0) + max(len(paths) - MOST, 0)
    common = {
        "check": finding.check,
        "status": str(finding.status),
        "objects": list(finding.objects),
        "message": finding.message,
        "remedy": finding.remedy,
    }
    ending = {"left_out": left_out} if left_out else {}
    for place, known in points[:MOST]:
        yield Point(place), {**common, **strict(known), **ending}
    for path in paths[:MOST]:
        yield LineString(path), {**common, **_kind("path"), **ending}


def _points(finding: Finding) -> Iterator[tuple[_Place, dict[str, Any]]]:
    """Yield each place of a finding once, with what is known of it: the worst, the parts, the others."""
    taken: set[_Place] = set()
    worst = finding.worst
    if worst is not None:
        taken.add((worst.x, worst.y, worst.z))
        yield (worst.x, worst.y, worst.z), _kind("worst", finding.count, worst.value, worst.unit)
    for part in finding.parts:
        taken.add(part.place)
        objects = {"objects": list(part.objects)} if part.objects else {}
        yield part.place, {**_kind(part.kind, part.count, part.value, part.unit), **objects}
    for x, y, z in finding.places.tolist():
        if (x, y, z) not in taken:
            taken.add((x, y, z))
            yield (x, y, z), _kind("place")


def _kind(kind: str, count: int = 1, value: float | None = None, unit: str = "") -> dict[str, Any]:
    return {"kind": kind, "count": count, "value": value, "unit": unit}
