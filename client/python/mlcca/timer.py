# SPDX-License-Identifier: BSD-2-Clause
"""A timer as a file descriptor, timerfd_create(2), which os has only since Python 3.13."""
from __future__ import annotations

import ctypes
import math
import os
import time
from typing import Optional

TFD_TIMER_ABSTIME = 1
NANOSECONDS = 1_000_000_000


class _Timespec(ctypes.Structure):
    _fields_ = [("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long)]


class _Itimerspec(ctypes.Structure):
    _fields_ = [("interval", _Timespec), ("value", _Timespec)]


_libc = ctypes.CDLL(None, use_errno=True)
_libc.timerfd_create.argtypes = (ctypes.c_int, ctypes.c_int)
_libc.timerfd_settime.argtypes = (ctypes.c_int, ctypes.c_int, ctypes.POINTER(_Itimerspec), ctypes.c_void_p)


def _failed() -> OSError:
    number = ctypes.get_errno()
    return OSError(number, os.strerror(number))


class Timer:
    """It is readable from the time on that expire_at() sets, until that sets another one."""

    def __init__(self) -> None:
        self._at: Optional[float] = None
        self._fd = int(_libc.timerfd_create(time.CLOCK_MONOTONIC, os.O_CLOEXEC | os.O_NONBLOCK))
        if self._fd < 0:
            raise _failed()

    def fileno(self) -> int:
        return self._fd

    def expire_at(self, at: Optional[float]) -> None:
        """`at`: a time of time.monotonic(), in seconds; None: it does not expire."""
        if at == self._at:
            return
        # All 0 would stop the timer.
        seconds, nanoseconds = divmod(max(math.ceil(at * NANOSECONDS), 1) if at is not None else 0, NANOSECONDS)
        value = _Itimerspec(value=_Timespec(seconds, nanoseconds))
        if _libc.timerfd_settime(self._fd, TFD_TIMER_ABSTIME, ctypes.byref(value), None) != 0:
            raise _failed()
        self._at = at

    def close(self) -> None:
        os.close(self._fd)
