"""The 3D view of a run: horizons, faults and cutoffs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_hex

from graben.arrays import FloatArray, IntArray
from graben.modeling.results import HorizonResult
from graben.reports.scene import (
    FAULT_COLOURS,
    MOST_TRIANGLES,
    Group,
    Scene,
    Space,
    encoded,
    thinned_surface,
)
from graben.reports.style import FOOT, HANGING, Frame, elevation_colours

if TYPE_CHECKING:
    from matplotlib.colors import Colormap

    from graben.pipeline import RunResult

_SUBDOMAIN_COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442", "#666666")


def scene(result: RunResult) -> Scene | None:
    """Return the 3D view of a run, or None where there is nothing to see."""
    surfaces = [h.surface for h in result.horizons] + [f.surface for f in result.repaired.faults]
    surfaces = [s for s in surfaces if len(s.triangles) and np.isfinite(s.vertices).all()]
    if not surfaces:
        return None
    frame = Frame.of(result.model)
    space = Space.around([s.vertices for s in surfaces], frame)
    whole = sum(len(s.triangles) for s in surfaces)
    share = min(MOST_TRIANGLES / whole, 1.0)
    data: list[dict[str, Any]] = []
    groups: list[Group] = []
    meshes: list[int] = []
    thinned: list[tuple[HorizonResult, IntArray]] = []
    shown = 0
    for horizon in result.horizons:
        kept, triangles = thinned_surface(horizon.surface, share)
        thinned.append((horizon, kept))
        shown += len(triangles)
        meshes.append(len(data))
        data.append(
            space.mesh(horizon.name, horizon.surface.vertices[kept], triangles, coloraxis="coloraxis")
        )
        data += _lips(horizon, space)
        groups.append(Group("Horizons", horizon.name, tuple(range(meshes[-1], len(data)))))
    for number, fault in enumerate(f for f in result.repaired.faults if f.surface in surfaces):
        kept, triangles = thinned_surface(fault.surface, share)
        shown += len(triangles)
        groups.append(Group("Faults", fault.name, (len(data),)))
        style = {"color": FAULT_COLOURS[number % len(FAULT_COLOURS)], "opacity": 0.5, "flatshading": True}
        data.append(space.mesh(fault.name, fault.surface.vertices[kept], triangles, **style))
    colourings = _colourings(thinned, frame)
    for mesh, values in zip(meshes, colourings["height"]["values"], strict=True):
        data[mesh]["intensity"] = values
    note = ""
    if shown < whole:
        note = (
            f"Thinned for this view to {shown:,} of {whole:,} triangles; "
            "rims and cutoffs are whole, and the files hold every triangle."
        )
    layout = {**space.layout(), "coloraxis": colourings["height"]["axis"]}
    return Scene(data, layout, groups, space.exaggeration, colourings, meshes, note=note)


def _lips(result: HorizonResult, space: Space) -> list[dict[str, Any]]:
    """Return the cutoffs of a horizon as two traces of lines."""
    if not result.cutoffs:
        return []
    return [
        space.lines(
            f"{result.name}, {side} cutoff",
            [getattr(c, side) for c in result.cutoffs],
            line={"color": colour, "width": 6},
        )
        for side, colour in (("hanging", HANGING), ("foot", FOOT))
    ]


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
