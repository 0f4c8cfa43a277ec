"""Statements of RAPID as the pseudo-program's; what it has no word for stays verbatim."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Final

from assistant.base.diagnostics import Refused, span_over
from assistant.languages.rapid.lift.data import DataLift
from assistant.languages.rapid.lift.instructions import (
    INSTRUCTION_REASONS,
    NameResolver,
    lift_instruction,
)
from assistant.languages.rapid.lift.paths import PathLift
from assistant.languages.rapid.lift.timers import restarted_clock
from assistant.languages.rapid.tables.standard import INSTRUCTIONS, OF_OPTIONS
from assistant.languages.rapid.tables.words import LOADED_FROM
from assistant.languages.rapid.text import effects, verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called
from assistant.languages.vendor_statements import INTERRUPTS
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes.loops import ascends
from assistant.program.program import Program

BY_COMPONENTS: Final = "say it with the components, one by one"
"""What to do where a record is used in a way that no plain data can be."""
_STANDARD: Final = INSTRUCTIONS | OF_OPTIONS
_WORD: Final = re.compile(r"[A-Za-z]\w*")
_LOADED: Final = re.compile(rf"{re.escape(LOADED_FROM)}({_WORD.pattern})\.mod")


def statements_of(text: str, program: Program) -> tuple[p.Statement, ...]:
    """Statements of RAPID in a program; an Opaque that is no RAPID comes back as it is."""
    try:
        read = verbatim.statements(text)
    except Refused:
        return (_opaque_text(text),)  # a finding when it is built
    if any(isinstance(n, s.Data | s.TargetRunNode) for n in read):
        return (_opaque_text(text),)
    return lift_of(program).block(read)


def lift_of(program: Program) -> StatementLift:
    """What lifts more statements of a program."""
    paths = PathLift((), DataLift((), (), str), str)
    return StatementLift(NameResolver(), paths, {q.name.lower() for q in program.procedures})


class StatementLift:
    """procedures: lower-case names of the user's own, which hide instructions.

    kept: statements that stay as their text, by `id`, each with why.
    """

    def __init__(
        self,
        meaning: NameResolver,
        paths: PathLift,
        procedures: Collection[str],
        kept: Mapping[int, str] = MappingProxyType({}),
    ) -> None:
        self._kept = kept
        self._meaning, self._paths, self._procedures = meaning, paths, procedures
        self._original, self._expression = meaning.original, meaning.expression

    def block(self, nodes: Sequence[s.StatementNode] | None) -> tuple[p.Statement, ...]:
        """The statements of a body; none for one that is not there."""
        return tuple(self._body(nodes or ()))

    def _body(self, nodes: Sequence[s.StatementNode]) -> Iterator[p.Statement]:
        at = 0
        while at < len(nodes):
            node = nodes[at]
            if at and isinstance(node, s.CommentLine) and node.trailing:
                yield p.Comment(node.text, span=nodes[at - 1].span)
                at += 1
                continue
            for count, read in ((3, self._loaded_call), (2, self._timer)):
                said = read(nodes[at : at + count])
                if said is not None:
                    yield said
                    at += count
                    break
            else:
                yield from self._statement(nodes[at])
                at += 1

    def _statement(self, node: s.StatementNode) -> Iterator[p.Statement]:
        span, original, expression = node.span, self._original, self._expression
        if id(node) in self._kept:
            yield replace(opaque(node), reason=e.Reason(self._kept[id(node)], BY_COMPONENTS))
            return
        match node:
            case s.CommentLine(text):
                yield p.Comment(text, span=span)
            case s.MoveRunNode():
                yield from self._paths.statements(node, self._meaning.motion)
            case s.Assignment(target, value) if not isinstance(target, s.Placeholder):
                turned = self._meaning.oriented(target, value)
                if isinstance(turned, e.Apply):
                    yield p.Assign(turned.arguments[0], turned, span=span)
                else:
                    yield p.Assign(expression(target), expression(value), span=span)
            case s.GotoLabel(label):
                yield p.Goto(original(label), span=span)
            case s.LabelMark(name):
                yield p.Label(original(name), span=span)
            case s.ReturnFrom(value):
                yield p.Return(None if value is None else expression(value), span=span)
            case s.Word("EXIT"):
                yield p.Stop(end=True, span=span)
            case s.IfThen(branches, otherwise) if all(b.condition is not None for b in branches):
                lifted = [
                    p.Branch(expression(b.condition), self.block(b.body))
                    for b in branches
                    if b.condition is not None
                ]
                yield p.If(tuple(lifted), self.block(otherwise), span=span)
            case s.CompactIf(condition, inner):
                body = tuple(self._statement(inner))
                yield p.If((p.Branch(expression(condition), body),), span=span)
            case s.ForLoop(variable, first, last, step, inner):
                bounds = expression(first), expression(last)
                known = map(self._meaning.known, bounds)
                upwards = {True: p.ONE, False: e.Number(-1), None: None}[ascends(*known)]
                by = upwards if step is None else expression(step)
                yield p.For(original(variable), *bounds, self.block(inner), by, span=span)
            case s.WhileLoop(condition, inner):
                yield p.While(expression(condition), self.block(inner), span=span)
            case s.TestOf(subject, cases, otherwise) if all(c.values for c in cases):
                chosen = tuple(
                    p.Case(tuple(map(expression, c.values)), self.block(c.body)) for c in cases
                )
                yield p.Switch(expression(subject), chosen, self.block(otherwise), span=span)
            case s.ProcedureCall(name=str()):
                yield replace(self._call(node), span=span)
            case s.Connect():
                yield replace(opaque(node), reason=INTERRUPTS)
            case _:
                yield opaque(node)

    def _call(self, node: s.ProcedureCall) -> p.Statement:
        name = str(node.name)
        if name.lower() in _STANDARD and name.lower() not in self._procedures:
            kept = replace(opaque(node), reason=INSTRUCTION_REASONS.get(name.lower()))
            return lift_instruction(node, self._meaning) or kept
        given = self._given(node)
        return opaque(node) if given is None else p.Call(self._original(name), given)

    def _given(self, node: s.ProcedureCall) -> tuple[e.Expression, ...] | None:
        call = called(node)
        if call is None or call.options:
            return None
        return tuple(self._expression(argument) for argument in call.given if argument is not None)

    def _timer(self, nodes: Sequence[s.StatementNode]) -> p.StartTimer | None:
        """`ClkReset c; ClkStart c;` as one, if the clock is nothing but restarted and read."""
        clock = restarted_clock(nodes)
        if clock is None or clock.name.lower() not in self._meaning.timers:
            return None
        return p.StartTimer(
            self._original(clock.name), span=span_over(nodes[0].span, nodes[1].span)
        )

    def _loaded_call(self, nodes: Sequence[s.StatementNode]) -> p.Call | None:
        r"""`Load \Dynamic, "HOME:/u.mod"; %"name"% …; UnLoad "HOME:/u.mod";` as one call."""
        match nodes:
            case (
                s.ProcedureCall(
                    str(load),
                    (s.Option(option, None), s.Positional(s.StringLiteral(file), None)),
                ) as first,
                s.ProcedureCall(s.StringLiteral(name)) as call,
                s.ProcedureCall(str(unload), (s.Positional(s.StringLiteral(same), None),)) as last,
            ) if (load.lower(), option.lower(), unload.lower()) == ("load", "dynamic", "unload"):
                module, given = _LOADED.fullmatch(file), self._given(call)
                if module is None or given is None or file != same or not _WORD.fullmatch(name):
                    return None
                unit, span = self._original(module[1]), span_over(first.span, last.span)
                return p.Call(self._original(name), given, unit, span=span)
        return None


def _opaque_text(text: str) -> p.Opaque:
    return p.Opaque(verbatim.LANGUAGE, text, effect=effects.of_text(text, "statement"))


def opaque(node: s.StatementNode) -> p.Opaque:
    return _opaque(node, verbatim.of_node(node, "statements"))


def handler(node: s.Handler) -> p.Opaque:
    return _opaque(node, verbatim.of_node(node, "handlers"))


def _opaque(node: s.Node, text: str) -> p.Opaque:
    effect = effects.of_nodes((node,), text)
    return p.Opaque(verbatim.LANGUAGE, text, span=node.span, effect=effect)
