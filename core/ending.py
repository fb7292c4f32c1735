"""How the command line ends: an exit code, one sentence for an error, and what an interrupt says."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import NoReturn

import click

from graben.errors import sentence_of
from graben.output import drop_partial, is_kept

_INTERRUPTED, _WRONG = 130, 2
_STDERR = 2


def ended(command: Callable[[], int | None], debug: bool) -> NoReturn:
    """Run a command and end with its exit code; every error becomes one sentence on stderr and a 2."""
    try:
        sys.exit(command() or 0)
    except click.ClickException as error:
        _fail(" ".join(error.format_message().split()))
    except Exception as error:
        _fail(sentence_of(error), debug)


def interrupted(number: int, frame: FrameType | None) -> None:
    """End at once: an exception raised inside a compiled library could crash instead."""
    drop_partial()
    with suppress(OSError):
        os.write(_STDERR, f"graben: interrupted{_kept_words()}.\n".encode())
    os._exit(_INTERRUPTED)


def _kept_words() -> str:
    """Return what an interrupted run left to go on from; nothing of another command."""
    context = click.get_current_context(silent=True)
    output = None if context is None else context.params.get("output")
    if context is None or context.info_name != "run" or not isinstance(output, Path):
        return ""
    if is_kept(output):
        return "; --resume goes on from what is finished"
    return " before anything was finished that --resume could go on from: start again without --resume"


def _fail(sentence: str, show_traceback: bool = False) -> NoReturn:
    if show_traceback:
        traceback.print_exc()
    click.echo(f"graben: {sentence}", err=True)
    sys.exit(_WRONG)
