"""Assignments, definitions, channels and waits as statements of the pseudo-program.

An assignment goes to a signal, a component, an element or a variable. `Open`, `Print #`, `Input #`
and `Close` are channels. A wait may be written as a loop of jumps (see tree.control_flow); one
that ends with error 9100 has a time-out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, TypeVar

from assistant.base.diagnostics import Span
from assistant.languages.melfa_basic.lift.expressions import (
    ADDITIONAL,
    Expressions,
    is_comparison,
    seconds_of,
)
from assistant.languages.melfa_basic.lift.paths import Runs
from assistant.languages.melfa_basic.lift.procedures import Code
from assistant.languages.melfa_basic.lift.symbols import (
    IO_BITS,
    SIGNAL_VARIABLES,
    VENDOR_ONLY_NAME,
    Unliftable,
)
from assistant.languages.melfa_basic.lift.untranslatable_reasons import (
    DELAYED_ASSIGNMENT,
    SLIDING_AXIS,
)
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.variables import (
    FILE_MODES,
    FILE_NUMBERS,
    LINE_NAME,
    VALUE_TYPES,
)
from assistant.languages.melfa_basic.tree import control_flow
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import literal, timer_number
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program import undeclared_names
from assistant.program.program import Signal

_ANGLES: Final = {melfa: name for name, melfa in poses.ANGLES.items()}


def lift_assignment(node: s.Assign, lift: Expressions, runs: Runs) -> list[p.Statement]:
    """An assignment: to a signal, a component, an element or a variable."""
    target = node.target
    if _assigns_truth(node, lift):
        return [_truth_assignment(node, lift, runs)]
    if target.key == "M_HND" and lift.m.telling:
        return [_hand_assignment(node, lift)]
    if target.key in SIGNAL_VARIABLES or (
        target.key in lift.m.io and not lift.m.is_shadowed(target.key)
    ):
        return [_signal_assignment(node, lift)]
    timer = lift.m.timers.get(timer_number(target) or 0)
    if timer and literal(node.value) == 0 and not node.delay:
        return [p.StartTimer(timer)]
    if node.delay is not None:
        raise Unliftable(DELAYED_ASSIGNMENT)
    # The assignment may change the position variable at which the robot is.
    runs.changed(target.key)
    if target.component:
        return [_component_assignment(node, lift)]
    place = lift.plain(target)
    match place:
        case e.Apply("inverse", (e.Name() as frame,)):  # what `Base` is given
            return [p.Assign(frame, e.inverse(assigned_value(node, lift)))]
        case e.Name() | e.Index():
            return [p.Assign(place, assigned_value(node, lift))]
    raise Unliftable


def _hand_assignment(node: s.Assign, lift: Expressions) -> p.Gripper:
    """`M_Hnd(1)=1` opens a hand, 0 closes it."""
    given = node.target.arguments or ()
    number = lift.m.value(given[0]) if len(given) == 1 else None
    state = lift.m.value(node.value)
    if not isinstance(number, float) or state not in (0.0, 1.0) or node.delay is not None:
        raise Unliftable
    return p.Gripper("open" if state else "close", round(number))


def _assigns_truth(node: s.Assign, lift: Expressions) -> bool:
    """True if a truth is assigned to a number: 1 where it holds, else 0."""
    if lift.m.own or lift.type_of(node.target) not in ("number", "integer"):
        return False
    comparison = is_comparison(node.value)
    return comparison or (isinstance(node.value, s.Binary) and lift.is_truth(node.value))


def _truth_assignment(node: s.Assign, lift: Expressions, runs: Runs) -> p.If:
    if node.delay is not None:
        raise Unliftable(DELAYED_ASSIGNMENT)
    one, zero = (
        tuple(lift_assignment(replace(node, value=s.Number(v)), lift, runs)) for v in (1, 0)
    )
    return p.If((p.Branch(lift.truth(node.value), one),), zero)


def assigned_value(node: s.Assign, lift: Expressions) -> e.Expression:
    """The value of an assignment; constants mean what the variable's type says."""
    value, kind = node.value, lift.type_of(node.target)
    if isinstance(value, s.Constant):
        return lift.m.value_of(value, kind)
    if lift.m.own:
        return lift.of(value)
    if lift.type_of(value) == "truth" and kind != "truth":
        return lift.verbatim(value)  # a number of its own: 0 or 1
    made = lift.of(value)
    # A variable of whole numbers rounds what it is given.
    if kind == "integer" and not isinstance(made, e.Verbatim) and lift.type_of(value) == "number":
        whole = isinstance(made, e.Number) and float(made.value).is_integer()
        return made if whole else e.Apply("round", (made,))
    return made


