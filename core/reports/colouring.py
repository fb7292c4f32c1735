"""What the surfaces of a 3D view can be coloured by: height, throw, move, subdomain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import to_hex

from graben.arrays import FloatArray, floats
from graben.modeling.results import HorizonResult
from graben.modeling.strike import Strike, stretches_on
from graben.reports.scene import encoded
from graben.reports.style import Frame, elevation_colours
from graben.surface import Surface

if TYPE_CHECKING:
    from matplotlib.colors import Colormap

_SUBDOMAIN_COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442", "#666666")
#: The colour of nothing: it stands out from a white page and from a dark one.
_NONE = "#DFDCD6"
#: Throws of the rarer sign below this share of the largest leave the colours to the other sign.
_ONE_SIGN = 0.05
#: Colourings that are offered even where every value is zero.
_ALWAYS = frozenset({"height", "subdomain"})
#: How opaque faults are in their own colours, and coloured by a value.
OPACITY, _COLOURED = 0.5, 0.9


@dataclass(frozen=True, eq=False)
class Painted:
    """One surface of the view with what it can be coloured by, at each of its k vertices; None for nothing.

    ``height`` (elevation), ``throw`` and ``move`` are in model units, ``subdomain`` is the id in report.json;
    ``height`` and ``subdomain`` are known of horizons alone.
    """

    throw: FloatArray | None
    move: FloatArray | None
    height: FloatArray | None = None
    subdomain: FloatArray | None = None


def colourings(painted: Sequence[Painted], frame: Frame) -> dict[str, dict[str, Any]]:
    """Return the colourings of a view, as :class:`graben.reports.scene.Scene` has them.

    Parameters
    ----------
    painted : sequence of Painted
        The surfaces, in the order of the meshes.
    frame : Frame
        Unit and sign of z.
    """
    count = len(_SUBDOMAIN_COLOURS)
    bands = [[(k + end) / count, colour] for k, colour in enumerate(_SUBDOMAIN_COLOURS) for end in (0, 1)]
    known = {key: [getattr(p, key) for p in painted] for key in ("height", "throw", "move", "subdomain")}
    heights = [None if h is None else frame.z_factor * h for h in known["height"]]
    bare = [None if s is None else s % count for s in known["subdomain"]]
    down = frame.z_factor < 0
    every = {
        "height": (
            frame.z_name,
            heights,
            _axis(_shades(elevation_colours()), frame.label(frame.z_name), down),
        ),
        "throw": ("throw", known["throw"], _throw_axis(known["throw"], frame)),
        "move": ("move from the input", known["move"], _move_axis(known["move"], frame)),
        "subdomain": (
            "subdomain",
            bare,
            _axis(bands, "", cmin=-0.5, cmax=count - 0.5, showscale=False),
        ),
    }
    return {
        key: {
            "label": label,
            "values": [None if v is None else encoded(v, "f4") for v in values],
            "opacity": [_opacity(p, v is not None) for p, v in zip(painted, values, strict=True)],
            "axis": axis,
        }
        for key, (label, values, axis) in every.items()
        if any(v is not None and len(v) and (key in _ALWAYS or np.any(v)) for v in values)
    }


def _opacity(painted: Painted, coloured: bool) -> float | None:
    """Return how opaque a fault is; None for a horizon, which the reader sets."""
    if painted.height is not None:
        return None
    return _COLOURED if coloured else OPACITY


def _throw_axis(values: Sequence[FloatArray | None], frame: Frame) -> dict[str, Any]:
    """Return the colours of throw: normal orange, reverse purple, grey between."""
    low, high = _range(values)
    most = max(-low, high) or 1.0
    colours, title = (
        _colours("throw", "#2D004B", "#8073AC", _NONE, "#E08214", "#7F3B08"),
        frame.label("throw"),
    )
    if low > -_ONE_SIGN * most:
        return _axis(_shades(colours, 0.5, 1.0), title, cmin=0.0, cmax=most)
    if high < _ONE_SIGN * most:
        return _axis(_shades(colours, 0.0, 0.5), title, cmin=-most, cmax=0.0)
    return _axis(_shades(colours), title, cmin=-most, cmax=most)


def _move_axis(values: Sequence[FloatArray | None], frame: Frame) -> dict[str, Any]:
    most = _range(values)[1] or 1.0
    return _axis(
        _shades(_colours("move", _NONE, "#8C96C6", "#6E016B")), frame.label("move"), cmin=0.0, cmax=most
    )


def _colours(name: str, *stops: str) -> Colormap:
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list(name, list(stops))


def _range(values: Sequence[FloatArray | None]) -> tuple[float, float]:
    known = [v for v in values if v is not None and len(v)]
    return min((float(v.min()) for v in known), default=0.0), max(
        (float(v.max()) for v in known), default=0.0
    )


def _shades(colours: Colormap, low: float = 0.0, high: float = 1.0) -> list[list[float | str]]:
    """Return a part of a colour map as plotly.js takes it."""
    stops = np.linspace(0.0, 1.0, 11)
    return [
        [float(s), to_hex(colour)]
        for s, colour in zip(stops, colours(low + (high - low) * stops), strict=True)
    ]


def _axis(scale: object, title: str, reverse: bool = False, **keys: object) -> dict[str, Any]:
    bar: dict[str, Any] = {"title": {"text": title, "side": "right"}, "thickness": 14, "len": 0.7}
    bar |= {"exponentformat": "none", "separatethousands": False, "tickformat": "~f"}
    turned = {"reversescale": True} if reverse else {}
    return {"colorscale": scale, "colorbar": bar, **turned, **keys}


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


def throw_on(results: Sequence[HorizonResult], fault: Surface) -> FloatArray | None:
    """Return the throw on a fault at its vertices, (n,), model units; None where it cuts no horizon.

    At each place along strike it is that of the cutoffs there, linear in elevation between two horizons;
    above the first and below the last it is theirs. Beyond a tip there is none.
    """
    lines = stretches_on(results, fault)
    if not lines:
        return None
    along, z = Strike.of(fault).along(fault.vertices), fault.vertices[:, 2]
    profiles = []
    for name in dict.fromkeys(line.horizon for line in lines):
        own = [line for line in lines if line.horizon == name]
        place = np.concatenate([line.along for line in own])
        order = np.argsort(place, kind="stable")
        level = np.concatenate([(line.hanging[:, 1] + line.foot[:, 1]) / 2.0 for line in own])
        throw = np.concatenate([line.throw for line in own])
        profiles.append([np.interp(along, place[order], values[order]) for values in (level, throw)])
    levels, throws = np.moveaxis(np.array(profiles), 1, 0)
    order = np.argsort(levels, axis=0, kind="stable")
    levels, throws = (np.take_along_axis(a, order, axis=0) for a in (levels, throws))
    step, rise = np.diff(levels, axis=0), np.diff(throws, axis=0)
    share = np.clip((z - levels[:-1]) / np.where(step > 0, step, 1.0), 0.0, 1.0)
    return floats(throws[0] + (share * rise).sum(axis=0))
