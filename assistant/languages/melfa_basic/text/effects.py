"""Effects of vendor text in MELFA-BASIC, read off its tree."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

from assistant.base.source_text import words_of
from assistant.languages.melfa_basic.reading.line import expression
from assistant.languages.melfa_basic.reading.line import statement as read_statement
from assistant.languages.melfa_basic.tables.vocabulary import commands, status
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.control_flow import is_block_word
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.languages.vendor_statements import Effects, NodeEffect, UnknownEffect
from assistant.program.expressions import (
    Effect,
    EffectBuilder,
    VendorTextKind,
    combined_effect,
    unknown_effect,
)


def of_node(tree: s.Statement | s.Expression, text: str) -> Effect:
    """Return the effect of a statement or an expression; any effect if it computes the name that it
    calls.

    text: of the statement or expression.
    """
    return _EFFECTS.of(tree) or unknown_effect(text)


@lru_cache(maxsize=1 << 14)
def of_text(text: str, kind: VendorTextKind) -> Effect:
    """Return the effect of a text; any effect if it is not MELFA-BASIC."""
    if kind == "expression":
        node = expression(text)
        return unknown_effect(text) if node is None else of_node(node, text)
    return combined_effect(map(_of_line, text.split("\n")))


def _of_line(text: str) -> Effect:
    line = read_statement(text)
    if line is None:
        return unknown_effect(text)
    label = Effect(frozenset((line.label.lower(),))) if line.label else Effect()
    return combined_effect((label, of_node(line.statement, text) if line.statement else Effect()))


def _variable(done: EffectBuilder, node: s.Variable) -> None:
    done.reads.add(node.key)
    if node.arguments and status(node.key) is None:  # an element, or a call of a function:
        done.writes.update(_EFFECTS.names(node.arguments))  # both look the same


def _jump(done: EffectBuilder, node: s.Jump | s.OnJump) -> None:
    done.jumps |= node.keyword == "GoTo"
    if node.keyword == "GoSub":
        targets = (node.target,) if isinstance(node, s.Jump) else node.targets
        done.calls.update(str(target.place) for target in targets if target is not None)


def _if(done: EffectBuilder, node: s.If) -> None:
    ways = (node.then, node.otherwise)
    done.jumps |= is_block_word(node) or any(isinstance(way, s.Target) for way in ways)


def _program(done: EffectBuilder, node: s.CallP) -> None:
    if not isinstance(node.program, s.String):
        raise UnknownEffect
    done.writes.update(_EFFECTS.names(node.arguments))
    done.calls.update(words_of(node.program.value))


def _include(done: EffectBuilder, node: s.Include) -> None:
    done.declare(*words_of(node.program))
    done.calls.update(words_of(node.program))


def _command(done: EffectBuilder, node: s.Command) -> None:
    """Add the effects of a command; where sources are silent, it may have them."""
    known = node.keyword in commands("reads")
    done.moves |= node.keyword in commands("moves")
    done.jumps |= node.keyword in commands("jumps") or is_block_word(node)
    done.waits |= node.keyword in commands("waits") or not known
    if not known:
        done.writes.update(_EFFECTS.names(*nodes(node.arguments)))


_EFFECTS: Final = Effects(
    nodes,
    lambda node: node.key if isinstance(node, s.Variable) else None,
    {
        s.Variable: _variable,
        s.String: NodeEffect(words=("value",)),  # which may be the name of a program
        s.Target: NodeEffect(reads=("place",)),
        s.Motion: NodeEffect(moves=True),
        s.Assign: NodeEffect(writes=("target",)),
        **dict.fromkeys((s.Const, s.DefIo), NodeEffect(writes=("variable",))),
        s.For: NodeEffect(writes=("variable",), jumps=True),
        s.Next: NodeEffect(writes=("variables",), jumps=True),
        s.Input: NodeEffect(writes=("variables",), waits=True),
        **dict.fromkeys((s.FPrm, s.DefNames, s.Dim), NodeEffect(writes=("variables",))),
        s.DefFunction: NodeEffect(declares=("name",), writes=("parameters",)),
        **dict.fromkeys((s.Function, s.FunctionParameter), NodeEffect(declares=("name",))),
        **dict.fromkeys((s.Select, s.ElseIf, s.Case), NodeEffect(jumps=True)),
        s.If: _if,
        **dict.fromkeys((s.Jump, s.OnJump), _jump),
        s.CallP: _program,
        s.Call: NodeEffect(calls=("function",)),
        s.Include: _include,
        s.Command: _command,
    },
)
"""Effects of each kind of statement and expression."""