def _component_assignment(node: s.Assign, lift: Expressions) -> p.Assign:
    target = node.target
    whole = lift.variable(s.Variable(target.name, target.suffix, target.arguments))
    if not isinstance(whole, e.Name | e.Index):
        raise Unliftable
    if target.component in ADDITIONAL:
        place = e.Member(whole, ADDITIONAL[target.component])
        if not (lift.m.own or lift.m.telling):
            raise Unliftable(SLIDING_AXIS)
        match node.value:
            case s.Binary("*", value, unit) if lift.is_unit(unit):
                return p.Assign(place, lift.of(value))
        return p.Assign(place, lift.of(node.value))
    member = e.Member(whole, _ANGLES.get(target.component, target.component.lower()))
    if poses.is_length(target.component, lift.m.robot):
        return p.Assign(member, lift.of(node.value))
    known = target.component in poses.JOINTS or target.component in _ANGLES
    if known and poses.is_angle(target.component, lift.m.robot):
        return p.Assign(member, lift.degrees(node.value))
    raise Unliftable


def _signal_assignment(node: s.Assign, lift: Expressions) -> p.SetSignal | p.Call:
    target = node.target
    masked = _masked_assignment(node, lift)
    if masked is not None:
        return masked
    if target.key in SIGNAL_VARIABLES:
        said = lift.plain(target)
        if isinstance(said, e.Apply):
            # A computed number: the call chooses the signal once it is lowered for other languages.
            kind, direction, bits = SIGNAL_VARIABLES[target.key]
            held = _output_value(node.value, Signal(kind, direction, 0, bits), lift)  # type: ignore[arg-type]
            delay = () if node.delay is None else (lift.of(node.delay),)
            return p.Call(said.function, (*said.arguments, held, *delay))
        if not isinstance(said, e.Name):
            raise Unliftable
        name = said.name
    else:
        name = lift.m.io_signal(target, "output")
    pulse = None if node.delay is None else lift.of(node.delay)
    given = node.value
    if pulse is not None and isinstance(known := lift.m.value(given), float) and not lift.m.own:
        given = s.Number(known)  # by a name that nothing changes: others pulse to 1 alone
    return p.SetSignal(name, _output_value(given, lift.m.signals[name], lift), pulse)


def _output_value(given: s.Expression, signal: Signal, lift: Expressions) -> e.Expression:
    """Return the part of a value that outputs take: the nearest integer, and for a group its low
    bits.

    Raises Unliftable where no manual states what they take: of a half, and for a bit of numbers
    other than 0 and 1.
    """
    value = lift.of(given)
    if signal.kind == "analog":
        return value
    if not isinstance(value, e.Number):
        plain = isinstance(value, e.Verbatim) or lift.type_of(given) != "number"
        return value if plain else lift.rounded(given)
    if float(value.value) % 1 == 0.5:
        raise Unliftable
    number = round(value.value)
    if signal.kind == "group":
        return e.Number(number & ((1 << signal.bits) - 1))
    if number not in (0, 1):
        raise Unliftable
    return e.Number(number)


def _masked_assignment(node: s.Assign, lift: Expressions) -> p.SetSignal | None:
    """`M_Out8(5)=(M_Out8(5) And &HF0) Or value`: the bits of the value alone."""
    match node.value:
        case s.Binary("OR", s.Binary("AND", same, s.Number(others)), value) if (
            same == node.target and node.delay is None and node.target.key in SIGNAL_VARIABLES
        ):
            kind, direction, width = SIGNAL_VARIABLES[node.target.key]
            mask = (1 << width) - 1 - int(others)
            bits = mask.bit_length()
            number = lift.m.value((node.target.arguments or (None,))[0])
            # A group begins at the lowest bit, so the mask has to be a run of bits from there.
            if kind != "group" or mask != (1 << bits) - 1 or not isinstance(number, float):
                return None
            match value:
                case s.Number(given) if 0 <= given <= mask:
                    pass
                case s.Binary("AND", inner, s.Number(same_mask)) if same_mask == mask:
                    value = inner
                case _:
                    return None
            name = lift.m.signal_at(kind, direction, bits, round(number))
            return p.SetSignal(name, _output_value(value, lift.m.signals[name], lift))
    return None


# -------------------------------------------------------------------------- definitions


def declare_variables(variables: Sequence[s.Variable], lift: Expressions) -> list[p.Statement]:
    """Declare variables, which adds no statement."""
    for variable in variables:
        if variable.arguments is not None and not lift.m.size_of(variable.key):
            raise Unliftable
        lift.m.name(s.Variable(variable.name, variable.suffix))
    return []


