"""Output folders and files that appear whole or not at all, and overwrite nothing of the user's."""

from __future__ import annotations

import fcntl
import os
import secrets
import shutil
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from graben.errors import OutputError

#: Says of a folder that graben made it and may remove it.
_MARK = ".graben-partial"
#: Folder in a partial folder for finished work, which lies in files of this ending.
KEPT = ".graben-kept"
KEPT_ENDING = ".npz"
#: A file larger than this, bytes, is none of graben's reports, and is not read to find out.
_LARGEST_REPORT = 2**28
#: Partial folders and files of this process.
_open: list[Path] = []


@contextmanager
def whole_folder(target: Path) -> Iterator[Path]:
    """Give a folder to write into, renamed to ``target`` at the end; on any error nothing is left.

    Raises
    ------
    OutputError
        As of :func:`partial_folder`, and when something in the folder cannot be written.
    """
    with partial_folder(target) as partial, written(target):
        yield partial


@contextmanager
def partial_folder(target: Path, *, resume: bool = False) -> Iterator[Path]:
    """Give ``target.partial``, in which work goes on, and rename it to ``target`` at the end.

    It belongs to this process until then. One that an ended process left behind is replaced, or taken up
    as it is; one that another process works in, or that graben did not make, is not touched. On an error it
    is removed, but left for a resume where finished work lies in its folder ``KEPT``, which is removed last.

    Parameters
    ----------
    target : Path
        Absent or an empty folder.
    resume : bool
        Whether to take up what an ended process left behind.

    Raises
    ------
    OutputError
        When ``target`` is a file or holds something, or the folder cannot be made or taken up.
    """
    require_free(target)
    partial = partial_of(target)
    with _claimed(partial, target, resume):
        try:
            yield partial
            with written(target):
                if (partial / KEPT).exists():
                    shutil.rmtree(partial / KEPT)
                (partial / _MARK).unlink()
                if target.is_dir():
                    target.rmdir()
                partial.rename(target)
        except BaseException:
            _dropped(partial)
            raise


def partial_of(target: Path) -> Path:
    """Return the folder in which work on ``target`` goes on."""
    return target.with_name(target.name + ".partial")


def is_partial(folder: Path) -> bool:
    """Return whether graben made a folder to work in."""
    return (folder / _MARK).is_file() and not folder.is_symlink()


@contextmanager
def written(target: Path, mend: str = "choose another -o") -> Iterator[None]:
    """Turn an error of the system into one that names what was to be written, and the mend."""
    try:
        yield
    except OSError as error:
        raise OutputError(f"{target} cannot be written: {error.strerror}; {mend}.") from error


@contextmanager
def _claimed(partial: Path, target: Path, resume: bool) -> Iterator[None]:
    """Make a partial folder, or take it up, and hold it: no other process may until this one ends."""
    with ExitStack() as held:
        try:
            if is_partial(partial):
                held.enter_context(_locked(partial))
                if not resume:
                    shutil.rmtree(partial)
            if not (resume and is_partial(partial)):
                _made_parents(target)
                partial.mkdir()
                (partial / _MARK).touch()
                held.enter_context(_locked(partial))
        except FileExistsError:
            raise OutputError(
                f"{partial} is in the way and was not made by graben: move it or choose another -o."
            ) from None
        except OSError as error:
            raise OutputError(f"{partial} cannot be made: {error.strerror}; choose another -o.") from error
        _open.append(partial)
        try:
            yield
        finally:
            _open.remove(partial)


@contextmanager
def _locked(partial: Path) -> Iterator[None]:
    """Hold the lock of a partial folder, which the system lets go when the process ends in any way."""
    with (partial / _MARK).open("rb") as mark:
        try:
            fcntl.flock(mark, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OutputError(
                f"Another graben works in {partial}: wait for it or choose another -o."
            ) from None
        except OSError:
            # Some network disks know no locks; the work goes on without.
            pass
        yield


def is_kept(target: Path) -> bool:
    """Return whether the partial folder of ``target`` holds finished work for a resume."""
    return _holds_work(partial_of(target))


def drop_partial() -> None:
    """Remove what this process has not finished, but what a resume needs; for a process that ends at once."""
    for partial in _open:
        _dropped(partial)


def _holds_work(partial: Path) -> bool:
    return any((partial / KEPT).glob(f"*{KEPT_ENDING}"))


def _dropped(partial: Path) -> None:
    """Remove a partial folder or file, if it is there and holds no finished work."""
    if _holds_work(partial):
        return
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
    if exists and not target.is_dir():
        raise OutputError(
            f"{target} is a file: graben makes a folder and overwrites nothing, choose another -o."
        )
    if exists:
        raise OutputError(f"{target} exists and is not empty: graben overwrites nothing, choose another -o.")
    above = next((p for p in target.absolute().parents if p.exists()), target.absolute())
    if not above.is_dir():
        raise OutputError(f"{above} is a file, not a folder: choose another -o.")
    if not os.access(above, os.W_OK | os.X_OK):
        raise OutputError(f"{above} may not be written to: choose another -o.")


def require_replaceable(target: Path, ours: Callable[[bytes], bool], *, parents: bool = False) -> None:
    """Raise OutputError unless ``target`` can be written without a loss to the user.

    Parameters
    ----------
    target : Path
        A file that is absent, in a folder that is there and may be written to; or one that ``ours`` knows.
    ours : callable
        Says of the content of a file whether graben wrote it as such a report, so that it may be replaced.
    parents : bool
        Whether its folder may be missing, and would be made.
    """
    folder = target.absolute().parent
    above = next(p for p in (folder, *folder.parents) if p.exists()) if parents else folder
    if not above.is_dir():
        kind = "is a file" if above.exists() else "does not exist"
        raise OutputError(f"{target} cannot be written: its folder {above} {kind}; choose another place.")
    try:
        mode = target.lstat().st_mode
    except FileNotFoundError:
        mode = None
    except OSError as error:
        raise OutputError(f"{target} cannot be written: {error.strerror}; choose another name.") from error
    if mode is not None:
        _require_ours(target, mode, ours)
    if not os.access(above, os.W_OK | os.X_OK):
        raise OutputError(f"{target} cannot be written: {above} may not be written to; choose another place.")


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

    Each is written beside its place under another name first. Folders are made where they are missing.

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
            with written(target, "choose another place"):
                target.parent.mkdir(parents=True, exist_ok=True)
                partial.write_bytes(contents[target])
        for target, partial in partials.items():
            with written(target, "choose another place"):
                partial.replace(target)
    finally:
        for partial in partials.values():
            _dropped(partial)
            _open.remove(partial)
