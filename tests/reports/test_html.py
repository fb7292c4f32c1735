"""report.html: says the verdict first, asks nothing of the network, shows names as text."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from types import MappingProxyType
from urllib.parse import unquote

import numpy as np
import pytest

from graben.cleaning.ledger import RepairAction, measured
from graben.finding import CheckResult, Finding, Profile, Status
from graben.model import Model
from graben.reports import html
from graben.reports.curve import curve
from graben.reports.fault_rows import lineage_of
from graben.reports.html import report_html
from graben.reports.images import Prints
from graben.reports.model_files import ModelFiles
from graben.reports.page import Room
from graben.reports.run_notes import first_of_kinds, notes
from graben.reports.style import Frame
from graben.reports.summary import verdict
from tests.reports import sample

VOID = {"meta", "link", "img", "input", "br", "wbr"}
LONG = "a horizon of 300 letters, ../slashes\\ \"quotes' & emoji \U0001f30b " * 5


class Page(HTMLParser):
    """Tags with their attributes, and the text outside scripts and styles."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self.open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not {"script", "style"} & set(self.open):
            self.text.append(data)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def __getitem__(self, tag):
        return [attrs for name, attrs in self.tags if name == tag]


@pytest.fixture(scope="module")
def passed() -> str:
    return report_html(sample.run_result(), {"Top A": {"surface": "horizons/Top_A.ts"}})


@pytest.fixture(scope="module")
def evil() -> str:
    run = sample.failed_run(sample.EVIL)
    return report_html(replace(run, model=replace(run.model, name=sample.EVIL)), {})


def test_tags_are_closed_and_ids_are_unique(passed, evil):
    for text in (passed, evil):
        page = Page(text)
        assert page.open == []
        ids = [attrs["id"] for _, attrs in page.tags if "id" in attrs]
        assert len(ids) == len(set(ids))
        targets = {a["href"][1:] for a in page["a"] if a["href"].startswith("#")}
        assert targets <= set(ids)


def test_verdict_is_the_first_line(passed, evil):
    for text, word in ((passed, "Modeled: 1 of 2 horizons"), (evil, "NOT PASSED: ")):
        body = "".join(Page(text).text).split("Skip to the results")[1]
        assert body.strip().startswith(word)


def test_page_asks_nothing_of_the_network(passed):
    page = Page(passed)
    addresses = [a[key] for _, a in page.tags for key in ("src", "href", "data", "action") if a.get(key)]
    assert addresses
    assert all(re.match(r"#|data:|[A-Za-z]+/[\w.]+$|report\.json$", address) for address in addresses)
    assert not re.search(r"https?://(?!www\.w3\.org)", passed.split("<script>", maxsplit=1)[0])
    style = passed.split("<style>")[1].split("</style>")[0]
    assert "url(" not in style
    assert "@import" not in style


def test_names_are_text_everywhere(evil):
    page = Page(evil)
    own = [t for t, _ in page.tags if t == "script"]
    assert len(own) == 4  # plotly.js, the scene, the controls, printing
    assert evil.count('alert("F1")') == 0
    text = "".join(page.text)
    assert sample.EVIL in text
    assert "A cycle of <b>traces</b>." in text
    assert "<script>alert" not in evil
    assert any(sample.EVIL in p["alt"] for p in page["img"])


def test_every_picture_has_words(passed):
    pictures = Page(passed)["img"]
    assert len(pictures) >= 5
    assert all(len(p["alt"]) > 20 and p["src"].startswith("data:image/") for p in pictures)


def test_failed_run_tells_where_and_what_to_do(evil):
    text = "".join(Page(evil).text)
    for words in ("Extend the fault downwards by 40 m", "short by 37.5 m", "elevation -2069", "Look <here>."):
        assert words in text
    assert "Top B is not a function of x and y." in text


def test_two_reports_are_the_same_bytes_and_small(passed):
    again = report_html(sample.run_result(), {"Top A": {"surface": "horizons/Top_A.ts"}})
    assert again == passed
    assert len(passed.encode()) < 10_000_000


def test_true_throw_stands_in_the_throw_figure(passed):
    result = sample.run_result()
    truth = {"Top A": [result.horizons[0].cutoffs[0].throw + 20.0]}
    files = {"Top A": {"surface": "horizons/Top_A.ts"}}
    with_truth = report_html(result, files, truth)
    assert [a == b for a, b in zip(Page(passed)["img"], Page(with_truth)["img"], strict=True)].count(
        False
    ) == 1


def test_run_without_any_surface_has_a_report():
    empty = Model("nothing")
    result = replace(sample.run_result(), model=empty, repaired=empty, horizons=(), repairs=())
    page = Page(report_html(result, {}))
    assert "".join(page.text).count("Nothing was changed.") == 1


