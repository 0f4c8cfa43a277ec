"""Which data instructions set up for moves, and which moves take."""

from __future__ import annotations

from assistant.languages.rapid.tables.triggers import (
    FURTHER_TRIGGERS,
    TRIGGER_MOVES,
    TRIGGER_SETUPS,
)
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import positional


def trigger_set_up(node: s.Node) -> str:
    """The lower-case name of the variable that an instruction sets up; empty for others."""
    match node:
        case s.ProcedureCall(str(word), (s.Positional(s.NameRef(name), None), *_)) if (
            word.lower() in TRIGGER_SETUPS
        ):
            return name.lower()
    return ""


def triggers_taken(node: s.Node) -> tuple[s.NameRef, ...]:
    """The plain variables that a move takes; none for what is no such move."""
    move = TRIGGER_MOVES.get(str(node.name).lower()) if isinstance(node, s.ProcedureCall) else None
    if move is None or not isinstance(node, s.ProcedureCall):
        return ()
    given = positional(node)
    more = [
        x.value
        for x in node.arguments
        if isinstance(x, s.Option) and x.name.lower() in FURTHER_TRIGGERS
    ]
    named = (*given[move.place : move.place + 1], *more)
    return tuple(one for one in named if isinstance(one, s.NameRef))
