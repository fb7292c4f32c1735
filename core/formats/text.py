"""Bytes and text of input files, with every failure told in one sentence."""

from __future__ import annotations

from pathlib import Path

from graben.errors import InputError

# Control characters other than tab, line feed, vertical tab, form feed and carriage return never stand in a
# text file of these formats.
_BINARY = bytes(range(0x09)) + bytes(range(0x0E, 0x20)) + b"\x7f"


def load_bytes(path: Path) -> bytes:
    """Return the content of a file that must exist and hold something.

    Raises
    ------
    InputError
        When the file is missing, empty, a folder, a device or a pipe, or may not be read.
    """
    if path.is_dir():
        raise InputError(f"{path} is a folder; give the file in it.")
    try:
        if path.exists() and not path.is_file():
            # Devices and pipes may give bytes for ever, or none and no end.
            raise InputError(f"{path} is a device or a pipe; copy what it gives into a file.")
        content = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path} does not exist; correct the path.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path} cannot be read ({reason}); check its name and its permissions.") from None
    if not content.strip():
        raise InputError(f"{path} is empty; export it again.")
    return content


def is_text(content: bytes) -> bool:
    """Return whether no byte of the content is one that only binary files hold.

    >>> is_text(b"1 2 3"), is_text(b"1 2\\x00")
    (True, False)
    """
    return len(content.translate(None, _BINARY)) == len(content)


def decoded(content: bytes, path: Path) -> str:
    """Return the content as text: UTF-8, else Latin-1, which older programs write.

    Raises
    ------
    InputError
        When the content holds bytes that only binary files (or UTF-16 text) hold.
    """
    if not is_text(content):
        raise InputError(f"{path} is not a text file; export it as text in UTF-8, or give the right file.")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def load_text(path: Path) -> str:
    """Return the text of a file; see :func:`load_bytes` and :func:`decoded` for what is raised."""
    return decoded(load_bytes(path), path)


def shortened(word: str, length: int = 40) -> str:
    """Return a word of the input fit to be quoted in a sentence: repr, cut at ``length`` characters.

    >>> shortened("abc")
    "'abc'"
    """
    return repr(word if len(word) <= length else word[: length - 3] + "...")
