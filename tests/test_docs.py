"""The pages of the reference say all that the code knows: keys, messages, repairs, terminations, commands."""

from __future__ import annotations

import re
import runpy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import pytest

from graben import errors
from graben.cleaning.registry import REPAIRS
from graben.cli import app
from graben.demo import names as demo_names
from graben.formats.model_file import SECTIONS
from graben.modeling.results import TerminationType
from graben.settings import ModelFile, meaning
from tests.pages import DOCS, ROOT, blocks

PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
COLLECTORS = ("collect_checks", "collect_settings", "collect_messages", "collect_gallery")


@pytest.fixture
def scripts(monkeypatch: pytest.MonkeyPatch) -> dict[str, dict[str, Any]]:
    """What the scripts of the docs define, by their names."""
    monkeypatch.syspath_prepend(str(DOCS))
    return {name: runpy.run_path(str(DOCS / f"{name}.py")) for name in (*COLLECTORS, "between_marks")}


def plain(text: str) -> str:
    return " ".join(text.split())


@pytest.mark.parametrize("name", COLLECTORS)
def test_collected_parts_are_up_to_date(scripts: dict[str, dict[str, Any]], name: str) -> None:
    for path, content in scripts[name]["pages"]().items():
        text = path.read_text(encoding="utf-8")
        assert text == scripts["between_marks"]["filled"](text, content), f"{path.name}: run docs/{name}.py"


def test_every_key_of_a_model_has_a_meaning_and_a_default() -> None:
    tables = {"": ModelFile, **SECTIONS}
    keys = [(table, key, about) for table, c in tables.items() for key, about in c.model_fields.items()]
    assert len(keys) > 30
    for table, key, about in keys:
        means, default = meaning(tables[table], key)
        assert means and not means.endswith("."), f"[{table}] {key}"
        # a value is told by itself; what is worked out is told in words
        assert bool(default) == (about.default is None or (about.default == () and table != "")), key


def test_a_link_of_the_keys_needs_its_words(
    scripts: dict[str, dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = scripts["collect_settings"]
    links = settings["LINKS"]
    assert "[the energy](theta.md)" in settings["page"]()
    for name, said in (("model.name", "no such words"), ("model.nothing", "name"), ("nothing", "name")):
        with monkeypatch.context() as patch:
            patch.setitem(links, name, (said, "page.md"))
            with pytest.raises(SystemExit):
                settings["page"]()


def test_a_page_without_marks_is_refused(scripts: dict[str, dict[str, Any]]) -> None:
    filled = scripts["between_marks"]["filled"]
    page = "a\n<!-- from the moon: x.py -->\n<!-- end -->\nb\n"
    assert filled(filled(page, "1"), "2") == filled(page, "2")
    with pytest.raises(SystemExit):
        filled(page.replace("end", "stop"), "1")


def test_every_warning_has_an_entry(scripts: dict[str, dict[str, Any]]) -> None:
    pages = plain(
        " ".join((DOCS / f"{n}.md").read_text(encoding="utf-8") for n in ("messages", "terminations"))
    )
    texts = scripts["collect_messages"]["warning_texts"]()
    assert len(texts) > 20
    for text in texts:
        for part in text.words.split("…"):
            said = plain(part).strip(" .;:,")
            assert said in pages, (
                f"{text.module}: {text.words!r} has no entry in messages.md or terminations.md"
            )


def test_every_entry_is_a_warning(scripts: dict[str, dict[str, Any]]) -> None:
    page = (DOCS / "messages.md").read_text(encoding="utf-8")
    part = page[page.index("## Warnings of a run") : page.index("## Errors")]
    known = plain(" ".join(text.words for text in scripts["collect_messages"]["warning_texts"]()))
    entries = [row for row in re.findall(r"^\| (.+?) \|", part, re.M) if "…" in row]
    assert len(entries) > 10
    for entry in entries:
        longest = max(entry.split("…"), key=len)
        assert plain(longest).strip(" .;:,") in known, f"nothing says {entry!r} any more"


def test_modules_that_warn_are_looked_at(scripts: dict[str, dict[str, Any]]) -> None:
    """A module of the modeling stage that writes warnings or notes is told to docs/collect_messages.py."""
    source = re.compile(r"\b(?:warnings|notes)\s*(?:=|\+=|\.append)\s*(?!\(\)|field)")
    known = scripts["collect_messages"]["WARNED"]
    handed_on = {"modeling/building.py"}
    made = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "modeling").glob("*.py")
        if source.search(path.read_text(encoding="utf-8"))
    }
    assert "modeling/preparation.py" in made
    assert made <= set(known) | handed_on


