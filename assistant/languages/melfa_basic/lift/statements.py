"""The code of one procedure as statements of the pseudo-program."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.columnar import MoveRows
from assistant.languages.melfa_basic.lift import data, passes, reasons, waits
from assistant.languages.melfa_basic.lift.blocks import Code, labels_in
from assistant.languages.melfa_basic.lift.contexts import Contexts, Form, depends
from assistant.languages.melfa_basic.lift.control import Control
from assistant.languages.melfa_basic.lift.expressions import Expressions
from assistant.languages.melfa_basic.lift.meanings import Meanings, Routine, Unliftable
from assistant.languages.melfa_basic.lift.moves import Moves
from assistant.languages.melfa_basic.lift.pallets import define as define_pallet
from assistant.languages.melfa_basic.lift.paths import Runs, Values
from assistant.languages.melfa_basic.lift.regions import Region
from assistant.languages.melfa_basic.lift.settings import FRAME, TOOL, State
from assistant.languages.melfa_basic.lift.ways import Ways
from assistant.languages.melfa_basic.names import ARC_START
from assistant.languages.melfa_basic.walk import nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.diagnostics import Span
from assistant.program.program import identifier
from assistant.program.rewriting import head, records
from assistant.program.text import SourceText


class Reader:
    """Reads the procedures of one file.

    routines: what each region is called, and what `GoSub` and functions mean. units, firsts:
    the programs that `CallP` names, and the procedures that those begin with. kept: lines whose
    setting has to stay, because something depends on it that is kept as its text. source: the
    text that the code was read from.
    """

    def __init__(
        self,
        code: Code,
        structure: dict[int, list[int]],
        meanings: Meanings,
        contexts: Contexts,
        routines: list[Routine],
        calls: tuple[dict[str, str], dict[str, str]],
        main: bool,
        kept: frozenset[int],
        source: SourceText | None,
    ) -> None:
        self.code, self.meanings, self.contexts = code, meanings, contexts
        self.flow, self.routines, self.main, self.kept = contexts.flow, routines, main, kept
        self.units, self.firsts = calls
        self.own = meanings.own
        self.ways = Ways(code, self.flow.effect, meanings.dialect, source)
        self.expressions = Expressions(meanings)
        self.runs = Runs(meanings, code, self.own, self.single)
        self.moves = Moves(self.expressions, self.runs)
        self.control = Control(code, structure, self.expressions, self.body, self.branch)
        self.by_label = {r.label: k for k, r in enumerate(self.flow.regions) if r.label}
        self.form: Form | None = None
        self.names: passes.Names | None = None
        self.own_labels: dict[str, str] = {}
        """Those of the lines that are read, upper case → name."""
        self.region = Region(0, 0)
        self.at = 0
        self.torn = False
        """Whether a text with a jump stands in a divided procedure, where it leads astray."""
        self.depending: list[tuple[Form, int]] = []
        """Lines kept as text that do what they do under the settings that hold there."""

    # ---------------------------------------------------------------------- procedures

    def read(self, form: Form) -> tuple[p.Statement, ...]:
        """The body of a procedure as it is called in one way."""
        self.form, region = form, self.flow.regions[form.region]
        self.region = region
        self.runs.previous, self.runs.arc_pending = None, False
        made: list[p.Statement] = []
        for at in range(*region.notes):
            made += self.control.note(at)
        if form.passes:
            made += self.in_passes(form)
        else:
            self._take_labels(region)
            if region.before[1] > 0:
                made += self.statements(*region.before)
            made += self.statements(region.low, region.high)
        made += self.ending(region)
        return tuple(made)

    def _take_labels(self, region: Region) -> None:
        taken: set[str] = set()
        self.control.labels = {}
        for low, high in (region.before, (region.low, region.high)):
            for label in sorted(labels_in(self.code, max(low, 0), high)):
                given = self.meanings.header.names["label"].get(label)
                name = given or identifier(self._spelled(label), taken)
                self.control.labels[label] = name
                taken.add(name)
        self.own_labels = self.control.labels

    def in_passes(self, head: Form) -> list[p.Statement]:
        """The statements of a divided procedure."""
        order = passes.in_order(head)
        self.names = passes.Names(order, self._labels)
        made: list[p.Statement] = []
        for one, below in zip(order, (*order[1:], None), strict=True):
            self.form, self.runs.arc_pending = one, False
            self.runs.forget()
            self.own_labels = self.names.of(one)
            # names made for blocks are unique among all passes
            self.control.labels = {f"**{n}": n for n in self.names.taken} | self.own_labels
            made += self.statements(one.low, one.high)
            self.names.taken |= set(self.control.labels.values())
            if passes.leaves(made) or one.falls is below:
                continue
            if one.falls is not None:
                made.append(p.Goto(self._label_at(one.falls)))
            elif one.high == self.region.high:
                made.append(self._leaving())
        self.form = head
        return made

    def _labels(self, low: int, high: int) -> dict[str, str]:
        return {key: self._spelled(key) for key in sorted(labels_in(self.code, low, high))}

    def _label_at(self, one: Form) -> str:
        item = self.code[one.low]
        assert self.names is not None and isinstance(item, s.Line) and item.label is not None
        return self.names.of(one)[item.label.upper()]

    def _leaving(self) -> p.Statement:
        """What stands for the end of a procedure above its last line."""
        return p.Stop(end=True) if self.region.label is None and self.main else p.Return()

    def _spelled(self, label: str) -> str:
        item = self.code[self.flow.labels[label]]
        return item.label if isinstance(item, s.Line) and item.label else label

    def ending(self, region: Region) -> list[p.Statement]:
        """What stands behind a body: the comment of its last word, a result that was kept."""
        made: list[p.Statement] = []
        if region.high < len(self.code):
            item = self.code[region.high]
            if isinstance(item, s.Line) and item.statement in ENDS:
                made += self.control.note(region.high)
        for at in range(*region.behind):
            made += self.control.note(at)
        inside = self.meanings.inside
        if inside is not None and inside.result is not None:
            made.append(p.Return(e.Name(inside.result)))
        return made

    def body(self, low: int, high: int) -> tuple[p.Statement, ...]:
        self.runs.forget()
        made = tuple(self.statements(low, high))
        self.runs.forget()
        return made

    def statements(self, low: int, high: int) -> list[p.Statement]:
        """The statements of a range of the code."""
        made: list[p.Statement] = []
        at = low
        while at < high:
            at = self.entry(at, high, made)
        self.runs.flush(made)
        return made

    # ---------------------------------------------------------------------------- a line

    @property
    def values(self) -> Values:
        assert self.form is not None
        state: State = self.contexts.at(self.at, self.form)
        return tuple(held.value for held in state)

    def enter(self, at: int) -> Values:
        """Sets what holds where a line begins."""
        self.at = at
        values = self.values
        self.meanings.placing = values[TOOL], values[FRAME]
        assert self.form is not None
        self.meanings.variants = {
            self._function_key(callee): self.name_of(made)
            for callee, made in self.form.called.get(at, {}).items()
        }
        for to in self.form.goes.get(at, {}).values():
            item = self.code[to.low]
            if isinstance(item, s.Line) and item.label is not None:
                self.control.labels[item.label.upper()] = self._label_at(to)
        return values

    def _function_key(self, region: int) -> str:
        function = self.flow.regions[region].function
        return function.name.upper() if function else f"*{self.flow.regions[region].label}"

    def name_of(self, form: Form) -> str:
        """What a procedure is called in the form that one way of calling it makes."""
        name = self.routines[form.region].name
        return name if form.number == 1 else f"{name}_{form.number}"

    def entry(self, at: int, high: int, made: list[p.Statement]) -> int:
        """Reads one entry, or a whole block; gives the place after it."""
        item = self.code[at]
        values = self.enter(at)
        if isinstance(item, MoveRows):
            self.runs.rows(item, values, made)
            return at + 1
        if item.comment is not None:
            self.runs.flush(made)
            made.append(p.Comment(waits.comment_text(item.comment), span=item.span))
        found = waits.waited(self.code, at, high, self.expressions)
        if found is not None:
            self.runs.flush(made)
            made.append(waits.spanned(found[0], item.span))
            return found[1]
        if item.label is not None:
            self.runs.flush(made)
            self.runs.forget()
            made.append(p.Label(self.own_labels[item.label.upper()], span=item.span))
        if item.statement is None or self.absorbed(item.statement, at):
            return at + 1
        if isinstance(item.statement, s.Motion):
            if self.runs.motion(item.statement, values, item.span, made):
                return at + 1
        self.runs.flush(made)
        after = self.control.block(at, high, made) or self.result(at, item.statement, made)
        if after:
            return after
        made += self.one(item.statement, at, item.span)
        return at + 1

    def absorbed(self, node: s.Statement, at: int) -> bool:
        """Takes in what only the moves that follow say: their settings, where an arc begins."""
        if isinstance(node, s.Assign) and node.target.key == ARC_START:
            here = isinstance(node.value, s.Variable) and node.value.key == "P_CURR"
            self.runs.arc_pending = here
            return here
        made = isinstance(node, s.Command) and self.flow.effect(node) is not None
        return made and at not in self.kept

    def one(self, node: s.Statement, at: int, span: Span | None) -> list[p.Statement]:
        """A statement that is no block, or its text."""
        try:
            if at in self.kept and not isinstance(node, s.If):
                raise Unliftable(reasons.DEPENDED_ON)
            lifted = self.simple(node)
        except Unliftable as found:
            lifted = [self.opaque(node, found.reason or self.control.refused.get(at))]
        if not isinstance(node, s.Motion) and depends(node) and _has_verbatim(lifted):
            self.note_dependence(at)
        return [waits.spanned(statement, span) for statement in lifted]

    def branch(self, node: s.Statement) -> list[p.Statement]:
        """The branch of an `If` in one line, or its text as that of a line of its own.

        Raises Unliftable for `Break`, which would leave the `If` if that becomes a block.
        """
        setting = isinstance(node, s.Command) and self.flow.effect(node) is not None
        try:
            if setting and self.at in self.kept:
                raise Unliftable(reasons.DEPENDED_ON)
            return self.simple(node)
        except Unliftable as found:
            if isinstance(node, s.Command) and node.keyword == "Break":
                raise
            return [self.opaque(node, found.reason)]

    def simple(self, node: s.Statement) -> list[p.Statement]:
        """A statement that is no block; raises Unliftable."""
        if isinstance(node, s.Command) and self.flow.effect(node) is not None:
            return []  # how the moves that follow are made
        lift = STATEMENTS.get(type(node))
        if lift is None:
            raise Unliftable
        return lift(self, node)

    def single(self, node: s.Motion, values: Values, span: Span | None) -> list[p.Statement]:
        """A move that is part of no path."""
        try:
            lifted = self.moves.move(node, values)
        except Unliftable as found:
            lifted = [self.opaque(node, found.reason)]
        return [waits.spanned(statement, span) for statement in lifted]

    def opaque(self, statement: s.Statement, found: p.Reason | None) -> p.Opaque:
        self.runs.forget()
        self.runs.arc_pending = False
        if depends(statement):
            self.note_dependence(self.at)
        if found is reasons.WAYS and self.form is not None:
            found = self.ways.differing(statement, self.contexts.at(self.at, self.form))
        dialect = self.meanings.dialect
        if self.form is not None and (self.form.passes or self.form.head):
            self.torn |= any(isinstance(part, s.Target) for part in nodes(statement))
        reason = reasons.reason_for(statement, found)
        return p.Opaque(dialect, reasons.text_of(statement, dialect), reason=reason)

    def note_dependence(self, at: int) -> None:
        assert self.form is not None
        self.depending.append((self.form, at))

    # ------------------------------------------------------------------------- functions

    def result(self, at: int, node: s.Statement, made: list[p.Statement]) -> int:
        """The result of a function, and the way out behind it; the place after both, or 0."""
        inside = self.meanings.inside
        if inside is None or not isinstance(node, s.Assign) or node.target.key != inside.key:
            return 0
        if node.target.arguments is not None or node.target.component:
            return 0
        value = self.expressions.of(node.value)
        span = self.code[at].span if isinstance(self.code[at], s.Line) else None
        if inside.result is not None:
            made.append(p.Assign(e.Name(inside.result), value, span=span))
            return at + 1
        made.append(p.Return(value, span=span))
        after = at + 1
        if after < self.region.high:
            made += self.control.note(after)
            after += 1  # `Exit Function`
        return after

    def left(self, _: s.Command) -> list[p.Statement]:
        """`Exit Function`."""
        inside = self.meanings.inside
        if self.region.function is None:
            raise Unliftable
        result = inside.result if inside is not None else None
        return [p.Return(None if result is None else e.Name(result))]

    # ---------------------------------------------------------------------------- simple

    def move(self, node: s.Motion) -> list[p.Statement]:
        return self.moves.move(node, self.values)

    def one_line_if(self, node: s.If) -> list[p.Statement]:
        made = self.control.one_line_if(node)
        self.runs.forget()
        return made

    def jump(self, node: s.Jump) -> list[p.Statement]:
        return [
            self.go_to_sub(node.target)
            if node.keyword == "GoSub"
            else self.control.goto(node.target)
        ]

    def on_jump(self, node: s.OnJump) -> list[p.Statement]:
        go = self.go_to_sub if node.keyword == "GoSub" else self.control.goto
        made = self.control.on_jump(node, go)
        self.runs.forget()
        return made

    def go_to_sub(self, target: s.Target) -> p.Statement:
        callee = self.by_label.get(str(target.place).upper())
        if callee is None:
            raise Unliftable(reasons.NO_PROCEDURE)
        assert self.form is not None
        self.runs.forget()
        return p.Call(self.name_of(self.form.called[self.at][callee]))

    def call(self, node: s.Call) -> list[p.Statement]:
        key = node.function.key
        routine = self.meanings.routines.get(key)
        if routine is None or routine.parameters is None:
            raise Unliftable
        given = self.expressions.arguments(routine.parameters, node.function.arguments or ())
        self.runs.forget()
        return [p.Call(self.meanings.variants.get(key, routine.name), given)]

    def callp(self, node: s.CallP) -> list[p.Statement]:
        if not isinstance(node.program, s.String):
            raise Unliftable(reasons.COMPUTED_PROGRAM)
        short = node.program.value.upper()
        unit = self.units.get(short) or identifier(node.program.value)
        first = self.firsts.get(short) or unit
        self.runs.forget()
        return [p.Call(first, tuple(self.expressions.plain(a) for a in node.arguments), unit)]

    def command(self, node: s.Command) -> list[p.Statement]:
        lift = COMMANDS.get(node.keyword)
        if lift is None:
            raise Unliftable
        return lift(self, node)

    def value(self, node: s.Command) -> e.Expression:
        return self.expressions.of(*_exactly(node.arguments, 1))

    def wait(self, node: s.Command) -> list[p.Statement]:
        (condition,) = _exactly(node.arguments, 1)
        return [waits.awaited(condition, self.expressions)]

    def hand(self, node: s.Command) -> list[p.Statement]:
        (hand,) = _exactly(node.arguments, 1)
        number = self.meanings.value(hand)
        if not isinstance(number, float):
            raise Unliftable
        action: Any = "open" if node.keyword == "HOpen" else "close"
        return [p.Gripper(action, round(number))]

    def acceleration(self, node: s.Command) -> list[p.Statement]:
        full: tuple[Any, ...] = (s.Number(100), s.Number(100))
        given = node.arguments
        given = (*given, *full[len(given) :]) if len(given) <= 2 else ()
        up, down = _exactly(given, 2)
        of = self.expressions.of
        return [p.SetAcceleration(of(up or full[0]), of(down or full[1]))]

    def end(self, node: s.Command) -> list[p.Statement]:
        """`End` ends a program; one that was called goes back to its caller."""
        _exactly(node.arguments, 0)
        if self.main:
            return [p.Stop(end=True)]
        if not self.region.is_first:
            raise Unliftable(reasons.NOT_FIRST)
        return [p.Return()]

    def returned(self, node: s.Command) -> list[p.Statement]:
        _exactly(node.arguments, 0)
        if self.region.label is None:
            raise Unliftable(reasons.NO_SUBROUTINE)
        return [p.Return()]

    def stopped(self, node: s.Command) -> list[p.Statement]:
        _exactly(node.arguments, 0)
        return [p.Stop()]


ENDS: Final = (s.Command("End"), s.Command("Return"), s.Command("FEnd"))


def _exactly(arguments: tuple[Any, ...], count: int) -> tuple[Any, ...]:
    if len(arguments) != count or (count == 1 and arguments[0] is None):
        raise Unliftable
    return arguments


def _has_verbatim(statements: list[p.Statement]) -> bool:
    return any(isinstance(part, e.Verbatim) for node in statements for part in records(head(node)))


COMMANDS: Final[dict[str, Callable[[Reader, s.Command], list[p.Statement]]]] = {
    "Dly": lambda reader, node: [p.Wait(reader.value(node))],
    "Wait": Reader.wait,
    "Ovrd": lambda reader, node: [p.SetOverride(reader.value(node))],
    "Accel": Reader.acceleration,
    "HOpen": Reader.hand,
    "HClose": Reader.hand,
    "Hlt": Reader.stopped,
    "End": Reader.end,
    "Return": Reader.returned,
    "Exit Function": Reader.left,
    "Break": lambda reader, _: reader.control.left(reader.at),
}

STATEMENTS: Final[dict[type, Callable[[Reader, Any], list[p.Statement]]]] = {
    s.Motion: Reader.move,
    s.Command: Reader.command,
    s.Assign: lambda reader, node: data.assign(node, reader.expressions, reader.runs),
    s.If: Reader.one_line_if,
    s.Jump: Reader.jump,
    s.OnJump: Reader.on_jump,
    s.Call: Reader.call,
    s.CallP: Reader.callp,
    s.DefNames: lambda reader, node: data.define(node.variables, reader.expressions),
    s.Dim: lambda reader, node: data.define(node.variables, reader.expressions),
    s.Static: lambda reader, node: data.define(node.definition.variables, reader.expressions),
    s.Const: lambda reader, node: data.constant(node, reader.expressions),
    s.DefIo: lambda reader, node: data.known_io(node, reader.expressions),
    s.DefOther: lambda reader, node: define_pallet(node, reader.meanings),
    s.DefFunction: lambda reader, node: data.known_function(node, reader.expressions),
}
