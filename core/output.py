"""Output folders and files that appear whole or not at all, and overwrite nothing of the user's."""

from __future__ import annotations

import os
import secrets
import shutil
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from graben.errors import OutputError

#: Says of a folder that graben made it and may remove it.
_MARK = ".graben-partial"
#: A file larger than this, bytes, is none of graben's reports, and is not read to find out.
_LARGEST_REPORT = 2**28
#: Partial folders and files of this process.
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
        _dropped(partial)


def _dropped(partial: Path) -> None:
    """Remove a partial folder or file, if it is there."""
    if partial.is_dir():
        shutil.rmtree(partial, ignore_errors=True)
    else:
        with suppress(OSError):
            partial.unlink()


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


def require_replaceable(target: Path, ours: Callable[[bytes], bool]) -> None:
    """Raise OutputError unless ``target`` can be written without a loss to the user.

    Parameters
    ----------
    target : Path
        A file that is absent, in a folder that is there and may be written to; or one that ``ours`` knows.
    ours : callable
        Says of the content of a file whether graben wrote it as such a report, so that it may be replaced.
    """
    folder = target.absolute().parent
    if not folder.is_dir():
        kind = "is a file" if folder.exists() else "does not exist"
        raise OutputError(f"{target} cannot be written: its folder {folder} {kind}; choose another place.")
    try:
        mode = target.lstat().st_mode
    except FileNotFoundError:
        mode = None
    except OSError as error:
        raise OutputError(f"{target} cannot be written: {error.strerror}; choose another name.") from error
    if mode is not None:
        _require_ours(target, mode, ours)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(
            f"{target} cannot be written: {folder} may not be written to; choose another place."
        )


def _require_ours(target: Path, mode: int, ours: Callable[[bytes], bool]) -> None:
    if stat.S_ISDIR(mode):
        raise OutputError(f"{target} is a folder: give the name of a file in it.")
    if not stat.S_ISREG(mode):
        raise OutputError(f"{target} is a link, a device or a pipe: give a plain file, or - for stdout.")
    try:
        known = target.stat().st_size <= _LARGEST_REPORT and ours(target.read_bytes())
    except OSError as error:
        raise OutputError(
            f"{target} exists and cannot be read: {error.strerror}; choose another name."
        ) from error
    if not known:
        raise OutputError(
            f"{target} exists and is no such report of graben: graben overwrites nothing of yours, "
            "choose another name."
        )


def write_whole(contents: Mapping[Path, bytes]) -> None:
    """Write files, replacing those of the same names; each appears whole, and on an error none does.

    Each is written beside its place under another name first.

    Raises
    ------
    OutputError
        When one of them cannot be written.
    """
    token = f"{os.getpid()}-{secrets.token_hex(4)}"
    partials = {t: t.with_name(f".graben-{token}-{k}.partial") for k, t in enumerate(contents)}
    _open.extend(partials.values())
    try:
        for target, partial in partials.items():
            with _named(target):
                partial.write_bytes(contents[target])
        for target, partial in partials.items():
            with _named(target):
                partial.replace(target)
    finally:
        for partial in partials.values():
            _dropped(partial)
            _open.remove(partial)


@contextmanager
def _named(target: Path) -> Iterator[None]:
    """Turn an error of the system into one that names the file."""
    try:
        yield
    except OSError as error:
        raise OutputError(f"{target} cannot be written: {error.strerror}; choose another place.") from error
