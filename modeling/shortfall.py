"""Where a fault ends too early for its horizon, and how far it would have to be extended (paper Table 4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import FloatArray
from graben.surface import Surface, boundary_edges, mean_dip_direction

#: Distance from the rim, as a share of the size of the surface, at which a line ends on it.
_ON_RIM = 1e-6
#: A rim whose outward normal lies within 45 degrees of the strike ends the fault along strike.
_SIDEWAYS = float(np.sqrt(0.5))
#: Places in the outer quarters along strike lie at an end of the fault.
_END = 0.25
_WINDS = (
    "eastern",
    "northeastern",
    "northern",
    "northwestern",
    "western",
    "southwestern",
    "southern",
    "southeastern",
)


@dataclass(frozen=True)
class Shortfall:
    """How far a fault would have to reach beyond its rim.

    Parameters
    ----------
    length : float
        Along the fault, across its rim, model units.
    way : str
        "upwards", "downwards", or "" where it is to be extended along strike.
    end : str
        The end along strike at which it is, "southern"; "" in between.
    """

    length: float
    way: str
    end: str

    def __str__(self) -> str:
        at = f"at its {self.end} end" if self.end else ""
        return " ".join(part for part in (self.way, at) if part)


def shortfall(surface: Surface, place: FloatArray, rise: float, tangent: FloatArray) -> Shortfall | None:
    """Return how far a fault must be extended for a line that ends on its rim to go on.

    Parameters
    ----------
    surface : Surface
        The fault.
    place : (3,) array
        Where the line ends, model units.
    rise : float
        How much higher it would go on to, model units; negative for lower.
    tangent : (3,) array
        How it would go on, per unit of elevation; zeros for straight up or down the fault.

    Returns
    -------
    Shortfall or None
        None where the line does not end on the rim, or would not leave the fault by it.
    """
    rim = boundary_edges(surface.triangles)
    if len(rim) == 0:
        return None
    reach = _ON_RIM * float(np.ptp(surface.vertices, axis=0).max())
    outward = [_outward(surface, edge) for edge in rim[_distances(surface.vertices[rim], place) <= reach]]
    lengths = [_across(out, rise, tangent) for out in outward]
    if not lengths or max(lengths) <= 0:
        return None
    length, out = max(zip(lengths, outward, strict=True), key=lambda pair: pair[0])
    dip, _ = mean_dip_direction(surface.vertices, surface.triangles)
    strike = np.array([-dip[1], dip[0]])
    along = surface.vertices[:, :2] @ strike
    middle, half = (along.max() + along.min()) / 2, np.ptp(along) / 2
    share = (place[:2] @ strike - middle) / half if half > 0 else 0.0
    aside = float(out[:2] @ strike)
    if abs(aside) > _SIDEWAYS:
        return Shortfall(length, "", _wind(strike * aside))
    end = _wind(strike * share) if abs(share) > 1 - 2 * _END else ""
    return Shortfall(length, "upwards" if out[2] > 0 else "downwards", end)


def _distances(edges: FloatArray, place: FloatArray) -> FloatArray:
    """Return the distance of a point (3,) from each edge (k, 2, 3), shape (k,)."""
    a, way = edges[:, 0], edges[:, 1] - edges[:, 0]
    share = ((place - a) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), np.finfo(float).tiny)
    near = a + np.clip(share, 0.0, 1.0)[:, None] * way
    return np.asarray(np.linalg.norm(near - place, axis=1), dtype=np.float64)


def _across(out: FloatArray, rise: float, tangent: FloatArray) -> float:
    """Return how far a line goes in the direction ``out``, 0 where it does not go there."""
    if tangent.any():
        return float(rise * (tangent @ out))
    return float(rise / out[2]) if rise * out[2] > 0 else 0.0


def _outward(surface: Surface, edge: FloatArray) -> FloatArray:
    """Return the unit vector (3,) in the plane of a rim edge's triangle that points out of the fault."""
    holder = surface.triangles[np.isin(surface.triangles, edge).sum(axis=1) == 2][0]
    a, b = surface.vertices[edge]
    c = surface.vertices[holder[~np.isin(holder, edge)][0]]
    along = (b - a) / np.linalg.norm(b - a)
    out = (a - c) - ((a - c) @ along) * along
    return np.asarray(out / np.linalg.norm(out), dtype=np.float64)


def _wind(way: FloatArray) -> str:
    """Return the wind that a plan direction (2,) points to: "northern".

    >>> _wind(np.array([0.0, -3.0]))
    'southern'
    """
    eighth = 2.0 * np.pi / len(_WINDS)
    return _WINDS[round(float(np.arctan2(way[1], way[0])) / eighth) % len(_WINDS)]
