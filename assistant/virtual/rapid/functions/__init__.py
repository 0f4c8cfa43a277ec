"""The functions of every controller that are simulated, by name in lower case."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.virtual.rapid.functions import (
    bits,
    data,
    frames,
    numbers,
    places,
    positions,
    texts,
    times,
)
from assistant.virtual.rapid.instructions import (
    dialogs,
    files,
    modules,
    raw,
    sockets,
    stopping,
    tasks,
)
from assistant.virtual.rapid.machine import Function

FUNCTIONS: Final[Mapping[str, Function]] = {
    **numbers.NUMBER_FUNCTIONS,
    **bits.BIT_FUNCTIONS,
    **texts.STRING_FUNCTIONS,
    **places.POSE_FUNCTIONS,
    **positions.ARM_FUNCTIONS,
    **frames.FRAME_FUNCTIONS,
    **data.RUN_FUNCTIONS,
    **times.DATE_FUNCTIONS,
    **dialogs.DIALOG_FUNCTIONS,
    **files.FILE_FUNCTIONS,
    **modules.MODULE_FUNCTIONS,
    **raw.RAW_FUNCTIONS,
    **sockets.SOCKET_FUNCTIONS,
    **stopping.STOP_FUNCTIONS,
    **tasks.TASK_FUNCTIONS,
}
