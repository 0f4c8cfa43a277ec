"""Names of a program in a cell that exists: what others call it, and what they see of it.

The table `[program]` of a process file states them, or the command line: the name of the entry, a
prefix before all that the program declares, and whether there is a main procedure.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error, warning
from assistant.compiler.cell_equipment import KEYS_WITHOUT_EFFECT
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import BASE, FLANGE
from assistant.program.motion import Path
from assistant.program.program import (
    IDENTIFIER,
    STANDALONE,
    Declaration,
    Interface,
    Procedure,
    Program,
    identifier,
)
from assistant.program.rewriting import records, rewrite, with_names_replaced
from assistant.program.statement_index import records_in_procedures
from assistant.program.vendor_statements import effect_of

if TYPE_CHECKING:
    from assistant.compiler.loader import Loaded
    from assistant.languages import Language


_NO_NAME = error("CO320", "`{name}` is no name: letters, digits and `_`, a letter first", "{cure}")
_NAME_TAKEN = error(
    "CO321",
    "the program cannot be called `{name}`: its {kind} `{there}` is called so",
    "choose another name, or put one before those of the program with `prefix`",
)
_OTHER_NAME = error(
    "CO322",
    "in {language} the program cannot be called `{name}`, but `{short}`",
    "choose a name that it can have, such as `{short}`",
)
_NAME_SHORTENED = warning(
    "CO323",
    "in {language} the program is called `{short}`: others call it by that",
    "have it called so, or choose a name that it can have",
)
_NOT_MERE_CALLS = error(
    "CO324",
    "`{name}` does more than call others, so the program cannot be without it",
    "give it the name that others call it by with `as`",
)
_BEGINS_AT_TOP = error(
    "CO325",
    "a program of {language} begins at its top: without a main nobody could call anything of it",
    "leave out `main = false`, or `--no-main`; others call the program by the name of its file",
)
_NO_MAIN_TO_NAME = error(
    "CO326", "there is no main that could be called `{name}`", "leave out `as`, or `main = false`"
)
_NAMES_IN_VENDOR_TEXT = error(
    "CO327",
    "`{text}` keeps its text, in which names stay as they are",
    "leave out `as` and `prefix`, or say it in plain statements",
)

_NAME_NOT_EXPRESSIBLE = error(
    "CO329",
    "{language} cannot name `{name}` as the controller has it",
    "give it a name that the language has, or the `number` that the controller counts it by, or"
    " leave out `on_controller`",
)

_SEVERAL_UNITS = error(
    "CL074",
    "the program is written in {count} units, which could not see what is local to one of them",
    "allow more targets of one unit with `--most-targets`, or give a `prefix` instead of `local`",
)

NAMED_TABLES: Final = (
    "targets",
    "joint_targets",
    "variables",
    "tools",
    "frames",
    "speeds",
    "blends",
)
"""Tables of named declarations, except signals, which belong to the controller."""


def stated_interface(given: Interface | None, called: str | None, main: bool | None) -> Interface:
    """Return the requested interface of a program; arguments override the stated one."""
    stated = given or STANDALONE
    if called is not None:
        stated = replace(stated, called=called)
    return stated if main is None else replace(stated, main=main)


def without_names(loaded: Loaded, process: object) -> Loaded:
    """Return a robot program that keeps its names, ignoring those of a process file.

    Names that the controller declares are still used and not written.
    """
    stands = loaded.program.interface
    if stands is None or replace(stands, there={}) == STANDALONE:
        return loaded
    finding = KEYS_WITHOUT_EFFECT(keys="`program`", path=None if process is None else str(process))
    program = replace(loaded.program, interface=Interface(there=stands.there))
    return replace(loaded, program=program, findings=(*loaded.findings, finding))


def with_interface(program: Program, wishes: Interface, language: Language[Any]) -> Program:
    """The program with the names that are asked of it; raises Refused where it cannot have them."""
    if wishes == STANDALONE:
        return program
    _check_interface(program, wishes, language)
    begins = program.procedure(program.entry or "")
    callable_ = {program.entry} if begins is not None else set()
    if not wishes.main and begins is not None:
        callable_ = {one.procedure for one in begins.body if isinstance(one, p.Call)}
        rest = tuple(one for one in program.procedures if one is not begins)
        program = replace(program, procedures=rest, entry=None)
    if wishes.local and not language.called_by_file:
        program = _with_local_names(program, {name.lower() for name in callable_ if name})
    if wishes.prefix:
        program = with_prefix(program, wishes.prefix, kept=wishes.there)
    if wishes.called and begins is not None:
        program = _with_program_name(program, wishes.called, language)
    return replace(program, interface=wishes)


def _check_interface(program: Program, wishes: Interface, language: Language[Any]) -> None:
    for name in filter(None, (wishes.called, wishes.prefix)):
        if IDENTIFIER.fullmatch(name) is None:
            raise Refused(_NO_NAME(name=name, cure=f"write {identifier(name)}"), exit_status=2)
    begins = program.procedure(program.entry or "")
    if wishes.called and (not wishes.main or begins is None):
        raise Refused(_NO_MAIN_TO_NAME(name=wishes.called))
    if not wishes.main:
        if language.called_by_file:
            raise Refused(_BEGINS_AT_TOP(language=language.title))
        if begins is not None and not _has_only_calls(begins):
            raise Refused(_NOT_MERE_CALLS(name=begins.name))
    kept = first_vendor_text(program, None if wishes.prefix else program.entry)
    if kept is not None and (wishes.prefix or wishes.called):
        raise Refused(_NAMES_IN_VENDOR_TEXT(text=" ".join(kept.split())))


def _has_only_calls(procedure: Procedure) -> bool:
    plain = all(isinstance(one, p.Call | p.Comment) for one in procedure.body)
    given = any(isinstance(one, p.Call) and one.arguments for one in procedure.body)
    return plain and not given and not procedure.variables


def first_vendor_text(program: Program, name: str | None) -> str | None:
    """The first text of a robot language that the program keeps; that says a name, if given."""
    others = records((program.declarations, program.variables))
    for part in (*records_in_procedures(program, p.Opaque, e.Verbatim), *others):
        if isinstance(part, p.Opaque | e.Verbatim | Declaration):
            if name is None or name.lower() in effect_of(part).names:
                return part.text
    return None


def _with_local_names(program: Program, callable_: set[str]) -> Program:
    """All that others do not call is the module's own."""
    procedures = (
        one if one.name.lower() in callable_ else replace(one, local=True)
        for one in program.procedures
    )
    variables = {name: replace(one, local=True) for name, one in program.variables.items()}
    return replace(program, procedures=tuple(procedures), variables=variables)


