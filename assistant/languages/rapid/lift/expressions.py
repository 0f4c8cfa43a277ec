"""Expressions of RAPID as the pseudo-program's; what it has no word for stays verbatim."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from assistant.languages.rapid.tables.operators import AS_FUNCTIONS, BINARY
from assistant.languages.rapid.tables.words import BITS, COMPONENTS, FUNCTIONS, UNUSED
from assistant.languages.rapid.text import effects
from assistant.languages.rapid.text.printer import expression as printed
from assistant.languages.rapid.text.verbatim import LANGUAGE
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number
from assistant.program import expressions as e
from assistant.program import rotations
from assistant.program.geometry import (
    BASE,
    FLANGE,
    UNUSED_AXIS,
    Configuration,
    JointTarget,
    Pose,
    Target,
)
from assistant.program.path import configuration_of
from assistant.robots.configurations import from_confdata

_OPERATORS: Final = {row[0]: name for name, row in BINARY.items()}
_FUNCTIONS: Final = {rapid.lower(): name for name, rapid in FUNCTIONS.items()}
_BITS: Final = {rapid.lower(): name for name, rapid in BITS.items()}
_POWERS: Final = {rapid.lower(): operator for operator, rapid in AS_FUNCTIONS.items()}
_COMPONENTS: Final = {pair: name for name, pair in COMPONENTS.items()}
ARITY: Final = {
    "atan2": (2,),
    "min": (2,),
    "max": (2,),
    "offset": (4,),
    "fixed": (2,),
    "part": (3,),
}
"""Arguments that a function must have to be the pseudo-program's own; 1 if not named."""

READS: Final = frozenset(("dinput", "doutput", "ginput", "goutput", "ainput", "aoutput"))
"""Functions that give what a signal's name says by itself (RAPID reference manual)."""

Original = Callable[[str], str]


def lift(node: s.Expression, original: Original) -> e.Expression:
    """original: gives a shortened name back."""
    simple = _literal(node)
    if simple is not None:
        return simple
    match node:
        case s.StringLiteral(value):
            return e.Text(value)
        case s.BoolLiteral(value):
            return e.Truth(value)
        case s.NameRef(name):
            return e.Name(original(name))
        case s.Group(inner):
            return lift(inner, original)
        case s.AggregateNode(items):
            return aggregate(tuple(lift(i, original) for i in items))
        case s.Component(s.Component(value, part), name):
            known = _COMPONENTS.get((part.lower(), name.lower()))
            if known is not None and not isinstance(value, s.Placeholder):
                return e.Member(lift(value, original), known)
            if name.lower() not in COMPONENTS:
                return e.Member(lift(node.value, original), name)
        case s.Component(value, name) if name.lower() not in COMPONENTS:
            if not isinstance(value, s.Placeholder):
                return e.Member(lift(value, original), name)
        case s.Element(value, indices) if not isinstance(value, s.Placeholder):
            if not any(isinstance(i, s.Whole) for i in indices):
                lifted = [lift(i, original) for i in indices if not isinstance(i, s.Whole)]
                return e.Index(lift(value, original), tuple(lifted))
        case s.Prefix("NOT", operand):
            return e.Unary("not", lift(operand, original))
        case s.Prefix("-", operand):
            return negative(lift(operand, original))
        case s.Prefix("+", operand):
            return lift(operand, original)
        case s.Infix(operator, left, right) if operator in _OPERATORS:  # or mistaken, as `:=`
            name_ = _OPERATORS[operator]
            return e.Binary(name_, lift(left, original), lift(right, original))  # type: ignore[arg-type]
        case s.FunctionCall():
            return _call(node, original)
    return kept(node)


def kept(node: s.Expression) -> e.Verbatim:
    """An expression as its text."""
    text = printed(node)
    return e.Verbatim(LANGUAGE, text, effect=effects.of_nodes((node,), text))


def negative(operand: e.Expression) -> e.Expression:
    if isinstance(operand, e.Number):
        return e.Number(-operand.value if operand.value else operand.value)
    return e.Unary("-", operand)


def aggregate(items: tuple[e.Expression, ...]) -> e.Expression:
    """Values in brackets: a target, joint target or pose if they have its form."""
    shape: list[int] = []
    values: list[list[float]] = []
    for item in items:
        if not isinstance(item, e.Aggregate):
            return e.Aggregate(items)
        numbers = [n.value for n in item.items if isinstance(n, e.Number)]
        if len(numbers) != len(item.items):
            return e.Aggregate(items)
        shape.append(len(numbers))
        values.append([float(n) for n in numbers])
    if shape == [3, 4, 4, 6] and any(values[1]):
        return e.TargetValue(target([v for part in values for v in part]))
    if shape == [6, 6]:
        return e.JointValue(JointTarget(tuple(values[0]), external(values[1])))
    if shape == [3, 4] and any(values[1]):
        return e.PoseValue(pose(values[0], values[1]))
    return e.Aggregate(items)


