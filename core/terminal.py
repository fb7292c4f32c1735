"""What the command line does with a terminal: colours, width, progress, and readers that leave early."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from rich.console import Console

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
def progress(quiet: bool) -> Iterator[Progress]:
    """Give a callable that shows the stage on a terminal, and does nothing when piped."""
    if quiet or sys.stderr is None or not sys.stderr.isatty():
        yield lambda stage, what: None
        return
    from rich.console import Console
    from rich.markup import escape

    with Console(stderr=True).status("") as status:
        yield lambda stage, what: status.update(f"{stage:<12} {escape(what)}")
