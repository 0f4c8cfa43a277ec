"""Expand the irregular lines of long runs into ordinary nodes.

A run holds lines for which no single-line rule has a finding and which every language treats alike:
moves to declared robtargets with a declared speed, zone, tool and work object, and declarations of
robtargets with unique names. Any other line of a run is read as a separate line. So a rule for
moves or declarations never inspects runs; only rules that compare lines with each other, and rules
for numbers, do.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import chain, pairwise
from typing import Any, Final, Literal

import numpy as np

from assistant.base.arrays import Truths
from assistant.base.diagnostics import Span
from assistant.languages.checks.names import NameSet, repeated_rows
from assistant.languages.rapid.checks.motions import PREDEFINED_SETTINGS, nearest_predefined
from assistant.languages.rapid.checks.rule_context import RuleContext, Task
from assistant.languages.rapid.reading.parser import parse_rows
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import lists, map_lists, nodes
from assistant.languages.runs.columns import Names

_Fit = Literal["plain", "unknown", "odd"]
"""Fit of a name in a move: data of the right kind, not data of the given modules, or something
else.
"""

_TYPES: Final = ("speeddata", "zonedata", "tooldata", "wobjdata")
"""Kinds of the words after the target of a move."""
_STORAGES: Final = {
    "robtarget": ("CONST", "PERS"),
    "tooldata": ("PERS",),
    "wobjdata": ("PERS",),
}
"""By type: how data of it are declared that any move takes; any way for those not listed."""


def with_single_rows(
    files: Sequence[s.File], common: Sequence[s.File] = (), *, unknown: bool = True
) -> tuple[s.File, ...]:
    """Return the files of a task, with an ordinary node for each irregular line of a run.

    unknown: True also expands the first line with a name that no given module declares, which a
    rule reports; another language treats it like any other line.
    """
    files = tuple(files)
    # Without runs there is nothing to expand.
    if not any(True for _ in _runs(files)):
        return files
    task = Task(files, common)
    shared = _shared_names(task)
    files = tuple(
        _changed(file, [_with_targets(file, module, shared) for module in file.modules])
        for file in files
    )
    # Declarations have changed, so names are looked up anew for the moves.
    task = Task(files, common)
    targets, local = NameSet(), dict[int, NameSet]()
    for module, node in task.runs:
        own = local.setdefault(id(module), NameSet()) if node.scope == "LOCAL" else targets
        own.columns.append(node.run.names)
    none = NameSet()
    made = []
    for file in files:
        modules = []
        for module in file.modules:
            seen = targets, local.get(id(module), none)
            modules.append(_Moves(RuleContext(file, module, task), seen, unknown=unknown).module())
        made.append(_changed(file, modules))
    return tuple(made)


def _runs(files: Sequence[s.File]) -> Iterator[s.RunNode]:
    for file in files:
        for module in file.modules:
            for item in module.items:
                if isinstance(item, s.RunNode):
                    yield item
                elif isinstance(item, s.Routine):
                    for body in lists(item):
                        yield from (node for node in body if isinstance(node, s.RunNode))


def _changed(file: s.File, modules: Iterable[s.Module]) -> s.File:
    made = iter(modules)
    parts = tuple(next(made) if isinstance(part, s.Module) else part for part in file.parts)
    same = all(one is other for one, other in zip(parts, file.parts, strict=True))
    return file if same else replace(file, parts=parts)


def _split(file: s.File, node: s.RunNode, single: Truths) -> list[Any]:
    """A run with an ordinary node for each of some rows (n,); all of it if it has no text."""
    if node.rows is None or node.span is None or file.source is None or not single.any():
        return [node]
    kind: Any = "items" if isinstance(node, s.TargetRunNode) else "statements"
    text, start = file.source.text, node.span.start
    # Stretches of rows that stay or go alternate.
    bounds = np.flatnonzero(single[1:] != single[:-1]) + 1
    found: list[Any] = []
    for first, stop in pairwise([0, *bounds.tolist(), len(single)]):
        if single[first]:
            spans = [Span(a + start, b + start) for a, b in node.rows[first:stop].tolist()]
            found += parse_rows(text, spans, kind)
            continue
        (begin, _), (_, end) = node.rows[first].tolist(), node.rows[stop - 1].tolist()
        part: Any = node
        span, rows = Span(start + begin, start + end), node.rows[first:stop] - begin
        run = part.run.rows(slice(first, stop))
        found.append(replace(part, run=run, rows=rows, span=span))
    return found


# Declarations


@cache
def _taken() -> NameSet:
    names = NameSet()
    names.words |= predefined.taken_names()
    return names


def _shared_names(task: Task) -> dict[int, Truths]:
    """By the `id` of a run, its rows (n,) whose name something else has as well."""
    single = {id(node): np.zeros(len(node.run), dtype=bool) for _, node in task.runs}
    modules = {id(module): at for at, module in enumerate(task.modules, 1)}
    columns = [node.run.names for _, node in task.runs]
    own = [modules[id(module)] for module, _ in task.runs]
    local = [node.scope == "LOCAL" for _, node in task.runs]
    # Once for all names of a module, and once for local names apart from global ones.
    for scopes in (own, (np.array(own) * local).tolist()) if columns else ():
        for at, row in chain.from_iterable(repeated_rows(columns, scopes)):
            single[id(task.runs[at][1])][row] = True
    others, inner = NameSet(), dict[int, NameSet]()
    others.words.update(task.shared.names)
    for module, node in task.runs:
        if id(module) not in inner:
            inner[id(module)] = NameSet()
            inner[id(module)].words.update(task.levels(module)[0].names)
        for names in (_taken(), others, inner[id(module)]):
            single[id(node)] |= names.among(node.run.names)
    return single


def _with_targets(file: s.File, module: s.Module, shared: dict[int, Truths]) -> s.Module:
    """Return the module with only valid, uniquely named declarations in runs."""
    items: list[Any] = []
    after = changed = False
    for item in module.items:
        match item:
            case s.TargetRunNode():
                single = shared[id(item)]
                # A declaration after a routine is out of order, which a rule reports row by row.
                items += _split(file, item, single | after)
                changed |= bool(single.any()) or after
                continue
            case s.Routine():
                after = True
                made = map_lists(item, lambda body: _declared(file, body))
                changed |= made is not item
                item = made
        items.append(item)
    return replace(module, items=tuple(items)) if changed else module


def _declared(file: s.File, body: tuple[s.StatementNode, ...]) -> tuple[s.StatementNode, ...]:
    """Return the statements of a routine; its declarations are separate data, never a run."""
    if not any(isinstance(node, s.TargetRunNode) for node in body):
        return body
    found: list[s.StatementNode] = []
    for node in body:
        if isinstance(node, s.TargetRunNode):
            found += _split(file, node, np.ones(len(node.run), dtype=bool))
        else:
            found.append(node)
    return tuple(found)


# Moves


class _Moves:
    """Moves of a module that are plain.

    targets: names of targets in runs, those of the task and the local ones of the module.
    unknown: see `with_single_rows`.
    """

    def __init__(
        self, look: RuleContext, targets: tuple[NameSet, NameSet], *, unknown: bool
    ) -> None:
        self.look, self.targets, self.unknown = look, targets, unknown

    def module(self) -> s.Module:
        items = tuple(
            self._routine(item) if isinstance(item, s.Routine) else item
            for item in self.look.module.items
        )
        same = all(one is other for one, other in zip(items, self.look.module.items, strict=True))
        return self.look.module if same else replace(self.look.module, items=items)

    def _routine(self, routine: s.Routine) -> s.Routine:
        if not any(isinstance(n, s.MoveRunNode) for body in lists(routine) for n in body):
            return routine
        loops = {n.variable.lower() for n in nodes(routine) if isinstance(n, s.ForLoop)}
        names = _Names(self.look, routine, loops)

        def body(statements: tuple[s.StatementNode, ...]) -> tuple[s.StatementNode, ...]:
            found: list[s.StatementNode] = []
            for node in statements:
                if isinstance(node, s.MoveRunNode):
                    found += _split(self.look.file, node, self._single(node, names))
                else:
                    found.append(node)
            # A run that is split grows the list; the same length means that nothing changed.
            return statements if len(found) == len(statements) else tuple(found)

        changed: s.Routine = map_lists(routine, body)
        return changed

    def _single(self, node: s.MoveRunNode, names: _Names) -> Truths:
        """(n,) the rows that are not plain."""
        run = node.run
        single = np.zeros(len(run), dtype=bool)
        for at, motion in enumerate(run.motions.table):
            given = (motion.speed, motion.zone, motion.tool, motion.frame)
            fits = {names.fit(*pair) for pair in zip(given, _TYPES, strict=True) if pair[0]}
            if "odd" in fits:
                single |= run.motions.index == at
            elif "unknown" in fits and self.unknown:
                # The first use is enough: the finding is about the name.
                single[np.flatnonzero(run.motions.index == at)[:1]] = True
        for column in (run.names, run.vias) if run.values is None else ():
            self._targets(column, names, single)
        return single

    def _targets(self, column: Names, names: _Names, single: Truths) -> None:
        """Adds the rows whose targets are not plain."""
        # Vias of moves that are not circular have no name.
        named = np.array([bool(stem) for stem in column.stems])[column.stem] | (column.number >= 0)
        shared, own = self.targets
        known = (shared.among(column) | own.among(column)) & ~names.inner.among(column)
        found: dict[str, _Fit] = {}
        for row in np.flatnonzero(named & ~known).tolist():
            low = column.name(row).lower()
            first = low not in found
            fit = found[low] if not first else names.fit(low, "robtarget")
            found[low] = fit
            single[row] |= fit == "odd" or (fit == "unknown" and first and self.unknown)


class _Names:
    """Meaning of names in a routine. loops: lower-case variables of its loops."""

    def __init__(self, look: RuleContext, routine: s.Routine, loops: set[str]) -> None:
        self.look, self.routine, self.loops = look, routine, loops
        self.inner = NameSet()
        self.inner.words |= {*look.frame(routine).names, *loops}

    def fit(self, name: str, type: str) -> _Fit:
        """Classify a name where data of a type are expected."""
        low = name.lower()
        found = None if low in self.loops else self.look.find(low, self.routine)
        if low in self.loops:
            return "odd"
        if found is None:
            return self._predefined(low, type)
        match found.node:
            case s.Data(dimensions=()) | s.ParameterNode(dimensions=0):
                storages = _STORAGES.get(type)
                fits = found.type.lower() == type and found.kind in (storages or (found.kind,))
                several = len(self.look.task.shared.all(low)) > 1
                return "plain" if fits and not several else "odd"
        return "odd"

    def _predefined(self, low: str, type: str) -> _Fit:
        standard = predefined.data().get(low)
        if standard is not None:
            return "plain" if standard.type.lower() == type else "odd"
        near = type in PREDEFINED_SETTINGS and nearest_predefined(low, PREDEFINED_SETTINGS[type][0])
        return "odd" if near else "unknown"
