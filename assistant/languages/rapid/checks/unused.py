"""Rules of what nothing uses: data and routines of a module, data of a routine."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

import numpy as np

from assistant.base.diagnostics import Rule
from assistant.languages.checks.names import NameSet
from assistant.languages.checks.registry import Found, Listing
from assistant.languages.rapid.checks import plain_rules as rules
from assistant.languages.rapid.checks.module_view import RuleContext, Task
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes

_STRING_WORD: Final = re.compile(r"[^\W\d]\w*")
SHORTEST_BEGINNING: Final = 3
"""Letters of a string that count as the begin of a name."""


def unused_declarations(look: RuleContext) -> Found:
    """LOCAL items that nothing uses, and data of routines; global ones in a task with a `main`.

    One finding for all data and one for all routines of a module, at the first of them. What is
    global may be started by hand or by an event if it is a PROC without parameters, and PERS
    data may be shared with other tasks: those are never unused. Nor is what system modules
    declare, which serve many programs.
    """
    used = look.task.once(used_names)
    data: Listing[s.Node] = Listing()
    routines: Listing[s.Node] = Listing()
    system = "SYSMODULE" in look.module.attributes or look.file in look.task.common
    open_to_all = system or not look.task.has_main
    for item in look.module.items:
        match item:
            case s.TargetRunNode(scope, run) if scope == "LOCAL" or not open_to_all:
                data.add_rows(item, np.flatnonzero(~used.among(run.names)), run.names.name)
            case s.Data(scope, storage, _, name):
                kept = scope != "LOCAL" and (open_to_all or storage == "PERS")
                if not kept and name.lower() not in used:
                    data.add(item, name)
            case s.Routine(kind, local, name):
                started = not local and (open_to_all or (kind == "PROC" and not item.parameters))
                if not started and name.lower() not in used:
                    routines.add(item, name)
    yield from _listing_finding(look, rules.UNUSED_DATA, data)
    yield from _listing_finding(look, rules.UNUSED_ROUTINE, routines)
    for routine in look.routines:
        yield from _unused_inner_data(look, routine)


def _unused_inner_data(look: RuleContext, routine: s.Routine) -> Found:
    declared = [item for item in routine.body if isinstance(item, s.Data)]
    if not declared:
        return
    used = _mentioned_names(nodes((routine.body, *(h.body for h in routine.handlers))))
    idle: Listing[s.Node] = Listing()
    for item in declared:
        if item.name.lower() not in used:
            idle.add(item, item.name)
    yield from _listing_finding(look, rules.UNUSED_DATA, idle)


def _listing_finding(look: RuleContext, rule: Rule, found: Listing[s.Node]) -> Found:
    if found.first is not None:
        node, row = found.first
        yield look.finding(rule, node, row=row, **found.words)


def used_names(task: Task) -> NameSet:
    """What a task mentions anywhere."""
    return _mentioned_names(nodes(task.modules))


def _mentioned_names(places: Iterable[s.Node]) -> NameSet:
    """Names that some nodes mention, in lower case.

    A word in a string counts: routines are called and data are found by name. Where a name is
    put together while the program runs, whatever begins like it counts as well.
    """
    names = NameSet()
    for node in places:
        match node:
            case s.NameRef(name) | s.FunctionCall(name) | s.ProcedureCall(str(name)):
                names.words.add(name.lower())
            case s.Connect(trap=trap):
                names.words.add(trap.lower())
            case s.StringLiteral(value):
                words = [word.lower() for word in _STRING_WORD.findall(value)]
                names.words.update(words)
                names.beginnings.update(word for word in words if len(word) >= SHORTEST_BEGINNING)
            case s.MoveRunNode(run):
                names.columns += [run.names, run.vias]
                for m in run.motions.table:
                    names.words.update(w.lower() for w in (m.speed, m.zone, m.tool, m.frame))
    return names
