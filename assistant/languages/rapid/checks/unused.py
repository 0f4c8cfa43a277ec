"""Rules of what nothing uses: data and routines of a module, data of a routine."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from assistant.languages.rapid.checks import plain_rules as rules
from assistant.languages.rapid.checks.module_view import Look, Task
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.languages.runs.names import Names, split
from assistant.program.arrays import Truths
from assistant.program.diagnostics import Diagnostic

Found = Iterator[Diagnostic]

_WORD: Final = re.compile(r"[^\W\d]\w*")
SHOWN: Final = 6
"""Names that one finding lists."""
SHORTEST: Final = 3
"""Letters of a string that count as the begin of a name."""


def unused(look: Look) -> Found:
    """LOCAL items that nothing uses, and data of routines; global ones in a task with a `main`.

    One finding for all data and one for all routines of a module, at the first of them. What is
    global may be started by hand or by an event if it is a PROC without parameters, and PERS
    data may be shared with other tasks: those are never unused. Nor is what system modules
    declare, which serve many programs.
    """
    used = look.task.once(Used)
    data: list[tuple[s.Node, int, str]] = []
    routines: list[tuple[s.Node, int, str]] = []
    system = "SYSMODULE" in look.module.attributes or look.file in look.task.common
    open_to_all = system or not look.task.has_main
    for item in look.module.items:
        match item:
            case s.TargetRunNode(scope, run) if scope == "LOCAL" or not open_to_all:
                rows = np.flatnonzero(~used.rows(run.names))
                data += [(item, int(row), run.names.name(int(row))) for row in rows[: SHOWN + 1]]
                data += [(item, int(row), "") for row in rows[SHOWN + 1 :]]
            case s.Data(scope, storage, _, name):
                kept = scope != "LOCAL" and (open_to_all or storage == "PERS")
                if not kept and name not in used:
                    data.append((item, 0, name))
            case s.Routine(kind, local, name):
                started = not local and (open_to_all or (kind == "PROC" and not item.parameters))
                if not started and name not in used:
                    routines.append((item, 0, name))
    yield from _told(look, rules.UNUSED_DATA, data)
    yield from _told(look, rules.UNUSED_ROUTINE, routines)
    for routine in look.routines:
        yield from _inner(look, routine)


def _inner(look: Look, routine: s.Routine) -> Found:
    declared = [item for item in routine.body if isinstance(item, s.Data)]
    if not declared:
        return
    used = Used()
    for node in nodes((routine.body, *(h.body for h in routine.handlers))):
        used.take(node)
    idle: list[tuple[s.Node, int, str]] = [
        (item, 0, item.name) for item in declared if item.name not in used
    ]
    yield from _told(look, rules.UNUSED_DATA, idle)


def _told(look: Look, rule: Any, found: list[tuple[s.Node, int, str]]) -> Found:
    if found:
        first, row, _ = found[0]
        names = ", ".join(f"`{name}`" for _, _, name in found[:SHOWN])
        more = f" and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
        them = "them" if len(found) > 1 else "it"
        yield look.finding(rule, first, row=row, names=names + more, them=them)


class Used:
    """Names that a task mentions anywhere, lower case.

    A word in a string counts: routines are called and data are found by name. Where a name is
    put together while the program runs, whatever begins like it counts as well.
    """

    def __init__(self, task: Task | None = None) -> None:
        self.words: set[str] = set()
        self.beginnings: set[str] = set()
        self.runs: list[Names] = []
        for node in nodes(task.modules if task else ()):
            self.take(node)

    def take(self, node: s.Node) -> None:
        match node:
            case s.NameRef(name) | s.FunctionCall(name) | s.ProcedureCall(str(name)):
                self.words.add(name.lower())
            case s.Connect(trap=trap):
                self.words.add(trap.lower())
            case s.StringLiteral(value):
                words = [word.lower() for word in _WORD.findall(value)]
                self.words.update(words)
                self.beginnings.update(word for word in words if len(word) >= SHORTEST)
            case s.MoveRunNode(run):
                self.runs += [run.names, run.vias]
                for m in run.motions.table:
                    self.words.update(w.lower() for w in (m.speed, m.zone, m.tool, m.frame))

    def __contains__(self, name: str) -> bool:
        low = name.lower()
        if low in self.words or any(low.startswith(begin) for begin in self.beginnings):
            return True
        stem, number = split(low) if low.isascii() else (b"", 0)
        return any(
            (run.number[np.isin(run.stem, _stems(run, stem))] == number).any() for run in self.runs
        )

    def rows(self, names: Names) -> Truths:
        """(n,) which rows of declared names are used."""
        words: dict[bytes, list[int]] = {}
        for word in self.words:
            if word.isascii():
                stem, number = split(word)
                words.setdefault(stem, []).append(number)
        used = np.zeros(len(names), dtype=bool)
        for at, stem in enumerate(names.stems):
            low = stem.lower()
            if any(low.decode("ascii").startswith(begin) for begin in self.beginnings):
                used |= names.stem == at
                continue
            numbers = [np.array(words.get(low, ()), dtype=np.int64)]
            numbers += [run.number[np.isin(run.stem, _stems(run, low))] for run in self.runs]
            used |= (names.stem == at) & np.isin(names.number, np.concatenate(numbers))
        return used


def _stems(names: Names, stem: bytes) -> list[int]:
    return [at for at, other in enumerate(names.stems) if other.lower() == stem]