def _literal(node: s.Expression) -> e.Expression | None:
    number = literal_number(node)
    return None if number is None else e.Number(number if number else 0)


def _call(node: s.FunctionCall, original: Original) -> e.Expression:
    name = node.name.lower()
    options = {a.name.lower(): a.value for a in node.arguments if isinstance(a, s.Option)}
    plain = [a for a in node.arguments if isinstance(a, s.Positional) and a.name is None]
    if len(plain) + len(options) != len(node.arguments):
        return kept(node)
    if any(value is None for value in options.values()):
        return kept(node)
    given = tuple(lift(a.value, original) for a in plain)
    turned = {k: lift(v, original) for k, v in options.items() if v is not None}
    if name == "reltool" and len(given) == 4:
        if not turned:
            return e.Apply("relative", given)
        if set(turned) <= {"rx", "ry", "rz"}:
            turns = tuple(turned.get(k, e.Number(0)) for k in ("rx", "ry", "rz"))
            return e.Apply("relative", given + turns)
    if name == "crobt" and not given:
        return here(node, original) or kept(node)
    if turned:
        return kept(node)
    if name == "dnumtonum" and (bits := _bits(node, original)) is not None:
        return bits
    if name == "cjointt" and not given:
        return e.Apply("joints_here")
    if name == "distance" and len(plain) == 2:
        points = [_whole_target(a.value, original) for a in plain]
        if all(p is not None for p in points):
            return e.Apply("distance", tuple(p for p in points if p is not None))
        return kept(node)
    if name in READS and len(given) == 1:
        return given[0] if isinstance(given[0], e.Name) else kept(node)
    if name == "testdi" and len(given) == 1:
        return e.Binary("=", given[0], e.Number(1))
    if name in _POWERS and len(given) == 2:
        return e.Binary(_POWERS[name], *given)  # type: ignore[arg-type]
    if name in _FUNCTIONS:
        known = _FUNCTIONS[name]
        return e.Apply(known, given) if len(given) in ARITY.get(known, (1,)) else kept(node)
    if name in ("reltool", "crobt", "cjointt", "distance", "pow", "posemult"):
        return kept(node)
    if original(node.name) in e.FUNCTIONS:
        return kept(node)
    return e.Apply(original(node.name), given)


def _bits(node: s.FunctionCall, original: Original) -> e.Apply | None:
    """The bits of two numbers: they go to wide ones, and what becomes of them back."""
    match node.arguments:
        case (
            s.Positional(
                s.FunctionCall(
                    function,
                    (
                        s.Positional(s.FunctionCall(one, (s.Positional(left, None),)), None),
                        s.Positional(s.FunctionCall(two, (s.Positional(right, None),)), None),
                    ),
                ),
                None,
            ),
        ) if function.lower() in _BITS and one.lower() == two.lower() == "numtodnum":
            return e.Apply(_BITS[function.lower()], (lift(left, original), lift(right, original)))
    return None


def here(
    node: s.FunctionCall, original: Original, tool: str | None = None, frame: str | None = None
) -> e.Here | None:
    """What `CRobT` reads, None if it does not say so and it is not known.

    tool, frame: those of the move before, which hold for an argument that is left out (RAPID
    reference manual, CRobT).
    """
    known: dict[str, str | None] = {"tool": tool, "wobj": frame}
    for argument in node.arguments:
        match argument:
            case s.Option(option, s.NameRef(name)) if option.lower() in known:
                known[option.lower()] = original(name)
            case _:
                return None
    tool, frame = known["tool"], known["wobj"]
    return None if tool is None or frame is None else e.Here(tool_name(tool), frame_name(frame))


def tool_name(name: str) -> str:
    return FLANGE if name.lower() == FLANGE else name


def frame_name(name: str) -> str:
    return BASE if name.lower() in ("", "wobj0", BASE) else name


def _whole_target(node: s.Expression, original: Original) -> e.Expression | None:
    if isinstance(node, s.Component) and node.name.lower() == "trans":
        return None if isinstance(node.value, s.Placeholder) else lift(node.value, original)
    return None


def external(values: Sequence[float]) -> tuple[float, ...]:
    return tuple(UNUSED_AXIS if v >= UNUSED else v for v in values)


def pose(position: Sequence[float], quaternion: Sequence[float]) -> Pose:
    import numpy as np

    return Pose.of(np.array(position, dtype=np.float64), rotations.canonical(quaternion))


def target(values: Sequence[float]) -> Target:
    """From the 17 numbers of a robtarget whose quaternion is not zero."""
    configuration: Configuration | None = None
    if all(-127 <= v <= 127 and v == int(v) for v in values[7:11]):
        configuration = configuration_of(from_confdata([values[7:11]])[0])
    return Target(pose(values[:3], values[3:7]), configuration, external(values[11:17]))
