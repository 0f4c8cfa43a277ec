"""Arrays of clocks, and clocks read in high resolution, as clocks that other languages can count.

`ClkRead` with the option `HighRes` becomes a plain `ClkRead`. A clock in an array becomes three
numbers: the seconds that it ran before, 1 while it runs, and its last start on one clock that all
arrays share and nothing stops: `ClkRead(c{i})` is
`c_ran{i}+c_runs{i}*(ClkRead(clocks)-c_since{i})`. A clock value written to a file or socket is read
into a variable first.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.flatten.data_names import FreshNames
from assistant.languages.rapid.lift.flatten.library import function_call
from assistant.languages.rapid.lift.flatten.tree_rewriting import rewritten
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import inner_names, mentions, nodes
from assistant.program.rewriting import rewrite

_CLOCK_TYPE: Final = "clock"
_READ_FUNCTION: Final = "clkread"
_HIGH_RESOLUTION: Final = "highres"
_WRITE_INSTRUCTIONS: Final = frozenset(("write", "socketsend", "writestrbin"))
"""Instructions that stay as their text until their channel is known."""
_ARRAY_SUFFIXES: Final = ("ran", "runs", "since")
_ZERO, ONE = s.NumberLiteral("0"), s.NumberLiteral("1")


@dataclass(frozen=True, slots=True)
class _ClockArray:
    """The names of the three arrays that an array of clocks becomes, and of the shared clock.

    going: whether that has been started.
    """

    shared: str
    going: str
    ran: str
    runs: str
    since: str

    def now(self, at: Sequence[Any]) -> s.Expression:
        """The seconds that a clock has counted."""
        time = function_call("ClkRead", s.NameRef(self.shared))
        lately = s.Group(s.Infix("-", time, self.of("since", at)))
        counted = s.Infix("*", self.of("runs", at), lately)
        return s.Group(s.Infix("+", self.of("ran", at), counted))

    def of(self, part: str, at: Sequence[Any]) -> s.Element:
        return s.Element(s.NameRef(getattr(self, part)), tuple(at))

    def done(self, word: str, at: Sequence[Any]) -> Iterator[s.StatementNode]:
        """Instructions that start, stop or clear a clock."""
        if word == "clkstart":
            clock = (s.Positional(s.NameRef(self.shared)),)
            going = s.NameRef(self.going)
            started = (
                s.ProcedureCall("ClkReset", clock),
                s.ProcedureCall("ClkStart", clock),
                s.Assignment(going, s.BoolLiteral(True)),
            )
            # The shared clock starts with the first start of any clock and is never stopped.
            yield s.IfThen((s.IfBranch(s.Prefix("NOT", going), started),))
            now = function_call("ClkRead", s.NameRef(self.shared))
            begun = s.Assignment(self.of("since", at), now), s.Assignment(self.of("runs", at), ONE)
            # Starting a clock that runs must not lose the seconds that it has counted.
            yield s.IfThen((s.IfBranch(s.Infix("=", self.of("runs", at), _ZERO), begun),))
        else:
            # ClkReset clears the seconds; both leave the clock stopped.
            left = self.now(at) if word == "clkstop" else _ZERO
            yield s.Assignment(self.of("ran", at), left)
            yield s.Assignment(self.of("runs", at), _ZERO)


_ClockArrays = Mapping[str, _ClockArray]
"""By the lower-case name of the array of clocks."""


def with_plain_clocks(
    modules: Sequence[s.Module], files: Sequence[s.File]
) -> tuple[Sequence[s.Module], list[list[Diagnostic]]]:
    """The modules of some files with such clocks, and the findings of each."""
    remarks: list[list[Diagnostic]] = [[] for _ in modules]
    if not mentions(files, (_READ_FUNCTION,)):
        return modules, remarks
    if mentions(files, (_HIGH_RESOLUTION,)):
        remarks = [list(_fine_read_findings(module)) for module in modules]
        modules = [rewrite(module, _plain_read, ()) for module in modules]
    if mentions(files, tuple(_WRITE_INSTRUCTIONS)):
        modules = _with_reads_before(modules)
    found = [
        (at, item)
        for at, m in enumerate(modules)
        for item in _declarations(m)
        if _is_clock_array(item)
    ]
    sayable = _supported_arrays(modules, [item.name.lower() for _, item in found])
    found = [(at, item) for at, item in found if item.name.lower() in sayable]
    if not found:
        return modules, remarks
    name = FreshNames(modules)
    shared = name("clocks"), name("clocks_run")
    rows = {
        item.name.lower(): _ClockArray(
            *shared, *(name(f"{item.name}_{x}") for x in _ARRAY_SUFFIXES)
        )
        for _, item in found
    }
    made = [_with_clock_arrays(module, rows) for module in modules]
    first = found[0][0]
    clock, going = shared
    data = s.Data("", "VAR", _CLOCK_TYPE, clock), s.Data("", "VAR", "bool", going)
    made[first] = replace(made[first], items=(*data, *made[first].items))
    return made, remarks


def _with_reads_before(modules: Sequence[s.Module]) -> list[s.Module]:
    """The modules whose instructions for channels are given numbers instead of clocks."""
    own = {i.name.lower() for m in modules for i in m.items if isinstance(i, s.Routine)}
    name = FreshNames(modules)
    held: list[str] = []

    def said(node: s.StatementNode) -> Iterator[s.StatementNode]:
        word = str(node.name).lower() if isinstance(node, s.ProcedureCall) else ""
        if word not in _WRITE_INSTRUCTIONS or word in own:
            yield node
            return
        reads: list[s.FunctionCall] = []

        def read(part: Any) -> Any:
            if not isinstance(part, s.FunctionCall) or str(part.name).lower() != _READ_FUNCTION:
                return part
            reads.append(part)
            # Statements share their variables: each is read at once by the statement after it.
            if len(held) < len(reads):
                held.append(name("clocked"))
            return s.NameRef(held[len(reads) - 1])

        written = rewrite(node, read, ())
        for variable, one in zip(held, reads, strict=False):
            yield s.Assignment(s.NameRef(variable), one, span=node.span)
        yield written

    made = [rewritten(module, said) for module in modules]
    if held:
        data = (s.Data("", "VAR", "num", one) for one in held)
        made[0] = replace(made[0], items=(*data, *made[0].items))
    return made


def _declarations(module: s.Module) -> Iterator[s.Data]:
    return (item for item in module.items if isinstance(item, s.Data))


def _is_clock_array(item: s.Data) -> bool:
    return item.type.lower() == _CLOCK_TYPE and bool(item.dimensions) and item.value is None


def _is_fine_read(node: Any) -> bool:
    match node:
        case s.FunctionCall(str(word), (s.Positional(), s.Option(option, None))):
            return (word.lower(), option.lower()) == (_READ_FUNCTION, _HIGH_RESOLUTION)
    return False


def _plain_read(node: Any) -> Any:
    return replace(node, arguments=node.arguments[:1]) if _is_fine_read(node) else node


def _fine_read_findings(module: s.Module) -> Iterator[Diagnostic]:
    """A finding for each statement that reads a clock finely."""
    for node in nodes(module):
        if node.span is not None and any(map(_is_fine_read, nodes(_own_expressions(node)))):
            yield rules.LEFT_OUT(
                what=r"\HighRes", loss="the clock is read in the units of the timer there",
                cure="none is needed where milliseconds do", span=node.span,
            )  # fmt: skip


def _own_expressions(node: Any) -> Any:
    """Expressions of a statement, without those of the statements that it holds."""
    match node:
        case s.Assignment() | s.ProcedureCall() | s.ReturnFrom():
            return node
        case s.IfThen(branches):
            return tuple(one.condition for one in branches if one.condition is not None)
        case s.CompactIf(condition) | s.WhileLoop(condition):
            return condition
        case s.TestOf(subject):
            return subject
    return ()


def _clock_in(node: Any) -> tuple[str, str, tuple[Any, ...]] | None:
    """A call that acts on a clock in an array: its word, the array, the indices."""
    match node:
        case s.ProcedureCall(
            str(word), (s.Positional(s.Element(s.NameRef(array), at), None),)
        ) | s.FunctionCall(str(word), (s.Positional(s.Element(s.NameRef(array), at), None),)) if (
            word.lower() in (_READ_FUNCTION, "clkstart", "clkstop", "clkreset")
        ):
            return word.lower(), array.lower(), at
    return None


def _supported_arrays(modules: Sequence[s.Module], names: Sequence[str]) -> set[str]:
    """Arrays that are declared once, and in calls of clocks alone with indices that only read."""
    routines = [i for m in modules for i in m.items if isinstance(i, s.Routine)]
    named: Counter[str] = Counter()
    meant: Counter[str] = Counter()
    for node in nodes(tuple(modules)):
        if isinstance(node, s.NameRef):
            named[node.name.lower()] += 1
        elif (asked := _clock_in(node)) is not None:
            _, array, at = asked
            # The index is written three times, so it must not call anything.
            meant[array] += not any(isinstance(one, s.FunctionCall) for one in nodes(at))
    inner = {name.lower() for name in inner_names(routines)}
    once = {name for name, count in Counter(names).items() if count == 1}
    # Every mention of the array has to be one of those calls.
    return {name for name in once - inner if named[name] == meant[name]}


def _with_clock_arrays(module: s.Module, rows: _ClockArrays) -> s.Module:
    items: list[s.Item] = []
    for item in module.items:
        row = rows.get(item.name.lower()) if isinstance(item, s.Data) else None
        if row is not None and isinstance(item, s.Data):
            items += (replace(item, type="num", name=x) for x in (row.ran, row.runs, row.since))
        else:
            items.append(rewrite(item, lambda node: _clock_value(node, rows), ()))
    return rewritten(
        replace(module, items=tuple(items)), lambda node: _clock_statements(node, rows)
    )


def _clock_value(node: Any, rows: _ClockArrays) -> Any:
    asked = _clock_in(node)
    if asked is None or asked[0] != _READ_FUNCTION or asked[1] not in rows:
        return node
    return rows[asked[1]].now(asked[2])


def _clock_statements(node: s.StatementNode, rows: _ClockArrays) -> Iterator[s.StatementNode]:
    asked = _clock_in(node)
    if asked is None or asked[1] not in rows:
        yield node
        return
    word, array, at = asked
    for one in rows[array].done(word, at):
        yield replace(one, span=node.span)
