"""The closed fault blocks of a repaired model: between which depths, how large, and how they are told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from graben.cleaning.blocks import Block, fault_blocks, shared_depths
from graben.errors import ModelingError
from graben.formats.blocks import TABLE, block_files
from graben.model import Model
from graben.reports.check_parts import MOST_ROWS, told
from graben.reports.plain import named
from graben.reports.style import Frame, placed, rounded
from graben.surface import Surface, triangle_normals
from graben.validators.finite import usable
from graben.words import plural

#: Cubic metres from which on volumes are told in cubic kilometres.
_LARGE = 1e8
#: Share of the volume by which sums of many pyramids differ from rounding alone.
_ROUNDING = 1e-12


@dataclass(frozen=True, eq=False)
class BlocksMade:
    """The blocks of a model, or why there are none.

    Parameters
    ----------
    blocks : tuple of Block
        The largest first; empty where they could not be made.
    top, bottom : float
        Elevations of head and foot of the prism, model units.
    shared : bool
        Whether every fault has points from head to foot; else these are those of the whole model.
    prism_volume : float
        Plan area of the head times the height, cubic model units.
    reason : str
        Why there are no blocks; empty where there are.
    folder : str
        Where their files are, beside the report; empty where none are written.
    """

    blocks: tuple[Block, ...]
    top: float
    bottom: float
    shared: bool
    prism_volume: float
    reason: str = ""
    folder: str = ""

    @property
    def sum_error(self) -> float:
        """By how much the volumes of the blocks together miss that of the prism, as a share of it."""
        return abs(sum(b.volume for b in self.blocks) / self.prism_volume - 1.0)


def blocks_of(model: Model) -> BlocksMade:
    """Return the fault blocks of a model between the depths that all faults share, else its full range."""
    unfit = [s.name for s in model.surfaces if not _fit(s)]
    if unfit:
        reason = f"{named(unfit)}: undefined coordinates or corners; repair this first (check finite)."
        return BlocksMade((), 0.0, 0.0, False, 0.0, reason)
    try:
        depths = shared_depths(model) if model.faults else (0.0, 0.0)
        shared = depths[0] > depths[1]
        blocks = fault_blocks(model, *depths) if shared else fault_blocks(model)
    except ModelingError as error:
        return BlocksMade((), 0.0, 0.0, False, 0.0, str(error))
    levels = np.concatenate([b.surface.vertices[:, 2] for b in blocks])
    # What was asked for; without it the prism itself says where it begins and ends.
    high, low = depths if shared else (float(levels.max()), float(levels.min()))
    return BlocksMade(blocks, high, low, shared, sum(map(_head_area, blocks)) * (high - low))


def _fit(surface: Surface) -> bool:
    """Return whether all coordinates are numbers of this world, and all corners are vertices."""
    t = surface.triangles
    inside = ((t >= 0) & (t < len(surface.vertices))).all()
    return bool(inside and usable(surface.vertices).all())


def _head_area(block: Block) -> float:
    """Return the area of a block's part of the prism's head, square model units."""
    own = block.surface.triangles[block.origin < 0]
    up = 0.5 * triangle_normals(block.surface.vertices, own)[:, 2]
    return float(up[up > 0].sum())


def blocks_entry(made: BlocksMade, model: Model) -> dict[str, Any]:
    """Return what report.json says of the blocks; z counts as in the model file."""
    if made.reason:
        return {"reason": made.reason, "files": []}
    whole = sum(b.volume for b in made.blocks)
    return {
        "top": made.top * model.z_factor + 0.0,
        "bottom": made.bottom * model.z_factor + 0.0,
        "depths": "shared" if made.shared else "full",
        "prism_volume": made.prism_volume,
        "sum_error": made.sum_error,
        "files": [
            {
                "block": block.name,
                "file": f"{made.folder}/{file}",
                "volume": block.volume,
                "share": block.volume / whole,
                "faults": list(block.faults),
                "neighbours": list(block.neighbours),
            }
            for block, file in zip(made.blocks, block_files(made.blocks), strict=True)
        ],
    }


def blocks_words(made: BlocksMade, model: Model) -> str:
    """Return in one sentence how many blocks there are, between which depths, and how they add up."""
    if made.reason:
        return f"No fault blocks: {made.reason}"
    frame, step = Frame.of(model), model.size / 100.0 or 1.0
    high, low = (placed(frame.z_factor * z + 0.0, step) for z in (made.top, made.bottom))
    which = "which every fault reaches" if made.shared else "the full range of the model"
    which += "" if made.shared or not model.faults else ", whose faults share no depths"
    unit = f" {frame.unit}" if frame.unit else ""
    missed = f"but for {made.sum_error:.0e} of it" if made.sum_error > _ROUNDING else "but for rounding"
    said = (
        f"{plural(len(made.blocks), 'fault block')} between {frame.z_name} {high} and {low}{unit} ({which}); "
    )
    if len(made.blocks) > 1:
        said += "their volumes add up to that of the prism"
    else:
        said += "no fault parts it from side to side, and its volume is that of the prism"
    return f"{said}, {_volume(made.prism_volume, frame)}, {missed}."


def blocks_rows(made: BlocksMade, model: Model) -> dict[str, Any]:
    """Return what the page shows: a sentence, rows for the largest blocks, how many have none."""
    frame, whole = Frame.of(model), sum(b.volume for b in made.blocks)
    rows = [
        {
            "name": block.name,
            "volume": _volume(block.volume, frame),
            "share": f"{rounded(100.0 * block.volume / whole)} %",
            "faults": told(_or_none(block.faults)),
            "neighbours": told(_or_none(block.neighbours)),
            "file": f"{made.folder}/{file}",
        }
        for block, file in zip(made.blocks[:MOST_ROWS], block_files(made.blocks), strict=False)
    ]
    more = len(made.blocks) - len(rows)
    sentence = told(blocks_words(made, model))
    return {"sentence": sentence, "rows": rows, "more": max(more, 0), "table": f"{made.folder}/{TABLE}.csv"}


def _or_none(names: Sequence[str]) -> str:
    return named(names) or "–"


def _volume(value: float, frame: Frame) -> str:
    if frame.unit == "m" and value >= _LARGE:
        return f"{rounded(value * 1e-9)} km³"
    if value >= _LARGE:
        return f"{rounded(value * 1e-6)} million {frame.unit}³" if frame.unit else f"{value:.3g}"
    return f"{rounded(value)} {frame.unit}³" if frame.unit else rounded(value)
