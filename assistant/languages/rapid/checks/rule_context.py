"""Context of a rule: the modules of a task, one of them, scopes of names, types of expressions.

A type is known as far as the given modules and the predefined tables define it. An expression of
uncertain type has no kind, and no rule reports it: it may be a signal, or data of a module that was
not given.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import takewhile
from typing import Any, Final, TypeVar, cast

from assistant.base.diagnostics import Diagnostic, Rule, Severity
from assistant.languages.checks.file_views import CachedResults, by_type
from assistant.languages.checks.names import Declaration, Symbols, find_declaration
from assistant.languages.checks.values import Kind, Kinds, Operators
from assistant.languages.rapid.reading.parser import parse_rows
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.rapid.text.header import module_header
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import inside, nodes
from assistant.languages.signatures import NamedTypes, Type
from assistant.program import expressions as e

N = TypeVar("N", bound=s.Node)


Declared = Declaration[s.Node]
"""Declaration of a name, by kind: `VAR`, `PERS`, `CONST`, `PROC`, `FUNC`, `TRAP`, `RECORD` or
`ALIAS`; for parameters `IN`, `VAR`, `PERS` or `INOUT`; `FOR` for the variable of a loop.
"""

VALUELESS: Final = {
    "PROC": "a procedure",
    "FUNC": "a function",
    "TRAP": "a trap routine",
    "RECORD": "a type",
    "ALIAS": "a type",
}
"""Kinds of declarations without a value, with their names in messages."""


class Task(CachedResults):
    """Declarations of all modules of a task: global names, and those of each module."""

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
                    _declare(own if declared.local else self.shared, item, declared)

    def levels(self, module: s.Node) -> tuple[Symbols[s.Node], Symbols[s.Node]]:
        """Return the names visible in a module: its LOCAL names first, then the global ones."""
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
        """Names in lower case of modules, and of declarations that are not data."""
        declared = (one for names in (self.shared, *self.own.values()) for one in names)
        found = {one.name.lower() for one in declared if one.kind in VALUELESS}
        return frozenset(found | {module.name.lower() for module in self.modules})

    @property
    def unsure(self) -> Severity:
        """Severity of a name that another module may declare: lower if only one module is given."""
        return Severity.WARNING if len(self.modules) > 1 else Severity.INFO

    @cached_property
    def mixed(self) -> bool:
        """True if the modules cannot all belong to one task: two have a `main` or the same name."""
        names = [module.name.lower() for module in self.modules]
        return len(self._mains) > 1 or len(set(names)) < len(names)


def _declare(symbols: Symbols[s.Node], item: Any, declared: Declared) -> None:
    """Adds what an item declares, of a long run every row."""
    if isinstance(item, s.TargetRunNode):
        symbols.add_rows(item.run.names, declared)
    else:
        symbols.add(declared)


def declaration(item: Any, module: s.Module | None = None) -> Declared | None:
    """Return the declaration made by an item of a module or of a routine's body, None if it
    declares nothing.
    """
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
        """True if the module's header identifies a complete program or a unit of one.

        A module from elsewhere may need modules that are not given, or come with others that are
        never loaded together: only in a compiled program are references between modules certain.
        """
        header = module_header(self.module)
        return bool(header.program or header.unit)

    def find(self, name: str, routine: s.Routine | None = None) -> Declared | None:
        """Return the declaration of a name in this module, or inside one of its routines if one is
        given.
        """
        inner = () if routine is None else (self.frame(routine),)
        return find_declaration(name, (*inner, *self.task.levels(self.module)))

    def frame(self, routine: s.Routine) -> Symbols[s.Node]:
        """Parameters and data of a routine."""
        frame = self._frames.get(id(routine))
        if frame is None:
            frame = self._frames[id(routine)] = Symbols()
            for item in (*parameters(routine), *routine.body):
                if (declared := declaration(item, self.module)) is not None:
                    _declare(frame, item, replace(declared, local=True))
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
        """Return every node of one class, in text order."""
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
        # A built tree has no text to point into.
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


NUMBER: Final = "number"
"""Type of a numeric literal, which is a num or a dnum as the place wants it."""
_NUMERIC: Final = frozenset({"num", "dnum"})
LOGICAL: Final = frozenset({"OR", "XOR", "AND"})
SIGNAL_TYPES: Final = frozenset({f"signal{kind}{way}" for kind in "adg" for way in "io"})
OPERATORS: Final = Operators(
    always=dict.fromkeys((*LOGICAL, *e.RELATIONS), "bool"),
    made={
        **{(o, n, n): n for o in ("+", "-", "*", "/", "DIV", "MOD") for n in _NUMERIC},
        ("+", "string", "string"): "string",
        **{(o, "pos", "pos"): "pos" for o in "+-*"},
        **{(o, "pos", "num"): "pos" for o in "*/"},
        ("*", "num", "pos"): "pos",
        ("*", "orient", "orient"): "orient",
    },
    choices={NUMBER: _NUMERIC},
    copied=dict.fromkeys(SIGNAL_TYPES, _NUMERIC),
    ordered=_NUMERIC,
)


class Types(NamedTypes):
    """Types that a module sees: its own, those of its task, predefined ones."""

    def __init__(self, look: RuleContext) -> None:
        super().__init__(predefined.types())
        self.look = look

    def declared(self, name: str) -> Type | None:
        found = self.look.find(name)
        match found.node if found is not None else None:
            case s.Alias(local, of, name):
                return Type(name, "ALIAS", of)
            case s.Record(local, name, components):
                # With several records of a name nothing tells which one is meant.
                several = not local and len(self.look.task.shared.all(name)) > 1
                known = None if several else {inner: type for type, inner in components}
                return Type(name, "RECORD", components=known)
        return None

    def atomic(self, base: str) -> bool:
        """True if a type certainly has no components."""
        return self.kind(base) == "VALUE"

    def device(self, base: str) -> bool:
        """True if the controller's configuration may name objects of a type."""
        return base == "" or self.kind(base) in ("DEVICE", "OTHER")

    def known(self) -> Iterator[str]:
        """Names of types as they are declared."""
        for level in reversed(self.look.task.levels(self.look.module)):
            yield from (one.name for one in level if one.kind in ("RECORD", "ALIAS"))
        yield from (standard.name for standard in self.predefined.values())


