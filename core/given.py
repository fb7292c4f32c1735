"""What the calls of the Python interface take for a model."""

from __future__ import annotations

import os
from pathlib import Path

from graben.model import Model
from graben.reading import read_model


def given(model: Model | str | os.PathLike[str]) -> Model:
    """Return a model as it is, and that of a model.toml which is named by its path.

    Raises
    ------
    TypeError
        When it is neither.
    InputError
        When the file cannot be read.
    """
    if isinstance(model, Model):
        return model
    if isinstance(model, str | os.PathLike):
        return read_model(Path(model))
    raise TypeError(
        f"A model or the path of a model.toml is needed, not {type(model).__name__}: see graben.read_model."
    )
