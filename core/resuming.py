"""What a run keeps in DIR.partial until it ends, and whether another may go on from there."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, MutableMapping
from hashlib import file_digest
from importlib.metadata import version
from pathlib import Path
from typing import Any

from graben.errors import OutputError
from graben.finding import Profile
from graben.formats.model_file import load_model_file
from graben.output import KEPT, KEPT_ENDING, is_partial, partial_of, written

_MANIFEST = "manifest.json"
#: Rises when the manifest says something else, or work is kept under other names.
_FORMAT = 1
#: Whose version the digits of a result may depend on.
_COMPUTING = ("graben", "numpy", "scipy")


def manifest(model: Path, profile: str, mend: bool) -> dict[str, Any]:
    """Return what the result of a run depends on: hashes of its files, its options, and versions.

    Parameters
    ----------
    model : Path
        The model.toml. It is to be read after this, so that nothing kept is newer than its hash.
    profile : str
        The profile.
    mend : bool
        Whether the run repairs.

    Returns
    -------
    dict
        For JSON. ``files`` has the SHA-256 of model.toml and of each file that it names, by the name it has
        there, None for one that cannot be read.

    Raises
    ------
    InputError
        When the model.toml cannot be read.
    """
    settings = load_model_file(model)
    named = [h.file for h in settings.horizons] + [f.file for f in settings.faults]
    if settings.model.truth is not None:
        named += [f"{settings.model.truth}/{name}" for name in _inside(model.parent / settings.model.truth)]
    return {
        "format": _FORMAT,
        "files": {model.name: _hash(model), **{name: _hash(model.parent / name) for name in named}},
        "options": {"profile": str(Profile(profile)), "repair": mend},
        "versions": {name: version(name) for name in _COMPUTING},
    }


def require_resumable(target: Path, now: Mapping[str, Any]) -> None:
    """Raise OutputError unless ``target.partial`` was left by a run of which all that matters is the same.

    Parameters
    ----------
    target : Path
        The output of the run.
    now : mapping
        Of :func:`manifest`.
    """
    partial = partial_of(target)
    mend = "run without --resume to start anew"
    try:
        then = json.loads((partial / KEPT / _MANIFEST).read_bytes()) if is_partial(partial) else None
    except (OSError, ValueError):
        then = None
    if not isinstance(then, dict):
        what = "holds nothing of a run" if partial.exists() else "does not exist"
        raise OutputError(f"There is nothing to resume, {partial} {what}: {mend}.")
    changed = _changed(then, now)
    if changed:
        raise OutputError(f"{changed} since the run that left {partial}: undo that, or {mend}.")


def _changed(then: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """Return the first thing that is not as it was, in words; empty where all is."""
    if then.get("format") != now["format"]:
        return "What graben keeps has changed"
    for key in now:
        if key == "format" or then[key] == now[key]:
            continue
        names = [name for name in {**now[key], **then[key]} if then[key].get(name) != now[key].get(name)]
        was, is_ = (str(side[key].get(names[0], "none")) for side in (then, now))
        if key == "files":
            return f"{names[0]} has changed"
        if (key, names[0]) == ("options", "repair"):
            return f"The option --no-repair was {'taken out' if now[key][names[0]] else 'added'}"
        name = f"--{names[0]}" if key == "options" else names[0]
        return f"The {key.removesuffix('s')} {name} has changed (from {was} to {is_})"
    return ""


def _inside(folder: Path) -> list[str]:
    """Return the files in a folder and below, relative to it; none where it cannot be looked into."""
    try:
        return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())
    except (OSError, ValueError):
        return []


def _hash(path: Path) -> str | None:
    """Return the SHA-256 of a file, None for what is none: a pipe would have no end."""
    try:
        if not path.is_file():
            return None
        with path.open("rb") as file:
            return file_digest(file, "sha256").hexdigest()
    except (OSError, ValueError):
        return None


class KeptFolder(MutableMapping[str, bytes]):
    """Work that is done, as files in a partial folder; each appears whole or not at all.

    Parameters
    ----------
    partial : Path
        The partial folder.
    now : mapping
        Of :func:`manifest`; it is written where there is none.
    """

    def __init__(self, partial: Path, now: Mapping[str, Any]) -> None:
        self._folder = partial / KEPT
        with written(self._folder):
            self._folder.mkdir(exist_ok=True)
        if not (self._folder / _MANIFEST).exists():
            self._write(_MANIFEST, json.dumps(now, indent=2).encode())

    def __getitem__(self, key: str) -> bytes:
        try:
            return self._file(key).read_bytes()
        except OSError:
            raise KeyError(key) from None

    def __setitem__(self, key: str, content: bytes) -> None:
        self._write(self._file(key).name, content)

    def __delitem__(self, key: str) -> None:
        try:
            self._file(key).unlink()
        except OSError:
            raise KeyError(key) from None

    def __iter__(self) -> Iterator[str]:
        return (path.stem for path in sorted(self._folder.glob(f"*{KEPT_ENDING}")))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def _file(self, key: str) -> Path:
        return self._folder / f"{key}{KEPT_ENDING}"

    def _write(self, name: str, content: bytes) -> None:
        """Write a file under another name first, so that one of its own name is whole."""
        part = self._folder / f"{name}.part"
        with written(self._folder / name):
            part.write_bytes(content)
            part.replace(self._folder / name)
