"""Names that a language takes: legal, short, unique, not reserved, spelled as declared."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.declared_types import Spelling
from assistant.program.geometry import BASE, FLANGE
from assistant.program.motion import Path
from assistant.program.passes.legalisation import Legalisation
from assistant.program.program import Declaration, Procedure, Program, identifier
from assistant.program.rewriting import rewrite
from assistant.program.statement_index import records_in_body

_FIELDS: Final[dict[type, tuple[str, ...]]] = {
    Program: ("name", "entry"),
    Procedure: ("name",),
    p.Motion: ("tool", "frame"),
    p.SetSignal: ("signal",),
    p.Trigger: ("signal",),
    p.WaitSignal: ("signal",),
    p.Call: ("procedure",),
    e.Name: ("name",),
}
"""Kind of record → its fields that are names."""
_TABLES: Final = ("tools", "frames", "signals", "targets", "joint_targets", "variables")
"""Tables of the program that declare names."""


class Names:
    """The names of one space that are taken, in any case.

    longest: characters of a name. legal: gives a name of legal characters, near to another one.
    """

    def __init__(
        self,
        longest: int,
        taken: Iterable[str] = (),
        legal: Callable[[str], str] = identifier,
    ) -> None:
        self.longest, self.legal = longest, legal
        self.taken = {name.lower() for name in taken}
        self._numbers: dict[str, int] = {}
        """By names in lower case, the first number that may be free as a suffix."""

    def take(self, name: str) -> None:
        self.taken.add(name.lower())

    def free(self, wanted: str, besides: Collection[str] = ()) -> str:
        """The legal name nearest to the one that is wanted, with a number if that is taken.

        besides: more that are taken, in lower case.
        """
        base = self.legal(wanted)[: self.longest]
        key = base.lower()
        if key not in self.taken and key not in besides:
            return base
        # From the last number on: a search from 2 takes quadratic time for many like names.
        number = self._numbers.get(key, 2)
        while self._numbered(base, number).lower() in self.taken:
            number += 1
        self._numbers[key] = number
        # `besides` differs from call to call: its numbers are not remembered.
        while (name := self._numbered(base, number)).lower() in self.taken or (
            name.lower() in besides
        ):
            number += 1
        return name

    def _numbered(self, base: str, number: int) -> str:
        end = f"_{number}"
        # The number has to fit within the longest name.
        return base[: self.longest - len(end)] + end


def free_counters(program: Program, procedure: Procedure) -> tuple[str, ...]:
    """Variables of a procedure's loops that are declared nowhere, once each."""
    loops = [loop.variable for loop in records_in_body(procedure, p.For)]
    if not loops:
        return ()
    declared = {v.lower() for v in (*program.variables, *procedure.variables)}
    found: dict[str, str] = {}
    for name in loops:
        if name.lower() not in declared:
            found.setdefault(name.lower(), name)
    return tuple(found.values())


def with_legal_names(job: Legalisation) -> Program:
    """Return the program with legal names for the language, each the same wherever it is used.

    It serves languages whose programs do not record original names.
    """
    can, program = job.can.names, job.program
    if can is None:
        return program
    names, legal = Names(can.longest, can.reserved, can.legal), dict[str, str]()
    given = [FLANGE, BASE, *(q.name for q in program.procedures)]
    given += [name for table in _TABLES for name in getattr(program, table)]
    given += [name for name in (program.name, program.entry) if name]
    # Legal names go first, so that no other name takes them.
    kept = [name for name in given if names.free(name) == name]
    for name in (*kept, *given):
        if name.lower() not in legal:
            legal[name.lower()] = short = names.free(name)
            names.take(short)
            if short != name:
                job.findings.append(can.renamed(given=name, name=short))

    def of(name: str) -> str:
        return legal.get(name.lower(), name)

    def renamed(part: Any) -> Any:
        fields = _FIELDS.get(type(part), ())
        return replace(part, **{f: of(getattr(part, f)) for f in fields if getattr(part, f)})

    rows: dict[str, Any] = {
        t: {of(n): part for n, part in getattr(program, t).items()} for t in _TABLES
    }
    return rewrite(replace(program, **rows), renamed)


def with_signals_renamed(program: Program, names: Mapping[str, str]) -> Program:
    """The program with other names for signals, which nothing else in it has. names: old to new."""

    def renamed(part: Any) -> Any:
        match part:
            case p.SetSignal() | p.Trigger() | p.WaitSignal() if part.signal in names:
                return replace(part, signal=names[part.signal])
            case e.Name(name) if name in names:
                return replace(part, name=names[name])
            case p.Opaque(effect=effect) | Declaration(effect=effect) if effect is not None:
                for old, new in names.items():
                    effect = effect.renamed(old.lower(), {new.lower()})
                return replace(part, effect=effect)
        return part

    if not names:
        return program
    signals = {names.get(name, name): signal for name, signal in program.signals.items()}
    return rewrite(replace(program, signals=signals), renamed)


def with_declared_names(program: Program) -> Program:
    """The program with every name as it was declared, and calls that say another unit than theirs.

    Tools, frames, speeds and blends are the business of motions.
    """
    spelling = Spelling(program)
    variables = _respelled(program.variables, spelling, None)
    return replace(
        program,
        variables=variables,
        procedures=tuple(_respelled_procedure(q, spelling) for q in program.procedures),
    )


def _respelled_procedure(procedure: Procedure, spelling: Spelling) -> Procedure:
    spelling.enter(procedure)
    return replace(
        procedure,
        variables=_respelled(procedure.variables, spelling, procedure.unit),
        body=_respelled(procedure.body, spelling, procedure.unit),
    )


def _respelled(value: Any, spelling: Spelling, unit: str | None) -> Any:
    """unit: in which it stands."""

    def visit(node: Any) -> Any:
        match node:
            case e.Name(name):
                return replace(node, name=spelling.name(name))
            case e.Elapsed(timer) | p.StartTimer(timer):
                return replace(node, timer=spelling.timer(timer))
            case e.Member(field=field):
                return replace(node, field=field.lower())
            case e.Apply(function) if function.lower() in e.FUNCTIONS:
                return replace(node, function=function.lower())
            case e.Apply(function) if called := spelling.procedure(function):
                return replace(node, function=called.name)
            case p.SetSignal(name) | p.WaitSignal(name) | p.Trigger(name):
                return replace(node, signal=spelling.name(name))
            case p.For(name):
                return replace(node, variable=spelling.name(name))
            case p.Call(name) if called := spelling.procedure(name):
                other = None if called.unit == unit else called.unit
                return replace(node, procedure=called.name, unit=other)
        return node

    return rewrite(value, visit, (Path, p.Motion, e.TargetValue, e.JointValue, e.PoseValue))