def test_every_exception_is_explained() -> None:
    text = (DOCS / "messages.md").read_text(encoding="utf-8")
    leaves = {
        t.__name__ for t in vars(errors).values() if isinstance(t, type) and t is not errors.GrabenError
    }
    assert set(re.findall(r"^\| `(\w+Error)` \|", text, re.M)) == leaves


def test_every_repair_has_a_part_in_order() -> None:
    text = (DOCS / "repairs.md").read_text(encoding="utf-8")
    assert re.findall(r"^## (\S+)$", text, re.MULTILINE) == [repair.id for repair in REPAIRS]


def test_every_termination_has_a_part() -> None:
    text = (DOCS / "terminations.md").read_text(encoding="utf-8")
    said = re.findall(r"^## Type (\d), (.+)$", text, re.M)
    assert said == [(str(int(t)), t.name.replace("_", " ").lower()) for t in TerminationType]


def commands(page: Path) -> Iterator[list[str]]:
    """Yield the words of each use of graben on a page: in its blocks for a shell, and in its lines."""
    text = page.read_text(encoding="utf-8")
    shells = [b.text for b in blocks(text) if b.language in ("sh", "console", "yaml")]
    lines = [line for shell in shells for line in shell.splitlines()]
    lines += re.findall(r"`(graben [a-z][^`]*)`", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S))
    for line in lines:
        found = re.search(r"(?:^|[\s$&])graben ([a-z]+\b.*)", line)
        if found and not line.lstrip().startswith("#"):
            yield re.split(r"[;&|]|\s#", found[1])[0].split()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_and_their_options_exist(page: Path) -> None:
    for verb, *words in commands(page):
        assert verb in app.commands, f"graben {verb}"
        known = {o for p in app.commands[verb].params if isinstance(p, click.Option) for o in p.opts}
        used = {w.partition("=")[0].strip("[],.") for w in words if w.strip("[").startswith("-")} - {"-"}
        assert used <= known | {"--help"}, f"graben {verb}: {used - known}"


def test_every_page_is_in_the_contents() -> None:
    """Pages that are not part of another one are listed where a reader finds them."""
    listed = set()
    for page in PAGES:
        for block in re.findall(r"^```\{toctree\}\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S):
            listed |= {(page.parent / f"{n}.md").resolve() for n in block.splitlines() if n and n[0] != ":"}
    settings = (DOCS / "conf.py").read_text(encoding="utf-8")
    parts = {(DOCS / name).resolve() for name in re.findall(r'"([\w-]+\.md)"', settings)}
    assert {p.resolve() for p in PAGES} - listed - parts == {ROOT / "README.md", DOCS / "index.md"}


def test_pictures_are_drawn_by_scripts_and_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(DOCS))
    gallery = runpy.run_path(str(DOCS / "collect_gallery.py"))
    drawn = set(gallery["pictures"]())
    shown = set(re.findall(r"\(images/([\w-]+)\.png\)", (DOCS / "gallery.md").read_text(encoding="utf-8")))
    assert drawn == shown == {path.stem for path in (DOCS / "images").iterdir()}
    scripts = {path.stem for path in DOCS.glob("make_*.py")}
    assert scripts == {"make_pictures", *gallery["SCRIPTS"]}


def test_the_gallery_shows_every_demo_model() -> None:
    text = (DOCS / "gallery.md").read_text(encoding="utf-8")
    source = (DOCS / "make_replica_picture.py").read_text(encoding="utf-8")
    for name in demo_names():
        assert f"graben demo {name} " in text or f'"{name}"' in source


def test_pictures_are_small() -> None:
    for path in (DOCS / "images").iterdir():
        assert path.stat().st_size < 300_000, path.name
