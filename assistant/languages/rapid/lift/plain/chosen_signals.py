r"""Signals that are chosen as the program runs: `AliasIO` with a text, or in several places.

`VAR signaldo x` that may be `doA` and `doB` becomes a number: `AliasIO "do"+c,x;` chooses it,
`SetDO x,1;` does the same to the one that is chosen, and `x` in an expression becomes a function of
the program's own. One that always stands for the same signal is that signal. `GetDataVal` of a
signal variable does what `AliasIO` does. For a name that is none of these the program ends.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid.lift.local_names import with_unique_data_names
from assistant.languages.rapid.lift.plain.known_texts import MOST_TEXTS, KnownTexts
from assistant.languages.rapid.lift.plain.scopes import FreshNames
from assistant.languages.rapid.lift.plain.signal_choices import (
    READ_FUNCTIONS,
    ChoiceWriter,
    ChosenSignal,
    chooses,
    is_named,
)
from assistant.languages.rapid.tables.signal_types import SIGNALS, VALUES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import lists, mentions, nodes
from assistant.program.program import Signal

_CHOICE_INSTRUCTIONS: Final = ("aliasio", "getdataval")
LEAST_CHOICES: Final = 2
"""Letters that a name has to begin with before names of signals are taken for what it may be."""


@dataclass(frozen=True, slots=True)
class SignalChoices:
    """modules: with choices for such signals. remarks: findings of each. signals: that may be
    chosen. gone: the variables that stood for them, in lower case.
    """

    modules: Sequence[s.Module]
    remarks: Sequence[tuple[Diagnostic, ...]]
    signals: Mapping[str, Signal] = field(default_factory=dict)
    gone: frozenset[str] = frozenset()


def with_chosen_signals(modules: Sequence[s.Module]) -> SignalChoices:
    """The modules with choices; themselves where there are none."""
    chosen: list[ChosenSignal] = []
    if any(map(chooses, nodes(tuple(modules)))):
        chosen = _SignalVariables(modules).found()
    if not chosen:
        return SignalChoices(modules, ((),) * len(modules))
    fresh = FreshNames(modules)
    for one in chosen:
        if len(one.names) > 1:
            one.choice = fresh(f"{one.data.name}_choice")
            one.function = fresh(f"{one.data.name}_value")
    work = ChoiceWriter(chosen)
    made = [work.module(module) for module in modules]
    remarks = tuple(tuple(work.remarks[id(module)]) for module in modules)
    signals = {name: SIGNALS[one.data.type.lower()] for one in chosen for name in one.names}
    gone = frozenset(one.data.name.lower() for one in chosen)
    return SignalChoices(made, remarks, signals, gone)


def chosen_signals(files: Sequence[s.File]) -> Mapping[str, Signal]:
    """Signals that texts alone may name."""
    if not mentions(files, _CHOICE_INSTRUCTIONS):
        return {}
    modules = with_unique_data_names([module for file in files for module in file.modules])
    return with_chosen_signals(modules).signals


class _SignalVariables:
    """What signal variables may stand for."""

    def __init__(self, modules: Sequence[s.Module]) -> None:
        self.texts = KnownTexts(modules)
        self.items = [item for module in modules for item in module.items]
        self.variables: dict[tuple[int, str], ChosenSignal] = {}
        for item in self.items:
            inside = item if isinstance(item, s.Routine) else None
            for node in (item,) if inside is None else inside.body:
                match node:
                    case s.Data(storage="VAR", type=type, dimensions=()) if type.lower() in VALUES:
                        one = ChosenSignal(node, inside)
                        self.variables[one.key] = one
        self.sources: dict[tuple[int, str], set[str] | None] = {}

    def found(self) -> list[ChosenSignal]:
        declared = {i.name.lower() for i in self.items if isinstance(i, s.Data)}
        self.declared = declared
        signals = {n for n in self._names() if n.lower() not in declared}
        for item in self.items:
            if isinstance(item, s.Routine):
                for body in lists(item):
                    self._look(body, item, signals)
        chosen = []
        for key, names in self.sources.items():
            one = self.variables.get(key)
            if one is None or not names or len(names) > MOST_TEXTS:
                continue
            spelled = {name.lower(): name for name in sorted(names, reverse=True)}
            one.names = tuple(sorted(spelled.values(), key=str.lower))
            if self._is_only_used_well(one):
                chosen.append(one)
        return chosen

    def _names(self) -> Iterator[str]:
        for node in nodes(tuple(self.items)):
            if isinstance(node, s.NameRef):
                yield node.name

    def variable(self, name: str, inside: s.Routine) -> ChosenSignal | None:
        low = name.lower()
        if low in self.texts.own.get(id(inside), ()):
            return self.variables.get((id(inside), low))
        return self.variables.get((0, low))

    def _look(self, body: Sequence[s.StatementNode], inside: s.Routine, signals: set[str]) -> None:
        for at, node in enumerate(body):
            match node:
                case s.ProcedureCall(str(), (s.Positional(source), s.Positional(s.NameRef(name)))):
                    if chooses(node) and (one := self.variable(name, inside)) is not None:
                        names = self._sources(source, body[:at], inside, signals)
                        known = self.sources.setdefault(one.key, set())
                        both = None if names is None or known is None else known | names
                        self.sources[one.key] = both

    def _sources(
        self,
        source: s.Expression,
        before: Sequence[s.StatementNode],
        inside: s.Routine,
        signals: set[str],
    ) -> set[str] | None:
        """Names of signals that a first argument may mean."""
        if isinstance(source, s.NameRef):
            low = source.name.lower()
            own = self.texts.own.get(id(inside), ())
            if low not in own and low not in self.declared:
                return {source.name}
            if self.variable(low, inside) is not None:
                return None
            source = _assigned_before(low, before) or source
        texts = self.texts.of(source, inside)
        if texts is not None:
            return set(texts)
        start = self._start(source, inside)
        like = {
            name for name in signals if len(start) >= LEAST_CHOICES and _starts_with(name, start)
        }
        return like or None

    def _start(self, source: s.Expression, inside: s.Routine) -> str:
        """What a text surely begins with."""
        while isinstance(source, s.Infix) and source.operator == "+":
            source = source.left
        texts = self.texts.of(source, inside)
        return next(iter(texts)) if texts is not None and len(texts) == 1 else ""

    def _is_only_used_well(self, one: ChosenSignal) -> bool:
        """Whether every use of a variable is one that a choice may stand for."""
        if len(one.names) == 1:
            return True
        for item in self.items if one.inside is None else (one.inside,):
            if not isinstance(item, s.Routine):
                continue
            if one.inside is None and one.data.name.lower() in self.texts.own[id(item)]:
                continue
            for body in lists(item):
                for node in body:
                    if not _is_supported(node, one.data.name.lower()):
                        return False
        return True


def _starts_with(name: str, start: str) -> bool:
    return name.lower().startswith(start.lower()) and len(name) > len(start)


def _assigned_before(name: str, before: Sequence[s.StatementNode]) -> s.Expression | None:
    """What a variable was given right before, in the same list of statements."""
    for node in reversed(before):
        match node:
            case s.Assignment(s.NameRef(target), value):
                if target.lower() == name:
                    return value
            case s.ProcedureCall() if chooses(node):
                continue
            case s.CommentLine():
                continue
            case _:
                return None
    return None


def _is_supported(node: s.StatementNode, name: str) -> bool:
    """Whether a statement, without the blocks in it, may name a variable as it does."""
    if isinstance(node, s.ProcedureCall | s.Data):
        return True
    shallow = _own_expressions(node)
    plain = sum(is_named(part, name) for part in nodes(shallow))
    return plain == sum(_is_value_read(part, name) for part in nodes(shallow)) + _bare_uses(
        shallow, name
    )


def _own_expressions(node: Any) -> Any:
    """The expressions of a statement."""
    match node:
        case s.IfThen(branches):
            return tuple(b.condition for b in branches if b.condition is not None)
        case s.CompactIf(condition):
            return (condition,)
        case s.WhileLoop(condition):
            return (condition,)
        case s.ForLoop(first=first, last=last, step=step):
            return tuple(one for one in (first, last, step) if one is not None)
        case s.TestOf(subject, cases):
            return (subject, *(value for case in cases for value in case.values))
    return (node,)


def _is_value_read(node: Any, name: str) -> bool:
    """Whether it is a function of the value of a signal, or the signal compared."""
    match node:
        case s.FunctionCall(str(word), (s.Positional(s.NameRef(inner)),)):
            return inner.lower() == name and word.lower() in READ_FUNCTIONS
    return False


def _bare_uses(shallow: Any, name: str) -> int:
    """How often it stands for its value by itself: as a side of an operation, or as the whole."""
    count = sum(is_named(one, name) for one in shallow)
    for node in nodes(shallow):
        match node:
            case s.Infix(_, left, right):
                count += is_named(left, name) + is_named(right, name)
            case s.Prefix(_, inner) | s.Group(inner):
                count += is_named(inner, name)
            case s.Assignment(_, value) | s.ReturnFrom(value):
                count += is_named(value, name)
    return count
