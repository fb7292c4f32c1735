"""graben's values as bytes and back, to the bit: what a run keeps of its work until it ends.

A value is told as JSON, whose numbers have every digit; its arrays go beside it into an .npz archive. Nothing
in the archive can run code on reading, as a pickle could.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from graben.errors import GrabenError

#: Rises when the bytes of the same value change.
_FORMAT = 1
_HEAD = "value"
#: Classes are looked for in this package alone.
_PACKAGE = "graben."


class NotKeptError(GrabenError):
    """Bytes that are no value kept by this version of graben."""


def to_bytes(value: Any) -> bytes:
    """Return a value as bytes.

    Parameters
    ----------
    value : object
        None, a number, a string, a path, an array, an enumeration or a dataclass of graben's, or tuples,
        lists and mappings of these.

    Raises
    ------
    TypeError
        When something in it is of another kind.

    Examples
    --------
    >>> from_bytes(to_bytes({"a": (1, 0.1, None)}))
    {'a': (1, 0.1, None)}
    """
    arrays: list[NDArray[Any]] = []
    told = {"format": _FORMAT, "value": _told(value, arrays)}
    head = np.frombuffer(json.dumps(told).encode(), dtype=np.uint8)
    stream = BytesIO()
    named: dict[str, Any] = {_HEAD: head, **{str(k): array for k, array in enumerate(arrays)}}
    np.savez(stream, **named)
    return stream.getvalue()


def from_bytes(content: bytes) -> Any:
    """Return the value of :func:`to_bytes`.

    Raises
    ------
    NotKeptError
        When the bytes are damaged, or were made by a version of graben whose values were different.
    """
    try:
        with np.load(BytesIO(content), allow_pickle=False) as archive:
            told = json.loads(archive[_HEAD].tobytes())
            if told["format"] != _FORMAT:
                raise NotKeptError(f"Kept in format {told['format']}; this version reads {_FORMAT}.")
            return _value(told["value"], archive)
    except (
        BadZipFile,
        OSError,
        EOFError,
        ValueError,
        KeyError,
        TypeError,
        AttributeError,
        ImportError,
    ) as error:
        raise NotKeptError(f"Does not read back ({type(error).__name__}: {error}).") from error


def _told(value: Any, arrays: list[NDArray[Any]]) -> Any:
    """Return a value for JSON; all but the plainest is a list of one name and what belongs to it."""
    told: Any = value
    match value:
        case Enum():  # before the plain kinds, which some are as well
            told = ["enum", _name(type(value)), value.value]
        case np.ndarray() | np.generic():
            if value.dtype.hasobject:
                raise TypeError("An array of objects cannot be kept.")
            arrays.append(np.asarray(value))
            told = ["array" if isinstance(value, np.ndarray) else "number", len(arrays) - 1]
        case None | bool() | int() | float() | str():
            pass
        case tuple() | list():
            kind = "tuple" if isinstance(value, tuple) else "list"
            told = [kind, [_told(item, arrays) for item in value]]
        case Mapping():
            told = ["mapping", [[_told(k, arrays), _told(v, arrays)] for k, v in value.items()]]
        case Path():
            told = ["path", str(value)]
        case _ if is_dataclass(value) and not isinstance(value, type):
            own = {f.name: _told(getattr(value, f.name), arrays) for f in fields(value)}
            told = ["dataclass", _name(type(value)), own]
        case _:
            raise TypeError(f"A {type(value).__name__} cannot be kept.")
    return told


def _value(told: Any, archive: Mapping[str, NDArray[Any]]) -> Any:
    value: Any = told
    match told:
        case ["enum", str(name), plain]:
            value = _class(name)(plain)
        case ["array", int(number)]:
            value = archive[str(number)]
        case ["number", int(number)]:
            value = archive[str(number)][()]
        case ["tuple", [*items]]:
            value = tuple(_value(item, archive) for item in items)
        case ["list", [*items]]:
            value = [_value(item, archive) for item in items]
        case ["mapping", [*pairs]]:
            value = {_value(k, archive): _value(v, archive) for k, v in pairs}
        case ["path", str(name)]:
            value = Path(name)
        case ["dataclass", str(name), dict(own)]:
            value = _class(name)(**{key: _value(item, archive) for key, item in own.items()})
        case [*_] | dict():
            raise ValueError(f"nothing is told as {str(told)[:40]}")
    return value


def _name(kind: type) -> str:
    if not kind.__module__.startswith(_PACKAGE):
        raise TypeError(f"A {kind.__name__} of {kind.__module__} cannot be kept.")
    return f"{kind.__module__}:{kind.__qualname__}"


def _class(name: str) -> Any:
    module, _, own = name.partition(":")
    found = getattr(import_module(module), own) if module.startswith(_PACKAGE) else None
    if not isinstance(found, type) or not (is_dataclass(found) or issubclass(found, Enum)):
        raise ValueError(f"{name} is no value of graben's")
    return found
