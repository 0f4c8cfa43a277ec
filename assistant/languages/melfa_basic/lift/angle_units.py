"""Angles in degrees, for languages that have no other unit.

Expressions of MELFA-BASIC hold angles in radian: `M1=Rad(300)`, `M2=Cos(M1)`. Lifted as they are,
they would be multiplied where they are stored and divided where they are read. A number variable
that holds nothing but angles, and is read as nothing else, is held in degrees instead: `M1:=300`,
`M2:=Cos(M1)`. A variable stays in radian if a `Print` shows it, a call is given it, a sum with
plain numbers reads it, or other programs share it, as they do `M_01`. So does one that is counted
on and compared: in another unit, its loop could end a turn earlier or later.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import field, fields, replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Findings
from assistant.languages.melfa_basic import rules
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Path
from assistant.program.program import Declaration, Procedure, Program, Variable, bodies
from assistant.program.rewriting import map_bodies, record_fields, records
from assistant.program.statement_index import records_in_procedures
from assistant.program.vendor_statements import effect_of

_Key = tuple[str, str]
"""A variable: its procedure, empty for one of the program, and its name, both in lower case."""
_UNIT: Final = e.Number(e.DEGREE)
_NOTHING: Final = e.Number(0)
_QUOTED: Final = "| "
"""Begins a comment that quotes a statement which was not translated, for people to rewrite."""
_WORD: Final = re.compile(r"[^\W\d]\w*")


def with_degrees(program: Program, findings: Findings) -> Program:
    """Return the program with variables in degrees that hold angles alone; findings name them."""
    if not any(one == _UNIT for one in records_in_procedures(program, e.Number)):
        return program
    held = _numbers(program)
    while True:
        conversion = _Conversion(program, held)
        made = conversion.converted()
        # Whether a variable is counted on depends on which others are still in degrees.
        wrong = held & conversion.plainly or held & conversion.counted & conversion.compared
        if not wrong:
            break
        held -= wrong
    for owner, variables in (
        ("", made.variables),
        *((q.name, q.variables) for q in made.procedures),
    ):
        names = [name for name in variables if (owner.lower(), name.lower()) in held]
        if names:
            findings.append(rules.IN_DEGREES(names=", ".join(f"`{name}`" for name in names)))
    return made


def _numbers(program: Program) -> frozenset[_Key]:
    """Return the variables of the program alone that hold one assigned number, and that no text
    names.
    """
    named: set[str] = set()
    assigned: set[str] = set()
    for record in records((program.procedures, program.declarations)):
        match record:
            case p.Opaque() | e.Verbatim() | Declaration():
                named |= effect_of(record).names
            case p.Assign(e.Name(name)):
                assigned.add(name.lower())
            case p.Comment(text) if text.startswith(_QUOTED):
                named |= {word.lower() for word in _WORD.findall(text)}
        if not isinstance(record, e.Name):
            named |= {
                value.lower()
                for one in fields(record)
                if isinstance(value := getattr(record, one.name), str)
            }
    owners = (("", program.variables), *((q.name, q.variables) for q in program.procedures))
    return frozenset(
        (owner.lower(), low)
        for owner, variables in owners
        for name, one in variables.items()
        if (low := name.lower()) in assigned
        and low not in named
        and one.type == "number"
        and not one.size
        # Other programs read external variables, such as `M_01`, in radian.
        and one.storage == "variable"
    )


@dataclass
class _Conversion:
    """A conversion of a program with some variables in degrees.

    held: these variables. plainly: those of them that are read or set as plain numbers too.
    counted: those that are set from values of these variables. compared: those in comparisons.
    """

    program: Program
    held: frozenset[_Key]
    owner: Procedure | None = None
    plainly: set[_Key] = field(default_factory=set)
    counted: set[_Key] = field(default_factory=set)
    compared: set[_Key] = field(default_factory=set)

    def converted(self) -> Program:
        variables = self._variables(self.program.variables)
        procedures = []
        for procedure in self.program.procedures:
            self.owner = procedure
            own = self._variables(procedure.variables)
            body = tuple(map(self._statement, procedure.body))
            procedures.append(replace(procedure, body=body, variables=own))
        return replace(self.program, variables=variables, procedures=tuple(procedures))

    def _variables(self, variables: Mapping[str, Variable]) -> dict[str, Variable]:
        return {
            name: one
            if one.initial is None
            else replace(one, initial=self._value(name, one.initial))
            for name, one in variables.items()
        }

    def _statement(self, node: p.Statement) -> p.Statement:
        # The bodies are taken out first, so that each statement is read once.
        bare = map_bodies(node, lambda _: ())
        match bare:
            case p.Assign(e.Name(name), value):
                made: Any = replace(bare, value=self._value(name, value))
            case _:
                made = _with_expressions(bare, self._plain)
        inner = iter([tuple(map(self._statement, body)) for body in bodies(node)])
        return map_bodies(made, lambda _: next(inner))  # type: ignore[no-any-return]

    def _value(self, name: str, value: e.Expression) -> e.Expression:
        """Return the value that a variable is set to, in the unit of the variable."""
        key = self._key(e.Name(name))
        if key not in self.held:
            return self._plain(value)
        if self._names(value):
            self.counted.add(key)
        made = self._degrees(value)
        if made is None:
            self.plainly.add(key)
            return self._plain(value)
        return made

    def _key(self, x: e.Name) -> _Key:
        low = x.name.lower()
        owner = self.owner
        if owner is not None:
            own = {name.lower() for name in owner.variables}
            if low in own or low in {one.name.lower() for one in owner.parameters}:
                return owner.name.lower(), low
        return "", low

    def _names(self, x: e.Expression) -> set[_Key]:
        """Return the variables in degrees that an expression names."""
        return {self._key(one) for one in records(x) if isinstance(one, e.Name)} & self.held

    def _degrees(self, x: e.Expression) -> e.Expression | None:
        """Return an angle in radian as one in degrees, None for any other number."""
        match x:
            case e.Binary("*", inner, unit) if unit == _UNIT:
                return self._plain(inner)
            case e.Name() if self._key(x) in self.held:
                return x
            case e.Number(0):
                return x
            case e.Unary("-", operand):
                made = self._degrees(operand)
                return None if made is None else e.Unary("-", made)
            case e.Binary("+" | "-" as sign, left, right):
                one, two = self._degrees(left), self._degrees(right)
                return None if one is None or two is None else e.Binary(sign, one, two)
            case e.Binary("*" | "/" as sign, left, right) if right != _UNIT:
                one = self._degrees(left)
                if one is not None:
                    return e.Binary(sign, one, self._plain(right))
                two = self._degrees(right) if sign == "*" else None
                return None if two is None else e.Binary(sign, self._plain(left), two)
        return None

    def _plain(self, x: e.Expression) -> e.Expression:
        """Return an expression that is not an angle, with the angles inside it converted."""
        match x:
            case e.Name() if (key := self._key(x)) in self.held:
                self.plainly.add(key)
                return x
            case e.Binary("/", inner, unit) if unit == _UNIT:
                made = self._degrees(inner)
                if made is not None:
                    return made
            case e.Binary(sign, left, right) if sign in e.RELATIONS:
                one, two = self._degrees(left), self._degrees(right)
                if one is not None and two is not None and not left == right == _NOTHING:
                    self.compared |= self._names(x)
                    return e.Binary(sign, one, two)
            case e.Binary("+" | "-") if not self._names(x):
                made = self._degrees(x)
                if made is not None and made != x:
                    return e.Binary("*", made, _UNIT)
        return _with_expressions(x, self._plain)  # type: ignore[no-any-return]


def _with_expressions(record: Any, change: Callable[[e.Expression], e.Expression]) -> Any:
    """Return a record with its outermost expressions changed."""
    known = record_fields(type(record))
    if known is None or isinstance(record, Path):
        return record
    values = {
        name: _changed(value, change)
        for name, value in zip(known.names, known.of(record), strict=True)
    }
    new = {name: value for name, value in values.items() if value is not getattr(record, name)}
    return replace(record, **new) if new else record


def _changed(value: Any, change: Callable[[e.Expression], e.Expression]) -> Any:
    if isinstance(value, e.Expression):
        return change(value)
    if isinstance(value, tuple):
        made = tuple(_changed(one, change) for one in value)
        same = all(a is b for a, b in zip(made, value, strict=True))
        return value if same else made
    return _with_expressions(value, change)
