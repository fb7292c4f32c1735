"""The arrays of a cut horizon, with the parts of it that were meshed anew put in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, SignArray, ints
from graben.modeling.remeshing import Remeshed


@dataclass(frozen=True, eq=False)
class Patch:
    """A part of a cut horizon on its new mesh.

    Parameters
    ----------
    label : int
        Its subdomain.
    rows : (m,) array
        The triangles of the horizon that it replaces.
    nodes : (o,) array
        The copies in them, in the order of the old mesh.
    mesh : Remeshed
        From there to the new mesh.
    points : (n, 3) array
        Where the nodes of the new mesh lie in the end, model units.
    """

    label: int
    rows: IntArray
    nodes: IntArray
    mesh: Remeshed
    points: FloatArray


@dataclass(frozen=True, eq=False)
class CutArrays:
    """What a result says of a cut horizon, node by node; the meanings are those of ``HorizonResult``.

    ``labels`` (n,) are the subdomains, -1 for a node without triangles.
    """

    triangles: IntArray
    points: FloatArray
    first: FloatArray
    labels: IntArray
    unknown: BoolArray
    side: IntArray
    block: SignArray

    def patched(self, patches: Sequence[Patch]) -> CutArrays:
        """Return the arrays with parts on their new meshes: new nodes and triangles come after the others."""
        result, gone = self, np.zeros(len(self.triangles), dtype=bool)
        for patch in patches:
            gone[patch.rows] = True
        added = []
        for patch in patches:
            names, result = result._with_nodes(patch)
            added.append(names[patch.mesh.triangles])
        # Patches that lie side by side share triangles of fixed nodes.
        made = np.concatenate(added)
        once = np.unique(np.sort(made, axis=1), axis=0, return_index=True)[1]
        return replace(result, triangles=np.concatenate([self.triangles[~gone], made[np.sort(once)]]))

    def _with_nodes(self, patch: Patch) -> tuple[IntArray, CutArrays]:
        """Return the numbers of the nodes of a patch in the whole, and this with those that are new."""
        mesh, count = patch.mesh, len(self.points)
        stayed = len(mesh.kept)
        fresh = len(mesh.points) - stayed
        names = np.concatenate([patch.nodes[mesh.kept], count + np.arange(fresh)])
        weights = mesh.weights[stayed:]
        # The side of a node is a whole number: that of the old node next to it.
        nearest = patch.nodes[np.argmax(weights.toarray(), axis=1)]
        labels = self.labels.copy()
        labels[np.delete(patch.nodes, mesh.kept)] = -1
        return ints(names), replace(
            self,
            points=np.concatenate([self.points, patch.points[stayed:]]),
            first=np.concatenate([self.first, weights @ self.first[patch.nodes]]),
            labels=np.append(labels, np.full(fresh, patch.label)),
            unknown=np.append(self.unknown, np.ones(fresh, dtype=bool)),
            side=np.append(self.side, np.zeros(fresh, dtype=np.int64)),
            block=np.concatenate([self.block, self.block[nearest]]),
        )
