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
    **motions.MOTION_INSTRUCTIONS,
    **signals.SIGNAL_INSTRUCTIONS,
    **others.RUN_INSTRUCTIONS,
    **processes.PROCESS_INSTRUCTIONS,
    **displacing.DISPLACEMENT_INSTRUCTIONS,
    **errors.ERROR_INSTRUCTIONS,
    **files.FILE_INSTRUCTIONS,
    **dialogs.DIALOG_INSTRUCTIONS,
    **files.FILE_INSTRUCTIONS,
    **interrupts.INTERRUPT_INSTRUCTIONS,
    **raw.RAW_INSTRUCTIONS,
    **sockets.SOCKET_INSTRUCTIONS,
    **searching.SEARCH_INSTRUCTIONS,
    **stopping.STOP_INSTRUCTIONS,
    **tasks.TASK_INSTRUCTIONS,
    **waits.WAIT_INSTRUCTIONS,
    **naming.NAME_INSTRUCTIONS,
    **modules.MODULE_INSTRUCTIONS,
}
