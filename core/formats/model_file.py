"""model.toml: its keys read and validated, every failure told in one sentence."""

from __future__ import annotations

import re
import tomllib
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ValidationError

from graben.errors import InputError
from graben.formats.kinds import Kind, kind_of
from graben.formats.text import load_bytes, shortened
from graben.settings import (
    ContactRule,
    FaultSection,
    HorizonSection,
    ModelFile,
    ModelSection,
    Parameters,
    RepairSettings,
    meaning,
)

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

#: The classes of the tables, by name; [checks] has none, its keys are the ids of checks.
SECTIONS: dict[str, type[BaseModel]] = {
    "model": ModelSection,
    "horizons": HorizonSection,
    "faults": FaultSection,
    "parameters": Parameters,
    "repair": RepairSettings,
    "contacts": ContactRule,
}
_LISTS = ("horizons", "faults", "contacts")


def load_model_file(path: Path) -> ModelFile:
    """Read and validate a model.toml.

    Raises
    ------
    InputError
        When the file is missing or no TOML, or a key is missing, unknown or has an unfit value; names the
        first such key.
    """
    try:
        text = _content(path).decode("utf-8-sig")
        keys = tomllib.loads(text)
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path} is not UTF-8 text (byte {error.start}), as TOML must be; save it as UTF-8."
        ) from None
    except tomllib.TOMLDecodeError as error:
        held = _data_in(path)
        if held:
            raise InputError(
                f"{path} holds {held}, not a model: graben init {path} -o model.toml writes one."
            ) from None
        raise InputError(f"{path} is not valid TOML: {_toml_words(error, text)}.") from None
    except RecursionError:
        raise InputError(f"{path} is not valid TOML: it is nested too deeply; correct it.") from None
    try:
        return ModelFile.model_validate(keys)
    except ValidationError as error:
        found = error.errors(include_url=False, include_context=False)
        # A key that is spelled wrong is missing under its right name too: the first tells more.
        unknown = [e for e in found if e["type"] == "extra_forbidden"]
        first = next(iter(unknown or found))
        raise InputError(f"{path}: {_sentence(first, keys)}.") from None


def _content(path: Path) -> bytes:
    """Return the content of the file; one without anything says how a model is made."""
    if path.is_file() and not path.read_bytes().strip():
        raise InputError(f"{path} is empty: graben init FILES -o model.toml writes a model of your files.")
    return load_bytes(path)


def _data_in(path: Path) -> str:
    """Return what surface data a file holds in truth; empty for what may be a model with a slip."""
    if path.suffix.lower() == ".toml":
        return ""
    try:
        kind = kind_of(path)
    except InputError:
        return ""
    return "points" if kind is Kind.TABLE else f"data ({kind})"


def _toml_words(error: tomllib.TOMLDecodeError, text: str) -> str:
    """Return what is wrong with the TOML and the mend, without the full stop."""
    said = str(error).rstrip(".")
    number = re.search(r"at line (\d+)", said)
    line = text.splitlines()[int(number[1]) - 1] if number else ""
    if "\\" in line:
        return f"{said}: a backslash begins an escape there; write / in paths, or put them in single quotes"
    return f"{said}; correct it"


def _sentence(error: ErrorDetails, keys: dict[str, Any]) -> str:
    """Return what is wrong with a key and how to mend it, without the full stop."""
    location = error["loc"]
    section = str(location[0])
    place = _place(location, keys)
    key = ".".join(str(part) for part in location if not isinstance(part, int)).removeprefix(f"{section}.")
    if error["type"] == "extra_forbidden":
        known = list(SECTIONS[section].model_fields if len(location) > 1 else ModelFile.model_fields)
        near = get_close_matches(key, known, n=1)
        mend = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"
        return f"unknown key {shortened(key)}{place} ({mend}); correct it or take it out"
    if error["type"] == "missing":
        kind, owner = ("table", ModelFile) if len(location) == 1 else ("key", SECTIONS[section])
        return f"the {kind} {key!r} is missing{place}; add it: {meaning(owner, key)[0]}"
    what = error["msg"].replace("Input should be", "must be").replace("String should", "must")
    return f"{key} = {_quoted(error['input'])}{place} {what[0].lower()}{what[1:]}; correct it"


def _place(location: tuple[int | str, ...], keys: dict[str, Any]) -> str:
    """Return where a key stands: the table, and for lists of tables which one."""
    section = str(location[0])
    if len(location) == 1:
        return ""
    if section not in _LISTS or not isinstance(location[1], int):
        return f" in [{section}]"
    entry = keys[section][location[1]]
    name = entry.get("name") if isinstance(entry, dict) else None
    label = f" ({shortened(name)})" if isinstance(name, str) else ""
    return f" in [[{section}]] number {location[1] + 1}{label}"


def _quoted(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return shortened(value) if isinstance(value, str) else shortened(repr(value)).strip("'\"")
