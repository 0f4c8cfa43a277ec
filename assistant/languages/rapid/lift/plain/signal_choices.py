"""Variables that stand for one of some signals, as choices among these."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.signal_types import VALUES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.rewriting import rewrite

_CHOOSING: Final = ("aliasio", "getdataval")
_END_PROGRAM: Final = s.Word("EXIT")
READ_FUNCTIONS: Final = frozenset((*(one.lower() for one in VALUES.values()), "testdi"))
"""Functions of the value of a signal, in lower case."""


@dataclass(slots=True)
class ChosenSignal:
    """One variable. inside: the routine that declares it, None for a module. names: of what
    it may be. choice, function: what holds the choice, and what gives the value.
    """

    data: s.Data
    inside: s.Routine | None
    names: tuple[str, ...] = ()
    choice: str = ""
    function: str = ""

    @property
    def key(self) -> tuple[int, str]:
        return (0 if self.inside is None else id(self.inside)), self.data.name.lower()


def chooses(node: Any) -> bool:
    match node:
        case s.ProcedureCall(str(word), (s.Positional(), s.Positional(s.NameRef()))):
            return word.lower() in _CHOOSING
    return False


def is_named(node: Any, name: str) -> bool:
    return isinstance(node, s.NameRef) and node.name.lower() == name


@dataclass(slots=True)
class ChoiceWriter:
    """Writes choices. remarks: by `id` of the module."""

    chosen: Sequence[ChosenSignal]
    remarks: dict[int, list[Diagnostic]] = field(default_factory=dict)
    here: dict[str, ChosenSignal] = field(default_factory=dict)
    said: list[Diagnostic] = field(default_factory=list)

    def module(self, module: s.Module) -> s.Module:
        self.said = self.remarks.setdefault(id(module), [])
        items: list[s.Item] = []
        for item in module.items:
            if isinstance(item, s.Data):
                one = next((x for x in self.chosen if x.data is item), None)
                items += [item] if one is None else _choice_items(one)
            elif isinstance(item, s.Routine):
                items.append(self.routine(item))
                for one in self.chosen:
                    if one.inside is item:
                        items += _choice_items(one)
            else:
                items.append(item)
        same = len(items) == len(module.items)
        same = same and all(a is b for a, b in zip(items, module.items, strict=True))
        return module if same else replace(module, items=tuple(items))

    def routine(self, routine: s.Routine) -> s.Routine:
        own = {x.name.lower() for x in nodes(routine) if isinstance(x, s.Data | s.ParameterNode)}
        self.here = {
            one.data.name.lower(): one
            for one in self.chosen
            if one.inside is routine or (one.inside is None and one.data.name.lower() not in own)
        }
        names = {x.name.lower() for x in nodes(routine) if isinstance(x, s.NameRef)}
        if names.isdisjoint(self.here):
            return routine
        self.here = {name: one for name, one in self.here.items() if name in names}
        body = self.body(routine.body)
        handlers = tuple(replace(h, body=self.body(h.body)) for h in routine.handlers)
        return replace(routine, body=body, handlers=handlers)

    def body(self, body: Sequence[s.StatementNode]) -> tuple[s.StatementNode, ...]:
        return tuple(made for node in body for made in self.statement(node))

    def statement(self, node: s.StatementNode) -> Iterator[s.StatementNode]:
        match node:
            case s.Data() if any(node is one.data for one in self.here.values()):
                return
            case s.ProcedureCall(str(), (s.Positional(source), s.Positional(s.NameRef(name)))) if (
                chooses(node) and name.lower() in self.here
            ):
                yield from self.choice(self.here[name.lower()], source, node)
            case s.ProcedureCall():
                yield self.done(node)
            case s.IfThen(branches, otherwise):
                made = tuple(
                    replace(
                        b,
                        condition=b.condition and self.value(b.condition),
                        body=self.body(b.body),
                    )
                    for b in branches
                )
                other = None if otherwise is None else self.body(otherwise)
                yield replace(node, branches=made, otherwise=other)
            case s.CompactIf(condition, statement):
                inner = self.body((statement,))
                asked = self.value(condition)
                if len(inner) == 1:
                    yield replace(node, condition=asked, statement=inner[0])
                else:
                    yield s.IfThen((s.IfBranch(asked, inner),), span=node.span)
            case s.WhileLoop(condition, body):
                yield replace(node, condition=self.value(condition), body=self.body(body))
            case s.ForLoop(body=body):
                outer = self.value(replace(node, body=()))
                yield replace(outer, body=self.body(body))
            case s.TestOf(subject, cases, otherwise):
                tried = tuple(
                    replace(c, values=self.value(c.values), body=self.body(c.body)) for c in cases
                )
                other = None if otherwise is None else self.body(otherwise)
                subject = self.value(subject)
                yield replace(node, subject=subject, cases=tried, otherwise=other)
            case _:
                yield self.value(node)

    def choice(
        self, one: ChosenSignal, source: s.Expression, node: s.ProcedureCall
    ) -> Iterator[s.StatementNode]:
        """`AliasIO` as the number of the signal that is chosen."""
        if not one.choice:
            return
        target = s.NameRef(one.choice)
        names = {name.lower(): at for at, name in enumerate(one.names, 1)}
        said = source.value if isinstance(source, s.StringLiteral) else ""
        said = source.name if isinstance(source, s.NameRef) else said
        if said.lower() in names:
            number = s.NumberLiteral(str(names[said.lower()]))
            yield s.Assignment(target, number, span=node.span)
            return
        branches = tuple(
            s.IfBranch(
                s.Infix("=", source, s.StringLiteral(name)),
                (s.Assignment(target, s.NumberLiteral(str(at)), span=node.span),),
            )
            for at, name in enumerate(one.names, 1)
        )
        if node.span is not None:
            shown = ", ".join(f"`{name}`" for name in one.names)
            self.said.append(rules.CHOSEN(name=one.data.name, names=shown, span=node.span))
        yield s.IfThen(branches, (_END_PROGRAM,), span=node.span)

    def done(self, node: s.ProcedureCall) -> s.StatementNode:
        """An instruction, to whichever signal is chosen."""
        made: s.StatementNode = node
        for name, one in self.here.items():
            if not any(is_named(part, name) for part in nodes(node)):
                continue
            if not one.choice:
                made = _with_signal(made, name, one.names[0])
                continue
            cases = tuple(
                s.TestCase((s.NumberLiteral(str(at)),), (_with_signal(made, name, signal),))
                for at, signal in enumerate(one.names, 1)
            )
            made = s.TestOf(s.NameRef(one.choice), cases, (_END_PROGRAM,), span=node.span)
        return made

    def value(self, node: Any) -> Any:
        """An expression, or a statement without others in it, that reads the chosen signal."""

        def visit(part: Any) -> Any:
            match part:
                case s.FunctionCall(str(word), (s.Positional(s.FunctionCall(inner, ())),)):
                    if word.lower() in READ_FUNCTIONS and inner in functions:
                        read = s.FunctionCall(inner, ())
                        if word.lower() == "testdi":
                            return s.Group(s.Infix("=", read, s.NumberLiteral("1")))
                        return read
                case s.NameRef(name) if name.lower() in self.here:
                    one = self.here[name.lower()]
                    if not one.choice:
                        return replace(part, name=one.names[0])
                    return s.FunctionCall(one.function, ())
            return part

        functions = {one.function for one in self.here.values() if one.choice}
        return rewrite(node, visit, ())


def _with_signal(node: s.StatementNode, name: str, signal: str) -> s.StatementNode:
    def visit(part: Any) -> Any:
        return replace(part, name=signal) if is_named(part, name) else part

    made: s.StatementNode = rewrite(node, visit, ())
    return made


def _choice_items(one: ChosenSignal) -> list[s.Item]:
    """What holds a choice, and what gives the value of the signal that is chosen."""
    if not one.choice:
        return []
    read = VALUES[one.data.type.lower()]
    cases = tuple(
        s.TestCase(
            (s.NumberLiteral(str(at)),),
            (s.ReturnFrom(s.FunctionCall(read, (s.Positional(s.NameRef(name)),))),),
        )
        for at, name in enumerate(one.names, 1)
    )
    test = s.TestOf(s.NameRef(one.choice), cases, (_END_PROGRAM,))
    body = (test, s.ReturnFrom(s.NumberLiteral("0")))
    return [
        s.Data("", "VAR", "num", one.choice, span=one.data.span),
        s.Routine("FUNC", False, one.function, body, "num"),
    ]
