"""The house itself: what is installed, what the Makefile says, what no file may hold."""

from __future__ import annotations

import importlib
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = {
    "core": "graben",
    "cleaning": "graben.cleaning",
    "modeling": "graben.modeling",
    "validators": "graben.validators",
}
#: Written in two halves, so that this file passes its own test.
MACHINE_PATHS = tuple(
    re.escape("/" + folder + "/") for folder in ("home", "root", "work", "tmp", "opt", "Users", "mnt")
)
REGISTRIES = tuple(
    re.escape(a + b) for a, b in (("pypi", ".org"), ("python", "hosted"), ("ana", "conda.org"))
)
INDEXES = ("index" + "-url", "find" + "-links")
#: A path begins where no other path, name or address goes on.
FORBIDDEN = re.compile(rf"(?<![\w.\-/*}}\])])(?:{'|'.join(MACHINE_PATHS)})|{'|'.join(REGISTRIES + INDEXES)}")


def module_files() -> list[tuple[str, Path]]:
    found = []
    for folder, package in FOLDERS.items():
        for path in sorted((ROOT / folder).rglob("*.py")):
            parts = [package, *path.relative_to(ROOT / folder).with_suffix("").parts]
            found.append((".".join(p for p in parts if p != "__init__"), path))
    return found


def project_files() -> list[Path]:
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("not a git working copy: which files belong to the project is not known")
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"],
        cwd=ROOT,
        capture_output=True,
        check=True,
    ).stdout.decode()
    return [ROOT / name for name in listed.split("\0") if name and (ROOT / name).is_file()]


@pytest.mark.parametrize(("name", "path"), module_files(), ids=lambda value: str(value).rpartition("/")[2])
def test_every_module_can_be_imported_from_the_installed_package(name: str, path: Path) -> None:
    module = importlib.import_module(name)
    assert module.__file__ is not None
    assert Path(module.__file__).read_bytes() == path.read_bytes(), "installed from elsewhere: make install"


def test_no_folder_of_the_root_shadows_the_package() -> None:
    assert not (ROOT / "graben").exists()
    assert not (ROOT / "graben.py").exists()


def test_no_file_holds_a_machine_path_or_a_registry() -> None:
    found = []
    for path in project_files():
        if path.suffix == ".png":
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
            if FORBIDDEN.search(line):
                found.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()[:80]}")
    assert found == []


@pytest.mark.parametrize(
    ("line", "unfit"),
    [
        ('open("/' + 'tmp/x")', True),
        ("see /" + "home/me/x", True),
        ("https://" + "pypi" + ".org/simple", True),
        ("../shared/data/x", False),
        ("a/" + "work/b", False),
        ("https://example.org/" + "home/x", False),
    ],
)
def test_the_rule_for_paths_finds_paths(line: str, unfit: bool) -> None:
    assert bool(FORBIDDEN.search(line)) is unfit


def test_pictures_stay_small() -> None:
    assert sum(path.stat().st_size for path in (ROOT / "docs" / "images").iterdir()) < 3_000_000


def test_make_help_names_every_verb_with_a_sentence() -> None:
    if shutil.which("make") is None:
        pytest.skip("make is not installed")
    phony = re.search(r"^\.PHONY:(.*)$", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert phony is not None
    shown = subprocess.run(
        ["make", "-s", "help"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    said = dict(re.findall(r"^  make (\w+) +(\S.*\w.*)$", shown, re.MULTILINE))
    assert sorted(said) == sorted(phony[1].split())


def test_constraints_pin_what_make_installs() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [
        *project["dependencies"],
        *(r for e in ("test", "docs") for r in project["optional-dependencies"][e]),
    ]
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert all(re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.]+", pin) for pin in pins)
    assert pins == sorted(pins, key=str.lower)
    versions = {plain(name): version for name, version in (pin.split("==") for pin in pins)}
    for requirement in map(Requirement, wanted):
        assert plain(requirement.name) in versions, requirement
        assert requirement.specifier.contains(versions[plain(requirement.name)]), requirement


def plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()
