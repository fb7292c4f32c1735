"""Output folders that appear whole or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from graben.errors import OutputError

#: Says of a folder that graben made it and may remove it.
_MARK = ".graben-partial"
#: Partial folders of this process.
_open: list[Path] = []


@contextmanager
def whole_folder(target: Path) -> Iterator[Path]:
    """Give a folder to write into, renamed to ``target`` at the end; on any error nothing is left.

    Work goes on in ``target.partial`` beside it. A partial folder that an ended run left behind is
    replaced; one that graben did not make is not touched.

    Raises
    ------
    OutputError
        When ``target`` is a file or holds something, or the folder cannot be made.
    """
    require_free(target)
    partial = target.with_name(target.name + ".partial")
    try:
        if (partial / _MARK).is_file() and not partial.is_symlink():
            shutil.rmtree(partial)
        _made_parents(target)
        partial.mkdir()
        _open.append(partial)
        (partial / _MARK).touch()
    except FileExistsError:
        raise OutputError(
            f"{partial} is in the way and was not made by graben: move it or choose another -o."
        ) from None
    except OSError as error:
        raise OutputError(f"{partial} cannot be made: {error.strerror}; choose another -o.") from error
    try:
        yield partial
        (partial / _MARK).unlink()
        if target.is_dir():
            target.rmdir()
        partial.rename(target)
    except OSError as error:
        shutil.rmtree(partial, ignore_errors=True)
        raise OutputError(f"{target} cannot be written: {error.strerror}; choose another -o.") from error
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise
    finally:
        _open.remove(partial)


def drop_partial() -> None:
    """Remove what this process has not finished, for a process that ends at once."""
    for partial in _open:
        shutil.rmtree(partial, ignore_errors=True)


def _made_parents(target: Path) -> None:
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise OutputError(f"{target.parent} is a file, not a folder: choose another -o.") from None


def require_free(target: Path) -> None:
    """Raise OutputError unless ``target`` is absent or an empty folder, in one that may be written to."""
    if target.is_symlink():
        raise OutputError(f"{target} is a link: graben makes a folder of its own, choose another -o.")
    try:
        if target.is_dir() and not any(target.iterdir()):
            return
        exists = target.exists()
    except OSError as error:
        raise OutputError(f"{target} cannot be looked into: {error.strerror}; choose another -o.") from error
    if exists:
        raise OutputError(f"{target} exists and is not empty: graben overwrites nothing, choose another -o.")
    above = next((p for p in target.absolute().parents if p.exists()), target.absolute())
    if not above.is_dir():
        raise OutputError(f"{above} is a file, not a folder: choose another -o.")
    if not os.access(above, os.W_OK | os.X_OK):
        raise OutputError(f"{above} may not be written to: choose another -o.")
