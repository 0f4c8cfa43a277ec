"""RAPID's own rules over the modules of one program: what a controller would refuse."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, Final

import numpy as np

from assistant.languages.rapid import rules
from assistant.languages.rapid import syntax as s
from assistant.languages.rapid.declared import Declared, undeclared
from assistant.languages.rapid.gather import literal_number, literal_target
from assistant.languages.rapid.runs import MOVES, MoveRun, Names
from assistant.languages.rapid.tables import (
    LONGEST_NAME,
    LONGEST_STRING,
    PREDEFINED,
    PREDEFINED_DATA,
    SPEEDS,
    ZONES,
)
from assistant.program.diagnostics import Diagnostic, Rule

OFF_UNIT: Final = 1e-5
"""Most that the squares of a quaternion may miss 1 by."""


def check(files: Sequence[s.File]) -> tuple[Diagnostic, ...]:
    found: list[Diagnostic] = [f for file in files for f in file.findings]
    scope = _Scope(files)
    for file in files:
        for module in file.modules:
            look = _Look(file, module, scope)
            for rule in RULES:
                found += rule(look)
    return tuple(found)


class _Scope:
    """What all modules declare: storage and type by lower-case name, and runs of targets."""

    def __init__(self, files: Sequence[s.File]) -> None:
        self.storage: dict[str, str] = {}
        self.types: dict[str, str] = {}
        self.counts: Counter[str] = Counter()
        self.runs: list[Names] = []
        self.declared = Declared([m for f in files for m in f.modules])
        for item in (i for f in files for m in f.modules for i in m.items):
            if isinstance(item, s.TargetRunNode):
                if not item.scope:
                    self.runs.append(item.run.names)
            elif isinstance(item, s.Data | s.Routine | s.Record | s.Alias):
                local = item.scope == "LOCAL" if isinstance(item, s.Data) else item.local
                if not local:
                    self.counts[item.name.lower()] += 1
                if isinstance(item, s.Data):
                    self.storage[item.name.lower()] = item.storage
                    self.types[item.name.lower()] = item.type.lower()


class _Look:
    def __init__(self, file: s.File, module: s.Module, scope: _Scope) -> None:
        self.file, self.module, self.scope = file, module, scope
        self.storage = dict(scope.storage)
        self.parameters: set[str] = set()
        for node in nodes(module):
            if isinstance(node, s.Data):
                self.storage[node.name.lower()] = node.storage
            elif isinstance(node, s.ParameterNode):
                self.parameters.add(node.name.lower())

    def known(self, name: str) -> bool:
        """Whether any module, routine or parameter list declares the name."""
        return name.lower() in self.storage or name.lower() in self.parameters

    def finding(self, rule: Rule, node: s.Node, **given: Any) -> Diagnostic:
        if self.file.origin is not None and node.span is not None:
            return self.file.origin.source.finding(rule, node.span, **given)
        return rule(path=self.file.path, place=self.module.name, **given)


def nodes(root: Any) -> Iterator[Any]:
    """Every node of a tree, in no order."""
    pending = [root]
    while pending:
        item = pending.pop()
        if isinstance(item, tuple):
            pending += item
        elif isinstance(item, s.Node):
            yield item
            if is_dataclass(item):
                pending += [getattr(item, f.name) for f in fields(item)]


def loaded_files(root: s.File) -> tuple[str, ...]:
    """Names of the files that `Load` instructions with a literal path name."""
    files = [
        first.value.value.replace(":", "/").rsplit("/", 1)[-1]
        for call in nodes(root.modules)
        if isinstance(call, s.ProcedureCall) and str(call.name).lower() == "load"
        for first in call.arguments
        if isinstance(first, s.Positional) and isinstance(first.value, s.StringLiteral)
    ]
    return tuple(sorted(set(files)))


Found = Iterator[Diagnostic]


def _duplicates(look: _Look) -> Found:
    own: Counter[str] = Counter()
    for item in look.module.items:
        if not isinstance(item, s.Data | s.Routine | s.Record | s.Alias):
            continue
        name = item.name.lower()
        own[name] += 1
        local = item.scope == "LOCAL" if isinstance(item, s.Data) else item.local
        twice = own[name] > 1 or (not local and look.scope.counts[name] > 1)
        if twice:
            yield look.finding(rules.DUPLICATE, item, name=item.name)
    for item in look.module.items:
        if isinstance(item, s.TargetRunNode):
            yield from _duplicate_rows(look, item)


def _duplicate_rows(look: _Look, item: s.TargetRunNode) -> Found:
    names = item.run.names
    order = np.lexsort((names.number, names.stem))
    stem, number = names.stem[order], names.number[order]
    same = np.flatnonzero((stem[1:] == stem[:-1]) & (number[1:] == number[:-1]))
    for row in same[:1]:
        yield look.finding(rules.DUPLICATE, item, name=names.name(int(order[row])))


def _names(look: _Look) -> Found:
    yield from _name(look, look.module, look.module.name, reserved=False)
    for node in nodes(look.module.items):
        if isinstance(node, s.Data | s.Routine | s.Record | s.Alias | s.ParameterNode):
            own = isinstance(node, s.Data) and node.name.lower() in PREDEFINED_DATA
            predefined = isinstance(node, s.Data | s.Routine) and not own
            yield from _name(look, node, node.name, reserved=predefined)
        elif isinstance(node, s.ForLoop):
            yield from _name(look, node, node.variable, reserved=False)
        elif isinstance(node, s.LabelMark):
            yield from _name(look, node, node.name, reserved=False)


def _name(look: _Look, node: s.Node, name: str, *, reserved: bool) -> Found:
    if len(name) > LONGEST_NAME:
        yield look.finding(rules.LONG_NAME, node, name=name, length=len(name))
    if reserved and (name.lower() in SPEEDS or name.lower() in ZONES):
        yield look.finding(rules.RESERVED_NAME, node, name=name)


def _strings(look: _Look) -> Found:
    for node in nodes(look.module.items):
        if isinstance(node, s.StringLiteral) and len(node.value) > LONGEST_STRING:
            yield look.finding(rules.LONG_STRING, node, length=len(node.value))


def _motions(look: _Look) -> Found:
    for node in nodes(look.module.items):
        if isinstance(node, s.MoveRunNode):
            for motion in node.run.motions:
                yield from _motion(look, node, motion.speed, motion.zone, motion.tool, motion.frame)
        elif isinstance(node, s.ProcedureCall) and str(node.name).lower() in WORDS:
            given = [a.value for a in node.arguments if isinstance(a, s.Positional)]
            frame = next(
                (
                    a.value.name
                    for a in node.arguments
                    if isinstance(a, s.Option)
                    and a.name.lower() == "wobj"
                    and isinstance(a.value, s.NameRef)
                ),
                "",
            )
            named = [v.name if isinstance(v, s.NameRef) else "" for v in given[-3:]]
            if len(given) >= 4:
                yield from _motion(look, node, named[0], named[1], named[2], frame)


WORDS: Final = frozenset(word.lower() for word in (*MOVES, "MoveAbsJ"))


def _motion(look: _Look, node: s.Node, speed: str, zone: str, tool: str, frame: str) -> Found:
    for name, table, rule in (
        (speed, SPEEDS, rules.UNKNOWN_SPEED),
        (zone, ZONES, rules.UNKNOWN_ZONE),
    ):
        if not name or name.lower() in table or look.known(name):
            continue
        near = nearest(name, table)
        if near:
            yield look.finding(rule, node, name=name, near=near)
    for name, role, own in ((tool, "tool", "tool0"), (frame, "work object", "wobj0")):
        storage = look.storage.get(name.lower())
        if name and name.lower() != own and storage in ("VAR", "CONST"):
            yield look.finding(rules.NOT_PERSISTENT, node, name=name, role=role)


def nearest(name: str, table: Any) -> str:
    """The predefined names around one that looks like them, empty for any other name."""
    letter = "v" if table is SPEEDS else "z"
    if name[:1].lower() != letter or not name[1:].isdigit():
        return ""
    value = int(name[1:])
    sizes = sorted(int(n[1:]) for n in table if n[1:].isdigit())
    below = [n for n in sizes if n < value][-1:]
    above = [n for n in sizes if n > value][:1]
    return " or ".join(f"{letter}{n}" for n in below + above)


def _quaternions(look: _Look) -> Found:
    for node in nodes(look.module.items):
        if isinstance(node, s.TargetRunNode):
            q = node.run.values[:, 3:7]
            off = np.abs((q * q).sum(axis=1) - 1.0)
            bad = np.flatnonzero((off > OFF_UNIT) & q.any(axis=1))
            if len(bad):
                name = node.run.names.name(int(bad[0]))
                yield look.finding(rules.NOT_UNIT, node, name=name, off=float(off[bad].max()))
        elif isinstance(node, s.Data) and node.type.lower() == "robtarget":
            values = literal_target(node.value)
            if values is not None and any(values[3:7]):
                miss = abs(sum(v * v for v in values[3:7]) - 1.0)
                if miss > OFF_UNIT:
                    yield look.finding(rules.NOT_UNIT, node, name=node.name, off=miss)


def _persistents(look: _Look) -> Found:
    for node in nodes(look.module.items):
        if isinstance(node, s.Data) and node.storage == "PERS" and node.value is not None:
            if not literal(node.value):
                yield look.finding(rules.NOT_LITERAL, node, name=node.name)


def literal(value: s.Expression) -> bool:
    if isinstance(value, s.AggregateNode):
        return all(literal(v) for v in value.items)
    return (
        isinstance(value, s.BoolLiteral | s.StringLiteral | s.Placeholder)
        or literal_number(value) is not None
    )


def _order(look: _Look) -> Found:
    seen = 0
    for item in look.module.items:
        rank, what = next(((r, w) for kind, r, w in RANKS if isinstance(item, kind)), (seen, ""))
        if rank < seen:
            yield look.finding(rules.OUT_OF_ORDER, item, what=what, after=AFTER[seen])
        seen = max(seen, rank)
    for routine in look.module.items:
        if isinstance(routine, s.Routine):
            yield from _declarations_first(look, routine.body)


def _declarations_first(look: _Look, body: Sequence[s.StatementNode]) -> Found:
    stated = False
    for node in body:
        if isinstance(node, s.Data | s.TargetRunNode):
            if stated:
                yield look.finding(
                    rules.OUT_OF_ORDER, node, what="a declaration", after="a statement"
                )
        elif not isinstance(node, s.CommentLine | s.Placeholder):
            stated = True


def _undeclared(look: _Look) -> Found:
    for name in undeclared(look.module, look.scope.declared):
        yield look.finding(rules.UNDECLARED, name, name=name.name)


RANKS: Final[tuple[tuple[Any, int, str], ...]] = (
    (s.Record | s.Alias, 0, "a record"),
    (s.Data | s.TargetRunNode, 1, "data"),
    (s.Routine, 2, "a routine"),
)
AFTER: Final = {1: "data", 2: "a routine"}

RULES: Final[tuple[Callable[[_Look], Found], ...]] = (
    _duplicates,
    _names,
    _strings,
    _motions,
    _quaternions,
    _persistents,
    _order,
    _undeclared,
)

__all__ = ["PREDEFINED", "MoveRun", "check", "literal", "nearest", "nodes"]
