"""What text of MELFA-BASIC does that a program keeps as it is, read off its tree."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

from assistant.languages.melfa_basic.reading.line import expression
from assistant.languages.melfa_basic.reading.line import statement as read_statement
from assistant.languages.melfa_basic.tables.vocabulary import commands, status
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import is_word
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.program.effects import Collected, Effect, KeptKind, together, unknown
from assistant.program.text import words_of


def of_node(tree: s.Statement | s.Expression, text: str) -> Effect:
    """What a statement or an expression does; anything if it works out what it calls.

    text: of it.
    """
    collected = _Collected()
    for node in nodes(tree):
        if isinstance(node, s.CallP) and not isinstance(node.program, s.String):
            return unknown(text)
        collected.take(node)
    return collected.effect()


@lru_cache(maxsize=1 << 14)
def of_text(text: str, kind: KeptKind) -> Effect:
    """What a text does; anything if it is no MELFA-BASIC."""
    if kind == "expression":
        node = expression(text)
        return unknown(text) if node is None else of_node(node, text)
    return together(map(_of_line, text.split("\n")))


def _of_line(text: str) -> Effect:
    line = read_statement(text)
    if line is None:
        return unknown(text)
    label = Effect(frozenset((line.label.lower(),))) if line.label else Effect()
    return together((label, of_node(line.statement, text) if line.statement else Effect()))


class _Collected(Collected):
    """What the nodes do that were taken, in lower case."""

    def take(self, node: Any) -> None:
        """One node, without those in it."""
        self.jumps |= is_word(node)
        match node:
            case s.Variable(arguments=arguments):
                key = node.key.lower()
                self.reads.add(key)
                if arguments and status(key) is None:  # an element, or a call of a function:
                    self.write(*arguments)  # both look the same
            case s.String(text):  # which may be the name of a program
                self.reads.update(words_of(text))
            case s.Target(str(label)):
                self.reads.add(label.lstrip("*").lower())
            case s.Motion():
                self.moves = True
            case s.Assign(target) | s.Const(variable=target) | s.DefIo(variable=target):
                self.write(target)
            case s.For(variable):
                self.write(variable)
            case s.Next(variables) | s.Input(_, variables) | s.FPrm(variables):
                self.write(*variables)
                self.waits |= isinstance(node, s.Input)
            case s.DefNames(_, variables) | s.Dim(variables):
                self.write(*variables)
            case s.DefFunction(name, _, parameters):
                self.declare(name)
                self.write(*parameters)
            case s.Function(name=name) | s.FunctionParameter(name=name):
                self.declare(name)
            case s.If(_, then, otherwise):
                self.jumps |= any(isinstance(way, s.Target) for way in (then, otherwise))
            case s.Jump(keyword, target):
                self.go(keyword, target)
            case s.OnJump(_, keyword, targets):
                for place in targets:
                    self.go(keyword, place)
            case s.CallP(program, arguments):
                self.write(*arguments)
                if isinstance(program, s.String):
                    self.calls.update(words_of(program.value))
            case s.Call(called):
                self.calls.add(called.key.lower())
            case s.Include(program):
                self.declare(*words_of(program))
                self.calls.update(words_of(program))
            case s.Command(keyword, arguments):
                self.command(keyword, *arguments)

    def write(self, *places: Any) -> None:
        self.writes.update(p.key.lower() for p in places if isinstance(p, s.Variable))

    def go(self, keyword: str, target: s.Target | None) -> None:
        if keyword == "GoTo":
            self.jumps = True
        elif target is not None:
            self.calls.add(str(target.place).lstrip("*").lower())

    def command(self, keyword: str, *arguments: Any) -> None:
        """What no source tells of a command, it may do."""
        known = keyword in commands("reads")
        self.moves |= keyword in commands("moves")
        self.jumps |= keyword in commands("jumps")
        self.waits |= keyword in commands("waits") or not known
        if not known:
            self.write(*_variables(arguments))


def _variables(value: Any) -> Iterator[s.Variable]:
    return (node for node in nodes(value) if isinstance(node, s.Variable))
