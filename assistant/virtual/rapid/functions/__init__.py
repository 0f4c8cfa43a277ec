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
    **numbers.TABLE,
    **bits.TABLE,
    **texts.TABLE,
    **places.TABLE,
    **positions.TABLE,
    **frames.TABLE,
    **data.TABLE,
    **times.TABLE,
    **dialogs.FUNCTIONS,
    **files.FUNCTIONS,
    **modules.FUNCTIONS,
    **raw.FUNCTIONS,
    **sockets.FUNCTIONS,
    **stopping.FUNCTIONS,
    **tasks.FUNCTIONS,
}
