"""Where the faults of a complex meet, and how.

Two surfaces meet where they cross, by exact arithmetic: in the edges that both have in their common
refinement; and where an edge of one lies on the other to the contact distance: a rim computed to lie on
another fault, with coordinates of a few decimals, does so only to that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graben.complexes import Complex
from graben.surface import Surface
from graben.validators.measuring.contact import Contact, ContactKind
from graben.validators.measuring.contact_pieces import told_apart
from graben.validators.measuring.touching import meshes, shared_edges, touching

__all__ = ["Contact", "ContactKind", "contacts"]

#: The least contact distance over the extent of all surfaces: above the rounding of their coordinates.
_ROUNDING = 1e-12


def contacts(surfaces: Sequence[Surface], network: Complex, tolerance: float) -> tuple[Contact, ...]:
    """Return where surfaces meet, pair by pair in their order.

    Parameters
    ----------
    surfaces : sequence of Surface
        What the complex was made from: finite coordinates, indices in range.
    network : Complex
        Their common refinement.
    tolerance : float
        Distance at which two surfaces touch, model units.
    """
    if len(surfaces) < 2 or not len(network.vertices):
        return ()
    tolerance = max(tolerance, _ROUNDING * float(np.ptp(network.vertices, axis=0).max()))
    shared = shared_edges(network)
    all_meshes = meshes(surfaces)
    low = np.array([m.low for m in all_meshes]) - tolerance
    high = np.array([m.high for m in all_meshes])
    near = ((low[:, None] <= high) & (low <= high[:, None] + tolerance)).all(axis=2)
    found: list[Contact] = []
    for i, j in np.argwhere(np.triu(near, 1)).tolist():
        both = all_meshes[i], all_meshes[j]
        touch = touching(*both, shared.get((i, j), np.zeros((0, 2, 3))), tolerance)
        if touch is not None:
            found += told_apart((i, j), both, touch, tolerance)
    return tuple(found)
