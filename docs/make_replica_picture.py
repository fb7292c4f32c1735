"""Draw the models of the catalogue that have no pictures of their own: `python docs/make_replica_picture.py`.

Small maps side by side: three variants of the simple models, and the replicas of the paper's seven. It takes
some minutes.
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
from matplotlib.figure import Figure  # noqa: E402

import graben  # noqa: E402
from graben.demo_by_name import build as demo  # noqa: E402
from graben.demo_by_name import write as write_demo  # noqa: E402
from graben.modeling.results import HorizonResult  # noqa: E402
from graben.replica_list import REPLICAS  # noqa: E402
from graben.reports.images import png_bytes  # noqa: E402
from graben.reports.style import FOOT, HANGING, elevation_colours, styled  # noqa: E402

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TARGET = Path(__file__).resolve().parent / "images" / "replicas.png"
DEMOS = ("exit-both", "elliptic", "short")
DPI, ACROSS, CONTOURS = 90, 5, 12
#: What it shows, by the name of its file.
PICTURES = {
    TARGET.stem: "Three variants of the simple models, and the replicas of the paper's seven: contours of "
    "the rebuilt horizon, hanging wall cutoffs orange, footwall cutoffs blue."
}


def main() -> int:
    """Write the picture."""
    made = {}
    for name in (*DEMOS, *REPLICAS):
        print("run", name, file=sys.stderr)
        made[name] = rebuilt(name)
    TARGET.write_bytes(png_bytes(maps_figure(made), DPI))
    print(f"{TARGET.name}: {TARGET.stat().st_size / 1000:.0f} kB")
    return 0


def rebuilt(name: str) -> HorizonResult:
    """Return the horizon of a model of the catalogue, or of a replica."""
    with TemporaryDirectory() as folder:
        write_demo(demo(name), Path(folder))
        (horizon,) = graben.build(graben.read_model(Path(folder) / "model.toml")).horizons
        return horizon


@styled
def maps_figure(horizons: dict[str, HorizonResult]) -> Figure:
    """Return the maps side by side, each at a scale of its own."""
    figure = Figure(figsize=(11.0, 5.8), layout="constrained")
    places = figure.subplots(-(-len(horizons) // ACROSS), ACROSS, subplot_kw={"aspect": "equal"}).ravel()
    for axes, (name, horizon) in zip(places, horizons.items(), strict=True):
        _map(axes, horizon)
        faults = len(horizon.graph_faults)
        axes.set_title(f"{name}: {faults} {'fault' if faults == 1 else 'faults'}", fontsize=9)
    return figure


def _map(axes: Axes, horizon: HorizonResult) -> None:
    x, y, z = horizon.surface.vertices.T
    axes.tricontourf(x, y, horizon.surface.triangles, z, levels=CONTOURS, cmap=elevation_colours())
    for cutoff in horizon.cutoffs:
        for lip, colour in ((cutoff.hanging, HANGING), (cutoff.foot, FOOT)):
            axes.plot(*lip[:, :2].T, color=colour, lw=1.0)
    axes.set_axis_off()
    wide = float(np.ptp(x))
    axes.text(x.min(), y.min(), f"{wide / 1000:.1f} km wide", fontsize=7, va="top")


if __name__ == "__main__":
    sys.exit(main())
