"""View of one file and the files beside it, as rules see them: scopes, calls and variables.

`Look` is the file at hand, `Calls` are the programs that files name, and `Known` is what a file
and those that it includes state about variables, by name in upper case.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import field
from functools import cached_property
from typing import Any, Final, TypeVar

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, Span
from assistant.languages.checks.file_views import CachedResults, LineFormat, LineView, by_type
from assistant.languages.checks.names import NameSet
from assistant.languages.checks.registry import Damage
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import PositionRows
from assistant.languages.melfa_basic.tree.walk import (
    Use,
    lines_with,
    nodes,
    program_key,
    program_name,
    uses,
)
from assistant.languages.runs.columns import Names

N = TypeVar("N")
Named = s.Variable | s.Target
"""Nodes that know where they stand."""

_HEADING: Final = re.compile(r"'\s*robot-assistant:", re.IGNORECASE)
_HEADING_LINES: Final = 40
"""Lines at the top of a file, one of which tells that it was compiled."""


@dataclass(frozen=True, slots=True)
class Scope:
    """The main part of a file, or one Function of it: its labels are its own.

    entries: places of its lines in `Look.code`. function: None for the main part.
    """

    entries: tuple[int, ...]
    function: s.Function | None = None


class Calls(CachedResults):
    """Programs that the files of a program may call: name in upper case → the first tree of that
    name.
    """

    def __init__(self, trees: Sequence[s.File]) -> None:
        self.trees = trees
        # The first tree of a name wins, so it has to be put in last.
        named = ((program_name(tree).upper(), tree) for tree in reversed(trees))
        self.by_name = {name: tree for name, tree in named if name}


class Look(LineView):
    """View of one file for the rules. calls: the files next to it. damage: in them."""

    cut = LineFormat(
        begin=re.compile(r"[ \t]*[0-9]*[ \t]*"),
        token=re.compile(r"\"[^\"\r\n]*\"?|'.*|(?i:\brem\b.*)|[^\s]"),
        comments=("'", "rem"),
    )

    def __init__(
        self, tree: s.File, dialect: Dialect, calls: Calls, damage: Damage | None = None
    ) -> None:
        super().__init__(tree.source)
        self.tree, self.dialect, self.calls, self.damage = tree, dialect, calls, damage
        self.code = tree.code

    # ------------------------------------------------------------------------- what is in it

    @cached_property
    def lines(self) -> list[s.Line]:
        return [item for item in self.code if isinstance(item, s.Line)]

    @cached_property
    def _by_type(self) -> dict[type, list[tuple[s.Line, Any]]]:
        every = ((line, node) for line in self.lines for node in nodes(line.statement))
        return by_type((node, (line, node)) for line, node in every)

    def all(self, kind: type[N]) -> Sequence[tuple[s.Line, N]]:
        """Return every node of one class with its line, in the order of the text."""
        return self._by_type.get(kind, ())

    @cached_property
    def uses(self) -> list[tuple[s.Line, Use]]:
        """Every variable of the code lines, with what is done with it."""
        return [(line, use) for line in self.lines for use in uses(line.statement)]

    @cached_property
    def data(self) -> list[s.Data | PositionRows]:
        return [i for i in self.tree.items if isinstance(i, s.Data | PositionRows)]

    @cached_property
    def scopes(self) -> list[Scope]:
        """The main part first, then each Function."""
        main: list[int] = []
        inner = main
        found: list[tuple[list[int], s.Function]] = []
        for at, item in enumerate(self.code):
            statement = item.statement if isinstance(item, s.Line) else None
            if isinstance(statement, s.Function):
                inner = []
                found.append((inner, statement))
            inner.append(at)
            if statement == s.Command("FEnd"):
                inner = main
        return [Scope(tuple(main)), *(Scope(tuple(entries), of) for entries, of in found)]

    def lines_of(self, scope: Scope) -> list[s.Line]:
        """Return the lines of a scope that are not rows of a table."""
        return [item for at in scope.entries if isinstance(item := self.code[at], s.Line)]

    @cached_property
    def functions(self) -> dict[str, s.Function]:
        """Functions of MELFA-BASIC VI that the file and those it includes define, by name."""
        found: dict[str, s.Function] = {}
        for tree in self.included:
            for _, function in lines_with(tree.items, s.Function):
                found.setdefault(function.name.upper(), function)
        return found

    @cached_property
    def _including(self) -> tuple[list[s.File], bool]:
        found, lacking = [self.tree], False
        # The list grows while it is read: included files include others.
        for tree in found:
            for _, include in lines_with(tree.items, s.Include):
                other = self.calls.by_name.get(program_key(include.program))
                if other is None:
                    lacking = True
                elif not any(other is one for one in found):
                    found.append(other)
        return found, lacking

    @property
    def included(self) -> list[s.File]:
        """The file itself and the files that it includes, as far as they are there."""
        return self._including[0]

    @property
    def has_strangers(self) -> bool:
        """True if the file includes one that is not among the checked files."""
        return self._including[1]

    @cached_property
    def compiled(self) -> bool:
        """True if the heading states that this compiler wrote the file."""
        comments = (line.comment for line in self.lines[:_HEADING_LINES] if line.comment)
        return any(_HEADING.match(comment) for comment in comments)

    # ------------------------------------------------------------------------------ findings

    def at(self, rule: Rule, line: s.Item, what: str | Named, /, **words: Any) -> Diagnostic:
        """The rule's finding at a word or node of an item; at all of it if that is not found.

        A variable is what it is about, if `words` name no other.
        """
        where = self.word(line, what) if isinstance(what, str) else self.place(line, what)
        name = {"name": what.name} if isinstance(what, s.Variable) else {}
        return self.finding(rule, where or line, **(name | words))

    def place(self, item: s.Item, node: Named) -> Span | None:
        """Return the span of a node's name; search the line for a node that is from elsewhere."""
        if isinstance(node, s.Variable):
            return self.named(item, node, node.marked) or self.word(item, node.name)
        return self.named(item, node, f"*{node.place}") or self.word(item, f"*{node.place}")

    def text_of(self, line: s.Line) -> str:
        """Return a line as written in the file, without its line end."""
        if line.span is not None and self.source is not None:
            return self.source.text[line.span.start : line.span.end].rstrip("\r\n")
        return printer.line(line, self.dialect.upper)


