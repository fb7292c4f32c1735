"""Put every picture of the docs into the gallery: `python docs/collect_gallery.py`.

What there is, and what it shows, is told by the scripts that draw the pictures. A test holds the page and the
files in docs/images to them.
"""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

from between_marks import write
from make_pictures import CASES, DATA, VIEWS, Case

DOCS = Path(__file__).resolve().parent
#: The other scripts, with the titles of what they draw.
SCRIPTS = {
    "make_replica_picture": "The other models of the catalogue",
    "make_report_pictures": "Reports",
    "make_repair_pictures": "A repair",
    "make_blocks_picture": "Fault blocks",
    "make_method_pictures": "The method",
    "make_theta_pictures": "Theta and length",
    "make_check_pictures": "Models that fail a check",
}
#: More pictures of a script than these stand side by side, so many of them.
MANY, ACROSS = 9, 3


def page() -> str:
    """Return the gallery."""
    demos = [case for case in CASES if case.model not in DATA]
    real = [case for case in CASES if case.model in DATA]
    parts = [
        "## Models with a known answer",
        "`python docs/make_pictures.py` draws them: structure map, view in space, and the section where the "
        "throw is largest.",
    ]
    parts += [shown(case, f"graben demo {case.model} -o {case.model}") for case in demos]
    parts += ["## Public data", "Drawn by the same script, where the data are there."]
    parts += [shown(case) for case in real]
    for script, title in SCRIPTS.items():
        parts += [f"## {title}", f"`python docs/{script}.py` draws them.", others(script)]
    return "\n\n".join(parts)


def shown(case: Case, *commands: str) -> str:
    """Return the part of a model: what it is, how to make it, its three pictures."""
    title = f"### {case.model}" + (f", horizon {case.horizon}" if case.model in DATA else "")
    lines = "\n".join([*commands, f"graben run {case.model}/model.toml -o result"])
    plan, section, space = (
        f"![{words} of {case.model}](images/{case.stem}-{view}.png)" for view, words in VIEWS.items()
    )
    credit = f"\n\n*{case.credit}*" if case.credit else ""
    return f"{title}\n{case.shows}\n\n```sh\n{lines}\n```\n\n{_rows([plan, space], 2)}\n\n{section}{credit}"


def others(script: str) -> str:
    """Return the pictures of a script, each with what it shows."""
    pictures: dict[str, str] = import_module(script).PICTURES
    if len(pictures) > MANY:
        return _rows(
            [f"![{words}](images/{name}.png)<br>{words}" for name, words in pictures.items()], ACROSS
        )
    return "\n\n".join(f"![{words}](images/{name}.png)\n\n*{words}*" for name, words in pictures.items())


def pictures() -> dict[str, str]:
    """Return every picture that a script draws, with what it shows."""
    found: dict[str, str] = {}
    for script in ("make_pictures", *SCRIPTS):
        found |= import_module(script).PICTURES
    return found


def _rows(cells: list[str], across: int) -> str:
    """Return cells side by side, as a table without heads."""
    rows = [cells[k : k + across] for k in range(0, len(cells), across)]
    filled = [row + [""] * (across - len(row)) for row in rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in [[""] * across, ["---"] * across, *filled])


def pages() -> dict[Path, str]:
    """Return what stands between the marks of each page."""
    return {DOCS / "gallery.md": page()}


if __name__ == "__main__":
    sys.exit(write(pages()))
