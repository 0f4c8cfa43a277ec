"""Integer inference: numbers of a program that are integers, and numbers that are never below 0.

A variable is an integer if every value assigned to it is. All variables count as integers at first,
and those with another value are removed, until no more are.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import field, replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure, Program, Signal, Variable, walk
from assistant.program.rewriting import head, map_expressions, records

_BITS: Final = frozenset(("bitand", "bitor", "bitxor"))
_WHOLE: Final = frozenset(("round", "trunc", "floor", "length", "code")) | _BITS
_NOT_BELOW: Final = frozenset(("abs", "sqrt", "exp", "length", "code", "distance")) | _BITS
_WORD: Final = re.compile(r"\w+")


@dataclass(frozen=True, slots=True)
class NumberFact:
    """Known facts about a number. whole: an integer. positive: 0 or more."""

    whole: bool
    positive: bool


_NOTHING_KNOWN: Final = NumberFact(whole=False, positive=False)
_ALL_KNOWN: Final = NumberFact(whole=True, positive=True)

Key = tuple[str, str]
"""A variable: its procedure in lower case, "" if it is one of the program, and its own name."""


Given = tuple[e.Expression, str] | tuple[p.For, str] | NumberFact
"""Source of a variable's value: a value or the count of a loop, with its procedure."""


@dataclass
class NumberFacts:
    """Known facts about the numbers of a program."""

    program: Program
    found: dict[Key, NumberFact] = field(default_factory=dict)

    def __post_init__(self) -> None:
        program = self.program
        self._signals = {name.lower(): signal for name, signal in program.signals.items()}
        self._callees = {q.name.lower(): q for q in program.procedures}
        self._counted: dict[str, set[str]] = {
            q.name.lower(): {s.variable.lower() for s in walk(q.body) if isinstance(s, p.For)}
            for q in program.procedures
        }
        for name, variable in program.variables.items():
            self.found["", name.lower()] = _initial_fact(variable)
        for procedure in program.procedures:
            owner = procedure.name.lower()
            for name, variable in procedure.variables.items():
                self.found[owner, name.lower()] = _initial_fact(variable)
            for parameter in procedure.parameters:
                whole = parameter.type == "integer"
                self.found[owner, parameter.name.lower()] = NumberFact(whole, positive=False)
            for name in self._counted[owner]:  # one that is declared nowhere is the loop's own
                if ("", name) not in self.found:
                    self.found.setdefault((owner, name), _ALL_KNOWN)
        # Declared integers stay integers, whatever is assigned to them.
        self._integers = frozenset(self._typed())
        given = list(self._given())
        for key in self._left_alone({key for key, _ in given}):
            self._give(key, _NOTHING_KNOWN)
        # Facts are only ever lost: the loop ends.
        while True:
            before = dict(self.found)
            for key, value in given:
                self._give(key, value)
            if self.found == before:
                break

    def of(self, x: e.Expression, procedure: Procedure) -> NumberFact:
        """Return the known fact about an expression in a procedure."""
        return self._of(x, procedure.name.lower())

    def _typed(self) -> Iterator[Key]:
        """Variables that can only hold whole numbers."""
        for name, variable in self.program.variables.items():
            if variable.type == "integer":
                yield "", name.lower()
        for procedure in self.program.procedures:
            owner = procedure.name.lower()
            types = {name: variable.type for name, variable in procedure.variables.items()}
            types |= {parameter.name: parameter.type for parameter in procedure.parameters}
            yield from ((owner, name.lower()) for name in types if types[name] == "integer")

    def _left_alone(self, given: set[Key]) -> Iterator[Key]:
        """Variables that nothing gives a value to: nobody knows where they have it from."""
        for name, variable in self.program.variables.items():
            if variable.initial is None and ("", name.lower()) not in given:
                yield "", name.lower()

    def _give(self, key: Key, value: Given) -> None:
        known = self.found.get(key)
        if known is None:
            return
        match value:
            case NumberFact():
                given = value
            case p.For() as loop, owner:
                given = self._count(loop, owner)
            case x, owner:
                given = self._of(x, owner)
        self.found[key] = NumberFact(
            known.whole and (given.whole or key in self._integers),
            known.positive and given.positive,
        )

    def _given(self) -> Iterator[tuple[Key, Given]]:
        """Every value that a variable is given, or NOTHING for what cannot be followed."""
        texts: list[str] = [declaration.text for declaration in self.program.declarations]
        for procedure in self.program.procedures:
            owner = procedure.name.lower()
            for statement in walk(procedure.body):
                match statement:
                    case p.Assign(target, value):
                        if (name := _written_variable(target)) is not None:
                            yield self._key(name, owner), (value, owner)
                    case p.For():
                        yield self._key(statement.variable, owner), (statement, owner)
                    case p.Opaque(text=text):
                        texts.append(text)
                    case p.Call(called, arguments):
                        for name in self._changed(called, arguments):
                            yield self._key(name, owner), _NOTHING_KNOWN
                for part in records(head(statement)):
                    if isinstance(part, e.Apply) and part.function not in e.FUNCTIONS:
                        for name in self._changed(part.function, part.arguments):
                            yield self._key(name, owner), _NOTHING_KNOWN
                    elif isinstance(part, e.Verbatim):
                        texts.append(part.text)
        # A word in vendor text may assign a variable of that name.
        told = {word.lower() for text in texts for word in _WORD.findall(text)}
        yield from ((key, _NOTHING_KNOWN) for key in list(self.found) if key[1] in told)

    def _count(self, loop: p.For, owner: str) -> NumberFact:
        first, last = self._of(loop.first, owner), self._of(loop.last, owner)
        step = _ALL_KNOWN if loop.step is None else self._of(loop.step, owner)
        # without a stated step it goes down as well, but not below the last one
        positive = first.positive and (last.positive if loop.step is None else step.positive)
        return NumberFact(first.whole and step.whole, positive)

    def _changed(self, called: str, arguments: tuple[e.Expression, ...]) -> Iterator[str]:
        """Variables that a call may change."""
        callee = self._callees.get(called.lower())
        for at, argument in enumerate(arguments):
            copied = callee is not None and at < len(callee.parameters)
            if copied and callee is not None and callee.parameters[at].mode == "in":
                continue
            if (name := _written_variable(argument)) is not None:
                yield name

    def _key(self, name: str, owner: str) -> Key:
        inner = owner, name.lower()
        # A name that the procedure does not declare is the program's.
        return inner if inner in self.found else ("", name.lower())

    def _of(self, x: e.Expression, owner: str) -> NumberFact:
        match x:
            case e.Number(value):
                return NumberFact(float(value).is_integer(), value >= 0)
            case e.Name(name) | e.Index(e.Name(name)):
                signal = self._signals.get(name.lower())
                if signal is not None and isinstance(x, e.Name):
                    return _signal_fact(signal)
                return self.found.get(self._key(name, owner), _NOTHING_KNOWN)
            case e.Unary("-", operand):
                return NumberFact(self._of(operand, owner).whole, positive=False)
            case e.Binary(operator, left, right):
                return _fact_of_operation(operator, self._of(left, owner), self._of(right, owner))
            case e.Apply(function, given):
                return self._applied(function, [self._of(a, owner) for a in given])
            case e.Elapsed():
                return NumberFact(whole=False, positive=True)
        return _NOTHING_KNOWN

    def _applied(self, function: str, given: list[NumberFact]) -> NumberFact:
        if function not in e.FUNCTIONS:
            callee = self._callees.get(function.lower())
            return NumberFact(callee is not None and callee.result == "integer", positive=False)
        whole = function in _WHOLE
        positive = function in _NOT_BELOW
        if function in ("min", "max", "abs"):
            whole = all(one.whole for one in given)
        if function in ("min", "round", "trunc", "floor"):
            positive = all(one.positive for one in given)
        if function == "max":
            positive = any(one.positive for one in given)
        return NumberFact(whole, positive)