@dataclass(slots=True)
class Known:
    """Variables of a file and those that it includes, by name in upper case.

    given: names that receive a value, rows of positions too. declared: by Def, Dim, FPrm or a
    Function's head. dimensioned: arrays. read: names whose value is read.
    """

    given: NameSet = field(default_factory=NameSet)
    declared: set[str] = field(default_factory=set)
    dimensioned: set[str] = field(default_factory=set)
    read: set[str] = field(default_factory=set)


def known_variables(look: Look) -> Known:
    """Worked out once for a file."""
    found = Known()
    for tree in look.included:
        beside = look if tree is look.tree else Look(tree, look.dialect, look.calls, look.damage)
        _take_file(beside, found)
    return found


def _take_file(look: Look, found: Known) -> None:
    given = found.given.words
    for _, use in look.uses:
        key = use.variable.key
        if use.role in ("written", "either"):
            given.add(key)
        if use.role == "declared":
            found.declared.add(key)
            if use.variable.arguments is not None:
                found.dimensioned.add(key)
        if use.role in ("read", "either") or use.variable.component:
            found.read.add(key)
        for inner in nodes(use.variable.arguments):
            if isinstance(inner, s.Variable):
                found.read.add(inner.key)
    for line in look.lines:
        match line.statement:
            case s.FPrm(variables):
                found.declared |= {v.key for v in variables}
            case s.Function(_, name, _, parameters):
                # The result of a function is a variable of its name.
                given.add(name.upper())
                names = {p.name.upper() for p in parameters or ()}
                given |= names
                found.declared |= names
                found.dimensioned |= {p.name.upper() for p in parameters or () if p.array}
            case s.DefFunction(name, _, parameters):
                given |= {name.upper(), *(p.key for p in parameters)}
    _take_data(look.data, found.given)
    for item in look.data:
        if isinstance(item, s.Data) and item.variable.arguments is not None:
            found.dimensioned.add(item.variable.key)


def _take_data(items: Iterable[s.Data | PositionRows], given: NameSet) -> None:
    for item in items:
        if isinstance(item, PositionRows):
            given.columns.append(names_of(item))
        elif not _is_untaught(item):
            given.words.add(item.variable.key)


def given_by_data(calls: Calls) -> NameSet:
    """Variables that the data of any of some files gives a value, by name in upper case."""
    found = NameSet()
    for tree in calls.trees:
        _take_data(Look(tree, DIALECTS[tree.dialect], calls).data, found)
    return found


def given_anywhere(calls: Calls) -> NameSet:
    """Variables that any of some files gives a value, by name in upper case."""
    found = Known()
    for tree in calls.trees:
        _take_file(Look(tree, DIALECTS[tree.dialect], calls), found)
    return found.given


def names_of(rows: PositionRows) -> Names:
    return Names.numbered(rows.stem.upper().encode("ascii"), rows.numbers)


def is_position(item: s.Data) -> bool:
    """True if a data line holds a position or joints."""
    return isinstance(item.value, s.Constant)


def _is_untaught(item: s.Data) -> bool:
    """True if a line marks a position as untaught: `(,,,,,)(,)`, as the tools write it."""
    value = item.value
    return isinstance(value, s.Constant) and not any(v is not None for v in value.values)
