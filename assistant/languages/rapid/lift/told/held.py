"""Moves that are held and let go again (`StopMove`, `StartMove`) where nothing moves in between."""

from __future__ import annotations

from dataclasses import replace

from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.told.calls import call_of, word_of
from assistant.languages.rapid.lift.told.left_out import INSTRUCTIONS
from assistant.program import statements as p
from assistant.program.diagnostics import Findings
from assistant.program.kept import effect_of
from assistant.program.program import Program, walk
from assistant.program.rewriting import Body, map_bodies

_HOLD, _LET_GO = "stopmove", "startmove"


def with_held_moves(program: Program, findings: Findings) -> Program:
    """The program without holding moves that are let go before the arm is to move."""

    def body(statements: Body) -> Body:
        made: list[p.Statement] = []
        for place, node in enumerate(statements):
            if _word(node) == _HOLD and _is_let_go(statements[place + 1 :]):
                loss, cure = INSTRUCTIONS[_LET_GO]
                with findings.at(node.span):
                    findings.append(rules.LEFT_OUT(what="StopMove", loss=loss, cure=cure))
            else:
                made.append(map_bodies(node, body))
        return tuple(made)

    if not any(_word(node) == _HOLD for node in program.statements()):
        return program
    return replace(
        program, procedures=tuple(replace(q, body=body(q.body)) for q in program.procedures)
    )


def _word(node: p.Statement) -> str:
    call = call_of(node) if isinstance(node, p.Opaque) else None
    return "" if call is None else word_of(call)


def _is_let_go(behind: Body) -> bool:
    """Whether moves are let go before anything may move the arm or lead elsewhere."""
    for node in behind:
        if _word(node) == _LET_GO:
            return True
        if any(map(_goes_on, walk((node,)))):
            return False
    return False


def _goes_on(node: p.Statement) -> bool:
    match node:
        case p.Opaque():
            effect = effect_of(node)
            return effect.moves or effect.jumps or bool(effect.calls)
        case p.Follow() | p.Call() | p.Return() | p.Goto() | p.Label() | p.Stop():
            return True
    return isinstance(node, p.MoveStatement)
