"""A dask cluster as an executor, for horizons that are rebuilt side by side."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from importlib import import_module

from graben.errors import InputError

#: Seconds after which a scheduler that has not answered is taken to be away.
_PATIENCE = 10.0


@contextmanager
def cluster(address: str | None) -> Iterator[Executor | None]:
    """Give what runs work on a cluster; None without an address, where all is to be done here.

    Parameters
    ----------
    address : str or None
        Of a dask scheduler, such as ``tcp://host:8786``.

    Raises
    ------
    InputError
        When dask is not installed, or no scheduler answers.
    """
    if address is None:
        yield None
        return
    try:
        distributed = import_module("distributed")
    except ImportError:
        raise InputError("--scheduler needs dask, which is not here: pip install 'graben[dask]'.") from None
    try:
        client = distributed.Client(address, timeout=_PATIENCE)
    except (OSError, ValueError) as error:
        raise InputError(f"No scheduler answers at {address} ({error}); correct --scheduler.") from error
    with client:
        executor: Executor = client.get_executor()
        yield executor
