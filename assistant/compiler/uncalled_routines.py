"""Routines that nothing in a program calls, left out if a language has no equivalent for them.

Old routines in a file are normal: one that is never called must not prevent the translation. What
can be expressed of it stays, so that a user finds it there.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from typing import Final, TypeVar

from assistant.base.diagnostics import Declared, Diagnostic, ProgramTable, Severity, Span, warning
from assistant.base.source_text import lines_of
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import texts_in
from assistant.program.program import Declaration, Procedure, Program, walk
from assistant.program.rewriting import records
from assistant.program.statement_index import records_in_procedures
from assistant.program.vendor_statements import effect_of

T = TypeVar("T")
_DATA_TABLES: Final[tuple[ProgramTable, ...]] = ("tools", "frames", "targets", "joint_targets")
"""Data without a place in the text."""

NOT_CALLED: Final = warning(
    "CO015",
    "`{name}` is left out: nothing in the program calls it, and {language} has no equivalent for "
    "part of it",
    "translate it by hand if an operator or another program calls it",
)


def without_uncalled(
    program: Program, found: Iterable[Diagnostic], language: str
) -> tuple[Program, tuple[Diagnostic, ...]] | None:
    """Return the program without such routines, and a finding for each; None if none is in the way.

    found: what is found of the program, with errors for what the language cannot express.
    """
    wrong = [one for one in found if one.severity is Severity.ERROR]
    if program.entry is None or not wrong:
        return None
    routines: list[Procedure | Declaration] = [*program.procedures, *_kept_routines(program)]
    named = {_name_of(one): _names_in(one) for one in routines}
    if _may_call_unknown(program, named):
        return None
    called = program.origin.called if program.origin is not None else frozenset[str]()
    live = _routines_reached({program.entry.lower(), *called}, program, named)
    dead = {name: one for one in routines if (name := _name_of(one)) not in live}
    bad = _data_without_equivalent(program, wrong) - _names_alive(program, named, live)
    faulty = {
        name
        for name, one in dead.items()
        if named[name] & bad or any(_is_about_routine(x, name, one) for x in wrong)
    }
    if not faulty and not bad:
        return None
    gone = {name for name in dead if not faulty.isdisjoint(_reached_from(name, named))}
    idle = _named_only_in(gone, program, named)
    left = replace(
        program,
        tools=_without_names(program.tools, bad),
        frames=_without_names(program.frames, bad),
        targets=_without_names(program.targets, bad),
        joint_targets=_without_names(program.joint_targets, bad),
        variables=_without_names(program.variables, bad),
        procedures=tuple(one for one in program.procedures if one.name.lower() not in gone),
        declarations=tuple(
            one
            for one in program.declarations
            if effect_of(one).writes.isdisjoint(gone) and not effect_of(one).writes & idle
        ),
    )
    # Forms of a routine for what it is given share its span: it is not left out if one is called.
    kept = {one.span for one in left.procedures}
    told = [
        x
        for name, one in dead.items()
        if name in gone and one.span not in kept
        for x in _left_out_finding(one, name, language)
    ]
    told += [
        NOT_CALLED(name=name, language=language, span=one.span)
        for one in program.declarations
        for name in sorted(effect_of(one).writes & idle)
        if one.span is not None
    ]
    told += [
        NOT_CALLED(name=name, language=language, span=span, about=about)
        for name, span, about in _routine_data(program)
        if name.lower() in bad
    ]
    return left, tuple(told)


def is_uncalled(name: str, program: Program) -> bool:
    """True if surely nothing calls a routine."""
    routines: list[Procedure | Declaration] = [*program.procedures, *_kept_routines(program)]
    named = {_name_of(routine): _names_in(routine) for routine in routines}
    if program.entry is None or _may_call_unknown(program, named):
        return False
    called = program.origin.called if program.origin is not None else frozenset[str]()
    return name.lower() not in _routines_reached({program.entry.lower(), *called}, program, named)


def _routine_data(program: Program) -> Iterator[tuple[str, Span | None, Declared]]:
    """Names in routines, with their places if these are known."""
    for name, one in program.variables.items():
        yield name, one.span, Declared(name, "variables")
    for table in _DATA_TABLES:
        yield from ((name, None, Declared(name, table)) for name in getattr(program, table))


def _data_without_equivalent(program: Program, wrong: Sequence[Diagnostic]) -> set[str]:
    """Names in lower case of data that the language has no equivalent for."""
    about = {(x.about.table, x.about.name) for x in wrong if isinstance(x.about, Declared)}
    spans = {x.span for x in wrong if x.span is not None}
    return {
        name.lower()
        for name, span, subject in _routine_data(program)
        if (subject.table, name) in about or span in spans
    }


def _names_alive(program: Program, named: Mapping[str, Set[str]], live: Set[str]) -> set[str]:
    """Names in lower case that anything says but routines that nothing calls."""
    found = {name for key in live for name in named.get(key, ())}
    found |= texts_in(tuple(program.variables.values()))
    own = {id(one) for one in _kept_routines(program)}
    for one in program.declarations:
        if id(one) not in own:
            found |= effect_of(one).names
    return found


def _without_names(table: Mapping[str, T], names: Set[str]) -> dict[str, T]:
    return {name: one for name, one in table.items() if name.lower() not in names}


def _named_only_in(
    gone: Set[str], program: Program, named: Mapping[str, Set[str]]
) -> frozenset[str]:
    """Data of kept declarations that only routines which are left out name."""
    own = {id(one) for one in _kept_routines(program)}
    data = {
        name
        for one in program.declarations
        if id(one) not in own and one.effect is not None
        for name in one.effect.writes
    }
    inside = {name for key in gone for name in named[key]}
    outside = {name for key, names in named.items() if key not in gone for name in names}
    outside |= texts_in(tuple(program.variables.values()))
    for one in program.declarations:
        if id(one) not in own:
            outside |= effect_of(one).names - effect_of(one).writes
    return frozenset(data & inside - outside)


def _left_out_finding(
    one: Procedure | Declaration, name: str, language: str
) -> Iterator[Diagnostic]:
    """A finding for the routine, which is about all that its span holds."""
    spelled = one.name if isinstance(one, Procedure) else name
    spans = [one.span]
    if one.span is None and isinstance(one, Procedure):
        spans = [statement.span for statement in walk(one.body)]
    for span in dict.fromkeys(spans):
        if span is not None:
            yield NOT_CALLED(name=spelled, language=language, span=span)


def is_about_left_out(finding: Diagnostic, told: Sequence[Diagnostic]) -> bool:
    """True if a finding is about what is left out, and would stop the program."""
    spans = [one.span for one in told if one.span is not None]
    return finding.severity is Severity.ERROR and _is_inside(finding.span, spans)


def _is_inside(span: Span | None, outer: Sequence[Span]) -> bool:
    return span is not None and any(o.start <= span.start and span.end <= o.end for o in outer)


def _name_of(one: Procedure | Declaration) -> str:
    if isinstance(one, Procedure):
        return one.name.lower()
    return next(iter(sorted(effect_of(one).writes)), "")


def _kept_routines(program: Program) -> Iterator[Declaration]:
    """Declarations of one name that do something where they are called."""
    for one in program.declarations:
        effect = effect_of(one)
        if len(effect.writes) == 1 and one.effect is not None and _is_routine(one):
            yield one


def _is_routine(one: Declaration) -> bool:
    """True if a kept declaration has statements: more lines than data have."""
    return len(lines_of(one.text.strip())) > 1


def _names_in(one: Procedure | Declaration) -> frozenset[str]:
    """Every name and text in a routine, in lower case."""
    if isinstance(one, Declaration):
        return effect_of(one).names
    found = texts_in((one.body, tuple(one.variables.values())))
    for record in records(one.body):
        if isinstance(record, p.Opaque | e.Verbatim):
            found |= effect_of(record).names
    return frozenset(found)


def _routines_reached(
    called: Set[str], program: Program, named: Mapping[str, Set[str]]
) -> set[str]:
    """Return the routines that run with the program, or through its declarations.

    called: by the controller; names that are not routines do not matter.
    """
    routines = {id(one) for one in _kept_routines(program)}
    begun = called & named.keys()
    for declaration in program.declarations:
        if id(declaration) not in routines:
            begun |= effect_of(declaration).names & named.keys()
    begun |= texts_in(tuple(program.variables.values())) & named.keys()
    found: set[str] = set()
    pending = list(begun)
    while pending:
        name = pending.pop()
        if name not in found:
            found.add(name)
            pending += named.get(name, frozenset()) & named.keys()
    return found


def _reached_from(name: str, named: Mapping[str, Set[str]]) -> set[str]:
    found: set[str] = set()
    pending = [name]
    while pending:
        one = pending.pop()
        if one not in found:
            found.add(one)
            pending += named.get(one, frozenset()) & named.keys()
    return found


def _may_call_unknown(program: Program, named: Mapping[str, Set[str]]) -> bool:
    """True if a kept statement calls what is no routine of the program, and may go on anywhere."""
    return any(
        effect.jumps and not effect.calls <= named.keys()
        for part in records_in_procedures(program, p.Opaque)
        if isinstance(part, p.Opaque)
        for effect in (effect_of(part),)
    )


def _is_about_routine(finding: Diagnostic, name: str, one: Procedure | Declaration) -> bool:
    if finding.span is not None:
        return one.span is not None and _is_inside(finding.span, (one.span,))
    match finding.about:
        case Declared(name=about, table="procedures"):
            return about.lower() == name
        case Declared(owner=owner):
            return owner.lower() == name
    return False
