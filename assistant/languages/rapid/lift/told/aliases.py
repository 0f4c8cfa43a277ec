"""Signals by a second name (`AliasIO`): what has one is called by its own name."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from typing import Any

from assistant.languages.rapid.lift.told.calls import instruction_of, word_of
from assistant.languages.rapid.tables.signal_types import SIGNALS
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Declaration, Program, Signal, walk
from assistant.program.rewriting import Body, map_bodies, records, rewrite


def with_aliases(program: Program) -> Program:
    """The program without names that stand for one signal, the same all through it.

    Such a name is declared, given its signal by one `AliasIO` and in no kept text besides.
    """
    given: Counter[str] = Counter()
    meant: dict[str, str] = {}
    for node in program.statements():
        if isinstance(node, p.Opaque) and (pair := _alias_of(node)) is not None:
            given[pair[1]] += 1
            meant[pair[1]] = pair[0]
    if not meant:
        return program
    declared = {name: signal for d in program.declarations for name, signal in _declared_signals(d)}
    inside = {
        name
        for q in program.procedures
        for node in walk(q.body)
        if isinstance(node, p.Opaque)
        for name, _ in _declared_signals(node)
    }
    known = {*program.variables, *(n for q in program.procedures for n in q.variables)}
    data = {name.lower() for name in known}
    names = {
        alias: source
        for alias, source in meant.items()
        if given[alias] == 1
        and alias in declared
        and alias not in inside
        and source.lower() not in data
        and source.lower() not in declared
    }
    names = {
        alias: source for alias, source in names.items() if not _is_named_in_text(program, alias)
    }
    return _with_signal_names(program, names, declared) if names else program


def _alias_of(node: p.Opaque) -> tuple[str, str] | None:
    """The signal and the lower-case name that it gets; None if it is not said by its name."""
    call = instruction_of(node)
    if call is None or word_of(call) != "aliasio":
        return None
    found = called(call)
    match found.given if found is not None else ():
        case (s.NameRef(source) | s.StringLiteral(source), s.NameRef(alias)):
            return source, alias.lower()
    return None


def _declared_signals(kept: Declaration | p.Opaque) -> list[tuple[str, Signal]]:
    read = verbatim.items if isinstance(kept, Declaration) else verbatim.statements
    match verbatim.understood(read, kept.text):
        case (s.Data(type=type, name=str(name), dimensions=()),) if type.lower() in SIGNALS:
            return [(name.lower(), SIGNALS[type.lower()])]
    return []


def _is_named_in_text(program: Program, alias: str) -> bool:
    """Whether a text that stays names it."""
    word = re.compile(rf"\b{re.escape(alias)}\b", re.IGNORECASE)
    for record in records((program.procedures, program.declarations)):
        if isinstance(record, p.Opaque | e.Verbatim | Declaration) and word.search(record.text):
            of_alias = isinstance(record, p.Opaque) and _alias_of(record) is not None
            if not of_alias and not (isinstance(record, Declaration) and _declared_signals(record)):
                return True
    return False


def _with_signal_names(
    program: Program, names: dict[str, str], declared: dict[str, Signal]
) -> Program:
    def named(part: Any) -> Any:
        match part:
            case p.SetSignal(name) | p.WaitSignal(name) | p.Trigger(name):
                return replace(part, signal=names.get(name.lower(), name))
            case e.Name(name) if name.lower() in names:
                return e.Name(names[name.lower()])
        return part

    def gone(node: p.Statement) -> bool:
        pair = _alias_of(node) if isinstance(node, p.Opaque) else None
        return pair is not None and pair[1] in names

    def body(statements: Body) -> Body:
        return tuple(map_bodies(node, body) for node in statements if not gone(node))

    procedures = tuple(replace(q, body=body(rewrite(q.body, named))) for q in program.procedures)
    left = tuple(
        d for d in program.declarations if not any(n in names for n, _ in _declared_signals(d))
    )
    signals = {n: x for n, x in program.signals.items() if n.lower() not in names}
    there = {n.lower() for n in signals}
    for alias, source in names.items():
        if source.lower() not in there:
            there.add(source.lower())
            signals[source] = declared[alias]
    return replace(program, procedures=procedures, declarations=left, signals=signals)
