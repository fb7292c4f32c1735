"""report.html: says the verdict first, asks nothing of the network, shows names as text."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from graben.model import Model
from graben.reports.html import report_html
from graben.reports.summary import summary, verdict
from tests.reports import sample

VOID = {"meta", "link", "img", "input", "br"}


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


def test_verdict_and_summary_in_words():
    passed, failed = sample.run_result(), sample.failed_run()
    assert verdict(passed) == "Modeled: 1 of 2 horizons cut by faults, all converged."
    uncut = replace(passed, horizons=passed.horizons[1:], model=sample.model(names=("Top B",)))
    assert verdict(uncut) == "Modeled: no fault cuts the horizon."
    for part in ("acyclic", "Top A", "did not converge", "Top B", "was not modeled"):
        assert part in verdict(failed)
    text = summary(failed)
    assert text.splitlines()[0] == verdict(failed)
    assert "largest throw 138 m" in text
    assert "largest throw -90 m" in summary(sample.run_result(throw=-90.0))
    assert "subdomain 0 (F1)" in summary(passed, verbose=True)
    assert "subdomain 0" not in summary(passed)


def test_report_survives_numbers_that_are_not_finite():
    result = sample.run_result()
    subdomain = replace(result.horizons[0].subdomains[0], history=(1.0, np.nan), mean_deviation=np.nan)
    odd = replace(result, horizons=(replace(result.horizons[0], subdomains=(subdomain,)),))
    assert "nan" not in "".join(Page(report_html(odd, {})).text)
