"""The 3D view of a run: horizons, faults and cutoffs as plain values for plotly.js.

Coordinates are local, so that the single precision of WebGL is enough; the axes name the offset.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_hex
from numpy.typing import ArrayLike

from graben.arrays import FloatArray, IntArray
from graben.modeling.results import HorizonResult
from graben.reports.style import FOOT, HANGING, Frame, elevation_colours, plain_numbers
from graben.surface import Surface

if TYPE_CHECKING:
    from matplotlib.colors import Colormap

    from graben.pipeline import RunResult

#: Above so many triangles in all, surfaces are thinned for the view; smaller ones than the second stay.
MOST_TRIANGLES = 60_000
_SMALL = 1_500
_EXAGGERATIONS = (1, 2, 3, 5, 10, 20)
#: Height of the model over its longer side in plan that the first exaggeration aims at.
_HEIGHT = 0.35
_FAULT_COLOURS = ("#8C8C8C", "#B08D57", "#6C8EAD", "#9B7FA8", "#7F9B72", "#A3A3A3")
_SUBDOMAIN_COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442", "#666666")
_LIGHT = {"ambient": 0.62, "diffuse": 0.6, "specular": 0.05, "roughness": 0.9}


@dataclass(frozen=True)
class Scene:
    """What the page needs to draw: traces and layout for plotly.js, colourings, and a note.

    ``colourings`` maps a name to {"values": one array for each horizon, "axis": coloraxis};
    ``groups`` are (label, indices of its traces); ``exaggerations`` the choices, the first one set.
    """

    data: list[dict[str, Any]]
    layout: dict[str, Any]
    colourings: dict[str, dict[str, Any]]
    groups: list[tuple[str, list[int]]]
    meshes: list[int]
    exaggeration: int
    exaggerations: tuple[int, ...]
    note: str


def scene(result: RunResult) -> Scene | None:
    """Return the 3D view of a run, or None where there is nothing to see."""
    surfaces = [h.surface for h in result.horizons] + [f.surface for f in result.repaired.faults]
    surfaces = [s for s in surfaces if len(s.triangles) and np.isfinite(s.vertices).all()]
    if not surfaces:
        return None
    frame = Frame.of(result.model)
    low = np.min([s.vertices.min(axis=0) for s in surfaces], axis=0)
    high = np.max([s.vertices.max(axis=0) for s in surfaces], axis=0)
    offset = np.append(np.floor((low + high)[:2] / 2), 0.0)
    whole = sum(len(s.triangles) for s in surfaces)
    share = min(MOST_TRIANGLES / whole, 1.0)
    data: list[dict[str, Any]] = []
    groups: list[tuple[str, list[int]]] = []
    thinned: list[tuple[HorizonResult, IntArray]] = []
    shown = 0
    for horizon in result.horizons:
        kept, triangles = thinned_surface(horizon.surface, share)
        thinned.append((horizon, kept))
        first, shown = len(data), shown + len(triangles)
        data.append(_horizon(horizon, kept, triangles, offset, frame))
        data += _lips(horizon, offset, frame)
        groups.append((f"{horizon.name} (horizon)", list(range(first, len(data)))))
    for number, fault in enumerate(f for f in result.repaired.faults if f.surface in surfaces):
        kept, triangles = thinned_surface(fault.surface, share)
        shown += len(triangles)
        groups.append((f"{fault.name} (fault)", [len(data)]))
        data.append(_fault(fault.surface, kept, triangles, offset, frame, number))
    meshes = [group[1][0] for group in groups[: len(result.horizons)]]
    colourings = _colourings(thinned, frame)
    for mesh, values in zip(meshes, colourings["height"]["values"], strict=True):
        data[mesh]["intensity"] = values
    ratio = (high - low) / max(float((high - low)[:2].max()), np.finfo(np.float64).tiny)
    exaggeration = max((e for e in _EXAGGERATIONS if e * ratio[2] <= _HEIGHT), default=1)
    note = ""
    if shown < whole:
        note = (
            f"Thinned for this view to {shown:,} of {whole:,} triangles; "
            "rims and cutoffs are whole, and the files hold every triangle."
        )
    layout = _layout(low - offset, high - offset, offset, ratio, exaggeration, frame)
    layout["coloraxis"] = colourings["height"]["axis"]
    return Scene(data, layout, colourings, groups, meshes, exaggeration, _EXAGGERATIONS, note)


def thinned_surface(surface: Surface, share: float) -> tuple[IntArray, IntArray]:
    """Return a surface with about ``share`` of its triangles; its boundary, lips included, stays whole.

    Returns
    -------
    kept : (k,) array
        The vertices that remain, none of them moved.
    triangles : (m, 3) array
        Indices into ``kept``.
    """
    if share >= 1.0 or len(surface.triangles) <= _SMALL:
        return np.arange(len(surface.vertices)), surface.triangles
    # VTK computes in single precision: large coordinates first lose their offset.
    mesh = surface.moved(-surface.vertices.mean(axis=0)).to_pyvista()
    mesh.point_data["index"] = np.arange(len(surface.vertices))
    mesh = mesh.decimate_pro(1.0 - share, preserve_topology=True, boundary_vertex_deletion=False)
    return np.asarray(mesh.point_data["index"], dtype=np.int64), mesh.regular_faces.astype(np.int64)


def encoded(values: ArrayLike, kind: str) -> dict[str, str]:
    """Return an array as plotly.js takes it in few bytes: its type, such as "f4", and base64."""
    content = np.ascontiguousarray(values).astype(f"<{kind}")
    return {"dtype": kind, "bdata": base64.b64encode(content.tobytes()).decode("ascii")}


def _mesh(
    surface: Surface, kept: IntArray, triangles: IntArray, offset: FloatArray, frame: Frame
) -> dict[str, Any]:
    points = (surface.vertices[kept] - offset) * [1.0, 1.0, frame.z_factor]
    kind = "u2" if len(kept) < 2**16 else "u4"
    return {
        "type": "mesh3d",
        **{key: encoded(points[:, k], "f4") for k, key in enumerate("xyz")},
        **{key: encoded(triangles[:, k], kind) for k, key in enumerate("ijk")},
        "name": escape(surface.name),
        "lighting": _LIGHT,
        "hovertemplate": f"%{{x}}, %{{y}}, {frame.z_name} %{{z}}",
    }


def _horizon(
    result: HorizonResult, kept: IntArray, triangles: IntArray, offset: FloatArray, frame: Frame
) -> dict[str, Any]:
    return {**_mesh(result.surface, kept, triangles, offset, frame), "coloraxis": "coloraxis"}


def _fault(
    surface: Surface, kept: IntArray, triangles: IntArray, offset: FloatArray, frame: Frame, number: int
) -> dict[str, Any]:
    colour = _FAULT_COLOURS[number % len(_FAULT_COLOURS)]
    mesh = _mesh(surface, kept, triangles, offset, frame)
    return {**mesh, "color": colour, "opacity": 0.5, "flatshading": True}


def _lips(result: HorizonResult, offset: FloatArray, frame: Frame) -> list[dict[str, Any]]:
    """Return the cutoffs of a horizon as two traces of lines, undefined between pieces."""
    if not result.cutoffs:
        return []
    traces = []
    for side, colour in (("hanging", HANGING), ("foot", FOOT)):
        pieces = [
            np.append(getattr(c, side) - offset, np.full((1, 3), np.nan), axis=0) for c in result.cutoffs
        ]
        points = np.concatenate(pieces) * [1.0, 1.0, frame.z_factor]
        traces.append(
            {
                "type": "scatter3d",
                "mode": "lines",
                **{key: encoded(points[:, k], "f4") for k, key in enumerate("xyz")},
                "line": {"color": colour, "width": 6},
                "name": f"{escape(result.name)}, {side} cutoff",
                "hoverinfo": "name",
            }
        )
    return traces


def _colourings(thinned: Sequence[tuple[HorizonResult, IntArray]], frame: Frame) -> dict[str, dict[str, Any]]:
    """Return the colourings of the horizons: height, throw and subdomain."""
    height = [frame.z_factor * h.surface.vertices[kept, 2] for h, kept in thinned]
    throw = [node_throws(h)[kept] for h, kept in thinned]
    subdomain = [h.subdomain[kept] % len(_SUBDOMAIN_COLOURS) for h, kept in thinned]
    most = max((float(np.abs(t).max()) for t in throw if len(t)), default=0.0) or 1.0
    count = len(_SUBDOMAIN_COLOURS)
    bands = [[(k + end) / count, colour] for k, colour in enumerate(_SUBDOMAIN_COLOURS) for end in (0, 1)]
    return {
        "height": {
            "label": frame.z_name,
            "values": [encoded(h, "f4") for h in height],
            "axis": _colour_axis(
                _shades(elevation_colours()), frame.label(frame.z_name), reversescale=frame.z_factor < 0
            ),
        },
        "throw": {
            "label": "throw near the cutoffs",
            "values": [encoded(t, "f4") for t in throw],
            "axis": _colour_axis(_shades(colormaps["PuOr_r"]), frame.label("throw"), cmin=-most, cmax=most),
        },
        "subdomain": {
            "label": "subdomain",
            "values": [encoded(s, "f4") for s in subdomain],
            "axis": _colour_axis(bands, "", cmin=-0.5, cmax=count - 0.5, showscale=False),
        },
    }


def _shades(colours: Colormap) -> list[list[float | str]]:
    """Return a colour map as plotly.js takes it."""
    stops = np.linspace(0.0, 1.0, 11)
    return [[float(s), to_hex(colour)] for s, colour in zip(stops, colours(stops), strict=True)]


def _colour_axis(scale: object, title: str, **keys: object) -> dict[str, Any]:
    bar = {"title": {"text": title, "side": "right"}, "thickness": 14, "len": 0.7}
    return {"colorscale": scale, "colorbar": bar, **keys}


def node_throws(result: HorizonResult) -> FloatArray:
    """Return the throw of the nearest cut node at each node of the rebuilt zone, 0 elsewhere, shape (n,)."""
    from scipy.spatial import KDTree

    points = result.surface.vertices
    throws = np.zeros(len(points))
    zone = ~result.fixed
    if result.cutoffs and zone.any():
        lips = np.concatenate([line for c in result.cutoffs for line in (c.hanging, c.foot)])
        values = np.concatenate([c.throw for c in result.cutoffs for _ in range(2)])
        throws[zone] = values[KDTree(lips[:, :2]).query(points[zone, :2])[1]]
    return throws


def _layout(
    low: FloatArray, high: FloatArray, offset: FloatArray, ratio: FloatArray, exaggeration: int, frame: Frame
) -> dict[str, Any]:
    written = plain_numbers()
    axes: dict[str, Any] = {}
    for k, key in enumerate("xy"):
        shift = f" − {written(float(offset[k]))}" if offset[k] else ""
        axes[f"{key}axis"] = {
            "title": {"text": frame.label(f"{key}{shift}")},
            "range": [float(low[k]), float(high[k])],
        }
    heights = [float(low[2]), float(high[2])] if frame.z_factor > 0 else [float(-low[2]), float(-high[2])]
    axes["zaxis"] = {"title": {"text": frame.label(frame.z_name)}, "range": heights}
    for axis in axes.values():
        axis.update({"exponentformat": "none", "separatethousands": False, "nticks": 6})
    aspect = {"x": float(ratio[0]), "y": float(ratio[1]), "z": float(ratio[2]) * exaggeration}
    camera = {"eye": {"x": -0.86, "y": -1.3, "z": 0.86}, "center": {"x": 0, "y": 0, "z": -0.1}}
    return {
        "scene": {**axes, "aspectmode": "manual", "aspectratio": aspect, "camera": camera},
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "showlegend": False,
        "uirevision": "kept",
        "paper_bgcolor": "rgba(0,0,0,0)",
    }
