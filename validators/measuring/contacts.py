"""Where the faults of a complex meet, and how.

Two surfaces meet where they cross, by exact arithmetic: in the edges that both have in their common
refinement; and where an edge of one lies on the other to the contact distance: a rim computed to lie on
another fault, with coordinates of a few decimals, does so only to that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from graben.arrays import FloatArray
from graben.complexes import Complex
from graben.surface import Surface
from graben.validators.measuring.contact import Contact, ContactKind
from graben.validators.measuring.contact_pieces import told_apart
from graben.validators.measuring.touching import Mesh, meshes, shared_edges, touching

__all__ = ["Contact", "ContactKind", "KnownContacts", "contacts"]

#: The least contact distance over the extent of all surfaces: above the rounding of their coordinates.
_ROUNDING = 1e-12


class KnownContacts:
    """How pairs of surfaces meet, kept while surfaces stay the same objects and share the same edges."""

    def __init__(self) -> None:
        self._found: dict[tuple[Surface, Surface], tuple[bytes, float, tuple[Contact, ...]]] = {}

    def of(
        self,
        pair: tuple[Surface, Surface],
        shared: FloatArray,
        tolerance: float,
        measure: Callable[[], Sequence[Contact]],
    ) -> tuple[Contact, ...]:
        """Return the contacts of a pair: those kept, else those that ``measure`` returns.

        Parameters
        ----------
        pair : tuple of two Surface
            The surfaces.
        shared : (e, 2, 3) array
            The edges that both have in their common refinement, model units.
        tolerance : float
            Distance at which two surfaces touch, model units.
        measure : callable
            Returns the contacts where they are not known.
        """
        edges = shared.tobytes()
        known = self._found.get(pair)
        if known is None or known[:2] != (edges, tolerance):
            known = self._found[pair] = edges, tolerance, tuple(measure())
        return known[2]


def contacts(
    surfaces: Sequence[Surface], network: Complex, tolerance: float, known: KnownContacts | None = None
) -> tuple[Contact, ...]:
    """Return where surfaces meet, pair by pair in their order.

    Parameters
    ----------
    surfaces : sequence of Surface
        What the complex was made from: finite coordinates, indices in range.
    network : Complex
        Their common refinement.
    tolerance : float
        Distance at which two surfaces touch, model units.
    known : KnownContacts, optional
        What is known of pairs of these surfaces; what is found is added.
    """
    known = known or KnownContacts()
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
        edges = shared.get((i, j), np.zeros((0, 2, 3)))
        both = all_meshes[i], all_meshes[j]

        def measure(both: tuple[Mesh, Mesh] = both, edges: FloatArray = edges) -> Sequence[Contact]:
            touch = touching(*both, edges, tolerance)
            return () if touch is None else told_apart((0, 1), both, touch, tolerance)

        pair = surfaces[i], surfaces[j]
        found += [_between(c, (i, j)) for c in known.of(pair, edges, tolerance, measure)]
    return tuple(found)


def _between(contact: Contact, pair: tuple[int, int]) -> Contact:
    """Return a contact of surfaces 0 and 1 as one of the surfaces of these numbers."""
    return replace(contact, surfaces=pair, rims=tuple(pair[k] for k in contact.rims))
