"""Make the pictures of reports: `python docs/make_report_pictures.py [tee] [drogon] [cfm]`.

They are parts of the reports of check, repair and run, as a browser shows them: of a run on the demo model
`tee`, of all three on Drogon, which takes some minutes, and of check and repair on six faults of the
Community Fault Model. The last two lie outside the project; where they are missing, their pictures stay as
they are and the script says so. A Chromium with its chromedriver is needed.
"""

from __future__ import annotations

import base64
import io
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from PIL import Image  # noqa: E402

from tests.reports.chromium import DRAWN, programs, settled, started, waited  # noqa: E402

IMAGES = ROOT / "docs" / "images"
DATA = ROOT.parent / "shared" / "data"
#: Width of the window, pixels of the page.
WIDTH = 960
#: Colours of a picture: a palette makes it a third as large and shows no difference.
COLOURS = 256
#: The faults of the Community Fault Model that are shown, by the beginning of their names.
GROUP = "SAFS-MHFZ"
#: What graben is asked to do with the model.toml of each model.
COMMANDS = {
    "tee": (("run", "-o", "run"),),
    "drogon": (
        ("check", "--profile", "paper", "--html", "check.html"),
        ("repair", "--profile", "paper", "-o", "repair"),
        ("run", "-o", "run"),
    ),
    "cfm": (
        ("check", "--profile", "paper", "--html", "check.html"),
        ("repair", "--profile", "paper", "-o", "repair"),
    ),
}
#: What each picture shows: the report, and in it from the top of the first element to the foot of the last.
PARTS: dict[str, dict[str, tuple[str, str, str]]] = {
    "tee": {
        "map": ("run/report.html", ".verdict", "#maps ~ .choice:not([hidden]) figure"),
        "3d": ("run/report.html", "#view", "#view3d"),
        "products": ("run/report.html", "#products", "#products ~ .wide:last-of-type"),
    },
    "drogon": {
        "drogon-check": ("check.html", ".finding", ".finding"),
        "drogon-repair": ("repair/report.html", "#parts", "#parts ~ .check figure"),
        "drogon-run": ("run/report.html", ".verdict", "#maps ~ .choice:not([hidden]) figure"),
    },
    "cfm": {
        "cfm-map": ("check.html", "#map", "#map ~ *:last-of-type"),
        "cfm-3d": ("check.html", "#view", "#view3d"),
        "cfm-repair": ("repair/report.html", "#parts", "#parts ~ .check figure"),
    },
}

_DROGON = "Data: Drogon, Equinor, CC BY-SA 4.0; this picture is under the same licence."
_CFM = "Data: SCEC Community Fault Model 7.0, BSD-3; Plesch et al. 2007, doi:10.1785/0120050211."
#: What they show, by the names of their files.
PICTURES = {
    "report-map": "Run, demo model tee: the verdict, the figures that stand out, the structure map.",
    "report-3d": "Run, demo model tee: the 3D view, faults and horizon coloured by throw.",
    "report-products": "Run, demo model tee: a link to every file.",
    "report-drogon-check": f"Check, Drogon: a finding, its place, why it matters, what to do. {_DROGON}",
    "report-drogon-repair": f"Repair, Drogon: the fault F2, square to its plane; added is green. {_DROGON}",
    "report-drogon-run": f"Run, Drogon: what to look at first, the map of one of four horizons. {_DROGON}",
    "report-cfm-map": f"Check, six faults of the Community Fault Model ({GROUP}): each finding. {_CFM}",
    "report-cfm-3d": f"Check, the same: faults in space, findings as diamonds. {_CFM}",
    "report-cfm-repair": (
        "Repair, the same: a fault that leaned over at its end, as it is and as it was; blue is how far it "
        f"moved. {_CFM}"
    ),
}


def main(models: list[str]) -> int:
    """Make the reports of the models and write their pictures."""
    if programs() is None:
        print("no Chromium with a chromedriver is installed", file=sys.stderr)
        return 1
    for model in models or PARTS:
        with TemporaryDirectory() as name:
            folder = Path(name)
            if reported(model, folder):
                photographed(folder, PARTS[model])
    return 0


def reported(model: str, folder: Path) -> bool:
    """Make the reports of a model in a folder; a public model that is not there is told and left out."""
    file = folder / "model.toml"
    if model == "tee":
        asked("demo", model, "-o", str(folder / "model"))
        file = folder / "model" / file.name
    elif not (DATA / model).exists():
        print(f"no {model} in the data folder: its pictures stay as they are", file=sys.stderr)
        return False
    elif model == "cfm":
        asked("init", *map(str, sorted((DATA / model).glob(f"{GROUP}-*.ts"))), "-o", str(file))
    else:
        file = DATA / model / file.name
    for verb, *options in COMMANDS[model]:
        asked(verb, str(file), *options, folder=folder)
    return True


def asked(*words: str, folder: Path | None = None) -> None:
    """Run graben in a folder. A check that fails is what is to be shown."""
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    command = [sys.executable, "-m", "graben.cli", *words, "-q"]
    ended = subprocess.run(command, cwd=folder, env={**os.environ, **threads}, check=False).returncode
    if ended not in (0, 1):
        raise SystemExit(f"graben {' '.join(words)} ended with exit code {ended}")


def photographed(folder: Path, parts: Mapping[str, tuple[str, str, str]]) -> None:
    """Write the pictures of the reports in a folder."""
    browser = started(WIDTH, 900)
    for part, (report, first, last) in parts.items():
        browser.get((folder / report).as_uri())
        waited(browser, DRAWN)
        if report.startswith("run"):
            coloured(browser, "throw")
        written(shot(browser, first, last), IMAGES / f"report-{part}.png")
    browser.quit()


def coloured(browser: Any, key: str) -> None:
    """Colour the surfaces of the view by a value, and wait until it is drawn."""
    browser.execute_script(
        "const s = document.getElementById('colouring'); s.value = arguments[0];"
        "s.dispatchEvent(new Event('change', { bubbles: true }));",
        key,
    )
    settled(browser)


def shot(browser: Any, first: str, last: str) -> bytes:
    """Return the page from the top of one element to the foot of another as PNG."""
    box = browser.execute_script(
        "const [a, b] = [...arguments].map((s) => document.querySelector(s).getBoundingClientRect());"
        "return [a.top + scrollY, b.bottom + scrollY];",
        first,
        last,
    )
    clip = {"x": 0, "y": box[0] - 10, "width": WIDTH, "height": box[1] - box[0] + 20, "scale": 1}
    made = browser.execute_cdp_cmd("Page.captureScreenshot", {"captureBeyondViewport": True, "clip": clip})
    return base64.b64decode(made["data"])


def written(picture: bytes, path: Path) -> None:
    """Write a picture with a palette; by the median cut, which keeps the colours of thin lines."""
    image = Image.open(io.BytesIO(picture)).convert("RGB")
    image = image.quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    image.save(path, "png", optimize=True)
    print(path.name, path.stat().st_size)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
