"""Rules of what stands in a row: corners that are left on at a stop, the tool, pulses at a time."""

from __future__ import annotations

from typing import Final

from assistant.languages.checks.registry import Found
from assistant.languages.melfa_basic.checks import motion_rules as rules
from assistant.languages.melfa_basic.checks import value_rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.tables.words import MOST_PULSES
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import is_block_word
from assistant.languages.melfa_basic.tree.columnar import KEYWORDS, MoveRows
from assistant.languages.melfa_basic.tree.walk import lines_with, literal

STOPPING_COMMANDS: Final = frozenset({"Hlt", "End", "Dly", "HOpen", "HClose"})
WAITING_COMMANDS: Final = frozenset({"Wait"})


def corners_at_stops(look: Look) -> Found:
    """Corners that are left on where the program stops or waits behind a move."""
    rounded: bool | None = False
    moved = False
    for item in look.code:
        if isinstance(item, MoveRows):
            moved = True
            continue
        statement = item.statement
        if item.label is not None or is_block_word(statement):
            rounded, moved = None, False
        match statement:
            case s.Motion():
                moved = statement.append is None
            case s.Command("Cnt", arguments):
                value = literal(arguments[0]) if arguments else None
                rounded = None if value is None else value != 0
                moved = False
            case s.Command(keyword=word) if word in STOPPING_COMMANDS or word in WAITING_COMMANDS:
                if rounded and moved:
                    yield look.at(rules.CNT_LEFT, item, word, word=word)
                moved = False
                if word == "End":
                    rounded = False
            case s.Jump() | s.CallP() | s.Call() | s.OnJump():
                rounded, moved = None, False


def missing_tool(look: Look) -> Found:
    """Programs that move and set no tool."""
    if look.compiled or look.once(_sets_tool):
        return
    for item in look.code:
        if isinstance(item, MoveRows):
            word = KEYWORDS[int(item.kinds[0])]
            yield look.finding(rules.NO_TOOL, look.row(item, 0, word))
            return
        if isinstance(item.statement, s.Motion):
            yield look.at(rules.NO_TOOL, item, item.statement.keyword)
            return


def _sets_tool(look: Look) -> bool:
    return any(
        command.keyword == "Tool"
        for tree in look.calls.trees
        for _, command in lines_with(tree.items, s.Command)
    ) or any(use.variable.key == "M_TOOL" and use.role == "written" for _, use in look.uses)


def pulses_at_a_time(look: Look) -> Found:
    """More pulses in a row than run beside each other, with nothing between that takes time."""
    count = 0
    for item in look.code:
        statement = item.statement
        other = statement is not None and not isinstance(statement, s.Assign)
        if other or isinstance(item, MoveRows) or item.label is not None:
            count = 0
        if isinstance(statement, s.Assign) and statement.delay is not None:
            count += 1
            if count == MOST_PULSES + 1:
                yield look.finding(value_rules.MANY_PULSES, item, most=MOST_PULSES)
