"""Pages of the documentation as the tests read them: fenced blocks, and what a reader would do with each."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from doctest import ELLIPSIS, NORMALIZE_WHITESPACE, OutputChecker
from pathlib import Path
from unittest import mock

from tests.commands import graben

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
#: Pages whose commands and scripts are run from their top, each in a folder of its own.
WORKED = tuple(DOCS / f"{name}.md" for name in ("tutorial", "howto-gate", "howto-repair"))
#: The name of that folder, which `graben init` takes for the name of a model.
FOLDER = "field"
_FENCE = re.compile(r"^```(\{code-block\} )?(\w+)\n(?::caption: (\S+)\n)?(.*?)^```$", re.M | re.S)
#: Output may run over lines as it likes, and `...` stands for what differs from run to run.
_LENIENT = ELLIPSIS | NORMALIZE_WHITESPACE
_PROMPT = "$ "
#: A command of graben without redirection, expansion or another command than one that shows its exit code.
_PLAIN = re.compile(r'graben((?: [\w./-]+)*)(; echo "exit code \$\?")?')
#: One order of file names wherever the tests run, and lines as wide as in a plain terminal log.
_ENVIRONMENT = {"LC_ALL": "C.UTF-8", "COLUMNS": "100"}


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, the file it is to be saved as (None: none), its text."""

    language: str
    file: str | None
    text: str


@dataclass(frozen=True)
class Done:
    """A command or script of a page: the output that the page shows, and what came."""

    command: str
    shown: str
    came: str

    @property
    def true(self) -> bool:
        """Whether the page shows what came."""
        return OutputChecker().check_output(self.shown, self.came, _LENIENT)

    def __str__(self) -> str:
        return f"{self.command}\nshown:\n{self.shown}\ncame:\n{self.came}"


def blocks(text: str) -> list[Block]:
    """Return the fenced blocks of a page, in their order."""
    return [Block(m[2], m[3], m[4]) for m in _FENCE.finditer(text)]


def sessions(block: Block) -> list[tuple[str, str]]:
    """Return the commands of a console block, each with the output that the page shows."""
    parts = block.text.removeprefix(_PROMPT).split(f"\n{_PROMPT}")
    return [(command, output) for command, _, output in (part.partition("\n") for part in parts)]


def worked_through(text: str, folder: Path) -> Iterator[Done]:
    """Do in ``folder`` what a page says, from its top: save files, run commands and scripts.

    A text block after a Python block is its output.
    """
    found = blocks(text)
    for block, following in zip(found, [*found[1:], None], strict=True):
        if block.file:
            (folder / block.file).write_text(block.text, encoding="utf-8")
        elif block.language == "console":
            for command, shown in sessions(block):
                yield Done(command, shown, _answered(command, folder))
        elif block.language == "python":
            shown = following.text if following and following.language == "text" else ""
            yield Done(block.text, shown, _output([sys.executable, "-c", block.text], folder))


def renewed(text: str, done: list[Done]) -> str:
    """Return a page that shows what came; times and memory, which no two runs share, become `...`.

    What a page shows no output of is left as it is.
    """
    before = ""
    for each in done:
        start, command, text = text.partition(each.command)
        before += start + command
        if not each.true and each.shown.strip():
            gap, _, after = text.partition(each.shown)
            came = re.sub(r"\b[\d.]+(?= s\b)|\b\d+(?= Mi?B\b)", "...", each.came)
            came = "\n".join(line.rstrip() for line in came.splitlines())
            before += gap + came
            text = ("\n" if each.shown.endswith("\n") else "") + after
    return before + text


def _answered(command: str, folder: Path) -> str:
    """Return what a command prints: a shell's, unless it is graben and nothing else, which needs none."""
    plain = _PLAIN.fullmatch(command)
    if plain is None:
        return _output(["sh", "-c", command], folder)
    with mock.patch.dict(os.environ, _ENVIRONMENT):
        done = graben(*plain[1].split(), cwd=folder, merged=True)
    return f"{done.stdout}exit code {done.returncode}\n" if plain[2] else _told(done)


def _output(command: list[str], folder: Path) -> str:
    """Return what a command prints, errors included, where `graben` and `python` are those of the tests."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    done = subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, "PATH": path, **_ENVIRONMENT},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return _told(done)


def _told(done: subprocess.CompletedProcess[str]) -> str:
    ended = f"exit code {done.returncode}\n" if done.returncode else ""
    return done.stdout + ended
