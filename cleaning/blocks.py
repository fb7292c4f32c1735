"""Closed fault blocks: the prism under an outline in plan, between two depths, cut by the faults."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from graben.arrays import FloatArray, IntArray, ints
from graben.cells import cells
from graben.cleaning.shaping.block_sheets import Sheets, parting_sheets
from graben.errors import ModelingError
from graben.model import Model
from graben.prism import Prism, bounds_solid, prism, volume
from graben.surface import Surface, boundary_edges
from graben.validators.measuring.crossings import crossings
from graben.validators.self_intersection import TOUCH

#: Share of the prism by which the volumes of its blocks may miss it. What was measured is below 1e-13.
ADD_UP = 1e-9
#: Blocks whose volumes differ by less than this share of the prism are of one size when they are numbered.
_SAME_SIZE = 1e-6


@dataclass(frozen=True, eq=False)
class Block:
    """A closed part of the prism from which no way leads to another but through a fault.

    Parameters
    ----------
    name : str
        "block 1" and so on, from the largest to the smallest.
    surface : Surface
        Its closed boundary, triangles turned outward, model units.
    volume : float
        Cubic model units.
    faults : tuple of str
        The faults that bound it, in the order they were given.
    neighbours : tuple of str
        The blocks beyond these faults.
    origin : (m,) array
        For each triangle of the surface the place of its fault in ``faults``; -1 on the prism.
    """

    name: str
    surface: Surface
    volume: float
    faults: tuple[str, ...]
    neighbours: tuple[str, ...]
    origin: IntArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", ints(self.origin))

    def __repr__(self) -> str:
        faults = ", ".join(self.faults) or "no fault"
        return f"Block {self.name!r}: volume {self.volume:.6g}, bounded by {faults}"


def fault_blocks(
    model: Model | Sequence[Surface],
    top: float | None = None,
    bottom: float | None = None,
    outline: FloatArray | None = None,
    margin: float = 0.0,
) -> tuple[Block, ...]:
    """Return the blocks into which faults part the prism between two depths.

    The faults and the prism are refined to one complex by exact arithmetic; its cells are the blocks. A fault
    that ends inside the prism parts nothing by itself, so that what lies on both sides of it is one block; a
    fault parts where its rim lies outside the prism, or on other faults. One that stops short of another, by
    however little, does not reach it: see the check near-miss.

    Parameters
    ----------
    model : Model or sequence of Surface
        A model, or the fault surfaces alone.
    top, bottom : float, optional
        Elevations of head and foot, model units; default the highest and the lowest point of all surfaces.
    outline : (n, 2) array, optional
        Corners of the outline in plan, model units; default the outer boundaries of the horizons together,
        where there is none the upright box about the faults.
    margin : float
        How far that box lies outside the faults, model units; negative where it cuts their ends off.

    Returns
    -------
    tuple of Block
        The largest first. Their volumes add up to that of the prism to 1e-9 of it.

    Raises
    ------
    ModelingError
        When the prism has no inside, a fault crosses itself or has undefined coordinates, or the cells are
        not closed.

    Examples
    --------
    >>> wall = Surface("F", [[1, -1, -2], [1, 3, -2], [1, 3, 2], [1, -1, 2]], [[0, 1, 2], [0, 2, 3]])
    >>> square = np.array([[0.0, 0], [3, 0], [3, 2], [0, 2]])
    >>> for block in fault_blocks([wall], 1.0, 0.0, square):
    ...     print(block)
    Block 'block 1': volume 4, bounded by F
    Block 'block 2': volume 2, bounded by F
    """
    horizons = [h.surface for h in model.horizons] if isinstance(model, Model) else []
    faults = [f.surface for f in model.faults] if isinstance(model, Model) else list(model)
    _reject_unfit([*horizons, *faults])
    high, low = _depths([*horizons, *faults], top, bottom)
    loops = _outline(horizons, faults, margin) if outline is None else _ring(outline)
    return _parted(_prism(loops, low, high), faults)


def shared_depths(model: Model) -> tuple[float, float]:
    """Return the elevations, higher first, between which every fault of the model has points.

    Between the highest and the lowest point of a whole model faults often end inside; here fewer do. The
    first is not above the second where the faults share no depth.
    """
    levels = [f.surface.vertices[:, 2] for f in model.faults if len(f.surface.vertices)]
    if not levels:
        raise ModelingError(f"Model {model.name!r} has no faults whose depths could be shared.")
    return float(min(z.max() for z in levels)), float(max(z.min() for z in levels))


def _reject_unfit(surfaces: Sequence[Surface]) -> None:
    for s in surfaces:
        if not np.isfinite(s.vertices).all():
            raise ModelingError(
                f"{s.name} has undefined coordinates, so that it parts nothing; repair it first "
                "(check finite)."
            )


def _depths(surfaces: Sequence[Surface], top: float | None, bottom: float | None) -> tuple[float, float]:
    """Return the elevations of head and foot."""
    levels = np.concatenate([s.vertices[:, 2] for s in surfaces] or [np.zeros(0)])
    if not len(levels) and (top is None or bottom is None):
        raise ModelingError("There is no surface to take the depths of the blocks from; give top and bottom.")
    high = float(levels.max()) if top is None else float(top)
    low = float(levels.min()) if bottom is None else float(bottom)
    if not low < high:
        raise ModelingError(
            f"The top of the blocks, elevation {high:g}, must lie above their bottom, {low:g}; "
            "z counts upwards here."
        )
    return high, low


def _outline(horizons: Sequence[Surface], faults: Sequence[Surface], margin: float) -> list[FloatArray]:
    """Return the corners of the outline, counter-clockwise, one array (n, 2) for each of its parts."""
    if horizons:
        areas = [
            shapely.union_all(shapely.polygonize(shapely.linestrings(h.vertices[rim, :2])).geoms)
            for h in horizons
            if len(rim := boundary_edges(h.triangles))
        ]
        # Holes are places without data, not places without rock.
        parts = shapely.get_parts(shapely.union_all(areas))
        return [loop for part in parts for loop in _ring(shapely.get_coordinates(part.exterior))]
    points = np.concatenate([f.vertices[:, :2] for f in faults] or [np.zeros((0, 2))])
    if not len(points):
        raise ModelingError("There is no surface to take the outline of the blocks from; give an outline.")
    (x0, y0), (x1, y1) = points.min(axis=0) - margin, points.max(axis=0) + margin
    return _ring(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]))


def _ring(corners: FloatArray) -> list[FloatArray]:
    """Return the corners of one ring, counter-clockwise and without the first again at the end."""
    ring = np.asarray(corners, dtype=np.float64).reshape(-1, 2)
    ring = ring[:-1] if len(ring) > 1 and (ring[0] == ring[-1]).all() else ring
    if len(ring) < 3 or not np.isfinite(ring).all() or not shapely.Polygon(ring).is_valid:
        raise ModelingError(
            "The outline of the blocks must be a ring of three corners or more that does not cross itself."
        )
    return [ring if shapely.is_ccw(shapely.linearrings(ring)) else ring[::-1]]


def _prism(loops: Sequence[FloatArray], low: float, high: float) -> Prism:
    starts = np.cumsum([0] + [len(loop) for loop in loops])
    edges = [
        start + np.stack([np.arange(len(loop)), np.roll(np.arange(len(loop)), -1)], axis=1)
        for start, loop in zip(starts, loops, strict=False)
    ]
    nodes = np.concatenate(loops) if loops else np.zeros((0, 2))
    return prism("the blocks", nodes, np.concatenate(edges) if edges else np.zeros((0, 2), int), low, high)


def _parted(whole: Prism, faults: Sequence[Surface]) -> tuple[Block, ...]:
    """Return the blocks of a prism."""
    low, high = whole.surface.vertices.min(axis=0), whole.surface.vertices.max(axis=0)
    for fault in faults:
        _reject_crossed(fault, low, high)
    sheets = parting_sheets(whole, faults)
    beside = cells(sheets.vertices, sheets.triangles)
    outside = beside[np.flatnonzero(sheets.owner == len(faults))[:1], 0]
    size = volume(whole.surface)
    blocks = {
        cell: _block(sheets, beside, cell, [f.name for f in faults])
        for cell in np.unique(beside).tolist()
        if cell not in outside
    }
    missed = abs(sum(b.volume for b in blocks.values()) / size - 1.0)
    if not missed <= ADD_UP or not all(bounds_solid(b.surface) for b in blocks.values()):
        meeting = [f.name for k, f in enumerate(faults) if (sheets.owner == k).any()]
        raise ModelingError(
            f"The blocks of {', '.join(meeting) or 'no fault'} are not closed (their volumes miss the whole "
            f"by {missed:.2g} of it): the faults meet improperly; repair the model, or take other depths."
        )
    return _named(blocks, beside, size)


def _reject_crossed(fault: Surface, low: FloatArray, high: FloatArray) -> None:
    """Raise if a fault crosses itself in the box of the prism, where its two sides are not defined."""
    corners = fault.vertices[fault.triangles]
    near = ((corners.max(axis=1) >= low) & (corners.min(axis=1) <= high)).all(axis=1)
    if not near.any():
        return
    size = float(np.linalg.norm(np.ptp(corners[near].reshape(-1, 3), axis=0)))
    count = len(crossings(Surface(fault.name, fault.vertices, fault.triangles[near]), TOUCH * size).pairs)
    if count:
        raise ModelingError(
            f"{fault.name} crosses itself (pairs of triangles: {count}), so that its two sides "
            "are not defined; repair it first (check self-intersection)."
        )


def _block(sheets: Sheets, beside: IntArray, cell: int, names: Sequence[str]) -> Block:
    """Return the block of one cell; its name and neighbours follow when all are known."""
    before, behind = (beside == cell).T
    front, back = before & ~behind, behind & ~before
    triangles = np.concatenate([sheets.triangles[front][:, ::-1], sheets.triangles[back]])
    owner = np.concatenate([sheets.owner[front], sheets.owner[back]])
    used, local = np.unique(triangles, return_inverse=True)
    surface = Surface(str(cell), sheets.vertices[used], local.reshape(-1, 3))
    mine = [k for k in np.unique(owner) if k < len(names)]
    origin = np.full(len(names) + 1, -1)
    origin[mine] = np.arange(len(mine))
    return Block(str(cell), surface, volume(surface), tuple(names[k] for k in mine), (), origin[owner])


def _named(blocks: Mapping[int, Block], beside: IntArray, size: float) -> tuple[Block, ...]:
    """Return the blocks, given by their cells, in their order, with names and neighbours."""

    def rank(cell: int) -> tuple[float, ...]:
        block = blocks[cell]
        return -round(block.volume / size / _SAME_SIZE), *block.surface.vertices.mean(axis=0).tolist()

    ranked = sorted(blocks, key=rank)
    place = {cell: k for k, cell in enumerate(ranked)}
    meeting = {(a, b) for a, b in np.unique(beside, axis=0).tolist() if a != b and a in place and b in place}
    meeting |= {(b, a) for a, b in meeting}
    names = [f"block {k}" for k in range(1, len(ranked) + 1)]
    return tuple(
        replace(
            blocks[cell],
            name=name,
            surface=replace(blocks[cell].surface, name=name),
            neighbours=tuple(names[k] for k in sorted(place[b] for a, b in meeting if a == cell)),
        )
        for cell, name in zip(ranked, names, strict=True)
    )
