"""Rules of what nothing uses: data and routines of a module, data of a routine."""

from __future__ import annotations

import re
from typing import Final

import numpy as np

from assistant.languages.checks.name_sets import NameSet
from assistant.languages.checks.registry import Found
from assistant.languages.checks.wording import SHOWN, listed
from assistant.languages.rapid.checks import plain_rules as rules
from assistant.languages.rapid.checks.module_view import Look, Task
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.languages.runs.names import Names
from assistant.program.arrays import Truths
from assistant.program.diagnostics import Rule

_WORD: Final = re.compile(r"[^\W\d]\w*")
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


def _told(look: Look, rule: Rule, found: list[tuple[s.Node, int, str]]) -> Found:
    if found:
        first, row, _ = found[0]
        yield look.finding(rule, first, row=row, **listed([name for _, _, name in found]))


class Used:
    """Names that a task mentions anywhere, lower case.

    A word in a string counts: routines are called and data are found by name. Where a name is
    put together while the program runs, whatever begins like it counts as well.
    """

    def __init__(self, task: Task | None = None) -> None:
        self.names = NameSet()
        self.beginnings: set[str] = set()
        for node in nodes(task.modules if task else ()):
            self.take(node)

    def take(self, node: s.Node) -> None:
        match node:
            case s.NameRef(name) | s.FunctionCall(name) | s.ProcedureCall(str(name)):
                self.names.words.add(name.lower())
            case s.Connect(trap=trap):
                self.names.words.add(trap.lower())
            case s.StringLiteral(value):
                words = [word.lower() for word in _WORD.findall(value)]
                self.names.words.update(words)
                self.beginnings.update(word for word in words if len(word) >= SHORTEST)
            case s.MoveRunNode(run):
                self.names.columns += [run.names, run.vias]
                for m in run.motions.table:
                    self.names.words.update(w.lower() for w in (m.speed, m.zone, m.tool, m.frame))

    def __contains__(self, name: str) -> bool:
        return self._may_be_made(name.lower()) or name.lower() in self.names

    def rows(self, names: Names) -> Truths:
        """(n,) which rows of declared names are used."""
        made = [self._may_be_made(stem.lower().decode("ascii")) for stem in names.stems]
        found: Truths = np.array(made)[names.stem] | self.names.among(names)
        return found

    def _may_be_made(self, name: str) -> bool:
        return any(name.startswith(begin) for begin in self.beginnings)
