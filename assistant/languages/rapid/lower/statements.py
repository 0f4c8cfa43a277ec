"""Statements of the pseudo-program as RAPID's."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Findings, Refused
from assistant.languages.patterns import Slot, Write
from assistant.languages.rapid import rules
from assistant.languages.rapid.lower.expressions import Expressions, not_expressible
from assistant.languages.rapid.lower.modules import resident_units
from assistant.languages.rapid.lower.motions import (
    blend_name_in,
    frame_name_in,
    path_moves,
    speed_name_in,
)
from assistant.languages.rapid.lower.triggers import trigger_set_up, with_triggers
from assistant.languages.rapid.tables.hands import hand_signal
from assistant.languages.rapid.tables.motions import usual_details
from assistant.languages.rapid.tables.operators import OR, SUM, TERM
from assistant.languages.rapid.tables.statements import STATEMENT_ROWS
from assistant.languages.rapid.tables.words import LOADED_FROM, LONGEST_PULSE, SHORTEST_PULSE
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import arguments
from assistant.languages.rapid.tree.gather import gathered
from assistant.languages.scoped_names import Naming, spelt
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.declared_types import is_value, known_types
from assistant.program.motion import Blend, Speed
from assistant.program.passes.loops import ascends
from assistant.program.passes.operator_texts import message_parts
from assistant.program.program import Procedure, Program, Signal

Lowered = Iterator[s.StatementNode]


class BodyLowering:
    """What the statements of one procedure are lowered with.

    names: of the whole program. expressions: as they are seen in the procedure. findings: why
    statements were left out.
    """

    def __init__(self, program: Program, names: Naming, procedure: Procedure) -> None:
        key = procedure.name.lower()
        self.names, self.labels = names, names.labels[key]
        self._inner, self._counters = names.inner[key], names.counters[key]
        self._counting: list[str] = []
        self.expressions = Expressions(names, self._value)
        self.lower = self.expressions.lower
        writers: dict[str, Write[s.Expression]] = {
            **self.expressions.writing.kinds,
            **dict.fromkeys(("signal", "digital", "analog", "group"), self.signal),
            "hand": lambda hand, _: s.NameRef(hand_signal(hand)),
            "speed": lambda speed, _: self._speed(speed),
            "blend": lambda blend, _: self._blend(blend),
            "other": lambda frame, _: s.NameRef(n) if (n := frame_name_in(names, frame)) else None,
        }
        self.writing = replace(self.expressions.writing, kinds=writers)
        self.known = known_types(program, procedure)
        self.signals = {n.lower(): g for n, g in program.signals.items()}
        self.resident = resident_units(program)
        self.findings = Findings()

    def statements(self, body: tuple[p.Statement, ...]) -> Iterator[s.StatementNode]:
        before: p.Statement | None = None
        for statement in body:
            above, before = before, statement
            if isinstance(statement, p.Comment):
                yield s.CommentLine(statement.text, statement.stands_at_end_of(above))
                continue
            with self.findings.at(statement.span):
                try:
                    if (lower := STATEMENTS.get(type(statement))) is None:
                        what = f"a {type(statement).__name__} statement"
                        raise not_expressible(what, "say it in other statements")
                    yield from lower(self, statement)
                except Refused as refused:
                    self.findings += refused.findings

    def block(self, body: tuple[p.Statement, ...]) -> tuple[Any, ...]:
        return gathered(self.statements(body))

    def counted(self, variable: str, body: tuple[p.Statement, ...]) -> tuple[str, tuple[Any, ...]]:
        """RAPID's name of the variable of a loop, and the loop's body."""
        self._counting.append(variable.lower())
        block = self.block(body)
        self._counting.pop()
        return spelt(self._counters, variable), block

    def _value(self, name: str) -> str:
        if name.lower() in self._counting:
            return spelt(self._counters, name)
        if name.lower() in self._inner:
            return spelt(self._inner, name)
        return self.names.value(name)

    def _speed(self, speed: Speed | p.ComputedSpeed | e.Name) -> s.Expression:
        if not isinstance(speed, p.ComputedSpeed):
            return s.NameRef(speed_name_in(self.names, speed))
        parts = (speed.tcp, speed.rotation, speed.external_linear, speed.external_rotary)
        return s.AggregateNode(tuple(self.lower(part) for part in parts if part is not None))

    def _blend(self, blend: Blend | p.ComputedBlend | e.Name) -> s.Expression:
        if not isinstance(blend, p.ComputedBlend):
            return s.NameRef(blend_name_in(self.names, blend))
        details = usual_details(blend.radius) if blend.details is None else blend.details
        parts = (blend.stops or e.Truth(False), blend.radius, *details)
        return s.AggregateNode(tuple(map(self.lower, parts)))

    def set_up(self, x: p.Trigger, variable: s.NameRef) -> s.ProcedureCall:
        signal = self.signals.get(x.signal.lower())
        kind = signal.kind if signal else "digital"
        named = s.NameRef(self.names.get("signals", x.signal))
        return trigger_set_up(x, variable, named, kind, self.lower)

    def call(self, word: str, *given: s.Expression, **options: s.Expression) -> s.ProcedureCall:
        arguments: list[s.Argument] = [s.Positional(g) for g in given]
        arguments += [s.Option(n, v) for n, v in options.items()]
        return s.ProcedureCall(word, tuple(arguments))

    def signal(self, name: str, slot: Slot) -> s.NameRef | None:
        """A signal, if it is of the kind and direction that the slot tells."""
        signal = self.signals.get(name.lower(), Signal("digital", "input"))
        fits = slot.kind in ("signal", signal.kind) and slot.of in ("", signal.direction)
        return s.NameRef(self.names.get("signals", name)) if fits else None


def _move(b: BodyLowering, x: p.MoveStatement) -> Lowered:
    (move,) = _table_row(b, replace(x, triggers=()))
    if x.triggers:
        yield from with_triggers(move, x.triggers, b.names.triggers, b.set_up)
    else:
        yield move


def _follow(b: BodyLowering, x: p.Follow) -> Lowered:
    yield from path_moves(x.path, b.names.rows[id(x)], b.names)


def _table_row(b: BodyLowering, x: p.Statement) -> Iterator[s.ProcedureCall]:
    """A statement that is a row of `tables.statements`."""
    call = STATEMENT_ROWS.write(x, b.writing)
    if call is None:
        raise not_expressible(f"such a {type(x).__name__}", "say it otherwise")
    yield s.ProcedureCall(call.word, arguments(call))


def _start_timer(b: BodyLowering, x: p.StartTimer) -> Lowered:
    clock = s.NameRef(b.names.get("timers", x.timer))
    yield b.call("ClkReset", clock)
    yield b.call("ClkStart", clock)


def _set_signal(b: BodyLowering, x: p.SetSignal) -> Lowered:
    if x.pulse is not None:
        _check_pulse(b, x, x.pulse)
    yield from _table_row(b, x)


def _check_pulse(b: BodyLowering, x: p.SetSignal, seconds: e.Expression) -> None:
    signal = b.signals.get(x.signal.lower())
    if isinstance(seconds, e.Number) and not SHORTEST_PULSE <= seconds.value <= LONGEST_PULSE:
        what = f"a pulse of `{x.signal}` that is not {SHORTEST_PULSE} to {LONGEST_PULSE} s"
        raise not_expressible(what, "give a time in that range")
    if x.value != e.Number(1) or (signal is not None and signal.kind != "digital"):
        group = signal is not None and signal.kind != "digital"
        what = f"a pulse of the group `{x.signal}`" if group else f"such a pulse of `{x.signal}`"
        raise not_expressible(what, "set the signal, wait and set it back")


def _call(b: BodyLowering, x: p.Call) -> Lowered:
    name = b.names.get("procedures", x.procedure)
    given = tuple(s.Positional(b.lower(a)) for a in x.arguments)
    if x.unit is None or x.unit in b.resident:
        yield s.ProcedureCall(name, given)
        return
    file = s.StringLiteral(LOADED_FROM + b.names.get("modules", x.unit) + ".mod")
    yield s.ProcedureCall("Load", (s.Option("Dynamic"), s.Positional(file)))
    yield s.ProcedureCall(s.StringLiteral(name), given)
    yield s.ProcedureCall("UnLoad", (s.Positional(file),))


def _assign(b: BodyLowering, x: p.Assign) -> Lowered:
    match x:
        case p.Assign(place, e.Apply("oriented", (base, *angles))) if place == base and len(
            angles
        ) == len(e.ANGLES):
            turn = b.expressions.orientation(place)
            first = angles[0]
            if isinstance(first, e.Member) and angles == [
                e.Member(first.value, name) for name in e.ANGLES
            ]:
                yield s.Assignment(turn, b.expressions.orientation(first.value))
                return
            yield s.Assignment(turn, b.expressions.oriented(tuple(angles)))
            return
    target = b.lower(x.target)
    if not isinstance(target, s.NameRef | s.Component | s.Element):
        raise not_expressible("an assignment to an expression", "name a variable")
    yield s.Assignment(target, b.lower(x.value))


def _if(b: BodyLowering, x: p.If) -> Lowered:
    branches = tuple(s.IfBranch(b.lower(c.condition), b.block(c.body)) for c in x.branches)
    yield s.IfThen(branches, b.block(x.otherwise) if x.otherwise else None)


def _while(b: BodyLowering, x: p.While) -> Lowered:
    yield s.WhileLoop(b.lower(x.condition), b.block(x.body))


def _for(b: BodyLowering, x: p.For) -> Lowered:
    # Without STEP a loop counts downwards where its bounds do (RAPID kernel manual, FOR).
    upwards = x.step == p.ONE and ascends(x.first, x.last)
    step = None if upwards or x.step is None else b.lower(x.step)
    first, last = b.lower(x.first), b.lower(x.last)
    variable, body = b.counted(x.variable, x.body)
    yield s.ForLoop(variable, first, last, step, body)


def _switch(b: BodyLowering, x: p.Switch) -> Lowered:
    cases = tuple(s.TestCase(tuple(map(b.lower, c.values)), b.block(c.body)) for c in x.cases)
    yield s.TestOf(b.lower(x.subject), cases, b.block(x.otherwise) if x.otherwise else None)


def _stop(b: BodyLowering, x: p.Stop) -> Lowered:
    if x.end:
        yield s.Word("EXIT")
    else:
        yield from _table_row(b, x)


def _return(b: BodyLowering, x: p.Return) -> Lowered:
    yield s.ReturnFrom(None if x.value is None else b.lower(x.value))


def _label(b: BodyLowering, x: p.Label) -> Lowered:
    yield s.LabelMark(spelt(b.labels, x.name))


def _goto(b: BodyLowering, x: p.Goto) -> Lowered:
    yield s.GotoLabel(spelt(b.labels, x.label))


def _message(b: BodyLowering, x: p.Message) -> Lowered:
    whole: s.Expression | None = None
    for part in message_parts(x, b.known) or (e.Text(""),):
        if is_value(part, b.known):
            own: s.Expression = s.FunctionCall("ValToStr", (s.Positional(b.lower(part, OR)),))
        else:
            own = b.lower(part, TERM if whole is not None else SUM)
        whole = own if whole is None else s.Infix("+", whole, own)
    assert whole is not None
    yield b.call("TPWrite", whole)


def _opaque(_: BodyLowering, x: p.Opaque) -> Lowered:
    if x.language != verbatim.LANGUAGE:
        raise Refused(rules.OTHER_LANGUAGE(**verbatim.foreign(x)))
    yield from verbatim.statements(x.text)


STATEMENTS: Final[dict[type, Callable[[BodyLowering, Any], Lowered]]] = {
    **dict.fromkeys(STATEMENT_ROWS.records, _table_row),
    **dict.fromkeys((p.Move, p.MoveCircular, p.MoveJoints), _move),
    p.Follow: _follow,
    p.StartTimer: _start_timer,
    p.SetSignal: _set_signal,
    p.Call: _call,
    p.Assign: _assign,
    p.If: _if,
    p.While: _while,
    p.For: _for,
    p.Switch: _switch,
    p.Stop: _stop,
    p.Return: _return,
    p.Label: _label,
    p.Goto: _goto,
    p.Message: _message,
    p.Opaque: _opaque,
}
