"""A program of RAPID with the plain data that other languages are told, beside its cell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, TypeGuard

from assistant.base.diagnostics import Diagnostic, Span
from assistant.base.source_text import starts_of
from assistant.languages.language_types import Adapted
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.plain import FlatProgram, flatten
from assistant.languages.rapid.lift.plain.unread import OMISSION_MARK
from assistant.languages.rapid.lift.program import lift
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.program import statements as p
from assistant.program.program import Procedure, Program, Signal
from assistant.program.rewriting import Body, map_bodies

_CELL_TABLES: Final = (
    "frames", "tools", "speeds", "blends", "signals", "targets", "joint_targets", "variables",
)  # fmt: skip
"""What a cell may have said anew since the program was lifted."""


@dataclass(frozen=True, slots=True)
class _Flattened:
    """files: as they were read; they are kept, so that nothing else has their ids. gone: see
    `Plain`.
    """

    files: tuple[s.File, ...]
    lifted: Program | None
    findings: tuple[Diagnostic, ...]
    gone: frozenset[str] = frozenset()


_NOT_FLATTENED: Final = _Flattened((), None, ())
_LAST_FLATTENED: Final[list[_Flattened]] = []
"""The program that was told last: one translation asks several times."""


def _flattened(files: tuple[s.File, ...]) -> _Flattened:
    """The program of some files with plain data, none if they have no other."""
    if _LAST_FLATTENED and len(_LAST_FLATTENED[0].files) == len(files):
        if all(a is b for a, b in zip(_LAST_FLATTENED[0].files, files, strict=True)):
            return _LAST_FLATTENED[0]
    found = flatten(files)
    if found is None:
        told = _Flattened(files, None, ())
    else:
        lifted = _with_signals(lift(found.files, found.kept), found.signals)
        told = _Flattened(
            files,
            lifted,
            (*_unread_findings(files, found), *_idle_assignment_findings(lifted)),
            found.gone,
        )
    _LAST_FLATTENED[:] = [told]
    return told


def _with_signals(program: Program, signals: Mapping[str, Signal]) -> Program:
    there = {name.lower() for name in program.signals}
    new = {name: one for name, one in signals.items() if name.lower() not in there}
    return replace(program, signals={**program.signals, **new}) if new else program


def _idle_assignment_findings(program: Program) -> Iterator[Diagnostic]:
    """What assigns only to what nothing reads, or what a speed or zone holds already."""
    said = list(program.statements())
    left = {node.span for node in said if not _is_omission_mark(node)}
    gone = {node.span: node.text for node in said if _is_omission_mark(node)}
    for span, text in gone.items():
        if span is not None and span not in left:
            name = text.removeprefix(OMISSION_MARK)
            yield rules.SETTLED(name=name, span=span) if name else rules.IDLE(span=span)


def _is_omission_mark(node: p.Statement) -> TypeGuard[p.Comment]:
    return isinstance(node, p.Comment) and node.text.startswith(OMISSION_MARK)


def without_omission_marks(program: Program) -> Program:
    """The program without the comments that stand for statements which were left out."""

    def body(statements: Body) -> Body:
        return tuple(map_bodies(node, body) for node in statements if not _is_omission_mark(node))

    if not any(map(_is_omission_mark, program.statements())):
        return program
    procedures = tuple(replace(q, body=body(q.body)) for q in program.procedures)
    return replace(program, procedures=procedures)


def _unread_findings(files: tuple[s.File, ...], found: FlatProgram) -> Iterator[Diagnostic]:
    """What is left out, a finding for each declaration."""
    starts = starts_of(file.source for file in files)
    rows = zip(starts, found.unread, found.outside, found.remarks, strict=True)
    for start, unread, outside, remarks in rows:
        for remark in dict.fromkeys(remarks):
            if remark.span is not None:
                yield replace(remark, span=remark.span.moved(start))
        for span, axis in dict.fromkeys(outside):
            if span is not None:
                yield rules.NO_AXIS(axis=axis, span=span.moved(start))
        spans: dict[Span, list[str]] = {}
        for one in unread:
            if one.span is not None:
                spans.setdefault(one.span.moved(start), []).append(f"`{one.name}`")
        for span, names in spans.items():
            yield rules.UNREAD(names=", ".join(names), span=span)


def with_flat_data(program: Program) -> Adapted:
    """The program with plain data, if it is still as it was lifted but for its cell and heads.

    Heads are statements in front of those of a procedure, and comments behind those of the program.
    """
    origin = program.origin
    if origin is None or origin.language != verbatim.LANGUAGE:
        return Adapted(program)
    heads = _heads(program, origin.lifted)
    told = _NOT_FLATTENED if heads is None else _flattened(origin.trees)
    if heads is None or told.lifted is None or not _has_all(told.lifted, heads):
        return Adapted(program)
    changed: dict[str, Any] = {}
    for table in _CELL_TABLES:
        before, now = getattr(origin.lifted, table), getattr(program, table)
        said = {name: one for name, one in now.items() if before.get(name) != one}
        changed[table] = {**getattr(told.lifted, table), **said}
    changed["signals"] = {n: x for n, x in changed["signals"].items() if n.lower() not in told.gone}
    whole = replace(
        told.lifted,
        **changed,
        procedures=_with_heads(told.lifted.procedures, heads),
        comments=(*told.lifted.comments, *program.comments[len(origin.lifted.comments) :]),
        name=program.name,
        entry=program.entry,
        robot=program.robot,
        origin=origin,
    )
    return Adapted(whole, told.findings)


def _heads(program: Program, lifted: Program) -> dict[str, Body] | None:
    """What stands in front of the procedures now, by lower-case name; None for other changes."""
    if program.procedures is lifted.procedures:
        return {}
    if len(program.procedures) != len(lifted.procedures):
        return None
    heads = dict[str, Body]()
    for now, was in zip(program.procedures, lifted.procedures, strict=True):
        if now is was:
            continue
        new = len(now.body) - len(was.body)
        alike = new >= 0 and all(a is b for a, b in zip(now.body[new:], was.body, strict=True))
        if not alike or replace(now, body=was.body) != was:
            return None
        heads[now.name.lower()] = now.body[:new]
    return heads


def _has_all(program: Program, heads: Mapping[str, Body]) -> bool:
    return all(program.procedure(name) is not None for name in heads)


def _with_heads(
    procedures: tuple[Procedure, ...], heads: Mapping[str, Body]
) -> tuple[Procedure, ...]:
    if not heads:
        return procedures
    return tuple(
        replace(one, body=(*heads.get(one.name.lower(), ()), *one.body)) for one in procedures
    )
