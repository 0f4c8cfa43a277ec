"""What the modules of a task declare together, and one of them as its rules see it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import takewhile
from typing import Any, Final, TypeVar, cast

from assistant.base.diagnostics import Diagnostic, Rule, Severity
from assistant.languages.checks.file_views import CachedResults, by_type
from assistant.languages.checks.names import Declaration, Symbols, find_declaration
from assistant.languages.rapid.reading.parser import parse_rows
from assistant.languages.rapid.text.header import module_header
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes

N = TypeVar("N", bound=s.Node)


Declared = Declaration[s.Node]
"""What declares a name: `VAR`, `PERS`, `CONST`, `PROC`, `FUNC`, `TRAP`, `RECORD` or `ALIAS`; of
parameters `IN`, `VAR`, `PERS` or `INOUT`; `FOR` for the variable of a loop.
"""

VALUELESS: Final = {
    "PROC": "a procedure",
    "FUNC": "a function",
    "TRAP": "a trap routine",
    "RECORD": "a type",
    "ALIAS": "a type",
}
"""What declares names that are no data, for people."""


class Task(CachedResults):
    """What all modules of a task declare: names that are global, and those of each module."""

    def __init__(self, files: Sequence[s.File], common: Sequence[s.File] = ()) -> None:
        """common: those of the files that other tasks have as well."""
        self.files, self.common = tuple(files), tuple(common)
        self.modules = tuple(module for file in files for module in file.modules)
        self.shared: Symbols[s.Node] = Symbols()
        """Global declarations."""
        self.own: dict[int, Symbols[s.Node]] = {}
        """LOCAL ones by the `id` of their module."""
        self.runs: list[tuple[s.Module, s.TargetRunNode]] = []
        for module in self.modules:
            own = self.own.setdefault(id(module), Symbols())
            for item in module.items:
                if isinstance(item, s.TargetRunNode):
                    self.runs.append((module, item))
                declared = declaration(item, module)
                if declared is not None:
                    declare(own if declared.local else self.shared, item, declared)

    def levels(self, module: s.Node) -> tuple[Symbols[s.Node], Symbols[s.Node]]:
        """What a module sees: its own LOCAL names, then the global ones."""
        return self.own.get(id(module), self.shared), self.shared

    def main(self, module: s.Module) -> s.Routine | None:
        """The procedure of a module that a task may start at."""
        return self._mains.get(id(module))

    @cached_property
    def _mains(self) -> dict[int, s.Routine]:
        return {
            id(declared.module): declared.node
            for declared in self.shared.all("main")
            if declared.kind == "PROC" and isinstance(declared.node, s.Routine)
        }

    @property
    def has_main(self) -> bool:
        return bool(self._mains)

    @cached_property
    def valueless(self) -> frozenset[str]:
        """Names in lower case of modules, and of what some module declares that is no data."""
        declared = (one for names in (self.shared, *self.own.values()) for one in names)
        found = {one.name.lower() for one in declared if one.kind in VALUELESS}
        return frozenset(found | {module.name.lower() for module in self.modules})

    @property
    def unsure(self) -> Severity:
        """How bad a name is that another module may declare: less if only one is given."""
        return Severity.WARNING if len(self.modules) > 1 else Severity.INFO

    @cached_property
    def mixed(self) -> bool:
        """Whether the modules cannot all be of one task: two have a `main` or the same name."""
        names = [module.name.lower() for module in self.modules]
        return len(self._mains) > 1 or len(set(names)) < len(names)


def declare(symbols: Symbols[s.Node], item: Any, declared: Declared) -> None:
    """Adds what an item declares, of a long run every row."""
    if isinstance(item, s.TargetRunNode):
        symbols.add_rows(item.run.names, declared)
    else:
        symbols.add(declared)


def declaration(item: Any, module: s.Module | None = None) -> Declared | None:
    """What an item of a module or of a routine's body declares, None if it declares nothing."""
    match item:
        case s.Data(scope, storage, type, name):
            return Declaration(name, storage, type, scope == "LOCAL", item, module)
        case s.Routine(kind, local, name, _, type):
            return Declaration(name, kind, type, local, item, module)
        case s.Record(local, name):
            return Declaration(name, "RECORD", "", local, item, module)
        case s.Alias(local, type, name):
            return Declaration(name, "ALIAS", type, local, item, module)
        case s.ParameterNode(mode, type, name):
            return Declaration(name, mode or "IN", type, True, item, module)
        case s.TargetRunNode(scope):
            return Declaration("", "CONST", "robtarget", scope == "LOCAL", None, module)
    return None


def parameters(routine: s.Routine) -> Iterator[s.ParameterNode]:
    for group in routine.parameters:
        for one in group.alternatives:
            if isinstance(one, s.ParameterNode):
                yield one


class RuleContext(CachedResults):
    """One module, as a rule sees it."""

    def __init__(self, file: s.File, module: s.Module, task: Task) -> None:
        self.file, self.module, self.task = file, module, task

    @cached_property
    def compiled(self) -> bool:
        """Whether the module's header says that it is a whole program or a unit of one.

        What others wrote may need modules that are not given, or come with others that are
        never loaded together: what modules say of each other is certain in a compiled one only.
        """
        header = module_header(self.module)
        return bool(header.program or header.unit)

    def find(self, name: str, routine: s.Routine | None = None) -> Declared | None:
        """What a name means in this module, inside one of its routines if that is given."""
        inner = () if routine is None else (self.frame(routine),)
        return find_declaration(name, (*inner, *self.task.levels(self.module)))

    def frame(self, routine: s.Routine) -> Symbols[s.Node]:
        """Parameters and data of a routine."""
        frame = self._frames.get(id(routine))
        if frame is None:
            frame = self._frames[id(routine)] = Symbols()
            for item in (*parameters(routine), *routine.body):
                if (declared := declaration(item, self.module)) is not None:
                    declare(frame, item, replace(declared, local=True))
        return frame

    @cached_property
    def _frames(self) -> dict[int, Symbols[s.Node]]:
        return {}

    @cached_property
    def routines(self) -> tuple[s.Routine, ...]:
        return tuple(item for item in self.module.items if isinstance(item, s.Routine))

    @cached_property
    def _by_type(self) -> dict[type, list[Any]]:
        return by_type((node, node) for node in nodes(self.module))

    def all(self, kind: type[N]) -> Sequence[N]:
        """Every node of one class, as they stand in the text."""
        return self._by_type.get(kind, ())

    @property
    def before(self) -> Iterator[s.Module]:
        """The modules of the task that stand before this one."""
        return takewhile(lambda other: other is not self.module, self.task.modules)

    def finding(
        self, rule: Rule, node: s.Node | None, *, row: int | None = None, **given: Any
    ) -> Diagnostic:
        """The rule's finding at a node. row: which line, of a node that is a long run; else its
        first one.
        """
        if self.file.origin is None or node is None or node.span is None:
            return rule(path=self.file.path, place=self.module.name, **given)
        source, span = self.file.origin.source, node.span
        if isinstance(node, s.RunNode):
            span = node.row_span(row or 0) or span
        return source.finding(rule, span, **given)

    def single(self, node: s.RunNode, row: int) -> s.Node:
        """A line of a long run as it is read alone; the run if there is no text."""
        span = node.row_span(row)
        if self.file.origin is None or node.rows is None or span is None:
            return node
        declares = isinstance(node, s.TargetRunNode)
        kind: Any = "items" if declares else "statements"
        found = parse_rows(self.file.origin.source.text, [span], kind)
        return cast("s.Node", found[0]) if len(found) == 1 else node
