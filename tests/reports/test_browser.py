"""The reports in a browser: no error, no request, the 3D view draws, switches work."""

from __future__ import annotations

import base64
import io
import json
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import graben
from graben.demo import build as demo
from graben.demo import write as write_demo
from graben.model import Model
from graben.pipeline import build, examine
from graben.reports.check_html import check_html
from graben.reports.html import report_html
from graben.reports.repair_html import repair_html
from tests.reports import sample
from tests.reports.chromium import DRAWN as HAS_DRAWN
from tests.reports.chromium import programs, settled, started, waited
from tests.reports.test_html import everything

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
#: A dot differs from another where one of its colours does by more than this.
VISIBLE = 24
#: Width of a sheet of A4 without its margins, 182 mm, dots.
A4 = 688
#: Least shares of dots of the view: that anything draws; that a switch changes.
DRAWN, CHANGED = 0.02, 0.002
#: A group of the CFM: three faults that meet, none of them large.
GROUP = "CRFA-BPPM-*.ts"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    pytest.importorskip("selenium", reason="selenium is not installed")
    if programs() is None:
        pytest.skip("no Chromium with a chromedriver is installed")
    running = started()
    yield running
    running.quit()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("pages")


def real(name: str) -> Model:
    """A data set beside the project; the horizon that is cut alone."""
    path = DATA / name / "model.toml"
    if not path.exists():
        pytest.skip(f"no {name} in the data folder")
    return graben.read_model(path)


def cfm(folder: Path) -> Model:
    files = sorted((DATA / "cfm").glob(GROUP))
    if not files:
        pytest.skip("no cfm in the data folder")
    text = '[model]\nname = "CFM"\n' + "".join(f'[[faults]]\nfile = "{file}"\n' for file in files)
    (folder / "cfm.toml").write_text(text, encoding="utf-8")
    return graben.read_model(folder / "cfm.toml")


@cache
def cross(folder: Path) -> Model:
    write_demo(demo("cross"), folder / "cross")
    return graben.read_model(folder / "cross" / "model.toml")


def ran(model: Model, *, mend: bool = True) -> str:
    return report_html(build(model, mend=mend), {})


def alone(model: Model, name: str) -> Model:
    """A model with one of its horizons."""
    return replace(model, horizons=tuple(h for h in model.horizons if h.name == name))


#: In an order that opens a page once for several tests.
PAGES = {
    "run-odd-names": lambda folder: everything(),
    "check-cross": lambda folder: check_html(examine(cross(folder))),
    "repair-cross": lambda folder: repair_html(graben.repair(cross(folder))),
    "run-claudius": lambda folder: ran(alone(real("claudius"), "D")),
    "run-drogon": lambda folder: ran(alone(real("drogon"), "TopVolon"), mend=False),
    "check-cfm": lambda folder: check_html(examine(cfm(folder))),
    "run-cross": lambda folder: ran(cross(folder)),
}


@cache
def page(name: str, folder: Path) -> Path:
    path = folder / f"{name}.html"
    path.write_text(PAGES[name](folder), encoding="utf-8", newline="\n")
    return path


def opened(browser: Any, path: Path) -> None:
    """Open a page and wait until its view has drawn, unless it is open already."""
    if browser.current_url == path.as_uri():
        return
    for log in ("browser", "performance"):
        browser.get_log(log)
    browser.get(path.as_uri())
    waited(browser, HAS_DRAWN)