def _with_program_name(program: Program, name: str, language: Language[Any]) -> Program:
    """The program whose entry has a name, and its file where others call that."""
    for kind, there in _declared_kinds(program):
        own = kind == "procedure" and there.lower() == (program.entry or "").lower()
        if there.lower() == name.lower() and not own:
            raise Refused(_NAME_TAKEN(name=name, kind=kind, there=there))
    made = with_entry_name(program, name)
    return replace(made, name=name) if language.called_by_file else made


def with_entry_name(program: Program, name: str) -> Program:
    """The program whose entry has a name that is free."""
    names = {(program.entry or "").lower(): name}
    procedures = tuple(with_names_replaced(one, names) for one in program.procedures)
    return replace(program, procedures=procedures, entry=name)


def _declared_kinds(program: Program) -> Iterator[tuple[str, str]]:
    """Yield each name that others see, with its kind."""
    yield from (("procedure", one.name) for one in program.procedures)
    yield from (("signal", name) for name in program.signals)
    for table in NAMED_TABLES:
        yield from ((table[:-1].replace("_", " "), name) for name in getattr(program, table))


def interface_findings(
    wishes: Interface, program: Program, language: Language[Any]
) -> Iterator[Diagnostic]:
    """Findings of what a language cannot call as it is to be called.

    program: as the language adapted it.
    """
    count = len({one.unit for one in program.procedures})
    if wishes.local and not language.called_by_file and count > 1:
        yield _SEVERAL_UNITS(count=count)
    for name in language.not_there(program):
        yield _NAME_NOT_EXPRESSIBLE(name=name, language=language.title)
    name = wishes.called
    if not name or program.entry is None:
        return
    if language.called_by_file:
        short = PurePath(language.file_name(program)).stem
    else:
        short = language.spelled(program)("procedure", "", program.entry)
    if short.lower() == name.lower():
        return
    near = short.lower() == name.replace("_", "").lower()
    rule = _NAME_SHORTENED if near else _OTHER_NAME
    yield rule(name=name, short=short, language=language.title)


