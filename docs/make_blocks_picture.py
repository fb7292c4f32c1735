"""Draw the blocks of two crossing faults, moved apart: `python docs/make_blocks_picture.py`."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")

import matplotlib.pyplot as plt
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from graben import demo
from graben.cleaning.blocks import fault_blocks

#: Half the side of the outline about the crossing, m: all of it lies within the tips of both faults.
HALF = 700.0
CENTRE = np.array([4500.0, 4050.0])
TOP, BOTTOM = -1250.0, -1750.0
#: How far the blocks are moved apart, as a share of their distance from the middle.
APART = 0.35
COLOURS = ("#4c78a8", "#f2a65a", "#6aa56e", "#b279a2")
#: What it shows, by the name of its file.
PICTURES = {
    "blocks-cross": "The four blocks of two crossing faults, moved apart, with their shares of the volume."
}


def main() -> int:
    """Write the picture."""
    made = demo.build("cross")
    outline = CENTRE + HALF * np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
    blocks = fault_blocks(made.faults, TOP, BOTTOM, outline)
    middle = np.append(CENTRE, 0.5 * (TOP + BOTTOM))
    axes = plt.figure(figsize=(6.4, 4.2)).add_subplot(projection="3d", computed_zorder=False)
    light = mpl.colors.LightSource(azdeg=240, altdeg=50)
    # matplotlib draws in the order given: the farthest, which is the most northern, first
    ordered = sorted(zip(blocks, COLOURS, strict=False), key=lambda b: -b[0].surface.vertices[:, 1].mean())
    for block, colour in ordered:
        solid = block.surface
        away = solid.vertices.mean(axis=0) - middle
        corners = (solid.vertices + APART * away * np.array([1.0, 1.0, 0.0]))[solid.triangles]
        axes.add_collection3d(Poly3DCollection(corners, facecolors=colour, shade=True, lightsource=light))
        share = block.volume / sum(b.volume for b in blocks)
        x, y, _ = corners.reshape(-1, 3).mean(axis=0)
        label = f"{block.name}: {share:.1%}"
        axes.text(x, y, TOP, label, ha="center", fontsize=8, color="white", zorder=10)
    reach = 1.15 * HALF
    axes.set(xlim=(CENTRE[0] - reach, CENTRE[0] + reach), ylim=(CENTRE[1] - reach, CENTRE[1] + reach))
    axes.set(zlim=(BOTTOM, TOP), box_aspect=(2 * reach, 2 * reach, TOP - BOTTOM))
    axes.view_init(elev=38, azim=-72)
    axes.set_axis_off()
    target = Path(__file__).parent / "images" / "blocks-cross.png"
    axes.figure.savefig(target, dpi=110, bbox_inches="tight", pad_inches=0.0)
    print(f"{target.name}: {', '.join(f'{b.volume:.6g}' for b in blocks)} m3")
    return 0


if __name__ == "__main__":
    sys.exit(main())
