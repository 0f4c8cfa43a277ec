"""Vendor text of RAPID that a program passes through unchanged: its nodes and its effects.

The nodes that a text was printed from are remembered, so that nothing is parsed twice. The effect
of a text (what it reads, writes, calls; whether it moves, waits or jumps) comes from its tree; a
text with a hole, or with a call whose name is computed, may do anything.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any, Final, Literal, TypeVar

from assistant.base.diagnostics import Refused
from assistant.base.source_text import words_of
from assistant.languages import vendor_statements
from assistant.languages.nodes import Walk
from assistant.languages.rapid import rules
from assistant.languages.rapid.reading.parser import parse_items, parse_statements
from assistant.languages.rapid.tables.predefined import (
    CALLING,
    JUMPING,
    MOVING,
    NAMING,
    WAITING,
    signature,
)
from assistant.languages.rapid.text.printer import print_nodes
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import root
from assistant.languages.runs.columns import Names
from assistant.languages.signatures import Parameter, Signature
from assistant.languages.vendor_statements import Effects, NodeEffect, ParsedTexts, UnknownEffect
from assistant.program.expressions import Effect, EffectBuilder, VendorTextKind, unknown_effect

T = TypeVar("T")
TextKind = Literal["items", "statements", "handlers"]

LANGUAGE: Final = "rapid"
_HANDLER: Final = re.compile(r"(?:ERROR|UNDO|BACKWARD)\b", re.IGNORECASE)
_TEXTS: Final = ParsedTexts(rules.NOT_RAPID)
foreign: Final = partial(vendor_statements.foreign_text_fields, language="RAPID")


def items(text: str) -> tuple[s.Item, ...]:
    """The declarations of a text; raises Refused if it is no RAPID."""
    return _TEXTS.read("items", text, parse_items)


def statements(text: str) -> tuple[s.StatementNode, ...]:
    """The statements of a text; raises Refused if it is no RAPID."""
    return _TEXTS.read("statements", text, parse_statements)


def error_handlers(text: str) -> tuple[s.Handler, ...] | None:
    """The error handlers of a text, None if it does not begin as one; raises Refused."""
    if not _HANDLER.match(text):
        return None
    known = _TEXTS.known("handlers", text)
    if known is not None:
        return known
    # The grammar has handlers only at the end of a routine.
    match items(f"PROC x()\n{text}\nENDPROC"):
        case (s.Routine(body=(), handlers=found),):
            return found
    raise _TEXTS.refused(text, "no error handler")


def expression(text: str) -> s.Expression:
    """Parse the expression in a text; raises Refused if it is not a RAPID expression."""
    # The line feed ends a comment in the text, which would hide the `;`.
    read = statements(f"x:={text}\n;")
    if len(read) == 1 and isinstance(read[0], s.Assignment):
        return read[0].value
    raise _TEXTS.refused(text, "no expression")


def understood(read: Callable[[str], T], text: str) -> T | None:
    """Parse a text with `items`, `statements` or `expression`, None if it is not RAPID."""
    try:
        return read(text)
    except Refused:
        return None


def declares(text: str) -> str:
    """Return the storage and type of data, or the word of another declaration; empty for any other
    text.
    """
    found = understood(items, text) or understood(statements, text) or ()
    match found[:1]:
        case (s.Data(storage=storage, type=type),):
            return f"{storage} {type.lower()}"
        case (s.TargetRunNode(),):
            return "CONST robtarget"
        case (s.Routine(kind=kind),):
            return kind
        case (s.Record(),):
            return "RECORD"
        case (s.Alias(),):
            return "ALIAS"
    return ""


def of_node(node: s.Item | s.StatementNode | s.Handler, kind: TextKind) -> str:
    """The text that says a declaration, a statement or an error handler."""
    # Remembering the node spares the parse when the text is lowered or examined.
    return _TEXTS.remember(kind, print_nodes((node,)), (node,))


_SPEED_TYPE: Final = "speeddata"
"""Type of a parameter that instructions have which move, and others have not."""
_WAIT_PREFIX: Final = "wait"
_TIMEOUT_PARAMETERS: Final = frozenset(("maxtime", "timeout"))
"""Names of parameters that say how long an instruction waits at most."""
_LITERALS: Final = (s.NumberLiteral, s.BoolLiteral)
"""Nodes that name nothing: a table of numbers has thousands."""
_effect_nodes: Final = Walk(lambda kind: issubclass(kind, s.Node) and kind not in _LITERALS).nodes


def effect_of_nodes(tree: Sequence[s.Node], text: str) -> Effect:
    """Return the effect of nodes; an unknown effect for a hole or a call with a computed name.
    text: of the nodes.
    """
    done = _EFFECTS.of(tuple(tree))
    if done is None:
        return unknown_effect(text)
    if all(isinstance(node, s.Handler) for node in tree):  # only once an error has happened
        return replace(done, calls=frozenset(), moves=False, waits=False)
    return done


@lru_cache(maxsize=1 << 14)
def effect_of_text(text: str, kind: VendorTextKind) -> Effect:
    """Return the effect of a text; an unknown effect if it is not RAPID."""
    try:
        match kind:
            case "expression":
                return effect_of_nodes((expression(text),), text)
            case "declaration":
                return effect_of_nodes(items(text), text)
        handlers = error_handlers(text)
        return effect_of_nodes(statements(text) if handlers is None else handlers, text)
    except Refused:
        return unknown_effect(text)


def _call_effect(done: EffectBuilder, node: s.ProcedureCall | s.FunctionCall) -> None:
    """Runs a routine; one of the user's may change what it is given."""
    # The name of the routine is known only when the program runs.
    if not isinstance(node.name, str) or node.name.lower() in CALLING:
        raise UnknownEffect
    key, known = node.name.lower(), signature(node.name)
    done.reads.add(key)
    if known is None:
        done.calls.add(key)
    else:
        done.moves |= key in MOVING or any(q.type == _SPEED_TYPE for q in _parameters(known))
        done.waits |= key in WAITING or key.startswith(_WAIT_PREFIX)
        done.waits |= any(q.name.lower() in _TIMEOUT_PARAMETERS for q in _parameters(known))
        done.jumps |= key in JUMPING
        if key in NAMING:
            done.writes.update(_named_words(node.arguments))
    for argument, parameter in _paired(node.arguments, known):
        # Arguments of unknown routines and parameters with a mode may be changed by the call.
        if parameter is None or parameter.mode:
            done.writes.update(_EFFECTS.names(argument))


