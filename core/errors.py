"""What graben raises: misuse and unreadable input, never a defect of the data."""

from __future__ import annotations


class GrabenError(Exception):
    """Base of everything graben raises on purpose; its text is one sentence for the user."""


class InputError(GrabenError):
    """A file or key that cannot be read: names the file, the place in it and the mend."""


class OutputError(GrabenError):
    """An output that cannot be written, such as a folder that is not empty."""


class ModelingError(GrabenError):
    """A horizon that cannot be modeled; the text says why and where."""
