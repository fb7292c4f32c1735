"""The files that `graben check` writes: which there are, when each may be written, and the writing."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from graben.errors import OutputError
from graben.output import require_replaceable, write_whole
from graben.reports.check_json import check_json, is_check_json
from graben.reports.junit import check_junit, is_check_junit
from graben.reports.places import check_places, is_check_places
from graben.reports.sarif import check_sarif, is_check_sarif

if TYPE_CHECKING:
    from graben.pipeline import Examination

#: Stands for stdout in place of a file.
STDOUT = Path("-")
_GENERATOR = re.compile(rb'<meta\s+name="generator"\s+content="graben\b')


@dataclass(frozen=True)
class Report:
    """A kind of file: what makes its text, and what knows a content that graben wrote as such."""

    text: Callable[[Examination], str]
    ours: Callable[[bytes], bool]


def _html(examination: Examination) -> str:
    # Draws maps, which takes longer to load than all the others to write.
    from graben.reports.check_html import check_html

    return check_html(examination)


def _is_html(content: bytes) -> bool:
    """Return whether a page says of itself, in its head, that graben made it."""
    return _GENERATOR.search(content.partition(b"</head>")[0]) is not None


#: Every kind, by the name of its option.
REPORTS: Mapping[str, Report] = {
    "json": Report(check_json, is_check_json),
    "junit": Report(check_junit, is_check_junit),
    "sarif": Report(check_sarif, is_check_sarif),
    "html": Report(_html, _is_html),
    "geojson": Report(check_places, is_check_places),
}


def require_targets(targets: Mapping[str, Path], model: Path) -> None:
    """Raise OutputError, with the option in its sentence, unless every file may be written.

    Parameters
    ----------
    targets : mapping of str to Path
        Where each kind of file goes, by its option's name; at most one to stdout, ``-``.
    model : Path
        The model.toml, which is no place for a report.
    """
    taken: dict[str, str] = {}
    for kind, target in targets.items():
        place = "-" if target == STDOUT else os.path.realpath(target)
        if place in taken:
            where = "stdout" if target == STDOUT else str(target)
            raise OutputError(f"--{taken[place]} and --{kind} both go to {where}: give each its own file.")
        taken[place] = kind
        if target == STDOUT:
            continue
        if place == os.path.realpath(model):
            raise OutputError(f"--{kind} {target} is the model itself: choose another name.")
        try:
            require_replaceable(target, REPORTS[kind].ours, parents=True)
        except OutputError as error:
            raise OutputError(f"--{kind}: {error}") from error.__cause__


def write_reports(examination: Examination, targets: Mapping[str, Path]) -> bytes:
    """Write every file, each whole or not at all, and return what goes to stdout, empty where nothing does.

    Raises
    ------
    OutputError
        When a file cannot be written, or was put there by another in the meantime.
    """
    contents = {kind: REPORTS[kind].text(examination).encode() for kind in targets}
    for kind, target in targets.items():
        if target != STDOUT:
            require_replaceable(target, REPORTS[kind].ours, parents=True)
    write_whole({target: contents[kind] for kind, target in targets.items() if target != STDOUT})
    return b"".join(contents[kind] for kind, target in targets.items() if target == STDOUT)
