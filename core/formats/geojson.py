"""GeoJSON files."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graben.formats.tsurf import Sign

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry


def write_geojson(
    path: Path,
    features: Iterable[tuple[BaseGeometry, Mapping[str, Any]]],
    *,
    z: Sign = "elevation",
    crs: str | None = None,
) -> None:
    """Write shapely geometries with their properties as a FeatureCollection; see :func:`geojson_text`.

    Parameters
    ----------
    path : Path
        The file.
    features, z, crs
        As there.
    """
    path.write_text(geojson_text(features, z=z, crs=crs), encoding="utf-8", newline="\n")


def geojson_text(
    features: Iterable[tuple[BaseGeometry, Mapping[str, Any]]],
    *,
    z: Sign = "elevation",
    crs: str | None = None,
    members: Mapping[str, Any] | None = None,
) -> str:
    """Return shapely geometries with their properties as the text of a FeatureCollection.

    The coordinates are the model's own; a coordinate system other than longitude and latitude is named in
    the member ``crs`` of the 2008 format, which GIS programs still read.

    Parameters
    ----------
    features : iterable of (geometry, properties)
        Geometries with elevations, or in plan; properties that JSON can hold.
    z : "elevation" or "depth"
        How the file counts z.
    crs : str, optional
        Name of the coordinate system, such as "EPSG:23031".
    members : mapping, optional
        Further members of the collection, which readers that do not know them pass over.
    """
    import numpy as np
    from shapely import transform
    from shapely.geometry import mapping

    sign = np.array([1.0, 1.0, 1.0 if z == "elevation" else -1.0])
    content: dict[str, Any] = {"type": "FeatureCollection", **(members or {})}
    if crs is not None:
        content["crs"] = {"type": "name", "properties": {"name": _urn(crs)}}
    content["features"] = [
        {
            "type": "Feature",
            "properties": dict(properties),
            "geometry": mapping(
                transform(shape, lambda p: p * sign, include_z=True) if shape.has_z else shape
            ),
        }
        for shape, properties in features
    ]
    return json.dumps(content, indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def _urn(crs: str) -> str:
    """Return the URN of an EPSG code, and any other name as it is."""
    code = re.fullmatch(r"\s*EPSG:+(\d+)\s*", crs, re.IGNORECASE)
    return f"urn:ogc:def:crs:EPSG::{code.group(1)}" if code else crs
