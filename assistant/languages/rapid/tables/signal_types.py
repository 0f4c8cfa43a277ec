"""Types of RAPID data that stand for signals (reference manual, data types signalxi, signalxo)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.program.program import Signal

SIGNAL_TYPES: Final[Mapping[str, Signal]] = {
    "signaldo": Signal("digital", "output"), "signaldi": Signal("digital", "input"),
    "signalgo": Signal("group", "output"), "signalgi": Signal("group", "input"),
    "signalao": Signal("analog", "output"), "signalai": Signal("analog", "input"),
}  # fmt: skip
"""By type of data, in lower case, what it stands for."""
VALUE_FUNCTIONS: Final[Mapping[str, str]] = {
    "signaldo": "DOutput", "signaldi": "DInput", "signalgo": "GOutput", "signalgi": "GInput",
    "signalao": "AOutput", "signalai": "AInput",
}  # fmt: skip
"""By the same, the function that gives its value."""
SIGNAL_READ_BY: Final[Mapping[str, Signal]] = {
    VALUE_FUNCTIONS[type].lower(): SIGNAL_TYPES[type] for type in VALUE_FUNCTIONS
}
"""By the name of such a function, in lower case, what it reads."""
