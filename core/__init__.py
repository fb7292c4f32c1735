"""graben: quality control, repair and structural modeling of geological faults and horizons."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graben.errors import GrabenError as GrabenError
    from graben.errors import InputError as InputError
    from graben.finding import Profile as Profile
    from graben.model import Fault as Fault
    from graben.model import Horizon as Horizon
    from graben.model import Model as Model
    from graben.pipeline import build as build
    from graben.pipeline import check as check
    from graben.reading import read_model as read_model
    from graben.repairs import repair as repair
    from graben.reports.saving import write as write
    from graben.surface import Surface as Surface

__version__ = "0.1.0"

# Imported on first use, so that the command line answers at once and can set the number of threads first.
_HOMES = {
    "Fault": "graben.model",
    "GrabenError": "graben.errors",
    "Horizon": "graben.model",
    "InputError": "graben.errors",
    "Model": "graben.model",
    "Profile": "graben.finding",
    "Surface": "graben.surface",
    "build": "graben.pipeline",
    "check": "graben.pipeline",
    "read_model": "graben.reading",
    "repair": "graben.repairs",
    "write": "graben.reports.saving",
}

__all__ = [*_HOMES]  # noqa: PLE0604  a literal list would be a second place for the names


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'graben' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOMES])
