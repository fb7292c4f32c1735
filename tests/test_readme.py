"""The README and the pages it points to are true: their commands and scripts run."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from graben.settings import ModelFile
from graben.validators.registry import CHECKS
from tests import pages
from tests.commands import graben

ROOT = pages.ROOT
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
#: One screen of a terminal window that fills the display.
LINES = 80


def blocks(language: str) -> list[str]:
    return [block.text for block in pages.blocks(README) if block.language == language]


def commands() -> list[list[str]]:
    found = (shlex.split(line, comments=True) for block in blocks("sh") for line in block.splitlines())
    return [words for words in found if words]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the commands of the README, make apart, have run in their order."""
    place = tmp_path_factory.mktemp("readme")
    for program, *rest in commands():
        if program == "graben":
            done = graben(*rest, cwd=place)
            assert done.returncode == 0, done.stderr + done.stdout
    return place


def test_it_is_one_screen() -> None:
    assert len(README.splitlines()) <= LINES


def test_commands_are_known_and_name_no_other_program() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    verbs = re.findall(r"^([a-z]+):", makefile, re.MULTILINE)
    said = commands()
    assert ["make", "demo"] in said
    assert ["make", "test"] in said
    for program, *rest in said:
        assert program in ("make", "graben")
        if program == "make":
            assert rest[0] in verbs


def test_commands_run_and_write_what_is_said(folder: Path) -> None:
    for name in ("report.html", "report.json", "horizons/Top.ts", "cutoffs/Top.csv", "polygons/Top.geojson"):
        assert (folder / "result" / name).stat().st_size > 0


def test_the_script_runs(folder: Path) -> None:
    (script,) = blocks("python")
    assert len([line for line in script.splitlines() if line.strip()]) <= 10
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "passed: True" in done.stdout
    assert (folder / "scene.vtm").exists()


def test_the_model_file_is_valid() -> None:
    (text,) = blocks("toml")
    model = ModelFile.model_validate(tomllib.loads(text))
    assert model.horizons
    assert model.faults


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files(page: Path) -> None:
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for target in re.findall(r"\]\(([^)#\s]+)", text):
        if not target.startswith("https://"):
            assert (page.parent / target).exists(), target


def test_every_check_has_a_page_with_a_picture() -> None:
    for check in CHECKS:
        text = (ROOT / "docs" / "checks" / f"{check.id}.md").read_text(encoding="utf-8")
        assert f"../images/check-{check.id}.png" in text
        assert all(f"## {part}" in text for part in ("Definition", "A model that fails", "What to do"))