def test_verdict_in_words():
    passed, failed = sample.run_result(), sample.failed_run()
    as_it_is = "no fault cuts Top B, which was passed through as it is"
    assert verdict(passed) == f"Modeled: 1 of 2 horizons cut by faults, all converged; {as_it_is}."
    uncut = replace(passed, horizons=passed.horizons[1:], model=sample.model(names=("Top B",)))
    assert verdict(uncut) == f"Modeled: {as_it_is}."
    cut = replace(passed, horizons=passed.horizons[:1], model=sample.model(names=("Top A",)))
    three = replace(passed, horizons=tuple(sample.uncut_result(n) for n in ("A", "B", "C")))
    assert verdict(three) == "Modeled: no fault cuts A, B and C, which were passed through as they are."
    assert verdict(cut) == "Modeled: 1 of 1 horizon cut by faults, all converged."
    assert verdict(failed) == (
        "NOT PASSED: 1 check (acyclic) fails; 1 of 2 horizons (Top A) did not converge everywhere; "
        "1 of 2 horizons (Top B) was not modeled."
    )


def test_verdict_tells_the_ends_of_horizons_apart():
    """One ended with type 3, one with type 0, and four are cut by no fault."""
    stopped, names = sample.failed_run().horizons[0], ("Top B", "Top C", "Top D", "Top E")
    result = replace(
        sample.run_result(),
        model=sample.model(names=("Top A", "Top Z", *names)),
        horizons=(stopped, sample.cut_result("Top Z"), *(sample.uncut_result(n) for n in names)),
    )
    assert verdict(result) == (
        "NOT PASSED: 1 of 6 horizons (Top A) did not converge everywhere; "
        "no fault cuts Top B, Top C, Top D and 1 more, which were passed through as they are."
    )
    line = "no fault cuts it: passed through as it is"
    assert "".join(Page(report_html(result, {})).text).count(line) >= len(names)


def test_report_survives_numbers_that_are_not_finite():
    result = sample.run_result()
    subdomain = replace(result.horizons[0].subdomains[0], history=(1.0, np.nan), mean_deviation=np.nan)
    odd = replace(result, horizons=(replace(result.horizons[0], subdomains=(subdomain,)),))
    assert "nan" not in "".join(Page(report_html(odd, {})).text)


def everything() -> str:
    """A run with odd names everywhere: 300 letters, quotes, slashes, emoji, markup."""
    run = sample.failed_run(LONG)
    first = replace(sample.cut_result(LONG, LONG), warnings=(f"Look at {LONG}.",))
    again = replace(sample.cut_result("Top B", LONG).moved(np.array([0.0, 0.0, -300.0])), score=None)
    model = replace(run.model, name=LONG, faults=(sample.fault(LONG),))
    action = RepairAction("weld", "duplicate", (LONG,), 4, 0.0, (*sample.ORIGIN, -2000.0), f"{LONG}!")
    run = replace(
        run,
        model=model,
        repaired=model,
        horizons=(first, again),
        not_modeled=MappingProxyType({}),
        repairs=(action,),
    )
    files = {LONG: {"surface": "horizons/a b#%?\U0001f30b.ts", "part 1": "parts/a-1.ts"}}
    whole = ModelFiles({"faults": "model/faults.vtu"}, {"resqml": "No <unit>."})
    return report_html(run, files, None, whole, ("throws",))


@pytest.fixture(scope="module")
def odd() -> str:
    return everything()


def test_odd_names_do_no_harm(odd):
    page = Page(odd)
    assert page.open == []
    assert len([t for t, _ in page.tags if t == "script"]) == 4
    assert "".join(page.text).count(LONG.strip()[:40]) > 10
    assert len(odd.encode()) < 10_000_000


def test_links_are_percent_encoded(odd):
    links = [a["href"] for a in Page(odd)["a"] if not a["href"].startswith("#")]
    assert all(re.fullmatch(r"[\w./~-]+(%[0-9A-F]{2}|[\w./~-])*", link) for link in links)
    assert {"horizons/a b#%?\U0001f30b.ts", "model/faults.vtu", "tables/throws.csv"} <= set(
        map(unquote, links)
    )
    assert "No <unit>." in "".join(Page(odd).text)


def test_page_is_usable_by_keyboard_and_ear(odd, passed):
    for text in (odd, passed):
        page = Page(text)
        assert page.tags[[t for t, _ in page.tags].index("a")][1]["class"] == "skip"
        # every input stands in a label of its own, every column and row head says what it is the head of
        labelled = re.findall(r"<label[^>]*>(?:(?!</label>).)*<(?:input|select)", text, flags=re.DOTALL)
        assert len(labelled) == len(page["input"]) + len(page["select"])
        assert all("scope" in head for head in page["th"])
        assert all(b.get("type") == "button" for b in page["button"])
        drawings = [a for t, a in page.tags if t == "svg" and "curve" in (a.get("class") or "")]
        assert drawings
        assert all(a["role"] == "img" and a["aria-label"] for a in drawings)