def dots(browser: Any) -> np.ndarray:
    """Return the view as it is seen, without its buttons and axes at the rim: (rows, columns, 3)."""
    settled(browser)
    view = browser.find_element("id", "view3d")
    browser.execute_script("arguments[0].scrollIntoView({ block: 'center' })", view)
    picture = np.asarray(Image.open(io.BytesIO(view.screenshot_as_png)).convert("RGB"), dtype=int)
    rows, columns = picture.shape[:2]
    return picture[rows // 5 : -rows // 5, columns // 5 : -columns // 5]


def share(one: np.ndarray, other: np.ndarray) -> float:
    """Return which share of the dots differs."""
    return float((np.abs(one - other).max(axis=2) > VISIBLE).mean())


def background(browser: Any) -> np.ndarray:
    said = browser.execute_script(
        "return getComputedStyle(document.getElementById('view3d')).backgroundColor"
    )
    return np.array([int(n) for n in re.findall(r"\d+", said)[:3]])


def asked(browser: Any) -> list[str]:
    """Return the addresses that the page asked for."""
    events = (json.loads(entry["message"])["message"] for entry in browser.get_log("performance"))
    return [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]


def switch(browser: Any, selector: str) -> None:
    browser.execute_script("document.querySelector(arguments[0]).click()", selector)


def test_one_map_at_a_time_and_all_of_them_on_paper(browser: Any, folder: Path) -> None:
    opened(browser, page("run-odd-names", folder))
    count = "return [...document.querySelectorAll('.choice')].filter((c) => c.offsetHeight > 0).length"
    assert browser.execute_script(count) == 1
    first = browser.execute_script("return document.querySelector('.choice:not([hidden])').id")
    switch(browser, ".choices input:not(:checked)")
    assert browser.execute_script("return document.querySelector('.choice:not([hidden])').id") != first
    closed = "return document.querySelectorAll('details:not([open]):not(.brief)').length"
    before = browser.execute_script(closed)
    assert before > 0
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    assert browser.execute_script(count) == 2
    waited(browser, "return document.querySelector('#still img')?.offsetHeight > 0")
    assert browser.execute_script("return document.querySelector('.controls').offsetHeight") == 0
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    pdf = base64.b64decode(browser.execute_cdp_cmd("Page.printToPDF", {})["data"])
    assert pdf.startswith(b"%PDF")
    browser.execute_script("dispatchEvent(new Event('beforeprint'))")
    assert browser.execute_script(closed) == 0
    browser.execute_script("dispatchEvent(new Event('afterprint'))")
    assert browser.execute_script(closed) == before


def test_tables_fit_on_paper(browser: Any, folder: Path) -> None:
    files = {key: f"horizons/Top_A.{key}" for key in ("surface", "vtp", "grid", "cutoffs", "polygons", "pol")}
    path = folder / "on-paper.html"
    path.write_text(report_html(sample.run_result(), {"Top A": files}), encoding="utf-8")
    opened(browser, path)
    size = {"width": A4, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    try:
        right = "return [...document.querySelectorAll('table')].map((t) => t.getBoundingClientRect().right)"
        assert max(browser.execute_script(right)) <= A4
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.mark.parametrize("name", PAGES)
def test_report_opens_draws_and_asks_for_nothing(browser: Any, folder: Path, name: str) -> None:
    path = page(name, folder)
    assert path.stat().st_size < 10_000_000
    opened(browser, path)
    errors = [e["message"] for e in browser.get_log("browser") if e["level"] == "SEVERE"]
    assert errors == []
    addresses = asked(browser)
    assert path.as_uri() in addresses
    assert [a for a in addresses if not a.startswith(("file:", "data:", "blob:"))] == []
    full = dots(browser)
    assert share(full, background(browser)) > DRAWN
    # Every surface switched off, nothing of them is left.
    boxes = "[...document.querySelectorAll('.controls [data-traces]')]"
    hide = f"return {boxes}.map((b) => {{ const was = b.checked; if (was) b.click(); return was; }})"
    shown = browser.execute_script(hide)
    assert any(shown)
    empty = dots(browser)
    assert share(full, empty) > CHANGED
    assert share(empty, background(browser)) < share(full, background(browser))
    browser.execute_script(f"{boxes}.forEach((b, k) => {{ if (arguments[0][k]) b.click(); }})", shown)
    assert browser.execute_script(f"return {boxes}.map((b) => b.checked)") == shown
    # Nothing is wider than the window but what scrolls by itself.
    wide = browser.execute_script("return document.documentElement.scrollWidth - innerWidth")
    assert wide <= 0


def test_skip_link_and_focus_can_be_seen(browser: Any, folder: Path) -> None:
    from selenium.webdriver.common.keys import Keys

    browser.get("about:blank")  # where the page is open already, something in it has been clicked
    opened(browser, page("run-cross", folder))
    browser.find_element("tag name", "body").send_keys(Keys.TAB)
    active = browser.switch_to.active_element
    assert active.get_attribute("class") == "skip"
    assert active.rect["x"] >= 0
    active.send_keys(Keys.ENTER)
    assert browser.execute_script("return document.activeElement.id") == "main"
    for _ in range(3):
        browser.switch_to.active_element.send_keys(Keys.TAB)
        width = browser.execute_script("return getComputedStyle(document.activeElement).outlineWidth")
        assert float(width.removesuffix("px")) >= 2.0


def test_view_answers_every_switch_and_the_keyboard(browser: Any, folder: Path) -> None:
    opened(browser, page("run-cross", folder))
    before = dots(browser)
    choose = (
        "const s = document.getElementById(arguments[0]); s.value = arguments[1];"
        "s.dispatchEvent(new Event('change', { bubbles: true }));"
    )
    options = browser.execute_script(
        "return [...document.querySelectorAll('#colouring option')].map((o) => o.value)"
    )
    assert options == ["height", "throw", "move", "subdomain"]
    seen = [before]
    for key, value in [
        *(("colouring", o) for o in options[1:]),
        ("look", "above"),
        ("exaggeration", "10"),
        ("veil", "20"),
    ]:
        browser.execute_script(choose, key, value)
        now = dots(browser)
        assert share(now, seen[-1]) > CHANGED, (key, value)
        seen.append(now)
    browser.find_element("id", "view3d").send_keys("\ue012")  # arrow to the left
    turned = dots(browser)
    assert share(turned, seen[-1]) > CHANGED
    switch(browser, ".buttons [data-near='0.8']")
    assert share(dots(browser), turned) > CHANGED
    switch(browser, "[data-place]")
    assert browser.execute_script("return document.activeElement.id") == "back"
    assert browser.execute_script("return document.activeElement.getAttribute('href')").startswith("#note-")
    switch(browser, "#camera")
    for key, value in (("colouring", "height"), ("exaggeration", "2"), ("veil", "100")):
        browser.execute_script(choose, key, value)
    switch(browser, ".controls [data-traces]:last-of-type")
    assert [e["message"] for e in browser.get_log("browser") if e["level"] == "SEVERE"] == []


def test_page_is_dark_where_the_reader_wants_it(browser: Any, folder: Path) -> None:
    opened(browser, page("run-cross", folder))
    colour = "return getComputedStyle(document.body)[arguments[0]]"

    def light(of: str) -> float:
        return float(np.mean([int(n) for n in re.findall(r"\d+", browser.execute_script(colour, of))[:3]]))

    for scheme, sign in (("light", 1), ("dark", -1)):
        wanted = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", wanted)
        assert sign * (light("backgroundColor") - light("color")) > 150
    assert background(browser).max() < 80
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
