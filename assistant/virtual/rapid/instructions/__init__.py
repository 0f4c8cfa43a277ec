"""The instructions of every controller that are simulated, by name in lower case."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.virtual.rapid.instructions import (
    dialogs,
    displacing,
    errors,
    files,
    interrupts,
    modules,
    motions,
    naming,
    others,
    processes,
    raw,
    searching,
    signals,
    sockets,
    stopping,
    tasks,
    waits,
)
from assistant.virtual.rapid.machine import Function

INSTRUCTIONS: Final[Mapping[str, Function]] = {
    **motions.TABLE,
    **signals.TABLE,
    **others.TABLE,
    **processes.TABLE,
    **displacing.TABLE,
    **errors.TABLE,
    **files.INSTRUCTIONS,
    **dialogs.INSTRUCTIONS,
    **files.INSTRUCTIONS,
    **interrupts.TABLE,
    **raw.INSTRUCTIONS,
    **sockets.INSTRUCTIONS,
    **searching.TABLE,
    **stopping.TABLE,
    **tasks.INSTRUCTIONS,
    **waits.TABLE,
    **naming.TABLE,
    **modules.INSTRUCTIONS,
}