class Scope(Kinds[s.Expression]):
    """Meaning of names at one source location: in a module, in a routine, in loops inside it."""

    operators = OPERATORS
    without_value = frozenset({"switch", "anytype"})
    types: Types

    def __init__(
        self,
        types: Types,
        routine: s.Routine | None = None,
        loops: frozenset[str] = frozenset(),
    ) -> None:
        super().__init__(types)
        self.look, self.routine, self.loops = types.look, routine, loops
        self._found: dict[str, Declared | None] = {}

    def inside(self, loop: s.ForLoop) -> Scope:
        return Scope(self.types, self.routine, self.loops | {loop.variable.lower()})

    def find(self, name: str) -> Declared | None:
        """The declaration that a name means, None if no given module has one."""
        low = name.lower()
        # Names are looked up many times in one scope.
        if low not in self._found:
            if low in self.loops:
                self._found[low] = Declaration(name, "FOR", "num", True)
            else:
                self._found[low] = self.look.find(name, self.routine)
        return self._found[low]

    def doubtful(self, found: Declared) -> bool:
        """True if several modules declare the name, or if another module of a mixed set does."""
        task = self.look.task
        if task.mixed and found.module is not None and found.module is not self.look.module:
            return True
        return not found.local and len(task.shared.all(found.name)) > 1

    def items(self, node: s.Expression) -> tuple[s.Expression, ...] | None:
        return node.items if isinstance(node, s.AggregateNode) else None

    def kind(self, node: s.Expression) -> Kind | None:
        match node:
            case s.NumberLiteral():
                return Kind(NUMBER)
            case s.StringLiteral():
                return Kind("string")
            case s.BoolLiteral():
                return Kind("bool")
            case s.NameRef(name):
                return self._name(name)
            case s.Component(value, name):
                return self.component(self.kind(value), name)
            case s.Element(value, indices):
                whole = sum(isinstance(index, s.Whole) for index in indices)
                return self.element(self.kind(value), len(indices), whole)
            case s.Group(inner):
                return self.kind(inner)
            case s.FunctionCall(name):
                return self._result(name)
            case s.Prefix(operator, operand):
                return Kind("bool") if operator == "NOT" else self.kind(operand)
            case s.Infix(operator, left, right):
                return self.infix(operator, left, right)
        return None

    def _name(self, name: str) -> Kind | None:
        found = self.find(name)
        if found is None:
            standard = predefined.data().get(name.lower())
            return self.of(standard.type) if standard else None
        if self.doubtful(found) or not found.type or found.kind in ("FUNC", "ALIAS"):
            return None
        match found.node:
            case s.Data(dimensions=dimensions):
                return self.of(found.type, len(dimensions))
            case s.ParameterNode(dimensions=dimensions):
                return self.of(found.type, dimensions)
            case None:
                # A loop counts in dnum if its bounds do.
                return Kind(NUMBER) if found.kind == "FOR" else self.of(found.type)
        return None

    def _result(self, name: str) -> Kind | None:
        found = self.find(name)
        if found is not None:
            sure = found.kind == "FUNC" and not self.doubtful(found)
            return self.of(found.type) if sure else None
        standard = signature(name)
        return self.of(standard.result) if standard and standard.result else None

    def read(self, node: s.Expression) -> Kind | None:
        """Return the kind of a value as it is read: a number for a signal."""
        kind = self.kind(node)
        if kind is not None and kind.type in SIGNAL_TYPES:
            # A group is a num or a dnum, as the place wants it.
            return None if kind.type.startswith("signalg") else Kind("num")
        return kind