@dataclass(frozen=True, slots=True)
class _NewNames:
    """New names by lower-case ones: of procedures, of data, of settings by their tables."""

    tables: Mapping[str, Mapping[str, str]]

    def of(self, table: str, name: str) -> str:
        return self.tables[table].get(name.lower(), name)


def with_prefix(program: Program, prefix: str, kept: Collection[str] = ()) -> Program:
    """The program with a prefix before all that it declares, but for signals.

    kept: lower-case names of tools and frames that the controller has, which stay.
    """
    there = {FLANGE, BASE, *kept}
    own: dict[str, list[str]] = {table: list(getattr(program, table)) for table in NAMED_TABLES}
    own["procedures"] = [one.name for one in program.procedures]
    names = _NewNames(
        {
            table: {
                name.lower(): prefix + name
                for name in given
                if table not in ("tools", "frames") or name.lower() not in there
            }
            for table, given in own.items()
        }
    )
    tables: dict[str, Any] = {
        table: {names.of(table, name): part for name, part in getattr(program, table).items()}
        for table in NAMED_TABLES
    }
    tables["variables"] = {
        name: _renamed(one, names, prefix, frozenset()) for name, one in tables["variables"].items()
    }
    procedures = []
    for one in program.procedures:
        inner = frozenset(
            name.lower() for name in (*one.variables, *(q.name for q in one.parameters))
        )
        counted = {s.variable.lower() for s in records(one.body) if isinstance(s, p.For)}
        hidden = inner | (counted - set(names.tables["variables"]))
        body = _renamed(one.body, names, prefix, hidden)
        variables = {n: _renamed(v, names, prefix, hidden) for n, v in one.variables.items()}
        name = names.of("procedures", one.name)
        procedures.append(replace(one, name=name, body=body, variables=variables))
    entry = program.entry and names.of("procedures", program.entry)
    begun = f"{program.name}_".lower().startswith(prefix.lower())
    title = program.name if begun else prefix + program.name
    return replace(program, name=title, procedures=tuple(procedures), entry=entry, **tables)


def _renamed(value: Any, names: _NewNames, prefix: str, hidden: frozenset[str]) -> Any:
    """A part of the program with the new names. hidden: what is its own, in lower case."""
    data = {
        low: new
        for table in ("targets", "joint_targets", "variables", "tools", "frames")
        for low, new in names.tables[table].items()
        if low not in hidden
    }

    def setting(table: str, part: Any) -> Any:
        if isinstance(part, e.Name):
            return e.Name(names.of(table, part.name))
        return rewrite(part, visit, _WITH_SETTING_NAMES)  # of one that is worked out

    def visit(part: Any) -> Any:
        match part:
            case e.Name(name):
                return replace(part, name=data.get(name.lower(), name))
            case e.Here(tool, frame):
                return e.Here(names.of("tools", tool), names.of("frames", frame))
            case e.Apply(name):
                return replace(part, function=names.of("procedures", name))
            case p.Call(name):
                return replace(part, procedure=names.of("procedures", name))
            case p.For(name):
                return replace(part, variable=data.get(name.lower(), name))
            case p.Motion(speed, blend, tool, frame):
                return p.Motion(
                    setting("speeds", speed),
                    setting("blends", blend),
                    names.of("tools", tool),
                    names.of("frames", frame),
                )
            case Path():
                return replace(
                    part,
                    name=prefix + part.name,
                    speeds=tuple(setting("speeds", one) for one in part.speeds),
                    blends=tuple(setting("blends", one) for one in part.blends),
                    tools=tuple(names.of("tools", one) for one in part.tools),
                    frames=tuple(names.of("frames", one) for one in part.frames),
                )
        return part

    return rewrite(value, visit, _WITH_SETTING_NAMES)


_WITH_SETTING_NAMES: Final = (Path, p.Motion)
"""Records with names of settings, which are not expressions."""
