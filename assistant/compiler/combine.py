"""One program of several drawings and tables: a routine for each, which others may call.

Tools, frames and signals are common to all sources and must agree; all other names get the
source's prefix.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.compiler.loader import Loaded
from assistant.compiler.program_files import load
from assistant.compiler.program_names import (
    NAMED_TABLES,
    first_vendor_text,
    with_entry_name,
    with_prefix,
)
from assistant.program.program import STANDALONE, Interface, Procedure, Program, identifier
from assistant.program.statements import Call

if TYPE_CHECKING:
    from assistant.sources.process import SurroundingsByRobot
    from assistant.sources.process.placement import DrawingPlacement


_NO_DRAWN_SOURCE = error(
    "CL070",
    "`{source}` is a robot program, or keeps text of one, and cannot be part of another one",
    "name drawings, tables and pseudo-programs only",
)
_STATED_DIFFERENTLY = error(
    "CL071",
    "`{first}` and `{second}` say different things of the {kind} `{name}`",
    "say the same of it in both, or give it two names",
)
_NAME_IN_BOTH = error(
    "CL072",
    "`{first}` and `{second}` both have a {kind} `{name}`",
    "give one of them another `prefix` under [program] of its process file, and with `as` another"
    " name",
)
_NAME_OF_MAIN = error(
    "CL075",
    "`{source}` has a routine `{name}`, and so is the one called that runs all of them",
    "rename the file, or name the routine by `as` under [program] of its process file",
)

_MAIN_PROCEDURE: Final = "main"
"""Procedure that runs all of them, and where a controller begins."""
_SHARED_TABLES: Final = ("tools", "frames", "signals")
"""Tables that all drawings of a cell share."""
_SEPARATE_TABLES: Final = tuple(table for table in NAMED_TABLES if table not in _SHARED_TABLES)


def combine_sources(
    sources: Sequence[str | FilePath],
    name: str,
    *,
    process: str | FilePath | None = None,
    unit: str | None = None,
    placement: DrawingPlacement | None = None,
    around: SurroundingsByRobot | None = None,
) -> Loaded:
    """One program of several sources, whose main calls a routine of each in their order.

    The routine of a source is called as its process file says, else like its file; a prefix stands
    before its other names, that of its process file or else the name of the routine. Tools, frames
    and signals are common to all. name: of the program. Others: as for `load`. Raises Unreadable
    and Refused, also where two sources do not go together.
    """
    parts: list[tuple[str, Program]] = []
    findings: list[Diagnostic] = []
    for source in sources:
        loaded = load(source, process=process, unit=unit, placement=placement, around=around)
        if loaded.language is not None or first_vendor_text(loaded.program, None) is not None:
            raise Refused(_NO_DRAWN_SOURCE(source=source, path=str(source)))
        findings += (one.within(str(source)) for one in loaded.findings)
        parts.append((str(source), _with_own_names(FilePath(source), loaded.program)))
    return Loaded(_combined_program(parts, identifier(name)), None, tuple(findings))


def _with_own_names(source: FilePath, program: Program) -> Program:
    """Return a program with unique names, so that it can be combined with the others."""
    stands = program.interface or STANDALONE
    called = stands.called or identifier(source.stem)
    common = (*program.tools, *program.frames)
    made = with_prefix(program, stands.prefix or f"{called}_", {one.lower() for one in common})
    if made.procedure(made.entry or "") is None:
        return made
    if not stands.main:
        return made
    return with_entry_name(made, called)


def _combined_program(parts: Sequence[tuple[str, Program]], name: str) -> Program:
    programs = [program for _, program in parts]
    tables: dict[str, Any] = {table: _common_entries(parts, table) for table in _SHARED_TABLES}
    tables |= {table: _separate_entries(parts, table) for table in _SEPARATE_TABLES}
    procedures = list(_separate_entries(parts, "procedures").values())
    calls: list[Call] = []
    for program in programs:
        stands, begins = program.interface or STANDALONE, program.procedure(program.entry or "")
        if begins is None:
            continue
        if stands.main:
            calls.append(Call(begins.name))
        else:  # its routines are called one by one
            procedures.remove(begins)
            calls += (one for one in begins.body if isinstance(one, Call))
    for source, program in parts:
        for one in program.procedures:
            if one in procedures and one.name.lower() == _MAIN_PROCEDURE:
                raise Refused(_NAME_OF_MAIN(source=source, path=source, name=one.name))
    return Program(
        name,
        (Procedure(_MAIN_PROCEDURE, tuple(calls)), *procedures),
        entry=_MAIN_PROCEDURE,
        robot=_common_robot(parts),
        comments=tuple(chain.from_iterable(program.comments for program in programs)),
        interface=_combined_interface(programs),
        **tables,
    )


def _common_robot(parts: Sequence[tuple[str, Program]]) -> str | None:
    stated = [(source, program.robot) for source, program in parts if program.robot is not None]
    for source, robot in stated[1:]:
        if robot != stated[0][1]:
            raise Refused(
                _STATED_DIFFERENTLY(first=stated[0][0], second=source, kind="robot", name=robot)
            )
    return stated[0][1] if stated else None


def _combined_interface(programs: Iterable[Program]) -> Interface | None:
    stated = [one.interface for one in programs if one.interface is not None]
    if not stated:
        return None
    there = {name: number for one in stated for name, number in one.there.items()}
    return Interface(local=any(one.local for one in stated), there=there)


def _common_entries(parts: Sequence[tuple[str, Program]], table: str) -> dict[str, Any]:
    """Return the entries that programs share; all must state the same for a name, which is listed
    once.
    """
    found: dict[str, tuple[str, str, Any]] = {}
    for source, program in parts:
        stands = program.interface or STANDALONE
        for name, value in getattr(program, table).items():
            key, said = name.lower(), (value, _spelling_of(stands.there, name))
            first, _, known = found.setdefault(key, (source, name, said))
            if known != said:
                raise Refused(
                    _STATED_DIFFERENTLY(first=first, second=source, kind=table[:-1], name=name)
                )
    return {name: said[0] for _, name, said in found.values()}


def _spelling_of(there: Mapping[str, int | None], name: str) -> tuple[bool, int | None]:
    return name.lower() in there, there.get(name.lower())


def _separate_entries(parts: Sequence[tuple[str, Program]], table: str) -> dict[str, Any]:
    """Return the separate entries of each program; two of them must not have the same name."""
    found: dict[str, tuple[str, str, Any]] = {}
    for source, program in parts:
        given = getattr(program, table)
        named = given.items() if isinstance(given, dict) else ((one.name, one) for one in given)
        for name, value in named:
            first, _, _ = found.setdefault(name.lower(), (source, name, value))
            if first != source:
                kind = table[:-1].replace("_", " ")
                raise Refused(_NAME_IN_BOTH(first=first, second=source, kind=kind, name=name))
    return {name: value for _, name, value in found.values()}