_LEAF_NODES: Final = frozenset(
    {s.NumberLiteral, s.StringLiteral, s.BoolLiteral, s.NameRef, s.CommentLine, s.Placeholder}
)
"""Most of a tree: nodes without anything inside, and without rules but for few names."""


def scoped_nodes(look: RuleContext) -> list[tuple[s.Node, Scope]]:
    """Return the nodes in text order with their scopes, without rows of runs and without leaves.

    Names of routines, types and modules do not count as leaves: they are wrong where data is
    expected.
    """
    return list(_walk_scopes(look))


def scoped_nodes_of(look: RuleContext, kind: type[N]) -> list[tuple[N, Scope]]:
    """Those of one class."""
    return look.once(_scoped_by_type).get(kind, [])


def _scoped_by_type(look: RuleContext) -> dict[type, list[tuple[Any, Scope]]]:
    return by_type((node, (node, scope)) for node, scope in look.once(scoped_nodes))


def _walk_scopes(look: RuleContext) -> Iterator[tuple[s.Node, Scope]]:
    odd = look.task.valueless

    def is_leaf(node: Any) -> bool:
        return type(node) in _LEAF_NODES and not (
            isinstance(node, s.NameRef) and node.name.lower() in odd
        )

    pending: list[tuple[Any, Scope]] = [(look.module.items, Scope(look.once(Types)))]
    while pending:
        item, scope = pending.pop()
        if isinstance(item, tuple):
            pending.extend([(one, scope) for one in reversed(item) if not is_leaf(one)])
        elif isinstance(item, s.ForLoop):
            # Pushed before the bounds, so that it is visited after them, in the order of the text.
            pending.append((item.body, scope.inside(item)))
            pending.append(((item.first, item.last, item.step), scope))
        elif isinstance(item, s.Node):
            if isinstance(item, s.Routine):
                scope = Scope(scope.types, item)
            yield item, scope
            for name in inside(type(item)) or ():
                part = getattr(item, name)
                if isinstance(part, tuple) or (isinstance(part, s.Node) and not is_leaf(part)):
                    pending.append((part, scope))
