"""The options that commands share, and the group of commands that takes them before a command as well."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import click

#: Every command has them: names, and what they do.
_COMMON = (
    (("--debug",), "Show the traceback of an error."),
    (("-q", "--quiet"), "Print errors only."),
    (("-v", "--verbose"), "Print more, and on stderr a line for each step with the time that passed."),
)
#: The files that a check can write, by option.
REPORTS = {
    "json": "Findings as JSON; `graben schema` prints its schema.",
    "junit": "Findings as JUnit XML, for CI.",
    "sarif": "Findings as SARIF 2.1.0, with the lines of the files.",
    "html": "Report in one HTML file, with maps.",
    "geojson": "Places of the findings as GeoJSON, for a GIS.",
}

profile = click.option(
    "--profile",
    type=click.Choice(["paper", "extended"]),
    default="extended",
    show_default=True,
    help="Which checks fail: all conditions of the paper, or those that modeling needs.",
)


def into(*, required: bool = False) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Return the option that names the folder to make."""
    kind, meaning = click.Path(path_type=Path), "Folder to make: absent or empty."
    return click.option("-o", "--output", type=kind, required=required, help=meaning)


class Commands(click.Group):
    """Commands that have common options; one that stands before the command is the command's."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Move common options from before the command to behind it, then read what is left."""
        names = {name for options, _ in _COMMON for name in options}
        count = next((k for k, word in enumerate(args) if word not in names), len(args))
        early, rest = args[:count], args[count:]
        return super().parse_args(ctx, [*rest[:1], *early, *rest[1:]] if rest else [])


def common(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options that every command has."""
    for names, meaning in _COMMON:
        command = click.option(*names, is_flag=True, help=meaning)(command)
    return command


def report_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add an option for each file that a check can write."""
    for name, meaning in reversed(REPORTS.items()):
        kind = click.Path(path_type=Path, allow_dash=True)
        command = click.option(f"--{name}", type=kind, metavar="F", help=meaning)(command)
    return command
