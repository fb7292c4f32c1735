"""A headless Chromium with a software renderer, which asks nothing of the network to start."""

from __future__ import annotations

import os
import shutil
from typing import Any
from unittest.mock import patch

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
#: Seconds after which a page that does not draw has failed: with a software renderer on a busy machine.
PATIENCE = 100


def programs() -> tuple[str, str] | None:
    """Return the browser and its driver; None where one of them is not installed."""
    driver = shutil.which("chromedriver")
    program = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    return None if driver is None or program is None else (program, driver)


def started(width: int = 720, height: int = 760) -> Any:
    """Return a running browser whose logs of the console and of requests are kept."""
    from selenium import webdriver

    found = programs()
    assert found is not None
    options = webdriver.ChromeOptions()
    options.binary_location = found[0]
    switches = ["headless=new", f"window-size={width},{height}", "use-gl=angle", "use-angle=swiftshader"]
    switches += ["enable-unsafe-swiftshader", "disable-dev-shm-usage", "disable-background-networking"]
    switches += ["hide-scrollbars"]
    if getattr(os, "geteuid", lambda: 1)() == 0:
        switches.append("no-sandbox")
    for switch in switches:
        options.add_argument(f"--{switch}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    with patch.dict(os.environ, {"SE_OFFLINE": "true"}):
        browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(executable_path=found[1]))
    browser.get_log("performance")
    browser.set_page_load_timeout(PATIENCE)
    browser.set_script_timeout(PATIENCE)
    return browser


def waited(browser: Any, script: str) -> None:
    """Wait until a script returns something true."""
    from selenium.webdriver.support.ui import WebDriverWait

    WebDriverWait(browser, PATIENCE, poll_frequency=0.1).until(lambda b: b.execute_script(script))


def settled(browser: Any) -> None:
    """Wait until the view has drawn what was asked for: two frames on."""
    frames = "requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 60)));"
    browser.execute_async_script(f"const done = arguments[0]; {frames}")


#: True once the 3D view of a page has drawn.
DRAWN = "return document.getElementById('view3d').dataset.drawn === 'yes'"
