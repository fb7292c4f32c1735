"""Make the pictures and the tables of results.md: `python docs/make_pictures.py`.

Each case is run from its model.toml; a structure map, a section and a view in space are drawn from the
result into docs/images, the figures go into docs/scores.md and docs/runs.md. The public data sets lie
outside the project; where they are missing, their pictures stay as they are and the script says so.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

for _library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import numpy as np  # noqa: E402
import pyvista  # noqa: E402

import graben  # noqa: E402
from graben.arrays import FloatArray  # noqa: E402
from graben.demo import build as demo  # noqa: E402
from graben.demo import names as demo_names  # noqa: E402
from graben.demo import write as write_demo  # noqa: E402
from graben.modeling.results import HorizonResult  # noqa: E402
from graben.pipeline import RunResult  # noqa: E402
from graben.reports.images import png_bytes  # noqa: E402
from graben.reports.plan_map import Window, detail_window, map_figure  # noqa: E402
from graben.reports.section import plane_across, section_figure, section_place  # noqa: E402
from graben.reports.style import FOOT, HANGING, Frame, elevation_colours  # noqa: E402
from graben.surface import Surface  # noqa: E402

DOCS = Path(__file__).resolve().parent
IMAGES = DOCS / "images"
#: Resolution of maps and sections, dots per inch; size in which views in space are drawn, pixels.
DPI, SIZE = 100, (1800, 1400)
#: Half the length of a section and margin of a map, in gammas.
HALF_WIDTH, MARGIN = 2.5, 1.0
#: Height of what a view shows over its width, as far as whole exaggerations reach.
HEIGHT, EXAGGERATIONS = 0.35, (1, 2, 3, 5, 10)
#: Contours of a view, radius of its cutoff lines in widths of it, and how close the camera comes.
LEVELS, TUBE, ZOOM = 26, 0.0035, 1.1
#: Width of a written view and height of the line below it, pixels.
WIDTH, FOOTER = 900, 30
FAULT_COLOURS = ("#8C8C8C", "#B08D57", "#6C8EAD", "#9B7FA8", "#7F9B72", "#A3A3A3")


@dataclass(frozen=True)
class Case:
    """Pictures to make: the model and horizon, what they show, and whether the faults fill the map."""

    model: str
    horizon: str
    shows: str
    detail: bool = True
    credit: str = ""

    @property
    def stem(self) -> str:
        """The beginning of its pictures' names."""
        return f"{self.model}-{self.horizon}" if self.model in DATA else self.model


DATA = ("claudius", "drogon", "hecho")
CASES = (
    Case("single", "Top", "One normal fault of 60 degrees, both tips inside."),
    Case("exit", "Top", "The fault leaves the domain at one end."),
    Case("cross", "Top", "Two faults that cross."),
    Case(
        "tee",
        "Top",
        "A branch that ends on the main fault. The throw of the main fault is larger beside the downthrown "
        "block of the branch than beside the other, and the foot of the main fault passes smoothly.",
    ),
    Case("reverse", "Top", "Dip 50, the lips overlap. The view is from the footwall, under the overlap."),
    Case("low-dip", "Top", "Dip 20, the horizon dipping against the fault."),
    Case("low-dip-12", "Top", "The same at 12 degrees."),
    Case(
        "claudius",
        "D",
        "Real seismic of the Carnarvon Basin; z is two-way time times -3. The mounds around are in the data.",
        credit="Data: Claudius3D survey, WesternGeco, courtesy of Geoscience Australia; MIT.",
    ),
    Case(
        "drogon",
        "TopVolon",
        "A synthetic field of six faults, given as sticks of 14 to 31 degrees: a wide gap.",
        detail=False,
        credit="Data: Drogon, Equinor, CC BY-SA 4.0; these three pictures are under the same licence.",
    ),
    Case(
        "hecho",
        "H8",
        "Folded turbidites, 16 units wide. The bay in the outline is where the data have no points.",
        detail=False,
        credit="Data: Hecho, MIT.",
    ),
)
#: How each result is shown.
VIEWS = {"map": "Structure map", "section": "Section where the throw is largest", "3d": "View in space"}
#: What the pictures show, by the names of their files.
PICTURES = {
    f"{case.stem}-{view}": f"{words} of {case.model} {case.horizon}."
    for case in CASES
    for view, words in VIEWS.items()
}


