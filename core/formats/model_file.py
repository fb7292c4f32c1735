"""model.toml: its keys read and validated, every failure told in one sentence."""

from __future__ import annotations

import tomllib
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ValidationError

from graben.errors import InputError
from graben.formats.text import load_bytes, shortened
from graben.settings import (
    ContactRule,
    FaultSection,
    HorizonSection,
    ModelFile,
    ModelSection,
    Parameters,
    RepairSettings,
)

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

_SECTIONS: dict[str, type[BaseModel]] = {
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
        text = load_bytes(path).decode("utf-8-sig")
        keys = tomllib.loads(text)
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path} is not UTF-8 text (byte {error.start}), as TOML must be; save it as UTF-8."
        ) from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path} is not valid TOML: {str(error).rstrip('.')}; correct it.") from None
    except RecursionError:
        raise InputError(f"{path} is not valid TOML: it is nested too deeply; correct it.") from None
    try:
        return ModelFile.model_validate(keys)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        raise InputError(f"{path}: {_sentence(first, keys)}.") from None


def _sentence(error: ErrorDetails, keys: dict[str, Any]) -> str:
    """Return what is wrong with a key and how to mend it, without the full stop."""
    location = error["loc"]
    section = str(location[0])
    place = _place(location, keys)
    key = ".".join(str(part) for part in location if not isinstance(part, int)).removeprefix(f"{section}.")
    if error["type"] == "extra_forbidden":
        known = list(_SECTIONS[section].model_fields if len(location) > 1 else ModelFile.model_fields)
        near = get_close_matches(key, known, n=1)
        mend = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"
        return f"unknown key {shortened(key)}{place} ({mend}); correct it or take it out"
    if error["type"] == "missing":
        kind = "table" if len(location) == 1 else "key"
        return f"the {kind} {key!r} is missing{place}; add it"
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
