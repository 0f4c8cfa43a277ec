"""Names of a language with one name space, in which each procedure and loop is a scope.

A name that does not fit gets another one. Names are compared without case.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from typing import Final
from weakref import ReferenceType, ref

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Declared, Diagnostic, Rule
from assistant.program.expressions import plain_number
from assistant.program.geometry import BASE, FLANGE
from assistant.program.passes.names import Names
from assistant.program.passes.procedure_forms import units
from assistant.program.program import Procedure, Program, Signal, identifier, walk
from assistant.program.statements import (
    Follow,
    For,
    Label,
    MoveStatement,
    Opaque,
    Statement,
    Trigger,
)
from assistant.program.undeclared_names import timers
from assistant.program.vendor_statements import effect_of

_ROW: Final = re.compile(r"(.+)_([1-9][0-9]*)")

_KINDS: Final = (
    "signals",
    "procedures",
    "tools",
    "frames",
    "speeds",
    "blends",
    "values",
    "timers",
    "modules",
)

HIDDEN: Final = ("values", "signals")
"""Kinds whose names a loop's variable may have: it hides them in the loop."""


def _value_word(trigger: Trigger, kinds: Mapping[str, str]) -> str:
    """The effect of a trigger, for its name: `on`, `off`, `2_5`; `set` if it is computed.

    kinds: of signals, by their names in lower case.
    """
    value = plain_number(trigger.value)
    if value is None:
        return "set"
    if kinds.get(trigger.signal.lower(), "digital") == "digital" and value in (0.0, 1.0):
        return "on" if value else "off"
    return f"{'minus_' if value < 0.0 else ''}{abs(value):g}".replace(".", "_").replace("+", "")


def spelt(names: Mapping[str, str], name: str) -> str:
    """The language's name of something; its own case where only that differs."""
    short = names.get(name.lower(), name)
    return name if short.lower() == name.lower() else short


@dataclass(slots=True)
class Naming:
    """The language's name of everything in a program.

    of: by kind and lower-case original. rows: stem of the targets of a Follow, by its id.
    triggers: the variable of each output that moves set on their way.
    inner, counters, labels: by procedure and lower-case original, its parameters and variables,
    the variables of its loops, its labels.
    changed: the other name that something got, and its own.
    """

    space: Names
    of: dict[str, dict[str, str]] = field(default_factory=lambda: {k: {} for k in _KINDS})
    rows: dict[int, str] = field(default_factory=dict)
    triggers: dict[Trigger, str] = field(default_factory=dict)
    inner: dict[str, dict[str, str]] = field(default_factory=dict)
    counters: dict[str, dict[str, str]] = field(default_factory=dict)
    labels: dict[str, dict[str, str]] = field(default_factory=dict)
    changed: list[tuple[str, str]] = field(default_factory=list)
    _numbered: dict[str, list[int]] = field(default_factory=dict)
    _meant: dict[str, str] = field(default_factory=dict)

    def get(self, kind: str, name: str) -> str:
        """The name of something of that kind; unknown ones keep theirs."""
        return spelt(self.of[kind], name)

    def value(self, name: str) -> str:
        """The name of a variable, target or signal."""
        return self.get("values", self.get("signals", name))

    def spelled(self, kind: str, owner: str, name: str) -> str:
        """The name of something, see `Language.spelled`."""
        low, own = name.lower(), owner.lower()
        if kind == "label":
            return self.labels.get(own, {}).get(low, name)
        if owner:
            return self.inner.get(own, {}).get(low, name)
        if kind in ("target", "joint target", "variable"):
            return self.value(name)
        return self.get(f"{kind}s", name)

    def take(self, name: str) -> None:
        self.space.take(name)
        # Longer digits cannot be the number of a row, and would not fit an integer of a column.
        if (row := _ROW.fullmatch(name.lower())) is not None and len(row[2]) < 16:
            self._numbered.setdefault(row[1], []).append(int(row[2]))

    def declare(self, kind: str, name: str) -> None:
        short = self.space.free(name)
        self.of[kind][name.lower()] = short
        self.take(short)
        self._note(short, name)

    def declare_inner(self, procedure: Procedure) -> None:
        key = procedure.name.lower()
        own: set[str] = set()
        inner = self.inner[key] = {}
        for name in (*(q.name for q in procedure.parameters), *procedure.variables):
            # The value kept its name, so that a local one may hide it as in the pseudo-program.
            if self.of["values"].get(name.lower(), "").lower() == name.lower():
                inner[name.lower()] = name  # hides the value of that name, here as there
                own.add(name.lower())
            else:
                self._declare_own(inner, name, own)
        counters = self.counters[key] = {}
        labels = self.labels[key] = {}
        for statement in walk(procedure.body):
            if isinstance(statement, Label):
                self._declare_own(labels, statement.name, own)
            elif isinstance(statement, For):
                name = statement.variable.lower()
                # A loop variable hides data of its name, so both need the same spelling.
                hidden = next(
                    (t for t in (inner, *map(self.of.get, HIDDEN)) if t and name in t), None
                )
                if hidden is not None:
                    counters[name] = hidden[name]
                else:
                    self._declare_own(counters, statement.variable, own)

    def _declare_own(self, known: dict[str, str], name: str, own: set[str]) -> None:
        if name.lower() in known:
            return
        short = known[name.lower()] = self.space.free(name, own)
        own.add(short.lower())
        # A changed name must not be given to anything else; an unchanged one is free elsewhere.
        if short != name:
            self.take(short)
        self._note(short, name)

    def declare_triggers(
        self, statements: Sequence[Statement], signals: Mapping[str, Signal]
    ) -> None:
        """Before the rows of paths, which may have such names too."""
        kinds = {name.lower(): signal.kind for name, signal in signals.items()}
        triggers = [t for x in statements if isinstance(x, MoveStatement) for t in x.triggers]
        if not triggers:
            return
        hiding = {
            n.lower() for x in statements if isinstance(x, Opaque) for n in effect_of(x).names
        }
        for table in (self.inner, self.counters, self.labels):
            hiding.update(name.lower() for own in table.values() for name in own.values())
        for trigger in triggers:
            if trigger not in self.triggers:
                signal = self.get("signals", trigger.signal)
                wanted = f"{signal}_{_value_word(trigger, kinds)}"
                self.triggers[trigger] = name = self.space.free(wanted, hiding)
                self.take(name)

    def declare_rows(self, follow: Follow) -> None:
        count = len(follow.path)
        # Room for `_` and the digits of the last row.
        room = self.space.longest - 1 - len(str(count))
        base = identifier(follow.path.name)[:room]
        stem, number = base, 2
        # `stem_1` to `stem_n` must not be names of other data.
        while self._rows_taken(stem.lower(), count) or self._means(stem, follow.path.name):
            end = f"_p{number}"
            stem, number = base[: room - len(end)] + end, number + 1
        self._numbered.setdefault(stem.lower(), []).extend((1, count))
        self.rows[id(follow)] = stem
        self._note(stem, follow.path.name)

    def _rows_taken(self, stem: str, count: int) -> bool:
        return any(number <= count for number in self._numbered.get(stem, ()))

    def _means(self, stem: str, name: str) -> bool:
        """True if a stem would be read as the name of another item, which was changed to it."""
        return self._meant.get(stem.lower(), name) != name

    def _note(self, short: str, name: str) -> None:
        if short != name and (short, name) not in self.changed:
            self.changed.append((short, name))
            self._meant.setdefault(short.lower(), name)


