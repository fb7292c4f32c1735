"""What the files of a check say when it could not be made, so that no old verdict stays in their place."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from graben.errors import OutputError, sentence_of
from graben.output import require_replaceable, write_whole
from graben.reports.check_files import REPORTS, STDOUT
from graben.reports.check_json import error_json
from graben.reports.junit import error_junit
from graben.reports.sarif import error_sarif
from graben.terminal import put


@contextmanager
def failing_reports(targets: Mapping[str, Path], model: Path, profile: str) -> Iterator[None]:
    """On an error, write it into the files of the kinds that can say it, and remove old ones of the others.

    Parameters
    ----------
    targets : mapping of str to Path
        Where each kind of file goes, by its option's name, as of ``require_targets``.
    model : Path
        What was to be checked.
    profile : str
        The profile.
    """
    try:
        yield
    except Exception as error:
        # An error of the writing is the one that is told already, or a second one.
        with suppress(OutputError):
            _write(sentence_of(error), targets, str(model), profile)
        raise


def _write(sentence: str, targets: Mapping[str, Path], model: str, profile: str) -> None:
    contents = {
        "json": error_json(sentence, profile),
        "junit": error_junit(sentence, model),
        "sarif": error_sarif(sentence, profile),
    }
    said: dict[Path, bytes] = {}
    for kind, target in targets.items():
        if target == STDOUT:
            put(contents.get(kind, "").encode(), sys.stdout)
            continue
        require_replaceable(target, REPORTS[kind].ours, parents=True)
        if kind in contents:
            said[target] = contents[kind].encode()
        else:
            with suppress(OSError):
                target.unlink()
    write_whole(said)
