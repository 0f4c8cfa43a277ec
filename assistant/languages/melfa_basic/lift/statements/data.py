"""Assignments and definitions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.melfa_basic.lift.statements.paths import Runs
from assistant.languages.melfa_basic.lift.values.expressions import ADDITIONAL, Expressions
from assistant.languages.melfa_basic.lift.values.operators import is_comparison
from assistant.languages.melfa_basic.lift.values.reasons import DELAYED_ASSIGNMENT, SLIDING_AXIS
from assistant.languages.melfa_basic.lift.values.symbols import (
    IO_BITS,
    SIGNAL_VARIABLES,
    Unliftable,
)
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.variables import VALUE_TYPES
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.timers import timer_number
from assistant.languages.melfa_basic.tree.walk import literal
from assistant.program import expressions as e
from assistant.program import statements as p
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
    runs.previous = None
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
    """Whether a number is given a truth: 1 where it holds, else 0."""
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
    """What outputs take of a value: the nearest whole number, and a group the low bits of it.

    Raises Unliftable where no manual tells what they take: of a half, and a bit of other numbers.
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
    """Declares variables, which is no statement of its own."""
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
