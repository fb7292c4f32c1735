"""Draw what theta and the length do, for theta.md: `python docs/make_theta_pictures.py`.

Two pictures: sections across the middle of the fault of the demo model `single` for seven thetas, and the
errors of six models against the one length that theta and l mean together (its runs take some minutes).
`sections` or `errors` behind the command makes one of them.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

for _library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import numpy as np  # noqa: E402
import pandas  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent))

from graben.arrays import FloatArray  # noqa: E402
from graben.demo import SyntheticModel  # noqa: E402
from graben.demo import build as demo  # noqa: E402
from graben.modeling.results import HorizonResult  # noqa: E402
from graben.reports.images import png_bytes  # noqa: E402
from graben.reports.section import Plane, cut_by  # noqa: E402
from graben.reports.style import CYCLE, FAULT, FOOT, HANGING, INPUT, styled  # noqa: E402
from tests.bench.energies import MODELS, NOISES, THETAS, Energy, Ready, mean_by, study  # noqa: E402

if TYPE_CHECKING:
    from matplotlib.axes import Axes

IMAGES = DOCS / "images"
DPI = 110
#: Colour of what is true, and of the zone that is rebuilt.
TRUTH, ZONE = "#7FC8A9", "#F1EDE2"
#: Half the width of a section in gammas, its lowest and highest elevation (m), and its exaggeration.
HALF_WIDTH, LOW, HIGH, EXAGGERATION = 2.0, -1650.0, -1350.0, 4.0
#: Where the lengths 0 and infinity stand on the logarithmic axis, and its other ticks, in gammas.
NONE, ENDLESS, TICKS = 0.03, 100.0, (0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
ERROR_TICKS = (2, 3, 5, 10, 20, 50, 100)

#: What they show, by the names of their files.
PICTURES = {
    "theta-sections": "Seven sections across the fault of the model single, one for each theta.",
    "theta-errors": "Errors of the cutoffs against the one length that theta and l mean, for three noises.",
}


def main() -> int:
    """Write the pictures and say how large they are."""
    drawings = {"sections": sections_figure, "errors": errors_figure}
    for name in sys.argv[1:] or drawings:
        target = IMAGES / f"theta-{name}.png"
        target.write_bytes(png_bytes(drawings[name](), DPI))
        print(f"{target.name}: {target.stat().st_size / 1000:.0f} kB")
    return 0


@styled
def sections_figure() -> Figure:
    """Return a section for each theta, all at one scale, and a legend."""
    made = demo("single")
    ready = Ready.of(made)
    fault = made.geology.faults[0]
    plane = Plane(np.asarray(fault.centre), fault.axes[1])
    figure = Figure(figsize=(9.6, 5.1), layout="constrained")
    axes = figure.subplots(2, 4, sharex=True, sharey=True).ravel()
    for ax, theta in zip(axes, THETAS, strict=False):
        energy = Energy(theta)
        result = ready.solved(energy, fit=True)
        _section(ax, made, plane, result)
        throw = np.interp(0.0, *_throw_along(result, plane))
        one = "no length" if theta == 0 else f"L = {energy.one_length:.2g} γ"
        one = "L = ∞" if theta == 1 else one
        ax.set_title(
            f"θ = {theta:g}{', default' if theta == 0.5 else ''}\n{one}, throw {throw:.0f} m", fontsize=9
        )
    for ax in axes[::4]:
        ax.set_ylabel("elevation [m]")
    for ax in axes[3:7]:
        ax.set_xlabel("distance across the fault [m]")
        ax.xaxis.set_tick_params(labelbottom=True)
    axes[7].set_axis_off()
    _legend(
        axes[7], f"true throw here: {_true_throw(made, plane):.0f} m\nvertical exaggeration {EXAGGERATION:g}"
    )
    figure.suptitle(
        "single: across the middle of the fault, l = 10 γ = 4000 m", x=0.01, ha="left", weight="bold"
    )
    return figure


def _section(axes: Axes, made: SyntheticModel, plane: Plane, result: HorizonResult) -> None:
    """Draw truth, input, result and fault; the fault's middle is at 0, its hanging wall to the right."""
    half = HALF_WIDTH * made.gamma
    axes.axvspan(-made.gamma, made.gamma, color=ZONE, lw=0, zorder=0)
    for x, z in _true_lines(made, plane):
        axes.plot(x, z, color=TRUTH, lw=5.0, solid_capstyle="butt", zorder=2)
    wall, _ = cut_by(plane, made.faults[0])
    axes.plot(*_polyline(wall), color=FAULT, lw=1.4, zorder=3)
    before, _ = cut_by(plane, result.horizon.surface)
    axes.plot(*_polyline(before), color=INPUT, lw=1.1, ls=(0, (4, 2)), zorder=4)
    rebuilt, triangles = cut_by(plane, result.surface)
    side = result.block[result.surface.triangles[triangles], 0].sum(axis=1)
    hanging = np.where(side != 0, side > 0, rebuilt[..., 0].mean(axis=1) > 0)
    for mine, colour in ((~hanging, FOOT), (hanging, HANGING)):
        axes.plot(*_polyline(rebuilt[mine]), color=colour, lw=1.8, zorder=5)
    axes.set(xlim=(-half, half), ylim=(LOW, HIGH), aspect=EXAGGERATION)


