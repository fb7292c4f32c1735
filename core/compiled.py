"""Loops over arrays, compiled to machine code by numba when they are first called."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from importlib import import_module
from typing import Any, TypeVar, cast

_Loop = TypeVar("_Loop", bound=Callable[..., Any])


def compiled(loop: _Loop) -> _Loop:
    """Return a function compiled for the types of the arrays that it is called with.

    Neither numba is loaded nor anything compiled before the first call. The code is kept beside the module,
    or in the user's cache, for the next process; where neither can be written to, each process compiles
    anew, which takes a few tenths of a second. Arithmetic is IEEE's, in the order that is written, with no
    error on division by zero; the interpreter is released meanwhile.
    """

    @cache
    def machine_code() -> Callable[..., Any]:
        njit = import_module("numba").njit
        options = {"error_model": "numpy", "nogil": True}
        try:
            return cast("Callable[..., Any]", njit(cache=True, **options)(loop))
        except RuntimeError:
            return cast("Callable[..., Any]", njit(**options)(loop))

    @wraps(loop)
    def run(*arrays: Any) -> Any:
        return machine_code()(*arrays)

    return cast(_Loop, run)
