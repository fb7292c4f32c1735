"""What the process asks of the system's memory, for runs on large models."""

from __future__ import annotations

import ctypes
import sys

#: Of glibc's malloc.h.
_M_TRIM_THRESHOLD, _M_MMAP_MAX = -1, -4
_MOST = 2**31 - 1  # bytes; the largest int


def keep_freed() -> None:
    """Have memory that is freed kept for what comes next, where the C library can (glibc).

    By default each large array is a mapping of its own, given back when it is freed, and the next one is
    filled with zeros page by page anew: on a horizon of a million nodes a sixth of all time. Kept, the peak
    is about a fifth higher, since what is free lies in pieces.
    """
    if sys.platform != "linux":
        return
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, AttributeError):
        return  # another C library
    mallopt(_M_MMAP_MAX, 0)
    mallopt(_M_TRIM_THRESHOLD, _MOST)
