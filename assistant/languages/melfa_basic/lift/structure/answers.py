"""Lines that do nothing but call what answers an interrupt."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.languages.melfa_basic.lift.structure.regions import target_name
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import statement_of

Answer = tuple[s.Jump | s.Call, s.Expression | None]
"""The call that an interrupt leads to, and the condition on which the program ends behind it."""
Answers = Mapping[str, Answer]
"""By the label of its lines in upper case."""
_SHUT: Final = s.Command("Act", (s.Binary("=", s.Number(0), s.Number(0)),))
_OPEN: Final = s.Command("Act", (s.Binary("=", s.Number(0), s.Number(1)),))
_BACK: Final = s.Command("Return", (s.Number(0),))
_END: Final = s.Command("End")


def without_trampolines(code: list[s.Entry]) -> tuple[list[s.Entry], Answers]:
    """The lines of a program that was written here without those, and what they call."""
    wanted = {
        target_name(node.target)
        for item in code
        if isinstance(node := statement_of(item), s.DefAct)
    }
    if not wanted:
        return code, {}
    found: dict[str, Answer] = {}
    left: list[s.Entry] = []
    at = 0
    while at < len(code):
        label = code[at].label
        after, answer = (
            _trampoline(code, at + 1) if label and label.upper() in wanted else (0, None)
        )
        if label is None or answer is None:
            left.append(code[at])
            at += 1
            continue
        found[label.upper()] = answer
        at = after
        if at < len(code) and statement_of(code[at]) == s.Command("FEnd") and _ends_program(left):
            left.pop()
    return left, found


def _trampoline(code: list[s.Entry], at: int) -> tuple[int, Answer | None]:
    """The call of the lines below a label, and the place behind them."""
    lines = [statement_of(item) for item in code[at : at + 5]]
    shut = bool(lines) and lines[0] == _SHUT
    match lines[shut:]:
        case [s.Jump("GoSub") | s.Call() as call, *rest]:
            end = at + shut + 1
        case _:
            return 0, None
    if shut:
        if not rest or rest[0] != _OPEN:
            return 0, None
        rest, end = rest[1:], end + 1
    ends = None
    match rest:
        case [s.If(condition, s.Command("End"), None), *rest]:
            ends, end = condition, end + 1
    return (end + 1, (call, ends)) if rest and rest[0] == _BACK else (0, None)


def _ends_program(code: list[s.Entry]) -> bool:
    return bool(code) and code[-1].label is None and statement_of(code[-1]) == _END
