"""Make the pictures of the report of a run: `python docs/make_report_pictures.py [MODEL]`.

They are parts of report.html of a demo model, as a browser shows them. A Chromium with its chromedriver is
needed.
"""

from __future__ import annotations

import base64
import io
import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

for _library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from PIL import Image  # noqa: E402

import graben  # noqa: E402
from graben.demo import build as demo  # noqa: E402
from graben.demo import write as write_demo  # noqa: E402
from graben.pipeline import build  # noqa: E402
from graben.reports.writing import write_run  # noqa: E402
from tests.reports.chromium import DRAWN, programs, settled, started, waited  # noqa: E402

IMAGES = ROOT / "docs" / "images"
#: Width of the window, pixels of the page.
WIDTH = 960
#: What each picture shows: from the top of the first element to the foot of the last.
PARTS = {
    "map": (".verdict", "#maps ~ .choice figure"),
    "3d": ("#view", "#view3d"),
    "products": ("#products", "#products ~ .wide:last-of-type"),
}


def main(model: str = "tee") -> int:
    """Run a demo model and write the pictures of its report."""
    if programs() is None:
        print("no Chromium with a chromedriver is installed", file=sys.stderr)
        return 1
    with TemporaryDirectory() as name:
        folder = Path(name)
        write_demo(demo(model), folder / "model")
        write_run(build(graben.read_model(folder / "model" / "model.toml")), folder / "run")
        browser = started(WIDTH, 900)
        browser.get((folder / "run" / "report.html").as_uri())
        waited(browser, DRAWN)
        coloured(browser, "throw")
        for part, (first, last) in PARTS.items():
            written(shot(browser, first, last), IMAGES / f"report-{part}.png")
        browser.quit()
    return 0


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
    """Write a picture; a palette would cost it the colours of thin lines."""
    Image.open(io.BytesIO(picture)).convert("RGB").save(path, "png", optimize=True)
    print(path.name, path.stat().st_size)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
