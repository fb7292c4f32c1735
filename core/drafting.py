"""A first model.toml, with the guesses that went into it as comments."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

from graben.errors import OutputError
from graben.guessing import Guess, Guesses, guesses
from graben.output import require_replaceable, write_whole
from graben.settings import ModelFile

_HEAD = """\
# Written by `graben init`. What follows "guess:" is one: look at each, then run `graben check` on this file.
"""
#: gamma and max_move that are written where no horizon says what the defaults come to.
_EXAMPLES = (400.0, 50.0)
_TAIL = """\
# [parameters]
{gamma}
# min_dip = 30.0          # degrees, below which a fault is warned of

# [repair]
{move}
"""


def draft_model(paths: Sequence[Path], target: Path) -> Guesses:
    """Write a model.toml that names the surfaces of some files, with the guesses as comments.

    Parameters
    ----------
    paths : sequence of Path
        Files, and folders whose files are taken.
    target : Path
        The model.toml, which must not be there. Paths in it are relative where the file lies in its folder or
        below, else absolute.

    Returns
    -------
    Guesses
        What it names, and what was left out.

    Raises
    ------
    InputError
        When a file that is named cannot be read, or no file holds a surface.
    OutputError
        When the target is there already or cannot be written.
    """
    if os.path.lexists(target):
        raise OutputError(f"{target} exists: graben overwrites nothing, choose another -o.")
    require_replaceable(target, lambda content: False)
    made = guesses(paths, beside=target)
    text = draft_text(made, target.absolute().parent)
    # What graben writes, it reads.
    ModelFile.model_validate(tomllib.loads(text))
    write_whole({target: text.encode()})
    return made


def draft_text(made: Guesses, folder: Path) -> str:
    """Return the text of a model.toml that lies in ``folder``."""
    parts = [_HEAD, _model(made, folder)]
    parts += [_table("horizons", [g], folder) for g in made.of("horizon")]
    for _, group in groupby(made.of("fault"), key=lambda g: g.file):
        parts += [_table("faults", gs, folder) for gs in _together(list(group))]
    if made.left_out:
        parts.append("# Not taken:\n" + "".join(f"# - {_plain(f'{w}: {why}')}\n" for w, why in made.left_out))
    return "\n".join([*parts, _tail(made)])


def _tail(made: Guesses) -> str:
    """Return the commented tables of settings, with what the defaults come to for these horizons."""
    steps = sorted(g.step for g in made.of("horizon") if g.step)
    if not steps:
        gamma_value, move_value = _EXAMPLES
        known, move = "default 4 x the step of the horizon", "default half the median edge of the fault"
    else:
        gamma_value, move_value = 4.0 * steps[0], 0.5 * steps[0]
        last = f" to {4.0 * steps[-1]:.4g}" if f"{steps[-1]:.4g}" != f"{steps[0]:.4g}" else ""
        known = f"default 4 steps of the horizon: {gamma_value:.4g}{last} here"
        move = "default half the least horizon step"
    return _TAIL.format(
        gamma=f"# gamma = {gamma_value:<#16.4g}# half-width of the zone beside a fault; {known}",
        move=f"# max_move = {move_value:<#13.4g}# no vertex of a fault is moved further; {move}",
    )


def _model(made: Guesses, folder: Path) -> str:
    return (
        "[model]\n"
        + _key("name", folder.name or "model")
        + f"# guess: {_plain(made.why_z)}\n"
        + _key("z", made.z)
        + _unit(made)
        + '# crs = "EPSG:23031"      # carried through to the outputs\n'
    )


def _unit(made: Guesses) -> str:
    """Return the key of the unit where the files state one, else a comment."""
    if made.unit is None:
        return f'# unit = "m"              # or "ft", or "none": {_plain(made.why_unit)}\n'
    return f"# guess: {_plain(made.why_unit)}\n" + _key("unit", made.unit)


def _together(group: list[Guess]) -> Iterator[list[Guess]]:
    """Yield the faults of a file: all as one where it holds nothing else, so that it is read once."""
    if len(group) == group[0].count and all(g.named for g in group):
        yield group
    else:
        yield from ([g] for g in group)


def _table(kind: str, group: list[Guess], folder: Path) -> str:
    """Return the table of a surface, or of all faults of a file, which names them itself."""
    labels = [f"{g.name}: " if len(group) > 1 else "" for g in group]
    lines = [f"# guess: {_plain(label + g.reason)}\n" for label, g in zip(labels, group, strict=True)]
    first = group[0]
    lines.append(f"[[{kind}]]\n")
    if len(group) == 1:
        lines.append(_key("name", first.name))
    lines.append(_key("file", _relative(first.file, folder)))
    if first.points and first.step is not None:
        lines.append(
            f"# step = {first.step:<#17.4g}# default: node spacing of the surface fitted to the points\n"
        )
        lines.append("# noise = 0.0             # standard deviation of the points\n")
    if first.role == "horizon" and first.step:
        what = "its step" if first.points else f"its own step, {first.step:.4g}"
        lines.append(f"# zone: gamma is {4.0 * first.step:.4g} by default, 4 x {what}\n")
    return "".join(lines)


def _key(name: str, value: str) -> str:
    import tomli_w

    return tomli_w.dumps({name: value})


def _plain(text: str) -> str:
    """Return a text fit for a comment: in one line, without control characters."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _relative(file: Path, folder: Path) -> str:
    """Return the path of a file as a model.toml in ``folder`` names it."""
    found, above = file.resolve(), folder.resolve()
    return (found.relative_to(above) if found.is_relative_to(above) else found).as_posix()
