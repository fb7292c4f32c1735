"""Draw what the method works on, for method.md: `python docs/make_method_pictures.py`.

Two pictures of the demo model `tee`: its cut graph on the horizon, and the triangulation of the zone around
the junction, cut open as it is first made and as the iteration leaves it.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

for _library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import numpy as np  # noqa: E402
from matplotlib.collections import LineCollection, PolyCollection  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402

import graben  # noqa: E402
from graben.arrays import FloatArray  # noqa: E402
from graben.cutgraph import NodeKind  # noqa: E402
from graben.demo import build as demo  # noqa: E402
from graben.demo import write as write_demo  # noqa: E402
from graben.modeling.results import HorizonResult  # noqa: E402
from graben.reports.images import png_bytes  # noqa: E402
from graben.reports.style import CYCLE, FOOT, HANGING, INPUT, styled  # noqa: E402

if TYPE_CHECKING:
    from matplotlib.axes import Axes

IMAGES = Path(__file__).resolve().parent / "images"
MODEL, DPI = "tee", 110
#: Colours of what is fixed and of the zone, of their edges, and of the gap.
FIXED, ZONE, EDGES = "#F2F2EE", "#DCE9F5", "#9AA7B0"
#: Half the side of the part around the junction that is shown, m.
HALF = 700.0
MARKS = {
    NodeKind.INTERIOR: ("o", "#FFFFFF", 14, "interior node"),
    NodeKind.TIP: ("^", CYCLE[2], 70, "tip: an end on the rim of its fault"),
    NodeKind.JUNCTION: ("s", CYCLE[3], 70, "junction: two faults meet"),
}
#: What they show, by the names of their files.
PICTURES = {
    "method-cut-graph": "The cut graph of the demo model tee in plan, and the zone rebuilt around it.",
    "method-zone": "The mesh around the junction: as first made, and with both lips on their faults.",
}


def main() -> int:
    """Write the pictures and say how large they are."""
    with TemporaryDirectory() as folder:
        write_demo(demo(MODEL), Path(folder))
        (horizon,) = graben.build(graben.read_model(Path(folder) / "model.toml")).horizons
    for name, figure in {"cut-graph": graph_figure(horizon), "zone": zone_figure(horizon)}.items():
        target = IMAGES / f"method-{name}.png"
        target.write_bytes(png_bytes(figure, DPI))
        print(f"{target.name}: {target.stat().st_size / 1000:.0f} kB")
    return 0


@styled
def graph_figure(horizon: HorizonResult) -> Figure:
    """Return the cut graph in plan, on the zone that is rebuilt around it."""
    figure = Figure(figsize=(6.4, 6.2), layout="constrained")
    axes = figure.add_subplot(aspect="equal")
    graph = horizon.graph
    _mesh(axes, horizon, horizon.first, edges=False)
    for k, name in enumerate(horizon.graph_faults):
        mine = graph.edges[graph.faults == k]
        lines = graph.nodes[mine][:, :, :2]
        axes.add_collection(LineCollection(lines, colors=CYCLE[k], linewidths=1.8, label=f"trace of {name}"))
    for kind, (mark, colour, size, words) in MARKS.items():
        at = graph.nodes[graph.kinds == kind]
        axes.scatter(*at.T[:2], s=size, marker=mark, c=colour, edgecolors="#222222", zorder=3, label=words)
    low, high = graph.nodes[:, :2].min(axis=0), graph.nodes[:, :2].max(axis=0)
    half = 0.58 * (high - low).max()
    _window(axes, (low + high) / 2, half)
    handles, _ = axes.get_legend_handles_labels()
    zone = [Patch(color=ZONE, label="the zone: within gamma of a trace, rebuilt")]
    figure.legend(handles=[*handles, *zone], loc="outside lower center", ncols=2, frameon=False)
    return figure


@styled
def zone_figure(horizon: HorizonResult) -> Figure:
    """Return the mesh around the junction, as first made and as the iteration leaves it."""
    figure = Figure(figsize=(9.6, 5.4), layout="constrained")
    (junction,) = horizon.graph.nodes[horizon.graph.kinds == NodeKind.JUNCTION]
    titles = "first: cut along the traces", "last: both lips on their faults"
    for axes, points, title in zip(
        figure.subplots(1, 2, subplot_kw={"aspect": "equal"}),
        (horizon.first, horizon.surface.vertices),
        titles,
        strict=True,
    ):
        _mesh(axes, horizon, points, edges=True)
        for side, colour in ((1, HANGING), (-1, FOOT)):
            _lips(axes, horizon, points, side, colour)
        axes.set_title(title)
        _window(axes, junction[:2], HALF)
    handles = [
        Patch(facecolor=FIXED, edgecolor=INPUT, label="outside the zone: fixed"),
        Patch(facecolor=ZONE, edgecolor=INPUT, label="the zone: unknowns"),
        Line2D([], [], color=HANGING, lw=2, label="hanging wall cutoff"),
        Line2D([], [], color=FOOT, lw=2, label="footwall cutoff"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
    return figure


def _mesh(axes: Axes, horizon: HorizonResult, points: FloatArray, edges: bool) -> None:
    """Draw the triangles, the zone in its colour."""
    triangles = horizon.surface.triangles
    known = horizon.fixed[triangles].all(axis=1)
    for which, colour in ((known, FIXED), (~known, ZONE)):
        corners = points[triangles[which], :2]
        line = EDGES if edges else colour
        axes.add_collection(PolyCollection(corners, facecolors=colour, edgecolors=line, linewidths=0.5))


def _lips(axes: Axes, horizon: HorizonResult, points: FloatArray, side: int, colour: str) -> None:
    """Draw the lips of one side along the cut, where the mesh has them at ``points``."""
    for cutoff in horizon.cutoffs:
        lip = cutoff.hanging if side > 0 else cutoff.foot
        at = np.argmin(np.linalg.norm(horizon.surface.vertices[None, :, :] - lip[:, None, :], axis=2), axis=1)
        axes.plot(*points[at, :2].T, color=colour, lw=2.0)


def _window(axes: Axes, middle: FloatArray, half: float) -> None:
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
    axes.set(xlabel="x [m]", ylabel="y [m]")


if __name__ == "__main__":
    sys.exit(main())
