"""Hands, which RAPID has no words for: an output opens one when 1 and closes it when 0."""

from __future__ import annotations

import re
from typing import Final, Literal

from assistant.program import expressions as e
from assistant.program import statements as p

_HAND_SIGNAL: Final = "hand{hand}_open"
_HAND_SIGNAL_NAME: Final = re.compile(_HAND_SIGNAL.format(hand="([1-9][0-9]?)"), re.IGNORECASE)
_HAND_ACTIONS: Final[dict[float, Literal["open", "close"]]] = {1: "open", 0: "close"}


def hand_of(signal: str) -> int | None:
    """The hand that a signal of that name opens, None if it is another signal."""
    name = _HAND_SIGNAL_NAME.fullmatch(signal)
    return None if name is None else int(name[1])


def hand_signal(hand: int) -> str:
    return _HAND_SIGNAL.format(hand=hand)


def gripper(signal: str, value: e.Expression) -> p.Gripper | None:
    """The hand that setting a signal opens or closes, if it is one of a hand."""
    hand = hand_of(signal)
    if hand is None or not isinstance(value, e.Number) or value.value not in _HAND_ACTIONS:
        return None
    return p.Gripper(_HAND_ACTIONS[value.value], hand)