def _moves_effect(done: EffectBuilder, node: s.MoveRunNode) -> None:
    done.moves = True
    done.reads.update((*_each_name(node.run.names), *_each_name(node.run.vias)))
    for motion in node.run.motions.table:
        given = (motion.speed, motion.zone, motion.tool, motion.frame)
        done.reads.update(name for name in given if name)


def _root_name(node: Any) -> str | None:
    data = root(node)
    return None if data is None else data.name


_EFFECTS: Final = Effects(
    _effect_nodes,
    _root_name,
    {
        s.NameRef: lambda done, node: done.reads.add(node.name),
        s.StringLiteral: NodeEffect(words=("value",)),  # which may be the name of something
        s.GotoLabel: NodeEffect(reads=("label",), jumps=True),
        s.LabelMark: NodeEffect(reads=("name",)),
        **dict.fromkeys((s.ReturnFrom, s.RaiseError, s.Word), NodeEffect(jumps=True)),
        s.Assignment: NodeEffect(writes=("target",)),
        s.ForLoop: NodeEffect(declares=("variable",)),
        s.Connect: NodeEffect(writes=("interrupt",), reads=("trap",)),
        **dict.fromkeys((s.ProcedureCall, s.FunctionCall), _call_effect),
        **dict.fromkeys(
            (s.Data, s.ParameterNode, s.Alias, s.Routine), NodeEffect(declares=("type", "name"))
        ),
        s.Record: lambda done, node: done.declare(node.name, *(t for t, _ in node.components)),
        s.TargetRunNode: lambda done, node: done.declare(*_each_name(node.run.names)),
        s.MoveRunNode: _moves_effect,
        s.Placeholder: NodeEffect(untold=True),
    },
)
"""Effects of each kind of statement, declaration and expression."""


def _named_words(value: Any) -> Iterator[str]:
    """Names in an expression or in arguments, and the words of texts in them."""
    for node in _effect_nodes(value):
        if isinstance(node, s.NameRef):
            yield node.name.lower()
        elif isinstance(node, s.StringLiteral):
            yield from words_of(node.value)


def _parameters(known: Signature) -> Iterator[Parameter]:
    return (q for slot in known.slots for q in slot.alternatives)


def _paired(
    arguments: Sequence[s.Argument], known: Signature | None
) -> Iterator[tuple[s.Expression, Parameter | None]]:
    """Yield the value of each argument with its parameter, None for an unknown one.

    Among alternatives the parameter is the one that the routine may change.
    """
    required = iter(()) if known is None else iter(known.required)
    named = {q.name.lower(): q for q in _parameters(known)} if known is not None else {}
    for argument in arguments:
        match argument:
            case s.Positional(value, None):
                slot = next(required, None)
                ordered = sorted(slot.alternatives, key=lambda q: not q.mode) if slot else []
                yield value, next(iter(ordered), None)
            case s.Positional(value, str(name)) | s.Option(name, value) if value is not None:
                yield value, named.get(name.lower())
            case s.Conditional(name, variable):
                yield variable, named.get(name.lower())


def _each_name(names: Names) -> Iterator[str]:
    return filter(None, (names.name(row) for row in range(len(names))))