def lift_constant(node: s.Const, lift: Expressions) -> list[p.Statement]:
    """A constant of the program, with its value."""
    if node.type and node.type not in VALUE_TYPES:
        raise Unliftable
    value: Any = lift.m.value(node.value)
    name = lift.m.name(node.variable)
    if value is None or not isinstance(name, e.Name) or name.name not in lift.m.variables:
        raise Unliftable
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    made = e.Text(value) if isinstance(value, str) else e.Number(value)
    known = lift.m.variables[name.name]
    lift.m.variables[name.name] = replace(known, initial=made, storage="constant")
    return []


def lift_known_definition(is_known: bool) -> list[p.Statement]:
    """A name of inputs and outputs, or a function of one expression, if it was taken in before."""
    if not is_known:
        raise Unliftable
    return []


def io_bits(node: s.DefIo, lift: Expressions) -> tuple[int, int] | None:
    """Bits and first number of a name that `Def Io` gives; None if it is masked or unknown."""
    number = lift.m.value(node.number)
    bits = IO_BITS.get(node.type.upper())
    if node.mask is not None or bits is None or not isinstance(number, float):
        return None
    return bits, round(number)


_RECEIVING_FUNCTIONS = {
    "text": "received",
    "number": "received_number",
    "integer": "received_number",
}
"""Functions that read an item, by the type of the variable for it."""
_PRINTED_TYPES = ("text", "number", "integer")


def _channel_name(node: s.Expression | None, lift: Expressions) -> str:
    """The channel of a file's number."""
    value = None if node is None else lift.m.value(node)
    if not isinstance(value, float) or round(value) not in FILE_NUMBERS:
        raise Unliftable
    return undeclared_names.name_of_channel(round(value))


def lift_open(node: s.Open, lift: Expressions) -> list[p.Statement]:
    """A line by its number; a file only with a mode, which says that it is one."""
    channel, mode = _channel_name(node.number, lift), FILE_MODES.get(node.mode)
    if isinstance(node.name, s.String) and ":" in node.name.value:
        found = LINE_NAME.fullmatch(node.name.value)
        if found is None or node.mode:
            raise Unliftable
        return [p.Attach(channel, "line", (e.Number(int(found[1])),))]
    if mode is None:
        raise Unliftable
    return [p.Attach(channel, "file", (lift.plain(node.name),), mode)]


def lift_close(node: s.Close, lift: Expressions) -> list[p.Statement]:
    if not node.numbers:
        if not lift.m.telling or lift.m.opened is None:
            raise Unliftable
        return [p.Detach(undeclared_names.name_of_channel(number)) for number in lift.m.opened]
    return [p.Detach(_channel_name(number, lift)) for number in node.numbers]


def lift_print(node: s.Print, lift: Expressions) -> list[p.Statement]:
    """Parts that follow each other at once, or behind a comma in the next column."""
    channel = _channel_name(node.number, lift)
    goes_on = bool(node.items) and node.items[-1][1] is None
    given = [value for _, value in node.items if value is not None]
    marks = [mark for mark, _ in node.items[1:]]
    columns = any(mark != ";" for mark in marks)
    # Columns count from the beginning of the line, which an unfinished `Print` moves.
    if columns and (lift.m.goes_on or not lift.m.telling):
        raise Unliftable
    if len(given) + goes_on != len(node.items):
        raise Unliftable
    if any(lift.type_of(value) not in _PRINTED_TYPES for value in given):
        raise Unliftable
    parts = tuple(lift.plain(value) for value in given)
    if columns:
        texts = [lift.type_of(value) == "text" for value in given]
        pairs = zip(parts, texts, strict=True)
        parts = _in_columns(
            [x if is_text else e.Apply("text", (x,)) for x, is_text in pairs], marks
        )
    return [p.Send(channel, "piece" if goes_on else "line", parts)]


_PRINT_COLUMN: Final = 10
"""Characters of a column that a comma begins the next one of (COSIROP: PRINT)."""


def _in_columns(parts: Sequence[e.Expression], marks: Sequence[str]) -> tuple[e.Expression, ...]:
    """The parts with blanks up to the next column where a comma is between them."""
    made = list(parts[:1])
    for mark, part in zip(marks, parts[1:], strict=True):
        if mark == ",":
            made = [_padded_to_column(made)]
        made.append(part)
    return tuple(made)