def main() -> None:
    """Run the cases and write what they give."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=DOCS.parent.parent / "shared" / "data")
    parser.add_argument("--images", type=Path, default=IMAGES, help="where the pictures go")
    data, images = (getattr(parser.parse_args(), key) for key in ("data", "images"))
    images.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as folder:
        results = dict(demo_runs(Path(folder)))
        (DOCS / "scores.md").write_text(score_table(results), encoding="utf-8", newline="\n")
        real = dict(real_runs(data))
        if len(real) == len(DATA):
            (DOCS / "runs.md").write_text(run_table(real), encoding="utf-8", newline="\n")
        results |= real
        for case in CASES:
            if case.model in results:
                draw(case, results[case.model], images)


def demo_runs(folder: Path) -> Iterator[tuple[str, RunResult]]:
    """Yield the run of every model of the catalogue, written into ``folder``."""
    for name in demo_names():
        write_demo(demo(name), folder / name)
        print("run", name, file=sys.stderr)
        yield name, graben.build(graben.read_model(folder / name / "model.toml"))


def real_runs(data: Path) -> Iterator[tuple[str, RunResult]]:
    """Yield the run of every data set that is there."""
    for name in DATA:
        model = data / name / "model.toml"
        if not model.exists():
            print(f"no {name} in the data folder: its pictures stay as they are", file=sys.stderr)
            continue
        print("run", name, file=sys.stderr)
        yield name, graben.build(graben.read_model(model))


def score_table(results: dict[str, RunResult]) -> str:
    """Return the errors of the models with a known answer as a table."""
    lines = [
        "| model | cutoffs | throw | zone | zone of the input | iterations |",
        "|---|---|---|---|---|---|",
    ]
    for name, run in results.items():
        (horizon,) = run.horizons
        assert horizon.score is not None
        errors = [f"{e['value']:.2f} m, {e['percent']:.1f} %" for e in horizon.score.as_dict().values()]
        iterations = max(s.iterations for s in horizon.subdomains)
        lines.append(f"| {name} | {' | '.join(errors)} | {iterations} |")
    return "\n".join(lines) + "\n"


def run_table(results: dict[str, RunResult]) -> str:
    """Return how each horizon of the public data sets ended as a table."""
    lines = [
        "| data set | horizon | cut by | iterations | types | largest throw | mean absolute throw |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, run in results.items():
        unit = "" if run.model.unit == "none" else f" {run.model.unit}"
        for wanted in run.model.horizons:
            if wanted.name in run.not_modeled:
                lines.append(f"| {name} | {wanted.name} | not modeled | | | | |")
                continue
            horizon = run[wanted.name]
            throws = np.concatenate([c.throw for c in horizon.cutoffs] or [np.zeros(0)])
            if len(throws) == 0:
                lines.append(f"| {name} | {wanted.name} | not cut | | | | |")
                continue
            cut = ", ".join(dict.fromkeys(c.fault for c in horizon.cutoffs))
            types = ", ".join(str(int(s.termination.type)) for s in horizon.subdomains)
            largest = throws[np.argmax(np.abs(throws))]
            lines.append(
                f"| {name} | {wanted.name} | {cut} | {max(s.iterations for s in horizon.subdomains)} | "
                f"{types} | {largest:.3g}{unit} | {np.abs(throws).mean():.3g}{unit} |"
            )
    return "\n".join(lines) + "\n"


def draw(case: Case, run: RunResult, images: Path) -> None:
    """Write the map, the section and the view in space of a case."""
    horizon = run[case.horizon]
    frame = Frame.of(run.model)
    gammas = {f.name: run.model.gamma(f, horizon.horizon) for f in run.repaired.faults}
    gamma = max(gammas[c.fault] for c in horizon.cutoffs)
    window = detail_window(horizon, MARGIN * gamma) if case.detail else None
    (images / f"{case.stem}-map.png").write_bytes(png_bytes(map_figure(horizon, frame, window), DPI))
    largest = max(horizon.cutoffs, key=lambda c: float(np.abs(c.throw).max()))
    place = section_place(horizon, largest.fault, gammas[largest.fault])
    assert place is not None
    half = HALF_WIDTH * gammas[largest.fault]
    figure = section_figure(horizon, *place, run.repaired.faults, frame, half)
    (images / f"{case.stem}-section.png").write_bytes(png_bytes(figure, DPI))
    view(horizon, run, plane_across(*place).along, window, images / f"{case.stem}-3d.png")
    print("drawn", case.stem, file=sys.stderr)


def view(
    horizon: HorizonResult, run: RunResult, along: FloatArray, window: Window | None, path: Path
) -> None:
    """Write a view in space: the rebuilt horizon by elevation, both cutoffs, the faults that cut it.

    ``along`` (2,) runs across the main fault: the view looks along its strike.
    """
    names = {c.fault for c in horizon.cutoffs}
    vertices = horizon.surface.vertices
    west, east, south, north = window or (*_span(vertices[:, 0]), *_span(vertices[:, 1]))
    inside = (vertices[:, 0] >= west) & (vertices[:, 0] <= east)
    inside &= (vertices[:, 1] >= south) & (vertices[:, 1] <= north)
    low, high = _span(vertices[inside, 2])
    width = max(east - west, north - south)
    exaggeration = max((e for e in EXAGGERATIONS if e * (high - low) <= HEIGHT * width), default=1)
    middle = np.array([(west + east) / 2, (south + north) / 2, (low + high) / 2])
    # Lengths in widths of the view: pyvista draws in single precision.
    stretch = np.array([1.0, 1.0, exaggeration]) / width
    lowest, highest = low - 0.15 * (high - low), high + 0.15 * (high - low)
    corners = np.array([[west, south, lowest], [east, north, highest]])
    box = ((corners - middle) * stretch).T.ravel()

    plotter = pyvista.Plotter(off_screen=True, window_size=list(SIZE))
    surface = Surface(horizon.name, (vertices - middle) * stretch, horizon.surface.triangles)
    mesh = surface.to_pyvista()
    mesh.point_data["z"] = vertices[:, 2]
    mesh = mesh.clip_box(box, invert=False).extract_surface(algorithm="dataset_surface")
    light = {"ambient": 0.45, "diffuse": 0.55, "specular": 0.0}
    plotter.add_mesh(
        mesh, scalars="z", cmap=elevation_colours(), clim=(low, high), show_scalar_bar=False, **light
    )
    lines = mesh.contour(np.linspace(low, high, LEVELS)[1:-1], scalars="z")
    plotter.add_mesh(lines, color="#56676E", line_width=2)
    for number, fault in enumerate(f for f in run.repaired.faults if f.name in names):
        wall = Surface(fault.name, (fault.surface.vertices - middle) * stretch, fault.surface.triangles)
        clipped = wall.to_pyvista().clip_box(box, invert=False)
        colour = FAULT_COLOURS[number % len(FAULT_COLOURS)]
        plotter.add_mesh(clipped, color=colour, opacity=0.4, **light)
    for cutoff in horizon.cutoffs:
        for lip, colour in ((cutoff.hanging, HANGING), (cutoff.foot, FOOT)):
            line = pyvista.lines_from_points((lip - middle) * stretch)
            plotter.add_mesh(line.tube(radius=TUBE), color=colour, **light)
    cutoff = max(horizon.cutoffs, key=lambda c: float(np.abs(c.throw).max()))
    # Into a gap one sees from above the hanging wall, under an overlap from low above the foot wall.
    gap = (cutoff.hanging - cutoff.foot)[:, :2].sum(axis=0)
    across = along if along @ gap > 0 else -along
    towards = np.array([across[1], -across[0]])
    eye = np.array([*(towards + 0.75 * across), 0.85 if cutoff.heave.sum() > 0 else 0.5])
    plotter.camera_position = [tuple(eye), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
    plotter.reset_camera(bounds=mesh.bounds)
    plotter.camera.zoom(ZOOM)
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    label = f"vertical exaggeration {exaggeration}" if exaggeration > 1 else "true scale"
    write_small(plotter.screenshot(return_img=True), label, path)
    plotter.close()


def _span(values: FloatArray) -> tuple[float, float]:
    return float(values.min()), float(values.max())


def write_small(pixels: np.ndarray, label: str, path: Path) -> None:
    """Write a picture on white as PNG with a palette, without its white margins, with a label below."""
    from PIL import Image, ImageChops, ImageDraw

    picture = Image.fromarray(pixels).convert("RGB")
    filled = ImageChops.difference(picture, Image.new("RGB", picture.size, "white")).getbbox()
    picture = picture.crop(filled)
    picture.thumbnail((WIDTH, WIDTH), Image.Resampling.LANCZOS)
    page = Image.new("RGB", (picture.width, picture.height + FOOTER), "white")
    page.paste(picture)
    ImageDraw.Draw(page).text((4, page.height - FOOTER + 8), label, fill="black", font_size=16)
    page.quantize(256, dither=Image.Dither.NONE).save(path, "png", optimize=True)


if __name__ == "__main__":
    main()
