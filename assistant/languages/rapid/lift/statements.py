"""Statements of RAPID as those of the pseudo-program, with calls of instructions and triggers.

A statement that the pseudo-program cannot express stays as its text (`Opaque`), with the reason. An
instruction is matched against the rows of `tables/equivalents.py`. `TriggL` and its kin, with the
data that `TriggIO` and `TriggEquip` set up, are outputs set on the way of a move.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

from assistant.base.diagnostics import Refused, span_over
from assistant.languages.patterns import Called, Read, Slot
from assistant.languages.rapid.lift.clocks import restarted_clock
from assistant.languages.rapid.lift.declared_data import DataLift, PathLift
from assistant.languages.rapid.lift.expressions import Expressions, frame_name, tool_name
from assistant.languages.rapid.tables.constants import LOADED_FROM
from assistant.languages.rapid.tables.equivalents import (
    BLENDS,
    SPEED_PARTS,
    SPEEDS,
    STATEMENT_ROWS,
    ZONE_SIZES,
    computed_zone,
    speed_of,
    zone_of,
)
from assistant.languages.rapid.tables.predefined import INSTRUCTIONS, OPTION_ROUTINES
from assistant.languages.rapid.tables.signals import (
    FURTHER_TRIGGERS,
    TRIGGER_MEASURES,
    TRIGGER_MOVES,
    TRIGGER_OUTPUTS,
    TRIGGER_SETUPS,
    TRIGGER_TYPE,
    TriggerMove,
    TriggerSetup,
    hand_of,
)
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number
from assistant.languages.rapid.tree.walk import called, nodes, trigger_set_up, triggers_taken
from assistant.languages.vendor_statements import INTERRUPTS
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Blend, Speed
from assistant.program.passes.loops import ascends
from assistant.program.passes.trigger_data import (
    Reasons,
    Told,
    TriggerData,
    TriggeredMove,
    TriggerSetUp,
)
from assistant.program.program import Declaration, Program, Signal
from assistant.program.vendor_statements import VendorText

EMPTY: Final = MappingProxyType[str, Any]({})


class NameResolver:
    """Meaning of the names in instructions.

    original: returns the original of a shortened name. speeds, blends: the declared ones by
    lower-case name. numbers: values of constants whose names are unique, by lower-case name.
    timers: lower-case names of the clocks that are timers. alone: joint targets without external
    axes, by unique lower-case name. used: signals as instructions use them, filled as statements
    are lifted.
    """

    def __init__(
        self,
        original: Callable[[str], str] = str,
        speeds: Mapping[str, Speed] = EMPTY,
        blends: Mapping[str, Blend] = EMPTY,
        numbers: Mapping[str, e.Number] = EMPTY,
        timers: Collection[str] = (),
        alone: Collection[str] = (),
    ) -> None:
        self.original, self.timers = original, timers
        self.speeds, self.blends, self.numbers, self.alone = speeds, blends, numbers, alone
        expressions = Expressions(original, timers)
        self.used = expressions.used
        self.expression, self.oriented = expressions.of, expressions.oriented
        kinds: dict[str, Read[s.Expression]] = {
            **expressions.reading.kinds,
            "target": lambda node, _: self._place(node),
            "speed": lambda node, _: self._speed(node),
            "blend": lambda node, _: self._blend(node),
            "other": expressions.reading.kinds["frame"],
            "load": lambda node, _: node if _is_no_load(node) else None,
            "robot": lambda node, _: self._robot_alone(self.expression(node)),
            "hand": lambda node, _: self._hand(node),
            "signal": lambda node, _: self._name(node),
            **dict.fromkeys(("digital", "analog", "group"), self._signal),
        }
        self.reading = replace(expressions.reading, kinds=kinds)

    def _name(self, node: s.Expression) -> str | None:
        return self.original(node.name) if isinstance(node, s.NameRef) else None

    def _signal(self, node: s.Expression, slot: Slot) -> str | None:
        """A signal, which is of the kind and direction that the slot tells."""
        name, kind, direction = self._name(node), slot.kind, slot.of or "output"
        if name is not None:
            self.used.append((name, Signal(kind, direction)))  # type: ignore[arg-type]
        return name

    def _hand(self, node: s.Expression) -> int | None:
        name = self._name(node)
        return None if name is None else hand_of(name)

    def _place(self, node: s.Expression) -> e.Expression | None:
        variable = isinstance(node, s.NameRef | s.Element | s.Component)
        return self.expression(node) if variable else None

    def known(self, value: e.Expression) -> e.Expression:
        """The number that a constant stands for; anything else as it is."""
        return self.numbers.get(value.name.lower(), value) if isinstance(value, e.Name) else value

    def _robot_alone(self, joints: e.Expression) -> e.Expression | None:
        """Return a joint target without external axes, None for any other value."""
        match joints:
            case e.JointValue(target) if not any(v == v for v in target.external):
                return joints
            case e.Name(name) if name.lower() in self.alone:
                return joints
        return None

    def _speed(self, node: s.Expression) -> Speed | p.ComputedSpeed | e.Name | None:
        """By its name, or written out in numbers or in what is worked out."""
        match node:
            case s.NameRef(name):
                return self.speed(name)
            case s.AggregateNode(items) if len(items) == len(SPEED_PARTS):
                values = _aggregate_numbers(node)
                return speed_of(values) if values else p.ComputedSpeed(*map(self._part, items))
        return None

    def _part(self, node: s.Expression) -> e.Expression:
        return self.known(self.expression(node))

    def _blend(self, node: s.Expression) -> Blend | p.ComputedBlend | e.Name | None:
        """By its name, or written out; a stop point has no sizes."""
        match node:
            case s.NameRef(name):
                return self.blend(name)
            # A computed stop condition or size; literal zones are read below.
            case s.AggregateNode((stop, *sizes)) if len(sizes) == len(ZONE_SIZES) and not (
                isinstance(stop, s.BoolLiteral)
                and _aggregate_numbers(s.AggregateNode(tuple(sizes)))
            ):
                return computed_zone(self.expression(stop), tuple(map(self._part, sizes)))
            case s.AggregateNode((s.BoolLiteral(fine), *sizes)):
                values = _aggregate_numbers(s.AggregateNode(tuple(sizes)))
                zone = zone_of(fine, values) if len(values) == 6 else None
                # A stop point with sizes is not the one that would be written back.
                return None if zone is None or (zone.radius is None and any(values)) else zone
        return None

    def speed(self, name: str) -> Speed | e.Name:
        return SPEEDS.meant(name, self.speeds) or e.Name(self.original(name))

    def blend(self, name: str) -> Blend | e.Name:
        return BLENDS.meant(name, self.blends) or e.Name(self.original(name))

    def motion(self, speed: str, zone: str, tool: str, frame: str) -> p.Motion:
        """frame: empty for none."""
        named = tool_name(self.original(tool)), frame_name(self.original(frame))
        return p.Motion(self.speed(speed), self.blend(zone), *named)


def lift_instruction(node: s.ProcedureCall, meaning: NameResolver) -> p.Statement | None:
    """Lift a call of an instruction to a statement, None if this form has no equivalent."""
    call = called(node)
    return None if call is None else lift_call(call, meaning)


def lift_call(call: Called[s.Expression], meaning: NameResolver) -> p.Statement | None:
    """The same of a call as the rows of tables have it."""
    said: p.Statement | None = STATEMENT_ROWS.read(call, meaning.reading)
    return said


def _is_no_load(node: s.Expression) -> bool:
    return isinstance(node, s.NameRef) and node.name.lower() == "load0"


def _aggregate_numbers(node: s.Expression) -> list[float]:
    """The numbers in brackets, none if there is anything else in them."""
    items = node.items if isinstance(node, s.AggregateNode) else ()
    numbers = [literal_number(item) for item in items]
    return [] if None in numbers else [float(n) for n in numbers if n is not None]


_INTERRUPT_INSTRUCTIONS: Final = (
    *("isignaldi", "isignaldo", "isignalgi", "isignalgo", "isignalai", "isignalao", "itimer"),
    *("idelete", "isleep", "iwatch", "ienable", "idisable", "ipers", "ierror", "triggint"),
)
_SYNCHRONISED_MOVES: Final = ("syncmoveon", "syncmoveoff", "syncmovesuspend", "syncmoveresume")
_SEVERAL_ARMS: Final = e.Reason(
    "arms of several tasks move together there, which no program of one arm does",
    "move them one after the other, each in its own program",
)
_INSTRUCTION_REASONS: Final[Mapping[str, e.Reason]] = {
    "pulsedo": e.Reason(
        r"without \High the pulse is the other value than that which the signal has",
        r"write `\High`, or set the signal, wait and set it back",
    ),
    **dict.fromkeys(_INTERRUPT_INSTRUCTIONS, INTERRUPTS),
    **dict.fromkeys(_SYNCHRONISED_MOVES, _SEVERAL_ARMS),
}
"""Why calls of instructions stay as their text, by lower-case name."""


_BY_COMPONENTS: Final = "say it with the components, one by one"
"""What to do where a record is used in a way that no plain data can be."""
_STANDARD: Final = INSTRUCTIONS | OPTION_ROUTINES
_WORD: Final = re.compile(r"[A-Za-z]\w*")
_LOADED: Final = re.compile(rf"{re.escape(LOADED_FROM)}({_WORD.pattern})\.mod")


def statements_of(text: str, program: Program) -> tuple[p.Statement, ...]:
    """Lift RAPID statements in a program; text that is not RAPID is returned as an Opaque."""
    try:
        read = verbatim.statements(text)
    except Refused:
        return (_opaque_text(text),)  # a finding when it is built
    # Declarations are no statements of a body.
    if any(isinstance(n, s.Data | s.TargetRunNode) for n in read):
        return (_opaque_text(text),)
    return lift_of(program).block(read)


def lift_of(program: Program) -> StatementLift:
    """Return a lift for further statements of a program."""
    paths = PathLift((), DataLift((), (), str), str)
    return StatementLift(NameResolver(), paths, {q.name.lower() for q in program.procedures})


class StatementLift:
    """procedures: lower-case names of the user's own, which hide instructions.

    kept: statements that stay as their text, by `id`, each with why.
    """

    def __init__(
        self,
        meaning: NameResolver,
        paths: PathLift,
        procedures: Collection[str],
        kept: Mapping[int, str] = MappingProxyType({}),
    ) -> None:
        self._kept = kept
        self._meaning, self._paths, self._procedures = meaning, paths, procedures
        self._original, self._expression = meaning.original, meaning.expression

    def block(self, nodes: Sequence[s.StatementNode] | None) -> tuple[p.Statement, ...]:
        """The statements of a body; none for one that is not there."""
        return tuple(self._body(nodes or ()))

    def _body(self, nodes: Sequence[s.StatementNode]) -> Iterator[p.Statement]:
        at = 0
        while at < len(nodes):
            node = nodes[at]
            # At the end of a line: it has the span of the statement there.
            if at and isinstance(node, s.CommentLine) and node.trailing:
                yield p.Comment(node.text, span=nodes[at - 1].span)
                at += 1
                continue
            # Several statements that lowering writes for one are read back as one.
            for count, read in ((3, self._loaded_call), (2, self._timer)):
                said = read(nodes[at : at + count])
                if said is not None:
                    yield said
                    at += count
                    break
            else:
                yield from self._statement(nodes[at])
                at += 1

    def _statement(self, node: s.StatementNode) -> Iterator[p.Statement]:
        span, original, expression = node.span, self._original, self._expression
        if id(node) in self._kept:
            yield replace(opaque(node), reason=e.Reason(self._kept[id(node)], _BY_COMPONENTS))
            return
        match node:
            case s.CommentLine(text):
                yield p.Comment(text, span=span)
            case s.MoveRunNode():
                yield from self._paths.statements(node, self._meaning.motion)
            case s.Assignment(target, value) if not isinstance(target, s.Placeholder):
                turned = self._meaning.oriented(target, value)
                if isinstance(turned, e.Apply):
                    yield p.Assign(turned.arguments[0], turned, span=span)
                else:
                    yield p.Assign(expression(target), expression(value), span=span)
            case s.GotoLabel(label):
                yield p.Goto(original(label), span=span)
            case s.LabelMark(name):
                yield p.Label(original(name), span=span)
            case s.ReturnFrom(value):
                yield p.Return(None if value is None else expression(value), span=span)
            case s.Word("EXIT"):
                yield p.Stop(end=True, span=span)
            case s.IfThen(branches, otherwise) if all(b.condition is not None for b in branches):
                lifted = [
                    p.Branch(expression(b.condition), self.block(b.body))
                    for b in branches
                    if b.condition is not None
                ]
                yield p.If(tuple(lifted), self.block(otherwise), span=span)
            case s.CompactIf(condition, inner):
                body = tuple(self._statement(inner))
                yield p.If((p.Branch(expression(condition), body),), span=span)
            case s.ForLoop(variable, first, last, step, inner):
                bounds = expression(first), expression(last)
                known = map(self._meaning.known, bounds)
                # Without STEP the direction depends on the bounds; None leaves it to the target
                # language.
                upwards = {True: p.ONE, False: e.Number(-1), None: None}[ascends(*known)]
                by = upwards if step is None else expression(step)
                yield p.For(original(variable), *bounds, self.block(inner), by, span=span)
            case s.WhileLoop(condition, inner):
                yield p.While(expression(condition), self.block(inner), span=span)
            case s.TestOf(subject, cases, otherwise) if all(c.values for c in cases):
                chosen = tuple(
                    p.Case(tuple(map(expression, c.values)), self.block(c.body)) for c in cases
                )
                yield p.Switch(expression(subject), chosen, self.block(otherwise), span=span)
            case s.ProcedureCall(name=str()):
                yield replace(self._call(node), span=span)
            case s.Connect():
                yield replace(opaque(node), reason=INTERRUPTS)
            case _:
                yield opaque(node)

    def _call(self, node: s.ProcedureCall) -> p.Statement:
        name = str(node.name)
        # A procedure of the user hides an instruction of that name.
        if name.lower() in _STANDARD and name.lower() not in self._procedures:
            kept = replace(opaque(node), reason=_INSTRUCTION_REASONS.get(name.lower()))
            return lift_instruction(node, self._meaning) or kept
        given = self._given(node)
        return opaque(node) if given is None else p.Call(self._original(name), given)

    def _given(self, node: s.ProcedureCall) -> tuple[e.Expression, ...] | None:
        call = called(node)
        if call is None or call.options:
            return None
        return tuple(self._expression(argument) for argument in call.given if argument is not None)

    def _timer(self, nodes: Sequence[s.StatementNode]) -> p.StartTimer | None:
        """`ClkReset c; ClkStart c;` as one, if the clock is nothing but restarted and read."""
        clock = restarted_clock(nodes)
        if clock is None or clock.name.lower() not in self._meaning.timers:
            return None
        return p.StartTimer(
            self._original(clock.name), span=span_over(nodes[0].span, nodes[1].span)
        )

    def _loaded_call(self, nodes: Sequence[s.StatementNode]) -> p.Call | None:
        r"""`Load \Dynamic, "HOME:/u.mod"; %"name"% …; UnLoad "HOME:/u.mod";` as one call."""
        match nodes:
            case (
                s.ProcedureCall(
                    str(load),
                    (s.Option(option, None), s.Positional(s.StringLiteral(file), None)),
                ) as first,
                s.ProcedureCall(s.StringLiteral(name)) as call,
                s.ProcedureCall(str(unload), (s.Positional(s.StringLiteral(same), None),)) as last,
            ) if (load.lower(), option.lower(), unload.lower()) == ("load", "dynamic", "unload"):
                module, given = _LOADED.fullmatch(file), self._given(call)
                if module is None or given is None or file != same or not _WORD.fullmatch(name):
                    return None
                unit, span = self._original(module[1]), span_over(first.span, last.span)
                return p.Call(self._original(name), given, unit, span=span)
        return None


def _opaque_text(text: str) -> p.Opaque:
    return p.Opaque(verbatim.LANGUAGE, text, effect=verbatim.effect_of_text(text, "statement"))


def opaque(node: s.StatementNode) -> p.Opaque:
    return _opaque(node, verbatim.of_node(node, "statements"))


def handler(node: s.Handler) -> p.Opaque:
    return _opaque(node, verbatim.of_node(node, "handlers"))


def _opaque(node: s.Node, text: str) -> p.Opaque:
    effect = verbatim.effect_of_nodes((node,), text)
    return p.Opaque(verbatim.LANGUAGE, text, span=node.span, effect=effect)


TRIGGER_REASONS: Final = Reasons(
    special=e.Reason(
        "what happens on the way of the move is not only that one output is given a number there",
        r"set an output by TriggIO or TriggEquip with \DOp, \GOp or \AOp and no more options",
    ),
    uncertain=e.Reason(
        "which output the move sets where depends on how the program came here",
        "set the triggdata up with plain numbers, in the statements before the move",
    ),
    move=e.Reason(
        "the move states more than its speed, zone, tool and work object",
        "leave out its other options",
    ),
)


class TriggerReader:
    """Reader of vendor statements about triggers. own: returns True for the lower-case name of a
    user's routine.
    """

    def __init__(self, meaning: NameResolver, own: Callable[[str], bool]) -> None:
        self.meaning, self.own = meaning, own

    def told(self, kept: VendorText) -> Told | None:
        """Return the role of a vendor text for outputs during moves."""
        match _trigger_node(kept):
            case s.Data(storage=storage, type=type, name=name) as node if (
                type.lower() == TRIGGER_TYPE
            ):
                plain = storage == "VAR" and node.scope != "TASK" and not node.dimensions
                inside = not isinstance(kept, Declaration)
                return TriggerData(name.lower(), plain, own=inside or node.scope == "LOCAL")
            case s.ProcedureCall(str(word)) as node if word.lower() in TRIGGER_MOVES:
                return self._taking(TRIGGER_MOVES[word.lower()], node)
            case s.ProcedureCall(str(word)) as node if name := trigger_set_up(node):
                return self._set_up(TRIGGER_SETUPS[word.lower()], name, node)
        return None

    def _taking(self, known: TriggerMove, node: s.ProcedureCall) -> TriggeredMove:
        """Read a trigger move; it is translated only if it takes plain variables alone."""
        call, names = called(node), tuple(one.name.lower() for one in triggers_taken(node))
        if call is None:
            return TriggeredMove(names, None)
        given = [*call.given[: known.place], *call.given[known.place + 1 :]]
        options = {name: x for name, x in call.options.items() if name not in FURTHER_TRIGGERS}
        # Every further option with a triggdata must have given a name.
        plain = len(names) == 1 + len(call.options) - len(options)
        move = lift_call(Called(known.plain, given, options), self.meaning) if plain else None
        return TriggeredMove(names, move if isinstance(move, p.MoveStatement) else None)

    def _set_up(self, known: TriggerSetup, name: str, node: s.ProcedureCall) -> TriggerSetUp:
        """Read a trigger set-up; it is translated for one output without further options or
        functions of the user.

        Such functions must be called once, at that position.
        """
        call, calls = called(node), (x for x in nodes(node) if isinstance(x, s.FunctionCall))
        # A function of the user may have effects, which moving the set-up to the move would repeat
        # or shift.
        if call is None or any(self.own(x.name.lower()) for x in calls):
            return TriggerSetUp(name)
        kinds = [kind for option, kind in TRIGGER_OUTPUTS.items() if option in call.options]
        signals = [x for option, x in call.options.items() if option in TRIGGER_OUTPUTS]
        measures = [option for option in call.options if option in known.measures]
        alone = len(call.options) == len(signals) + len(measures) and len(measures) <= 1
        given = [one for one in call.given if one is not None]
        match signals:
            case [s.NameRef(signal)] if alone and len(given) == known.count:
                _, amount, *delay, value = map(self.meaning.expression, given)
                measure = TRIGGER_MEASURES["".join(measures)]
                values = (value, amount, *delay)
                trigger = p.Trigger(
                    self.meaning.original(signal), value, amount, measure, None, *delay
                )
                fixed = all(isinstance(self.meaning.known(x), e.Number) for x in values)
                return TriggerSetUp(name, trigger, Signal(kinds[0], "output"), fixed)
        return TriggerSetUp(name)


def _trigger_node(kept: VendorText) -> Any:
    """The one declaration or statement that a text is, if it has to do with triggers."""
    # Looking for the word first spares the parse of most texts.
    if kept.language != verbatim.LANGUAGE or "trigg" not in kept.text.lower():
        return None
    read: Callable[[str], tuple[s.Node, ...]] = (
        verbatim.items if isinstance(kept, Declaration) else verbatim.statements
    )
    match verbatim.understood(read, kept.text):
        case (node,):
            return node
    return None