def without_needless_rounding(program: Program) -> Program:
    """The program with `round` left out where a number is whole as it is."""
    rounds = any(
        isinstance(part, e.Apply) and part.function == "round"
        for statement in program.statements()
        for part in records(head(statement))
    )
    if not rounds:
        return program
    numbers = NumberFacts(program)

    def plain(procedure: Procedure) -> Procedure:
        def change(x: e.Expression) -> e.Expression:
            match x:
                case e.Apply("round", (inner,)) if numbers.of(inner, procedure).whole:
                    return inner
            return x

        return replace(procedure, body=map_expressions(procedure.body, change))

    return replace(program, procedures=tuple(map(plain, program.procedures)))


def _initial_fact(variable: Variable) -> NumberFact:
    """Return the fact before any assignment; a persistent variable is changed from elsewhere."""
    whole = variable.type == "integer"
    if variable.storage == "persistent" or variable.type not in ("number", "integer"):
        return NumberFact(whole, positive=False)
    values = [part.value for part in records(variable.initial) if isinstance(part, e.Number)]
    # Any other part of a first value is unknown.
    others = [part for part in records(variable.initial) if not isinstance(part, _PLAIN)]
    if others:
        return NumberFact(whole, positive=False)
    return NumberFact(
        whole or all(float(v).is_integer() for v in values), min(values, default=0) >= 0
    )


_PLAIN: Final = (e.Number, e.Aggregate)


def _signal_fact(signal: Signal) -> NumberFact:
    return NumberFact(signal.kind != "analog", signal.kind != "analog")


def _fact_of_operation(operator: str, left: NumberFact, right: NumberFact) -> NumberFact:
    whole, positive = left.whole and right.whole, left.positive and right.positive
    match operator:
        case "+" | "*":
            return NumberFact(whole, positive)
        case "-":
            return NumberFact(whole, positive=False)
        case "/":
            return NumberFact(whole=False, positive=positive)
        case "div" | "mod":
            return NumberFact(whole=True, positive=positive)
        case "^":
            return NumberFact(whole=False, positive=left.positive)
    return _NOTHING_KNOWN


def _written_variable(x: Any) -> str | None:
    """Return the variable that is written, None for a component, which has no number fact."""
    match x:
        case e.Name(name) | e.Index(e.Name(name)):
            return name
    return None
