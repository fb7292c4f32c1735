"""What each stretch of a fault's rim does: it ends freely, on another fault, just short of it or past it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.complexes import Complex
from graben.proximity import Simplices
from graben.surface import Surface
from graben.validators.measuring.branch_lines import BranchLines
from graben.validators.measuring.hits import TriangleTree
from graben.validators.measuring.measures import remembered
from graben.validators.measuring.rim_labels import LABELS, Labels, RimLabel, Scene, with_tips
from graben.validators.measuring.rim_lines import RimPieces, rim_line, rim_pieces

#: Length of the pieces that a rim is looked at in, over the limit.
_PIECE = 0.25
#: A gap or a stub on a stretch shorter than this share of its size is a tooth of the rim, not a side of it.
_TOOTH = 0.5
#: A gap is as narrow as at an end of its pieces where it is less than this share of what it is in their
#: middles: pieces are short against the limit, not against a gap that closes.
_CLOSES = 0.5
#: Share by which sizes along a stretch may differ and count as one: above rounding.
_ALIKE = 1e-3


@dataclass(frozen=True, eq=False)
class Stretch:
    """A connected stretch of a rim that does one thing.

    Parameters
    ----------
    fault, neighbour : str
        The fault that ends, and the other; an empty name where the stretch is free or a tip.
    label : RimLabel
        What it does.
    least, greatest : float
        Of a gap the distance along the way the fault would go on, of a stub its length from the branch line;
        else 0. Model units.
    length : float
        Along the rim, model units.
    place : (3,) array
        On the rim, in the middle of where a gap is least or a stub greatest; else in the middle of all.
    path : (k, 3) array
        The stretch, model units.
    triangles : (t,) array
        Triangles of the fault along it.
    """

    fault: str
    label: RimLabel
    neighbour: str
    least: float
    greatest: float
    length: float
    place: FloatArray
    path: FloatArray
    triangles: IntArray

    @property
    def size(self) -> float:
        """The least width of a gap, the greatest length of a stub, model units; else 0."""
        return self.greatest if self.label is RimLabel.STUB else self.least


@remembered
def rim_stretches(
    network: Complex,
    faults: tuple[Surface, ...],
    limits: tuple[float, ...],
    contact: float,
    horizons: tuple[Surface, ...] = (),
) -> tuple[Stretch, ...]:
    """Return the rims of faults, stretch by stretch.

    A fault goes on beyond its rim in its own plane, square to the rim. Its neighbour there is the one it
    meets first; a fault that it would just miss counts as well when the nearest point of that fault lies
    ahead. A fault that crosses another and ends within the limit after it has a stub. Where two faults
    cross, their rims near the ends of the branch line run through and are neither.

    Parameters
    ----------
    network : Complex
        The common refinement of the faults.
    faults : tuple of Surface
        What it was made from.
    limits : tuple of float
        Widest gap and longest stub of each fault, model units.
    contact : float
        Distance at which two surfaces touch, model units.
    horizons : tuple of Surface
        Where given, tips are told apart from free stretches.

    Returns
    -------
    tuple of Stretch
        Fault by fault, in the order of the way along each rim. Together they are the whole rims, but for
        stretches shorter than ``contact``.
    """
    tree = TriangleTree(faults)
    crossed = TriangleTree(horizons) if horizons else None
    nearby = [Simplices(s.vertices, s.triangles) for s in faults]
    lines = [rim_line(s, network, k) for k, s in enumerate(faults)]
    scene = Scene(faults, lines, BranchLines(network, contact), tree, nearby, contact)
    found: list[Stretch] = []
    for own, (surface, limit, line) in enumerate(zip(faults, limits, lines, strict=True)):
        if not len(line.ends):
            continue
        reach = limit if limit > contact else 0.0
        near = tree.near(line.ends.min(axis=1) - reach, line.ends.max(axis=1) + reach, own)
        fine = np.asarray(near.any(axis=1), dtype=np.bool_)
        pieces = rim_pieces(line, _PIECE * reach, min(surface.median_edge, reach / 2), fine)
        labels = _without_teeth(pieces, scene.labelled(pieces, own, reach))
        if crossed is not None:
            labels = with_tips(labels, pieces, crossed)
        runs = (_stretch(pieces, labels, scene, own, run) for run in _runs(pieces, labels))
        found += [s for s in runs if s.length > contact]
    return tuple(found)


def _runs(pieces: RimPieces, labels: Labels) -> Iterator[IntArray]:
    """Return the pieces of each stretch of one label and one neighbour, in their order along the rim."""
    for chain, closed in enumerate(pieces.closed):
        rows = np.flatnonzero(pieces.chain == chain)
        label, other = labels.label[rows], labels.other[rows]
        change = np.flatnonzero((label[1:] != label[:-1]) | (other[1:] != other[:-1])) + 1
        if closed and len(change) and label[0] == label[-1] and other[0] == other[-1]:
            rows = np.roll(rows, -change[0])
            change = change[1:] - change[0]
        yield from (ints(run) for run in np.split(rows, change))


def _without_teeth(pieces: RimPieces, labels: Labels) -> Labels:
    """Return labels in which gaps and stubs of stretches too short for their size are free."""
    label, other = labels.label.copy(), labels.other.copy()
    lengths = pieces.lengths
    for run in _runs(pieces, labels):
        sized = LABELS[int(label[run[0]])] in (RimLabel.GAP, RimLabel.STUB)
        if sized and lengths[run].sum() < _TOOTH * labels.size[run].min():
            label[run], other[run] = LABELS.index(RimLabel.FREE), -1
    return Labels(ints(label), ints(other), labels.size)


def _stretch(pieces: RimPieces, labels: Labels, scene: Scene, own: int, run: IntArray) -> Stretch:
    """Return one stretch of a rim, made of the pieces ``run`` in their order."""
    label, other = LABELS[int(labels.label[run[0]])], int(labels.other[run[0]])
    size = labels.size[run] if label in (RimLabel.GAP, RimLabel.STUB) else np.zeros(len(run))
    worst = size.min() if label is RimLabel.GAP else size.max()
    place = _middle(pieces, run[np.abs(size - worst) <= _ALIKE * worst], run)
    if label is RimLabel.GAP:
        widths, narrowest = _at_ends(pieces, run, size, scene.nearby[other], scene.contact)
        if widths.min() < _CLOSES * worst:
            size, place = floats(np.append(size, widths.min())), narrowest
    return Stretch(
        scene.faults[own].name,
        label,
        scene.faults[other].name if other >= 0 else "",
        float(size.min()),
        float(size.max()),
        float(pieces.lengths[run].sum()),
        place,
        floats(np.concatenate([pieces.ends[run, 0], pieces.ends[run[-1:], 1]])),
        ints(np.unique(pieces.parent[run])),
    )


def _at_ends(
    pieces: RimPieces, run: IntArray, size: FloatArray, other: Simplices, contact: float
) -> tuple[FloatArray, FloatArray]:
    """Return the widths of a gap at the ends of the pieces, and the place of the least, (3,).

    The way ahead is longer than the nearest one by the same share at the ends of a piece as in its middle.
    Where the rim touches the other there is no gap: the width is infinite.
    """
    ends = pieces.ends[run].reshape(-1, 3)
    middle, at = (other.nearest(p).distance for p in (pieces.middles[run], ends))
    ratio = size / np.maximum(middle, np.finfo(float).tiny)
    widths = np.where(at > contact, at * np.repeat(ratio, 2), np.inf)
    return floats(widths), floats(ends[np.argmin(widths)])


def _middle(pieces: RimPieces, some: IntArray, run: IntArray) -> FloatArray:
    """Return the place on a run of pieces that is in the middle of some of them, along the run."""
    lengths = pieces.lengths[run]
    after = np.cumsum(lengths)
    mine = np.isin(run, some)
    weight = np.where(mine, np.maximum(lengths, np.finfo(float).tiny), 0.0)
    at = float(((after - lengths / 2) * weight).sum() / weight.sum())
    k = min(int(np.searchsorted(after, at)), len(run) - 1)
    share = 1.0 - (after[k] - at) / lengths[k] if lengths[k] > 0 else 0.5
    start, stop = pieces.ends[run[k]]
    return floats(start + np.clip(share, 0.0, 1.0) * (stop - start))
