"""`graben view`: the report of a run or repair in a browser with a window, else its address."""

from __future__ import annotations

import signal
import webbrowser
from collections.abc import Iterator
from pathlib import Path

import pytest

from graben.cli import main
from graben.errors import InputError
from graben.output import partial_folder
from graben.viewing import opened, report_of

REPORT = '<html><head><meta name="generator" content="graben"></head><body></body></html>'


@pytest.fixture
def result(tmp_path: Path) -> Path:
    folder = tmp_path / "a result"
    folder.mkdir()
    (folder / "report.html").write_text(REPORT)
    return folder


@pytest.fixture(autouse=True)
def _signals() -> Iterator[None]:
    before = signal.getsignal(signal.SIGINT)
    yield
    signal.signal(signal.SIGINT, before)


class Browser(webbrowser.GenericBrowser):
    """A browser that takes down what it was to open."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.asked: list[str] = []

    def open(self, url: str, new: int = 0, autoraise: bool = True) -> bool:
        self.asked.append(url)
        return True


def view(folder: Path, *words: str) -> int:
    with pytest.raises(SystemExit) as ended:
        main(["view", str(folder), *words])
    return int(ended.value.code or 0)


def test_it_opens_the_report(
    result: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    browser = Browser("firefox")
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(webbrowser, "get", lambda: browser)
    assert view(result) == 0
    assert browser.asked == [(result / "report.html").as_uri()]
    assert "a%20result" in browser.asked[0]
    assert capsys.readouterr().out == f"report: {browser.asked[0]}\n"
    assert view(result, "-q") == 0
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("name", ["lynx", "w3m", "/usr/bin/links", "www-browser"])
def test_a_browser_in_the_terminal_is_not_taken(
    name: str, result: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    browser = Browser(name)
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(webbrowser, "get", lambda: browser)
    assert view(result) == 0
    assert browser.asked == []
    assert (result / "report.html").as_uri() in capsys.readouterr().out


def test_without_a_screen_it_says_where_the_report_is(
    result: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setattr(webbrowser, "get", lambda: pytest.fail("asked for a browser"))
    assert view(result) == 0
    assert (result / "report.html").as_uri() in capsys.readouterr().out


def test_a_command_that_would_wait_is_left_to_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[list[str]] = []
    monkeypatch.setenv("BROWSER", "mybrowser")
    monkeypatch.setattr(webbrowser, "get", lambda: webbrowser.GenericBrowser(["mybrowser", "--new", "%s"]))
    monkeypatch.setattr(
        webbrowser.BackgroundBrowser,
        "open",
        lambda self, url: bool(started.append([self.name, *self.args, url])) or True,
    )
    assert opened("file:///x")
    assert started == [["mybrowser", "--new", "%s", "file:///x"]]


def test_what_is_no_result_ends_with_one_sentence(
    tmp_path: Path, result: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    foreign = tmp_path / "foreign"
    foreign.mkdir()
    (foreign / "report.html").write_text("<html><head></head><body>mine</body></html>")
    for folder in (tmp_path, foreign, tmp_path / "nowhere", result / "report.html"):
        assert view(folder) == 2
        out, err = capsys.readouterr()
        assert (out, err.count("\n")) == ("", 1)
        assert "folder of a" in err
    with partial_folder(tmp_path / "out") as partial:
        for folder in (tmp_path / "out", partial):
            with pytest.raises(InputError, match="has not ended"):
                report_of(folder)