def _true_lines(made: SyntheticModel, plane: Plane) -> list[tuple[FloatArray, FloatArray]]:
    """Return distance and elevation of the true horizon on each side, up to the fault."""
    x = np.linspace(-HALF_WIDTH * made.gamma, HALF_WIDTH * made.gamma, 2001)
    xy = plane.origin + x[:, None] * plane.along
    fault = made.geology.faults[0]
    wall = fault.elevation_at(*fault.coordinates(xy))
    lines = []
    for block, (sign,) in enumerate(made.geology.blocks):
        z = made.horizon(block, xy)
        kept = sign * (z - wall) >= 0
        lines.append((x[kept], z[kept]))
    return lines


def _true_throw(made: SyntheticModel, plane: Plane) -> float:
    (_, right), (_, left) = sorted(_true_lines(made, plane), key=lambda line: -line[0].mean())
    return float(left[-1] - right[0])


def _throw_along(result: HorizonResult, plane: Plane) -> tuple[FloatArray, FloatArray]:
    """Return the distances of the rows of the only cutoff from the section, ascending, and their throws."""
    (cutoff,) = result.cutoffs
    _, off = plane.coordinates((cutoff.hanging + cutoff.foot) / 2)
    order = np.argsort(off)
    return off[order], cutoff.throw[order]


def _polyline(segments: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return segments that hang together as one line, by distance."""
    points = segments.reshape(-1, 2)
    points = points[np.argsort(points[:, 0], kind="stable")]
    return points[:, 0], points[:, 1]


def _legend(axes: Axes, text: str) -> None:
    handles = [
        Line2D([], [], color=TRUTH, lw=5.0, label="true horizon"),
        Line2D([], [], color=INPUT, lw=1.1, ls=(0, (4, 2)), label="input, smeared across the fault"),
        Line2D([], [], color=FOOT, lw=1.8, label="result, footwall"),
        Line2D([], [], color=HANGING, lw=1.8, label="result, hanging wall"),
        Line2D([], [], color=FAULT, lw=1.4, label="fault, dip 60°"),
        Patch(color=ZONE, label="zone rebuilt, γ = 400 m each side"),
    ]
    axes.legend(handles=handles, loc="upper left", borderaxespad=0.0, handlelength=1.6)
    axes.text(0.02, 0.12, text, transform=axes.transAxes, fontsize=8)


@styled
def errors_figure() -> Figure:
    """Return the cutoff errors against the one length, for each noise, fitted and interpolated."""
    rows = study(MODELS)
    figure = Figure(figsize=(7.6, 4.6), layout="constrained")
    axes = figure.add_subplot()
    for noise, colour in zip(NOISES, (CYCLE[0], CYCLE[5], CYCLE[1]), strict=True):
        for fit, dash in ((True, "-"), (False, "--")):
            if noise or fit:
                mine = rows[(rows["fit"] == fit) & (rows["noise"] == noise)]
                _curve(axes, mean_by(mine, "energy")["cutoff, m"], color=colour, ls=dash)
    default = Energy(0.5).one_length
    axes.axvline(default, color=INPUT, lw=6.0, alpha=0.25, zorder=1)
    axes.annotate(
        "default", (default, 0.97), xycoords=("data", "axes fraction"), ha="center", va="top", fontsize=8
    )
    axes.set(xscale="log", yscale="log", xlim=(NONE / 1.5, ENDLESS * 1.5), ylim=(1.6, 110.0))
    axes.set_xticks([NONE, *TICKS, ENDLESS], ["0", *(f"{t:g}" for t in TICKS), "∞"])
    axes.set_yticks(ERROR_TICKS, [str(t) for t in ERROR_TICKS])
    axes.minorticks_off()
    axes.set_xlabel("length L = l √(θ / (1 − θ)), in γ")
    axes.set_ylabel("cutoff error, rms, mean of six models [m]")
    above = axes.secondary_xaxis("top")
    above.set_xticks([_place(Energy(t)) for t in THETAS], [f"{t:g}" for t in THETAS])
    above.minorticks_off()
    above.set_xlabel("θ, where l = 10 γ (the default)")
    handles = [
        Line2D([], [], color=CYCLE[0], label="no noise"),
        Line2D([], [], color=CYCLE[5], label="noise of 2 m, fitted (default)"),
        Line2D([], [], color=CYCLE[5], ls="--", label="noise of 2 m, interpolated"),
        Line2D([], [], color=CYCLE[1], label="noise of 5 m, fitted (default)"),
        Line2D([], [], color=CYCLE[1], ls="--", label="noise of 5 m, interpolated"),
    ]
    axes.legend(handles=handles, loc="lower left")
    return figure


def _curve(axes: Axes, errors: pandas.Series[float], **style: Any) -> None:
    x = [_place(energy) for energy in errors.index]
    axes.plot(x, errors.to_numpy(), marker="o", ms=3.5, lw=1.6, **style)


def _place(energy: Energy) -> float:
    return float(np.clip(energy.one_length, NONE, ENDLESS))


if __name__ == "__main__":
    sys.exit(main())
