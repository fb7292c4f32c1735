"""Commands as the tests give them: in this process, or in one of its own where that is what is tested."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, chdir, contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import IO

from graben.cli import main

Done = subprocess.CompletedProcess[str]
_STDOUT, _STDERR = 1, 2


def graben(*words: object, cwd: Path | None = None, merged: bool = False) -> Done:
    """Give a command in this process, which saves the seconds in which one loads its libraries.

    What these write past Python counts as well. Nothing stays of what a command sets: the folder, the answer
    to an interrupt, which warnings are shown.

    Parameters
    ----------
    words : objects
        After `graben`.
    cwd : Path, optional
        The folder to stand in.
    merged : bool
        Whether stderr goes where stdout goes.
    """
    given = list(map(str, words))
    with ExitStack() as stack:
        out = stack.enter_context(tempfile.TemporaryFile())
        err = out if merged else stack.enter_context(tempfile.TemporaryFile())
        with _as_a_process(out, err, cwd):
            code = _exit_code(given)
        return Done(given, code, _text(out), "" if merged else _text(err))


def started(*words: object, cwd: Path | None = None, **environment: str) -> Done:
    """Give a command in a process of its own, as a user does."""
    command = [sys.executable, "-m", "graben.cli", *map(str, words)]
    return subprocess.run(
        command,
        capture_output=True,
        text=True,
        cwd=cwd,
        env={**os.environ, **environment},
        timeout=120,
        check=False,
    )


def _exit_code(words: list[str]) -> int:
    try:
        main(words)
    except SystemExit as end:
        return int(end.code or 0)
    raise AssertionError("a command ends with an exit code")


@contextmanager
def _as_a_process(out: IO[bytes], err: IO[bytes], cwd: Path | None) -> Iterator[None]:
    """Have two files for stdout and stderr, those of compiled libraries too, and put back what main sets."""
    answer = signal.getsignal(signal.SIGINT)
    with ExitStack() as stack:
        stack.enter_context(warnings.catch_warnings())
        stack.callback(signal.signal, signal.SIGINT, answer)
        if cwd is not None:
            stack.enter_context(chdir(cwd))
        for number, file in ((_STDOUT, out), (_STDERR, err)):
            stack.enter_context(_turned(number, file))
        stdout = stack.enter_context(open(_STDOUT, "w", encoding="utf-8", closefd=False))
        stderr = stack.enter_context(open(_STDERR, "w", encoding="utf-8", buffering=1, closefd=False))
        stack.enter_context(redirect_stdout(stdout))
        stack.enter_context(redirect_stderr(stderr))
        yield


@contextmanager
def _turned(number: int, file: IO[bytes]) -> Iterator[None]:
    """Have a file in the place of a stream of the system."""
    kept = os.dup(number)
    try:
        _flushed()
        os.dup2(file.fileno(), number)
        yield
        _flushed()
    finally:
        os.dup2(kept, number)
        os.close(kept)


def _flushed() -> None:
    """Write what the C library still holds."""
    ctypes.CDLL(None).fflush(None)


def _text(file: IO[bytes]) -> str:
    file.seek(0)
    return file.read().decode()
