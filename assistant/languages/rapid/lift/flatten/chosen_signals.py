"""Signals that are chosen as the program runs: `AliasIO` with a text, or in several places.

`VAR signaldo x` that may be `doA` and `doB` becomes a number: `AliasIO "do"+c,x;` chooses it,
`SetDO x,1;` sets the chosen signal, and `x` in an expression becomes a function of the program. A
variable that always stands for one signal is that signal. `GetDataVal` of a signal variable does
what `AliasIO` does. For any other name the program ends. A text variable may have any text that the
program assigns to it anywhere; texts that are read, cut or received are not known.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.flatten.data_names import FreshNames
from assistant.languages.rapid.lift.name_clashes import with_unique_data_names
from assistant.languages.rapid.tables.signals import SIGNAL_TYPES, VALUE_FUNCTIONS
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import lists, mentions, nodes, root
from assistant.program.program import Signal
from assistant.program.rewriting import rewrite

_CHOOSING: Final = ("aliasio", "getdataval")
_END_PROGRAM: Final = s.Word("EXIT")
_READ_FUNCTIONS: Final = frozenset((*(one.lower() for one in VALUE_FUNCTIONS.values()), "testdi"))
"""Functions of the value of a signal, in lower case."""


@dataclass(slots=True)
class _ChosenSignal:
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


def _chooses(node: Any) -> bool:
    match node:
        case s.ProcedureCall(str(word), (s.Positional(), s.Positional(s.NameRef()))):
            return word.lower() in _CHOOSING
    return False


def _is_named(node: Any, name: str) -> bool:
    return isinstance(node, s.NameRef) and node.name.lower() == name


@dataclass(slots=True)
class _ChoiceWriter:
    """Writes choices. remarks: by `id` of the module."""

    chosen: Sequence[_ChosenSignal]
    remarks: dict[int, list[Diagnostic]] = field(default_factory=dict)
    here: dict[str, _ChosenSignal] = field(default_factory=dict)
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
            # Data of a module is hidden by data or a parameter of the same name.
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
            # The declaration of a local variable goes: its choice is data of the module.
            case s.Data() if any(node is one.data for one in self.here.values()):
                return
            case s.ProcedureCall(str(), (s.Positional(source), s.Positional(s.NameRef(name)))) if (
                _chooses(node) and name.lower() in self.here
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
                # A compact IF holds one statement only.
                if len(inner) == 1:
                    yield replace(node, condition=asked, statement=inner[0])
                else:
                    yield s.IfThen((s.IfBranch(asked, inner),), span=node.span)
            case s.WhileLoop(condition, body):
                yield replace(node, condition=self.value(condition), body=self.body(body))
            case s.ForLoop(body=body):
                # Without its body: the statements in it are made by `body`.
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
        self, one: _ChosenSignal, source: s.Expression, node: s.ProcedureCall
    ) -> Iterator[s.StatementNode]:
        """`AliasIO` as the number of the signal that is chosen."""
        # With a single signal nothing is chosen at run time.
        if not one.choice:
            return
        target = s.NameRef(one.choice)
        names = {name.lower(): at for at, name in enumerate(one.names, 1)}
        said = source.value if isinstance(source, s.StringLiteral) else ""
        said = source.name if isinstance(source, s.NameRef) else said
        # The choice is known here, so that no comparison is needed.
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
        # Every further variable in the call nests one more TEST around it.
        for name, one in self.here.items():
            if not any(_is_named(part, name) for part in nodes(node)):
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
                # `rewrite` goes from the inside out: the variable is a function call already, and
                # reads its value itself.
                case s.FunctionCall(str(word), (s.Positional(s.FunctionCall(inner, ())),)):
                    if word.lower() in _READ_FUNCTIONS and inner in functions:
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
        return replace(part, name=signal) if _is_named(part, name) else part

    made: s.StatementNode = rewrite(node, visit, ())
    return made


def _choice_items(one: _ChosenSignal) -> list[s.Item]:
    """Return the data that holds a choice, and the function that returns the value of the chosen
    signal.
    """
    if not one.choice:
        return []
    read = VALUE_FUNCTIONS[one.data.type.lower()]
    cases = tuple(
        s.TestCase(
            (s.NumberLiteral(str(at)),),
            (s.ReturnFrom(s.FunctionCall(read, (s.Positional(s.NameRef(name)),))),),
        )
        for at, name in enumerate(one.names, 1)
    )
    test = s.TestOf(s.NameRef(one.choice), cases, (_END_PROGRAM,))
    # Every way through a function needs a value, also the one that ends the program.
    body = (test, s.ReturnFrom(s.NumberLiteral("0")))
    return [
        s.Data("", "VAR", "num", one.choice, span=one.data.span),
        s.Routine("FUNC", False, one.function, body, "num"),
    ]


_MOST_TEXTS: Final = 60
"""Texts of one expression; of more nobody chooses one by one."""
_READING_INSTRUCTIONS: Final = frozenset(
    {"tpwrite", "errwrite", "errlog", "eventlog", "aliasio", "getdataval", "write", "strlen",
     "strpart", "strfind", "strmatch", "strtoval", "valtostr"}
)  # fmt: skip
"""Instructions that take a text without changing it, besides routines of the program with value
parameters.
"""

_TextScope = s.Routine | None
"""Scope of a name: a routine, or the modules."""


class _KnownTexts:
    """Knows the texts of a program."""

    def __init__(self, modules: Sequence[s.Module]) -> None:
        items = [item for module in modules for item in module.items]
        self.routines: dict[str, s.Routine] = {}
        twice: set[str] = set()
        for item in items:
            if isinstance(item, s.Routine):
                twice |= {item.name.lower()} & self.routines.keys()
                self.routines[item.name.lower()] = item
        self.declared = {i.name.lower(): i for i in items if isinstance(i, s.Data)}
        self.parameters = {
            (id(r), name) for r in self.routines.values() for name in _value_parameters(r)
        }
        self.own = {
            id(item): _declared_names(item) for item in items if isinstance(item, s.Routine)
        }
        self.given: dict[tuple[int, str], list[tuple[_TextScope, s.Expression]]] = {}
        self.lost: set[tuple[int, str]] = set()
        """Variables that something changes beside assignments, by scope and lower-case name."""
        for item in items:
            scope = item if isinstance(item, s.Routine) else None
            for node in nodes(item):
                self._look(node, scope)
        # With two routines of a name, nothing tells which one a call gives its texts to.
        for name in twice:
            self.lost |= {key for key in self.given if key[0] == id(self.routines[name])}

    def _key(self, name: str, scope: _TextScope) -> tuple[int, str]:
        inside = scope is not None and name.lower() in self.own.get(id(scope), ())
        return (id(scope) if inside else 0), name.lower()

    def _look(self, node: Any, scope: _TextScope) -> None:
        match node:
            case s.Assignment(s.NameRef(name), value):
                self.given.setdefault(self._key(name, scope), []).append((scope, value))
            case s.Assignment(target):
                found = root(target)
                if found is not None:
                    self.lost.add(self._key(found.name, scope))
            case s.Data(name=name, value=value, dimensions=()) if value is not None:
                self.given.setdefault(self._key(name, scope), []).append((scope, value))
            case s.ProcedureCall() | s.FunctionCall():
                self._called(node, scope)

    def _called(self, node: s.ProcedureCall | s.FunctionCall, scope: _TextScope) -> None:
        word = node.name.lower() if isinstance(node.name, str) else ""
        routine = self.routines.get(word)
        modes: Mapping[str, str] = {}
        places: Iterator[s.ParameterNode | None] = iter(())
        if routine is not None:
            groups = [g for g in routine.parameters if not g.optional]
            places = (_single_parameter(group) for group in groups)
            every = (one for g in routine.parameters for one in g.alternatives)
            modes = {x.name.lower(): x.mode for x in every if isinstance(x, s.ParameterNode)}
        for argument in node.arguments:
            value = getattr(argument, "value", None)
            if isinstance(argument, s.Positional):
                taken = next(places, None)
                name = "" if taken is None else taken.name
            else:
                name = argument.name
            mode = modes.get((name or "").lower())
            if routine is not None and mode == "" and value is not None:
                key = id(routine), str(name).lower()
                self.given.setdefault(key, []).append((scope, value))
            # The optional text may be there or not.
            elif isinstance(argument, s.Conditional):
                self.lost.add((id(routine), argument.name.lower()))
            # Any other routine may change the variable that it is given.
            elif word not in _READING_INSTRUCTIONS and (found := root(value)) is not None:
                self.lost.add(self._key(found.name, scope))
                if routine is not None:
                    self.lost.add((id(routine), str(name).lower()))

    # ------------------------------------------------------------------------------ texts

    def of(self, node: s.Expression, scope: _TextScope) -> frozenset[str] | None:
        """The texts that an expression may give, None if that is not known."""
        return self._of(node, scope, frozenset())

    def _of(
        self, node: s.Expression, scope: _TextScope, asked: frozenset[tuple[int, str]]
    ) -> frozenset[str] | None:
        match node:
            case s.StringLiteral(value):
                return frozenset((value,))
            case s.Group(inner):
                return self._of(inner, scope, asked)
            case s.Infix("+", left, right):
                first, second = self._of(left, scope, asked), self._of(right, scope, asked)
                # Sums multiply, so the limit is asked before they are formed.
                if first is None or second is None or len(first) * len(second) > _MOST_TEXTS:
                    return None
                return frozenset(a + b for a in first for b in second)
            case s.NameRef(name):
                return self._named(name, scope, asked)
        return None

    def _named(
        self, name: str, scope: _TextScope, asked: frozenset[tuple[int, str]]
    ) -> frozenset[str] | None:
        key = self._key(name, scope)
        # A text that is made from itself, as in a loop, has no end of values.
        if key in self.lost or key in asked:
            return None
        if key not in self.given and key not in self.parameters:
            return None
        if key[0] == 0 and key[1] not in self.declared:
            return None
        found: frozenset[str] = frozenset()
        for where, value in self.given.get(key, ()):
            texts = self._of(value, where, asked | {key})
            if texts is None or len(found | texts) > _MOST_TEXTS:
                return None
            found |= texts
        return found


def _single_parameter(group: s.ParameterGroup) -> s.ParameterNode | None:
    match group.alternatives:
        case (s.ParameterNode() as one,):
            return one
    return None


def _value_parameters(routine: s.Routine) -> Iterator[str]:
    """Parameters that take a value, in lower case, which they have from calls alone."""
    for group in routine.parameters:
        for one in group.alternatives:
            if isinstance(one, s.ParameterNode) and not one.mode:
                yield one.name.lower()


def _declared_names(routine: s.Routine) -> frozenset[str]:
    """Return the names that a routine declares, in lower case."""
    return frozenset(
        node.name.lower() for node in nodes(routine) if isinstance(node, s.Data | s.ParameterNode)
    )


_CHOICE_INSTRUCTIONS: Final = ("aliasio", "getdataval")
_LEAST_CHOICES: Final = 2
"""Minimum known first letters of a text before signals with that beginning count as its possible
values.
"""


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
    """Return the modules with signal choices; unchanged if they have none."""
    chosen: list[_ChosenSignal] = []
    if any(map(_chooses, nodes(tuple(modules)))):
        chosen = _SignalVariables(modules).found()
    if not chosen:
        return SignalChoices(modules, ((),) * len(modules))
    fresh = FreshNames(modules)
    for one in chosen:
        if len(one.names) > 1:
            one.choice = fresh(f"{one.data.name}_choice")
            one.function = fresh(f"{one.data.name}_value")
    work = _ChoiceWriter(chosen)
    made = [work.module(module) for module in modules]
    remarks = tuple(tuple(work.remarks[id(module)]) for module in modules)
    signals = {name: SIGNAL_TYPES[one.data.type.lower()] for one in chosen for name in one.names}
    gone = frozenset(one.data.name.lower() for one in chosen)
    return SignalChoices(made, remarks, signals, gone)


def chosen_signals(files: Sequence[s.File]) -> Mapping[str, Signal]:
    """Signals that texts alone may name."""
    if not mentions(files, _CHOICE_INSTRUCTIONS):
        return {}
    modules = with_unique_data_names([module for file in files for module in file.modules])
    return with_chosen_signals(modules).signals


class _SignalVariables:
    """Possible signals of each signal variable."""

    def __init__(self, modules: Sequence[s.Module]) -> None:
        self.texts = _KnownTexts(modules)
        self.items = [item for module in modules for item in module.items]
        self.variables: dict[tuple[int, str], _ChosenSignal] = {}
        for item in self.items:
            inside = item if isinstance(item, s.Routine) else None
            for node in (item,) if inside is None else inside.body:
                match node:
                    case s.Data(storage="VAR", type=type, dimensions=()) if (
                        type.lower() in VALUE_FUNCTIONS
                    ):
                        one = _ChosenSignal(node, inside)
                        self.variables[one.key] = one
        self.sources: dict[tuple[int, str], set[str] | None] = {}

    def found(self) -> list[_ChosenSignal]:
        declared = {i.name.lower() for i in self.items if isinstance(i, s.Data)}
        self.declared = declared
        # A name that nothing declares may be a signal of the controller's configuration.
        signals = {n for n in self._names() if n.lower() not in declared}
        for item in self.items:
            if isinstance(item, s.Routine):
                for body in lists(item):
                    self._look(body, item, signals)
        chosen = []
        for key, names in self.sources.items():
            one = self.variables.get(key)
            if one is None or not names or len(names) > _MOST_TEXTS:
                continue
            # One spelling for each signal, whatever the letter case of the texts.
            spelled = {name.lower(): name for name in sorted(names, reverse=True)}
            one.names = tuple(sorted(spelled.values(), key=str.lower))
            if self._is_only_used_well(one):
                chosen.append(one)
        return chosen

    def _names(self) -> Iterator[str]:
        for node in nodes(tuple(self.items)):
            if isinstance(node, s.NameRef):
                yield node.name

    def variable(self, name: str, inside: s.Routine) -> _ChosenSignal | None:
        low = name.lower()
        if low in self.texts.own.get(id(inside), ()):
            return self.variables.get((id(inside), low))
        return self.variables.get((0, low))

    def _look(self, body: Sequence[s.StatementNode], inside: s.Routine, signals: set[str]) -> None:
        for at, node in enumerate(body):
            match node:
                case s.ProcedureCall(str(), (s.Positional(source), s.Positional(s.NameRef(name)))):
                    if _chooses(node) and (one := self.variable(name, inside)) is not None:
                        names = self._sources(source, body[:at], inside, signals)
                        known = self.sources.setdefault(one.key, set())
                        # One unknown source makes the variable unknown for good.
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
            # An undeclared name is the signal itself.
            if low not in own and low not in self.declared:
                return {source.name}
            # Aliases of aliases are not followed.
            if self.variable(low, inside) is not None:
                return None
            source = _assigned_before(low, before) or source
        texts = self.texts.of(source, inside)
        if texts is not None:
            return set(texts)
        # Only the beginning of the text is known: every signal with that beginning may be meant.
        start = self._start(source, inside)
        like = {
            name for name in signals if len(start) >= _LEAST_CHOICES and _starts_with(name, start)
        }
        return like or None

    def _start(self, source: s.Expression, inside: s.Routine) -> str:
        """Return the text that an expression certainly begins with."""
        while isinstance(source, s.Infix) and source.operator == "+":
            source = source.left
        texts = self.texts.of(source, inside)
        return next(iter(texts)) if texts is not None and len(texts) == 1 else ""

    def _is_only_used_well(self, one: _ChosenSignal) -> bool:
        """True if a choice can replace every use of a variable."""
        # A single signal replaces the name anywhere.
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
    """Return the value assigned to a variable directly before, in the same list of statements."""
    for node in reversed(before):
        match node:
            case s.Assignment(s.NameRef(target), value):
                if target.lower() == name:
                    return value
            # Other choices between the assignment and this one do not change the text.
            case s.ProcedureCall() if _chooses(node):
                continue
            case s.CommentLine():
                continue
            case _:
                return None
    return None


def _is_supported(node: s.StatementNode, name: str) -> bool:
    """True if a statement, without its inner blocks, uses a variable only in supported
    positions.
    """
    if isinstance(node, s.ProcedureCall | s.Data):
        return True
    shallow = _own_expressions(node)
    # Every mention must be a supported one: any other use would need the signal itself.
    plain = sum(_is_named(part, name) for part in nodes(shallow))
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
    """True if a function reads the value of the signal."""
    match node:
        case s.FunctionCall(str(word), (s.Positional(s.NameRef(inner)),)):
            return inner.lower() == name and word.lower() in _READ_FUNCTIONS
    return False


def _bare_uses(shallow: Any, name: str) -> int:
    """Count the uses of the name as a plain value: as an operand, or as the complete expression."""
    count = sum(_is_named(one, name) for one in shallow)
    for node in nodes(shallow):
        match node:
            case s.Infix(_, left, right):
                count += _is_named(left, name) + _is_named(right, name)
            case s.Prefix(_, inner) | s.Group(inner):
                count += _is_named(inner, name)
            case s.Assignment(_, value) | s.ReturnFrom(value):
                count += _is_named(value, name)
    return count
