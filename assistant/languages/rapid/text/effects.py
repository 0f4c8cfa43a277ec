"""What text of RAPID does that a program keeps as it is, read off its tree."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, Final

from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.tables.standard import CALLING, JUMPING, MOVING, NAMING, WAITING
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import root
from assistant.languages.runs.names import Names
from assistant.languages.signatures import Parameter, Signature
from assistant.languages.walking import Walk
from assistant.program.diagnostics import Refused
from assistant.program.effects import Collected, Effect, KeptKind, unknown
from assistant.program.text import words_of

_SPEED: Final = "speeddata"
"""Type of a parameter that instructions have which move, and others have not."""
_WAIT: Final = "wait"
_TIMES: Final = frozenset(("maxtime", "timeout"))
"""Names of parameters that say how long an instruction waits at most."""
_LITERALS: Final = (s.NumberLiteral, s.BoolLiteral)
"""Nodes that name nothing: a table of numbers has thousands."""
_BETWEEN: Final = frozenset(
    (s.Positional, s.Option, s.AggregateNode, s.Infix, s.Prefix, s.Group, s.Component, s.Element)
)
"""Nodes that say nothing but what is in them."""
_nodes: Final = Walk(lambda kind: issubclass(kind, s.Node) and kind not in _LITERALS).nodes


def of_nodes(tree: Sequence[s.Node], text: str) -> Effect:
    """What nodes do; anything with a hole or a call whose name is worked out. text: of them."""
    collected = _Collected()
    for node in _nodes(tuple(tree)):
        if type(node) is s.NameRef:  # most of them
            collected.reads.add(node.name.lower())
        elif type(node) not in _BETWEEN:
            if isinstance(node, s.Placeholder) or _is_untold(node):
                return unknown(text)
            collected.take(node)
    done = collected.effect()
    if all(isinstance(node, s.Handler) for node in tree):  # only once an error has happened
        return replace(done, calls=frozenset(), moves=False, waits=False)
    return done


@lru_cache(maxsize=1 << 14)
def of_text(text: str, kind: KeptKind) -> Effect:
    """What a text does; anything if it is no RAPID."""
    try:
        match kind:
            case "expression":
                return of_nodes((verbatim.expression(text),), text)
            case "declaration":
                return of_nodes(verbatim.items(text), text)
        handlers = verbatim.handlers(text)
        return of_nodes(verbatim.statements(text) if handlers is None else handlers, text)
    except Refused:
        return unknown(text)


class _Collected(Collected):
    """What the nodes do that were taken, in lower case."""

    def take(self, node: Any) -> None:
        """One node, without those in it."""
        match node:
            case s.GotoLabel(name) | s.LabelMark(name):
                self.reads.add(name.lower())
                self.jumps |= isinstance(node, s.GotoLabel)
            case s.StringLiteral(text):  # which may be the name of something
                self.reads.update(words_of(text))
            case s.ReturnFrom() | s.RaiseError() | s.Word():
                self.jumps = True
            case s.Assignment(target):
                self.write(target)
            case s.ForLoop(variable):
                self.declare(variable)
            case s.Connect(interrupt, trap):
                self.write(interrupt)
                self.reads.add(trap.lower())
            case s.ProcedureCall(str(name), arguments) | s.FunctionCall(name, arguments):
                self.call(name, arguments)
            case s.Data(type=type, name=name) | s.ParameterNode(type=type, name=name):
                self.declare(name, type)
            case s.Alias(type=type, name=name) | s.Routine(type=type, name=name):
                self.declare(name, type)
            case s.Record(name=name, components=components):
                self.declare(name, *(type for type, _ in components))
            case s.TargetRunNode(run=run):
                self.declare(*_each(run.names))
            case s.MoveRunNode(run):
                self.moves = True
                self.reads.update(n.lower() for n in (*_each(run.names), *_each(run.vias)))
                for motion in run.motions.table:
                    given = (motion.speed, motion.zone, motion.tool, motion.frame)
                    self.reads.update(n.lower() for n in given if n)

    def write(self, place: Any) -> None:
        if (changed := root(place)) is not None:
            self.writes.add(changed.name.lower())

    def call(self, name: str, arguments: Sequence[s.Argument]) -> None:
        """Runs a routine; one of the user's may change what it is given."""
        key, known = name.lower(), signature(name)
        self.reads.add(key)
        if known is None:
            self.calls.add(key)
        else:
            self.moves |= key in MOVING or any(q.type == _SPEED for q in _parameters(known))
            self.waits |= key in WAITING or key.startswith(_WAIT)
            self.waits |= any(q.name.lower() in _TIMES for q in _parameters(known))
            self.jumps |= key in JUMPING
            if key in NAMING:
                self.writes.update(_said(arguments))
        for argument, parameter in _paired(arguments, known):
            if parameter is None or parameter.mode:
                self.write(argument)


def _is_untold(node: Any) -> bool:
    """Whether it calls a routine whose name is worked out."""
    match node:
        case s.ProcedureCall(name):
            return not isinstance(name, str) or name.lower() in CALLING
    return False


def _said(value: Any) -> Iterator[str]:
    """Names in an expression or in arguments, and the words of texts in them."""
    for node in _nodes(value):
        if isinstance(node, s.NameRef):
            yield node.name.lower()
        elif isinstance(node, s.StringLiteral):
            yield from words_of(node.value)


def _parameters(known: Signature) -> Iterator[Parameter]:
    return (q for slot in known.slots for q in slot.alternatives)


def _paired(
    arguments: Sequence[s.Argument], known: Signature | None
) -> Iterator[tuple[s.Expression, Parameter | None]]:
    """The value of each argument with its parameter, None where that is not known.

    Of alternatives it is the one that is handed back.
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


def _each(names: Names) -> Iterator[str]:
    return filter(None, (names.name(row) for row in range(len(names))))