def test_order_is_verdict_map_view_faults_subdomains_checks_repairs_products(passed):
    heads = re.findall(r'<h2 id="(\w+)"', passed)
    wanted = ["overview", "notes", "maps", "view", "horizons", "faults", "subdomains", "checks", "repairs"]
    assert heads == [*wanted, "products", "settings"]


def test_several_horizons_share_the_place_of_the_map(odd):
    page = Page(odd)
    radios = [i for i in page["input"] if i.get("type") == "radio"]
    assert len(radios) == 2
    assert sum("checked" in i for i in radios) == 1
    ids = {a.get("id") for _, a in page.tags}
    assert {i["value"] for i in radios} <= ids


def test_a_fault_on_two_horizons_has_a_profile_and_an_allan_diagram(odd, passed):
    alts = [p["alt"] for p in Page(odd)["img"]]
    assert sum(a.startswith("Allan diagram") for a in alts) == 1
    assert sum(a.startswith("Throw along the strike") for a in alts) == 1
    assert sum(a.startswith("Equal-area net") for a in alts) == 1
    assert not any(a.startswith("Allan") for a in [p["alt"] for p in Page(passed)["img"]])


def test_what_to_look_at_begins_with_failures_and_one_of_each_kind():
    run = sample.failed_run()
    warned = replace(run.horizons[0], warnings=("First.", "Second."))
    found = notes(replace(run, horizons=(warned,)))
    failures = [n for n in found if n.status is Status.FAIL]
    assert found[: len(failures)] == failures
    words = [n.words for n in failures]
    assert any("type 3" in w and "short by 37.5 m" in w for w in words)
    assert any("Top B is not a function" in w for w in words)
    shown = found[: first_of_kinds(found)]
    assert [n.words for n in found if n not in shown] == ["Second."]


def test_no_name_is_said_twice_in_a_row():
    run = sample.failed_run()
    said = ("Top A lies below Top B in 8 places.", "The throw of F1 on Top A jumps.", "2 holes were filled.")
    found = Finding("near-miss", Status.WARN, ("F1", "F2"), 1, None, "F1 ends short.", "Extend it.")
    result = replace(
        run,
        horizons=(replace(run.horizons[0], warnings=said),),
        after=CheckResult(Profile.EXTENDED, (found,)),
    )
    assert {n.parts for n in notes(result)} >= {
        ("Top A", " lies below Top B in 8 places."),
        ("", "The throw of F1 on Top A jumps."),
        ("Top A.", " 2 holes were filled."),
        ("near-miss: F1, F2.", " F1 ends short."),
    }
    page = report_html(result, {})
    assert "<b>Top A</b> lies below Top B" in page
    spoken = "".join(Page(page).text)
    assert not re.search(r"\b(Top [AB]|F\d)\W{1,3}\1\b", spoken.split("To look at")[2].split("Map")[0])


def test_curve_ends_below_the_tolerance_where_the_iteration_did():
    frame = Frame("m", 1.0)
    made = curve((61.0, 3.2, 0.02), 0.1, frame)
    assert made.words == "Largest change by iteration: 61, 3.2, 0.02 m."
    heights = [float(p.split(",")[1]) for p in made.points.split()]
    assert heights == sorted(heights)  # downwards
    assert heights[-1] > float(made.level) > heights[1]
    assert curve((), 0.1, frame) is None
    assert curve((0.0,), 0.1, frame).points.count(",") == 1  # zero has no logarithm


def test_lineage_is_read_from_the_ledger():
    one, two = (measured(replace(sample.fault().surface, name=name)) for name in ("F1", "F2"))
    part = replace(one, name="F1 (2)")
    both = RepairAction(
        "pieces", "x", ("F1", "F2"), 1, 0.0, None, "", before=(two, one), after=(two, one, part)
    )
    later = RepairAction(
        "weld", "x", ("F1 (2)",), 1, 0.0, None, "", before=(part,), after=(replace(part, name="G"),)
    )
    lineage = lineage_of([both, later], ["F1", "F2"])
    assert lineage["F1 (2)"] == lineage["G"] == "F1"
    assert lineage["F2"] == "F2"


def test_pictures_beyond_the_room_are_left_out(monkeypatch):
    monkeypatch.setattr(html, "_PICTURES", 60_000)
    page = Page(report_html(sample.run_result(), {}))
    sizes = [len(p["src"]) for p in page["img"]]
    assert sum(sizes) <= 60_000
    assert page.open == []


def test_room_hands_on_what_is_spared():
    from matplotlib.figure import Figure

    room = Room(50_000, 4)
    first = room.picture(Prints(lambda: Figure(figsize=(1, 1))), "a", "b")
    assert first is not None
    assert room.left == 50_000 - len(first.source)
    assert Room(10, 1).picture(Prints(lambda: Figure(figsize=(1, 1))), "a", "b") is None
