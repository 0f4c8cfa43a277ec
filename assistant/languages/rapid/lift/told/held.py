"""Moves that are held and let go again (`StopMove`, `StartMove`) where nothing moves in between."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial
from typing import Any, Final

from assistant.base.diagnostics import Findings
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.told.calls import instruction_of, word_of
from assistant.languages.rapid.lift.told.left_out import OMITTED_INSTRUCTIONS
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program, walk
from assistant.program.rewriting import Body, map_bodies, map_head, records
from assistant.program.vendor_statements import effect_of

_STOP_MOVE, _START_MOVE = "stopmove", "startmove"
_IS_STOPPED: Final = re.compile(r"IsStopMoveAct\b.*", re.IGNORECASE | re.DOTALL)


def with_held_moves(program: Program, findings: Findings) -> Program:
    """The program without holding moves that are let go before the arm is to move.

    Nor does it ask whether they are held, where nothing holds them any longer.
    """

    def body(statements: Body, after: Body = ()) -> Body:
        made: list[p.Statement] = []
        for place, node in enumerate(statements):
            behind = (*statements[place + 1 :], *after)
            if _instruction_word(node) == _STOP_MOVE and _is_released(behind):
                loss, cure = OMITTED_INSTRUCTIONS[_START_MOVE]
                with findings.at(node.span):
                    findings.append(rules.LEFT_OUT(what="StopMove", loss=loss, cure=cure))
            else:
                inside = () if isinstance(node, p.While | p.For) else behind
                made.append(map_bodies(node, partial(body, after=inside)))
        return tuple(made)

    if any(_instruction_word(node) == _STOP_MOVE for node in program.statements()):
        procedures = (replace(q, body=body(q.body)) for q in program.procedures)
        program = replace(program, procedures=tuple(procedures))
    return (
        program
        if any(map(_holds_moves, program.statements()))
        else _with_moves_never_held(program, findings)
    )


def _holds_moves(node: p.Statement) -> bool:
    """Whether moves are held behind a statement, as far as its text tells."""
    return isinstance(node, p.Opaque) and _STOP_MOVE in node.text.lower()


def _with_moves_never_held(program: Program, findings: Findings) -> Program:
    """The program in which moves are never held."""

    def answered(part: Any) -> Any:
        if isinstance(part, e.Verbatim) and _IS_STOPPED.fullmatch(part.text):
            findings.append(
                rules.LEFT_OUT(what=part.text, loss=_NEVER_HELD[0], cure=_NEVER_HELD[1])
            )
            return e.Truth(False)
        return part

    def body(statements: Body) -> Body:
        made = []
        for node in statements:
            with findings.at(node.span):
                own = map_head(node, answered)
            made.append(map_bodies(own, body))
        return tuple(made)

    if not any(
        isinstance(r, e.Verbatim) and _IS_STOPPED.fullmatch(r.text) for r in records(program)
    ):
        return program
    procedures = (replace(q, body=body(q.body)) for q in program.procedures)
    return replace(program, procedures=tuple(procedures))


_NEVER_HELD: Final = (
    "it is false, as nothing here holds the moves of the arm",
    "ask for a signal if anybody else may hold it",
)


def _instruction_word(node: p.Statement) -> str:
    call = instruction_of(node) if isinstance(node, p.Opaque) else None
    return "" if call is None else word_of(call)


def _is_released(behind: Body) -> bool:
    """Whether moves are let go before anything may move the arm or lead elsewhere."""
    for node in behind:
        if _instruction_word(node) == _START_MOVE:
            return True
        if any(map(_continues_unmoved, walk((node,)))):
            return False
    return False


def _continues_unmoved(node: p.Statement) -> bool:
    match node:
        case p.Opaque():
            effect = effect_of(node)
            return effect.moves or effect.jumps or bool(effect.calls)
        case p.Follow() | p.Call() | p.Return() | p.Goto() | p.Label() | p.Stop():
            return True
    return isinstance(node, p.MoveStatement)
