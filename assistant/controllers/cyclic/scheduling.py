"""What the loop asks of the machine: priority, memory that stays, no garbage collected."""

from __future__ import annotations

import ctypes
import gc
import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from pathlib import Path as FilePath
from typing import Final

from assistant.controllers.cyclic.settings import PRIORITY

_DMA_LATENCY: Final = "/dev/cpu_dma_latency"
_CURRENT: Final = 1
_FUTURE: Final = 2
"""MCL_CURRENT and MCL_FUTURE of Linux."""


@contextmanager
def real_time(wanted: bool) -> Iterator[tuple[str, str]]:
    """In here the garbage collector is off and, where that is permitted, the priority real-time.

    Yields what it runs with, and why that is no real-time priority ("" if none was wanted).
    """
    said = _priority() if wanted else ("ordinary priority", "")
    _keep_memory()
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        with _awake() if wanted else nullcontext():
            yield said
    finally:
        gc.enable()
        gc.unfreeze()
        if said[0].startswith("SCHED_FIFO"):
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


@contextmanager
def _awake() -> Iterator[None]:
    """Where that is permitted, processors do not sleep as long as the file is open.

    It takes the microseconds that waking up may last (Documentation/power/pm_qos_interface.rst of
    Linux).
    """
    with ExitStack() as kept:
        with suppress(OSError):
            kept.enter_context(FilePath(_DMA_LATENCY).open("wb", buffering=0)).write(bytes(4))
        yield


def _keep_memory() -> None:
    """Keeps all pages in memory where that is permitted: to fetch one again may cost a cycle."""
    if sys.platform == "linux":
        ctypes.CDLL(None).mlockall(_CURRENT | _FUTURE)


def _priority() -> tuple[str, str]:
    if not hasattr(os, "sched_setscheduler"):
        return "ordinary priority", "this system has no SCHED_FIFO"
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except OSError as error:
        return "ordinary priority", f"SCHED_FIFO is not permitted: {error.strerror}"
    return f"SCHED_FIFO {PRIORITY}", ""