def _padded_to_column(texts: Sequence[e.Expression]) -> e.Expression:
    if all(isinstance(one, e.Text) for one in texts):
        whole = "".join(one.value for one in texts if isinstance(one, e.Text))
        # Blanks up to the next multiple of the column.
        return e.Text(whole + " " * (-len(whole) % _PRINT_COLUMN))
    line = texts[0]
    for one in texts[1:]:
        line = e.Binary("+", line, one)
    return e.Apply(VENDOR_ONLY_NAME.format("in_next_column"), (line, e.Number(_PRINT_COLUMN)))


def lift_input(node: s.Input, lift: Expressions, runs: Runs) -> list[p.Statement]:
    """One item after the other."""
    channel, made = _channel_name(node.number, lift), list[p.Statement]()
    for variable in node.variables:
        function = _RECEIVING_FUNCTIONS.get(lift.type_of(variable) or "")
        place = lift.plain(variable)
        if function is None or variable.component or not isinstance(place, e.Name | e.Index):
            raise Unliftable
        made.append(p.Assign(place, e.Apply(function, (e.Text(channel),))))
    # A variable may be the position at which the robot is.
    for variable in node.variables:
        runs.changed(variable.key)
    return made


T = TypeVar("T", bound=p.Spanned)

_TIMEOUT_ERROR: Final = 9100
"""The error of a wait that took too long."""


def with_span(statement: T, span: Span | None) -> T:
    """The statement as one that stood there, if it does not know where it stood."""
    return statement if statement.span is not None else replace(statement, span=span)


def comment_text(comment: str) -> str:
    """A comment without its mark and outer blanks."""
    return comment[1:].strip() if comment.startswith("'") else comment[3:].strip()


def wait_at(
    code: Code, at: int, high: int, lift: Expressions, named: Mapping[str, int]
) -> tuple[p.Statement, int] | None:
    """A wait that begins at a line, and the line after it; None for anything else.

    named: how often jumps name each label, in upper case. Another one that leads there needs it.
    """
    if not isinstance(first := code[at], s.Line) or not _may_wait(first):
        return None
    for count, wait in ((6, _timed_wait), (3, _endless_wait)):
        lines = code[at : min(at + count, high)]
        if any(line.comment is not None for line in lines):
            continue  # a comment among them has its place
        labels = [line.label.upper() for line in lines if line.label is not None]
        if any(named[label] != 1 for label in labels):
            continue
        try:
            made = wait(lines, lift)
        except Unliftable:
            continue
        if made is not None:
            return made, at + count
    return None


def _may_wait(line: s.Line) -> bool:
    timer = isinstance(line.statement, s.Assign) and timer_number(line.statement.target) is not None
    return timer or (line.label is not None and bool(control_flow.WAIT_LABEL.fullmatch(line.label)))


def _endless_wait(lines: Sequence[object], lift: Expressions) -> p.Statement | None:
    found = control_flow.read_waiting_loop(lines)
    return None if found is None else wait_for(found[1], lift)


def _timed_wait(lines: Sequence[object], lift: Expressions) -> p.Statement | None:
    """`M_TIMER(1)=0`, `*W1`, `If condition Then *W1Z`, `If M_TIMER(1)<ms Then *W1`,
    `Error 9100`, `*W1Z`.
    """
    match lines:
        case (
            s.Line(label=None, statement=s.Assign(timer, s.Number(0), None)),
            s.Line(label=str() as name, statement=None),
            s.Line(label=None, statement=s.If(condition, s.Target(place=out), None)),
            s.Line(
                label=None,
                statement=s.If(s.Binary("<", clock, most), s.Target(place=again), None),
            ),
            s.Line(label=None, statement=s.Command("Error", (s.Number(number),))),
            s.Line(label=str() as last, statement=None),
        ) if (
            control_flow.WAIT_LABEL.fullmatch(name)
            and again == name
            and out == last == name + "Z"
            and number == _TIMEOUT_ERROR
            and timer_number(timer)
            and timer_number(timer) == timer_number(clock)
        ):
            return wait_for(condition, lift, _timeout_seconds(most, lift))
    return None


def _timeout_seconds(milliseconds: s.Expression, lift: Expressions) -> e.Expression:
    match milliseconds:
        case s.Number(value=value):
            return seconds_of(value)
        case s.Binary("*", left, s.Number(1000)):
            return lift.plain(left)
    raise Unliftable


def wait_for(
    condition: s.Expression, lift: Expressions, timeout: e.Expression | None = None
) -> p.Statement:
    """Until a signal has a value, or until any other condition holds."""
    held = lift.condition(condition)
    match held:
        case e.Binary("=", e.Name(name), e.Number() as value) if (
            name in lift.m.signals and lift.m.signals[name].kind != "analog"
        ):
            return p.WaitSignal(name, value, timeout)
    return p.WaitUntil(held, timeout)
