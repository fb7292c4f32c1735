"""Put into the tutorial and the how-to pages what their commands print: `python docs/collect_outputs.py`.

Output that a page shows as it comes stays as it is; a page of which nothing changed is left alone.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.pages import FOLDER, WORKED, renewed, worked_through

#: No page shows this: what says so is to be mended first.
BROKEN = "error of its own"


def main() -> int:
    """Run the pages and write what came."""
    for page in WORKED:
        with TemporaryDirectory() as name:
            folder = Path(name) / FOLDER
            folder.mkdir()
            text = page.read_text(encoding="utf-8")
            done = list(worked_through(text, folder))
        for each in done:
            if BROKEN in each.came:
                raise SystemExit(f"{page.name}, which stays as it is: {each.command}\n{each.came}")
            if not each.true:
                print(f"{page.name}: {each.command.splitlines()[0]}")
        page.write_text(renewed(text, done), encoding="utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