@dataclass(slots=True)
class Scopes:
    """Rules of a language for names.

    longest: characters of one. reserved: lower-case names that have a meaning. kept: names that
    vendor declarations of a program declare. flange, base: names of the bare flange and the robot's
    base. renamed: reports a name that is written as another one (short), and why. language: its
    title.
    """

    longest: int
    reserved: frozenset[str]
    kept: Callable[[Program], Iterable[str]]
    flange: str
    base: str
    renamed: Rule
    language: str
    _latest: tuple[ReferenceType[Program], Naming] | None = field(default=None, init=False)
    """The program that was named last: every unit of a long one asks for the same names."""
    _rows: tuple[str, ...] = field(default=(), init=False)
    """Reserved names that rows could have."""

    def __post_init__(self) -> None:
        self._rows = tuple(filter(_ROW.fullmatch, self.reserved))

    def naming(self, program: Program) -> Naming:
        """Names of a whole program; raises Refused if a kept declaration cannot be read."""
        # The same object, not an equal one: naming is asked for again and again while a program is
        # built.
        if self._latest is None or self._latest[0]() is not program:
            self._latest = ref(program), self._named(program)
        return self._latest[1]

    def findings(self, program: Program) -> Iterator[Diagnostic]:
        """Report each name that became another one."""
        for short, name in self.naming(program).changed:
            about = Declared(name)
            yield self.renamed(name=name, short=short, why=self._why(name), about=about)

    def _why(self, name: str) -> str:
        """Why something cannot have its own name."""
        if len(name) > self.longest:
            return f"it has more than {self.longest} characters"
        return (
            f"it is a word of {self.language}" if name.lower() in self.reserved else "it is taken"
        )

    def _named(self, program: Program) -> Naming:
        names = Naming(Names(self.longest, self.reserved))
        # Taken first: vendor declarations keep their names in any case.
        for name in (*self._rows, *self.kept(program)):
            names.take(name)
        for kind, table in (
            ("signals", program.signals),
            ("procedures", [p.name for p in program.procedures]),
            ("tools", [t for t in program.tools if t != FLANGE]),
            ("frames", [f for f in program.frames if f != BASE]),
            ("speeds", program.speeds),
            ("blends", program.blends),
            ("values", [*program.targets, *program.joint_targets, *program.variables]),
            ("timers", timers(program)),
            ("modules", [program.name, *units(program)]),
        ):
            for name in table:
                names.declare(kind, name)
        names.of["tools"][FLANGE] = self.flange
        names.of["frames"][BASE] = self.base
        for procedure in program.procedures:
            names.declare_inner(procedure)
        statements = tuple(program.statements())
        names.declare_triggers(statements, program.signals)
        for statement in statements:
            if isinstance(statement, Follow):
                names.declare_rows(statement)
        return names
