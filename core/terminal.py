"""What the command line does with a terminal: colours, width, progress, and readers that leave early."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions
    from rich.spinner import Spinner

    from graben.display import Course
    from graben.stages import Progress


def console(stream: TextIO) -> Console | None:
    """Return a console with the width and colours of the terminal that a stream is, None for any other."""
    from rich.console import Console

    return Console(file=stream) if stream.isatty() else None


def encoded(text: str, stream: TextIO) -> bytes:
    """Return text as a stream takes it; what its encoding lacks is written out."""
    return text.encode(stream.encoding or "utf-8", "backslashreplace")


def put(content: bytes, stream: TextIO) -> None:
    """Write to a stream; a reader that has seen enough, such as `head`, may close it."""
    try:
        stream.buffer.write(content)
        stream.flush()
    except BrokenPipeError:
        # What is still in the buffer must go somewhere when the program ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


@contextmanager
def progress(plan: Sequence[str], began: float, *, quiet: bool, verbose: bool) -> Iterator[Progress]:
    """Give a callable that shows the course of a command on a terminal, and does nothing when piped.

    Parameters
    ----------
    plan : sequence of str
        The stages of the command, in their order.
    began : float
        When it began, by ``time.perf_counter``.
    quiet, verbose : bool
        Show nothing; or write a line for each step to stderr instead, on a terminal or not.
    """
    if quiet or sys.stderr is None or not (verbose or sys.stderr.isatty()):
        yield lambda stage, what: None
        return
    from graben.display import Course

    if verbose:
        yield Course(plan, began, sys.stderr)
        return
    from rich.console import Console
    from rich.live import Live

    course = Course(plan, began)
    with Live(_Line(course), console=Console(stderr=True), transient=True):
        yield course


class _Line:
    """The course of a command in one line that is never broken, as it is when it is drawn."""

    def __init__(self, course: Course) -> None:
        from rich.spinner import Spinner

        self._course, self._spinner = course, Spinner("dots")

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Spinner]:
        from rich.text import Text

        self._spinner.text = Text(self._course.line(), no_wrap=True, overflow="ellipsis")
        yield self._spinner
