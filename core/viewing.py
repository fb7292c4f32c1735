"""The report of a finished run or repair in the browser."""

from __future__ import annotations

import os
import sys
import webbrowser
from pathlib import Path

from graben.errors import InputError
from graben.output import is_partial, partial_of
from graben.reports.check_files import REPORTS

#: Browsers that draw in the terminal: they would hold it, and show no picture.
_IN_TERMINAL = frozenset({"www-browser", "links", "links2", "elinks", "lynx", "w3m", "browsh"})
#: One of these says that there is a screen, or what to open pages with.
_SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")


def report_of(folder: Path) -> Path:
    """Return the report in the folder of a finished run or repair.

    Raises
    ------
    InputError
        When there is none.
    """
    page = folder / "report.html"
    if is_partial(folder) or (not folder.exists() and is_partial(partial_of(folder))):
        raise InputError(f"The run into {folder} has not ended: its report is there when it has.")
    if folder.is_file():
        raise InputError(f"{folder} is a file: give the folder of a run or repair (its -o DIR).")
    try:
        known = REPORTS["html"].ours(page.read_bytes())
    except OSError:
        known = False
    if not known:
        what = "holds no report of graben" if folder.is_dir() else "does not exist"
        raise InputError(f"{folder} {what}: give the folder of a finished run or repair (its -o DIR).")
    return page.absolute()


def opened(address: str) -> bool:
    """Open an address in a browser with a window; return whether there is one."""
    if sys.platform.startswith("linux") and not any(os.environ.get(name) for name in _SCREENS):
        return False
    try:
        browser = webbrowser.get()
    except webbrowser.Error:
        return False
    name = Path(str(getattr(browser, "name", ""))).name
    if name in _IN_TERMINAL:
        return False
    if type(browser) is webbrowser.GenericBrowser:
        # As it stands it would wait until the window is closed.
        browser = webbrowser.BackgroundBrowser([browser.name, *browser.args])
    return bool(browser.open(address))
