"""What is written alike as a truth and as bits of a number."""

from __future__ import annotations

from collections.abc import Mapping

from assistant.program import expressions as e
from assistant.program.program import Signal


def is_truth(value: e.Expression, signals: Mapping[str, Signal]) -> bool:
    """Whether a value is written as a truth is: 0, 1 or a digital signal.

    signals: by lower-case name.
    """
    match value:
        case e.Number(number):
            return number in (0, 1)
        case e.Name(name):
            known = signals.get(name.lower())
            return known is not None and known.kind == "digital"
    return False
