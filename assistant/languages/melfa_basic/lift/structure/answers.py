"""Lines that do nothing but call what answers an interrupt."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.languages.melfa_basic.lift.structure.regions import place_name
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import statement_of

Answers = Mapping[str, s.Jump | s.Call]
"""The call that interrupts lead to, by the label of its lines in upper case."""
_SHUT: Final = s.Command("Act", (s.Binary("=", s.Number(0), s.Number(0)),))
_OPEN: Final = s.Command("Act", (s.Binary("=", s.Number(0), s.Number(1)),))
_BACK: Final = s.Command("Return", (s.Number(0),))
_END: Final = s.Command("End")


def without_answers(code: list[s.Entry]) -> tuple[list[s.Entry], Answers]:
    """The lines of a program that was written here without those, and what they call."""
    wanted = {
        place_name(node.target) for item in code if isinstance(node := statement_of(item), s.DefAct)
    }
    if not wanted:
        return code, {}
    found: dict[str, s.Jump | s.Call] = {}
    left: list[s.Entry] = []
    at = 0
    while at < len(code):
        label = code[at].label
        after, call = _answer(code, at + 1) if label and label.upper() in wanted else (0, None)
        if label is None or call is None:
            left.append(code[at])
            at += 1
            continue
        found[label.upper()] = call
        at = after
        if at < len(code) and statement_of(code[at]) == s.Command("FEnd") and _ends(left):
            left.pop()
    return left, found


def _answer(code: list[s.Entry], at: int) -> tuple[int, s.Jump | s.Call | None]:
    """The call of the lines below a label, and the place behind them."""
    lines = [statement_of(item) for item in code[at : at + 4]]
    match lines:
        case [s.Jump("GoSub") | s.Call() as call, back, *_] if back == _BACK:
            return at + 2, call
        case [shut, s.Jump("GoSub") | s.Call() as call, open, back] if (shut, open, back) == (
            _SHUT, _OPEN, _BACK,
        ):  # fmt: skip
            return at + 4, call
    return 0, None


def _ends(code: list[s.Entry]) -> bool:
    return bool(code) and code[-1].label is None and statement_of(code[-1]) == _END
