"""Signals that open and close hands."""

from __future__ import annotations

import re
from typing import Final

from assistant.languages.rapid.tables.words import GRIPPER_SIGNAL, GRIPPER_VALUE
from assistant.program import expressions as e
from assistant.program import statements as p


def gripper(signal: str, value: e.Expression) -> p.Gripper | None:
    """The hand that setting a signal opens or closes, if it is one of a hand."""
    match = _HAND.fullmatch(signal)
    if match is None or not isinstance(value, e.Number) or value.value not in _ACTION:
        return None
    return p.Gripper(_ACTION[int(value.value)], int(match[1]))  # type: ignore[arg-type]


_HAND: Final = re.compile(GRIPPER_SIGNAL.format(hand="([1-9][0-9]?)"), re.IGNORECASE)
_ACTION: Final = {value: action for action, value in GRIPPER_VALUE.items()}
