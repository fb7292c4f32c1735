"""What graben raises: misuse and unreadable input, never a defect of the data."""

from __future__ import annotations


class GrabenError(Exception):
    """Base of everything graben raises on purpose; its text is one sentence for the user."""


class InputError(GrabenError):
    """A file or key that cannot be read: names the file, the place in it and the mend."""


class OutputError(GrabenError):
    """An output that cannot be written, such as a folder that is not empty."""


class ModelingError(GrabenError):
    """A horizon that cannot be modeled; the text says why.

    ``place`` is where, (x, y, z) in the frame that was worked in, or None: as numbers, so that it can be told
    in the frame of the input.
    """

    def __init__(self, text: str, place: tuple[float, float, float] | None = None) -> None:
        super().__init__(text)
        self.place = place


def sentence_of(error: Exception) -> str:
    """Return what to say of an error, in one line.

    >>> sentence_of(InputError("model.toml has no faults: name some."))
    'model.toml has no faults: name some.'
    """
    if isinstance(error, GrabenError):
        said = str(error)
    elif isinstance(error, (OSError, MemoryError)):
        said = f"{type(error).__name__}: {error}"
    else:
        said = f"graben met an error of its own ({type(error).__name__}: {error}); --debug shows where."
    return " ".join(said.split())
