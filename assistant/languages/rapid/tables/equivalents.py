"""Statements, functions, operators, speeds and zones that RAPID shares with the pseudo-program.

One row for each statement or function, read in both directions: the lift takes RAPID to the
pseudo-program by it, lowering goes back. Speeds and zones are translated between physical values
(mm/s, mm, degrees) and RAPID's names and records: `v100`, `z10`, `speed_147`, `zone_2_5`. Operators
have a level each, how tightly they bind, so that parentheses are written where they are needed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from assistant.languages.patterns import FunctionRow, MotionRow, Row, Rows, pattern
from assistant.languages.rapid.tables import constants
from assistant.languages.rapid.tables.constants import SPEED_CAP, usual_sizes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.expressions import Binary, Expression, Number, Truth
from assistant.program.motion import Blend, Speed, ValueNames
from assistant.program.statements import ComputedBlend

_MOTION_ARGUMENTS: Final = r"{speed}, {blend}, {tool} \WObj:={frame:other?} \TLoad:={load?}"
"""A `TLoad` of load0 leaves the load to the tool (RAPID reference manual, MoveL)."""
_TEXT: Final = e.Name("{text}")
_TARGET, _BY = e.Name("{target}"), e.Name("{by}")
_ZERO, _ONE = e.Number(0), e.Number(1)

STATEMENT_ROWS: Final = Rows(
    MotionRow(f"MoveJ {{target:value}}, {_MOTION_ARGUMENTS}", p.Move, kind="joint"),
    MotionRow(f"MoveL {{target:value}}, {_MOTION_ARGUMENTS}", p.Move, kind="linear"),
    MotionRow(f"MoveC {{via}}, {{target:value}}, {_MOTION_ARGUMENTS}", p.MoveCircular),
    MotionRow(f"MoveAbsJ {{target:value}}, {_MOTION_ARGUMENTS}", p.MoveJoints),
    Row("WaitTime {seconds}", p.Wait),
    Row(r"WaitUntil {condition} \MaxTime:={timeout?}", p.WaitUntil),
    Row(r"WaitDI {signal:digital input}, {value} \MaxTime:={timeout?}", p.WaitSignal),
    Row(r"WaitDO {signal:digital output}, {value} \MaxTime:={timeout?}", p.WaitSignal),
    Row(r"WaitGI {signal:group input}, {value} \MaxTime:={timeout?}", p.WaitSignal),
    Row(r"WaitGO {signal:group output}, {value} \MaxTime:={timeout?}", p.WaitSignal),
    # Rows are tried in order: an output that opens a hand is a gripper, not a plain signal.
    Row("SetDO {hand}, 1", p.Gripper, action="open"),
    Row("SetDO {hand}, 0", p.Gripper, action="close"),
    Row("SetDO {signal:digital}, {value}", p.SetSignal),
    Row("SetAO {signal:analog}, {value}", p.SetSignal),
    Row("SetGO {signal:group}, {value}", p.SetSignal),
    Row(r"PulseDO \High \PLength:={pulse=0.2}, {signal}", p.SetSignal, value=_ONE),
    Row("AccSet {acceleration}, 100", p.SetAcceleration, deceleration=e.Name("{acceleration}")),
    Row(f"VelSet {{percent}}, {SPEED_CAP}", p.SetOverride),
    Row("Stop", p.Stop),
    # Read only: lowering writes the first row that fits.
    also=(
        MotionRow(rf"MoveAbsJ {{target:robot}} \NoEOffs, {_MOTION_ARGUMENTS}", p.MoveJoints),
        Row("TPWrite {text}", p.Message, parts=(_TEXT,)),
        *(
            Row(
                rf"TPWrite {{text}} \{option}:={{shown}}",
                p.Message,
                parts=(_TEXT, e.Apply("text", (e.Name("{shown}"),))),
            )
            for option in ("Num", "Bool", "Pos", "Orient", "Dnum")
        ),
        Row("Set {hand}", p.Gripper, action="open"),
        Row("Reset {hand}", p.Gripper, action="close"),
        Row("Set {signal}", p.SetSignal, value=_ONE),
        Row("Reset {signal}", p.SetSignal, value=_ZERO),
        Row("Incr {target}", p.Assign, value=e.Binary("+", _TARGET, _ONE)),
        Row("Decr {target}", p.Assign, value=e.Binary("-", _TARGET, _ONE)),
        Row("Add {target}, {by}", p.Assign, value=e.Binary("+", _TARGET, _BY)),
        Row("Clear {target}", p.Assign, value=_ZERO),
    ),
)


FUNCTION_ROWS: Final = Rows(
    FunctionRow("abs", "Abs({x})"),
    FunctionRow("sqrt", "Sqrt({x})"),
    FunctionRow("sin", "Sin({x})"),
    FunctionRow("cos", "Cos({x})"),
    FunctionRow("tan", "Tan({x})"),
    FunctionRow("asin", "ASin({x})"),
    FunctionRow("acos", "ACos({x})"),
    FunctionRow("atan", "ATan({x})"),
    FunctionRow("atan2", "ATan2({y}, {x})"),
    FunctionRow("exp", "Exp({x})"),
    FunctionRow("round", "Round({x})"),
    FunctionRow("trunc", "Trunc({x})"),
    FunctionRow("min", "Min({a}, {b})"),
    FunctionRow("max", "Max({a}, {b})"),
    FunctionRow("text", "ValToStr({x})"),
    FunctionRow("fixed", "NumToStr({x}, {decimals})"),
    FunctionRow("part", "StrPart({text}, {first}, {count})"),
    FunctionRow("length", "StrLen({text})"),
    # StrToByte takes a text of one character.
    FunctionRow("code", r"StrToByte(StrPart({text}, 1, 1) \Char)"),
    FunctionRow("character", r"ByteToStr({number} \Char)"),
    FunctionRow("offset", "Offs({point}, {x}, {y}, {z})"),
    FunctionRow("inverse", "PoseInv({pose})"),
    FunctionRow("relative", "RelTool({point}, {x}, {y}, {z})"),
    FunctionRow("relative", r"RelTool({point}, {x}, {y}, {z} \Rx:={rx=0} \Ry:={ry=0} \Rz:={rz=0})"),
    FunctionRow("distance", "Distance({a:position}, {b:position})"),
    FunctionRow("joints_here", "CJointT()"),
    FunctionRow("time_of_day", "CTime()"),
    # of whole numbers up to 52 bits; those of a byte have other names
    FunctionRow("bitand", "DnumToNum(BitAndDnum(NumToDnum({a}), NumToDnum({b})))"),
    FunctionRow("bitor", "DnumToNum(BitOrDnum(NumToDnum({a}), NumToDnum({b})))"),
    FunctionRow("bitxor", "DnumToNum(BitXOrDnum(NumToDnum({a}), NumToDnum({b})))"),
    Row("Pow({left}, {right})", e.Binary, operator="^"),
    Row("PoseMult({left}, {right})", e.Binary, operator="@"),
    *(
        Row(rf"EulerZYX(\{axis}, {{value:turned}})", e.Member, field=name)
        for axis, name in zip("XYZ", e.ANGLES, strict=True)
    ),
    Row("ClkRead({timer})", e.Elapsed),
    Row(r"CRobT(\Tool:={tool} \WObj:={frame})", e.Here),
    also=(Row("TestDI({left})", e.Binary, operator="=", right=e.Number(1)),),
)
CURRENT_TARGET: Final = pattern(r"CRobT(\Tool:={tool?} \WObj:={frame?})")
"""The same where it reads in the tool or frame of the move before (RAPID reference manual)."""

NO_OTHER: Final = frozenset(("dnumtonum", "testdi", "clkread"))
"""Functions with a row that in another form are calls like those of the user's own."""

ORIENTATION: Final = pattern("OrientZYX({about_z}, {about_y}, {about_x})")
ORIENTATION_COMPONENT: Final = "rot"
"""The component of a target or pose that is its orientation."""

ARM_FUNCTIONS: Final = {"flange_at": "CalcRobT", "joints_at": "CalcJointT"}
"""Functions that RAPID gives a tool, here always tool0."""
SIGNAL_FUNCTIONS: Final = frozenset(("dinput", "doutput", "ginput", "goutput", "ainput", "aoutput"))
"""Functions that return the same value as the signal's name alone (RAPID reference manual)."""


OR, AND, _RELATION, SUM, TERM, PRIMARY = range(6)
"""Precedence levels of expressions; one with a lower level than its position requires gets
parentheses.
"""

BINARY: Final[dict[str, tuple[str, int, int, int]]] = {
    # All operators group to the left: an equal level on the right needs parentheses. A relation
    # takes no relation on either side.
    "or": ("OR", OR, OR, AND),
    "xor": ("XOR", OR, OR, AND),
    "and": ("AND", AND, AND, _RELATION),
    **{o: (o, _RELATION, SUM, SUM) for o in e.RELATIONS},
    "+": ("+", SUM, SUM, TERM),
    "-": ("-", SUM, SUM, TERM),
    "*": ("*", TERM, TERM, PRIMARY),
    "/": ("/", TERM, TERM, PRIMARY),
    "div": ("DIV", TERM, TERM, PRIMARY),
    "mod": ("MOD", TERM, TERM, PRIMARY),
}
"""Operator → RAPID's, its own level, and the levels that its operands must have."""


_SPEED_NAMES: Final = {speed: name for name, speed in constants.SPEEDS.items()}
_ZONE_NAMES: Final = {blend: name for name, blend in constants.ZONES.items()}
_SPEED_PLACES: Final = 3
_FASTEST: Final = max(s.tcp for s in constants.SPEEDS.values() if math.isfinite(s.tcp))

_WIDEST_CHOSEN: Final = 10.0
"""mm of a corner without a size, at most: where it is known to lead along, somebody says so."""
_LEAST_CHOSEN: Final = 0.3
"""mm of one at a crawl: z0."""
_BRAKING: Final = 5000.0
"""mm/s², as much as arms brake by along a line: with less the way that it takes were longer."""


SPEED_PARTS: Final = ("v_tcp", "v_ori", "v_leax", "v_reax")
ZONE_SIZES: Final = (
    "pzone_tcp", "pzone_ori", "pzone_eax", "zone_ori", "zone_leax", "zone_reax"
)  # fmt: skip
"""Components of speeds, and those of zones that are not stop points (3HAC050917)."""


def speed_name(speed: Speed) -> str:
    """`v150` if predefined, else the name under which it is declared: `speed_147`."""
    first, *rest = speed_values(speed)
    # Other parts of the record belong to the name, so that two records never share one.
    usual = rest == speed_values(Speed(first))[1:]
    return _SPEED_NAMES.get(speed) or _record_name("speed", first, () if usual else rest)


def zone_name(blend: Blend) -> str:
    """`z100` or `fine` if predefined, else the name under which it is declared: `zone_2_5`."""
    return _ZONE_NAMES.get(blend) or _record_name("zone", blend.radius or 0.0, blend.details or ())


def _record_name(kind: str, first: float, more: Sequence[float]) -> str:
    """The name of a record by its values, of one with usual sizes by the first alone."""
    if not more:
        return f"{kind}_{_number_in_name(first)}"
    # `_` separates the values, so the decimal point becomes `d`: `1.5` and `1, 5` get different
    # names.
    return f"{kind}_" + "_".join(_number_in_name(v).replace("_", "d") for v in (first, *more))


def _number_in_name(value: float) -> str:
    return f"{value:.{_SPEED_PLACES}f}".rstrip("0").rstrip(".").replace(".", "_")


def speed_values(speed: Speed) -> list[float]:
    return [speed.tcp, speed.rotation, speed.external_linear, speed.external_rotary]


def zone_values(blend: Blend) -> list[float]:
    """Return the six sizes of a zonedata, zero for a stop point."""
    if blend.radius is None:
        return [0.0] * 6
    return [blend.radius, *(blend.details or usual_sizes(blend.radius))]


def speed_of(values: Sequence[float]) -> Speed:
    return Speed(*(float(v) for v in values))


def zone_of(stop: bool, values: Sequence[float]) -> Blend:
    """A zone without details if these are the usual ones of its radius."""
    if stop:
        return Blend()
    radius, a, b, c, d, e = map(float, values)
    details = (a, b, c, d, e)
    return Blend(radius, details=None if details == usual_sizes(radius) else details)


def computed_zone(stops: Expression, sizes: tuple[Expression, ...]) -> ComputedBlend:
    """A zone of six sizes that are worked out; without details if these are the usual ones."""
    radius, *details = sizes
    usual = tuple(details) == usual_details(radius)
    # A literal FALSE counts as no condition, as blends without one are compared with this.
    never = None if stops == Truth(False) else stops
    return ComputedBlend(radius, never, None if usual else tuple(details))


def usual_details(radius: Expression) -> tuple[Expression, ...]:
    """Sizes beside a radius that is worked out, in the proportion of the predefined zones."""
    length = Binary("*", radius, Number(1.5))
    angle = Binary("*", radius, Number(0.15))
    return length, length, angle, length, angle


def sayable_speed(speed: Speed) -> tuple[Speed, str | None]:
    """The speed as RAPID has it, and what was changed."""
    changed = None
    if speed.joint is not None:
        changed, speed = "a joint speed in percent", replace(speed, joint=None)
    if math.isinf(speed.tcp) and speed != Speed(math.inf):
        changed, speed = "an unlimited speed", replace(speed, tcp=_FASTEST)
    rounded = [v if math.isinf(v) else round(v, _SPEED_PLACES) for v in speed_values(speed)]
    return speed_of(rounded), changed


def corner_of(speed: Speed) -> float:
    """Radius in mm of a corner that the controller is to choose, for a move of that speed.

    A controller that chooses leaves the path where braking begins: v² / 2a, by BRAKING. The largest
    predefined size below that, so that the corner is never wider, and at most WIDEST_CHOSEN.
    """
    if not math.isfinite(speed.tcp):
        return _WIDEST_CHOSEN
    braking = speed.tcp * speed.tcp / (2.0 * _BRAKING)  # `**` would raise where that is too large
    sizes = (b.radius for b in constants.ZONES.values() if b.radius and b.radius <= _WIDEST_CHOSEN)
    return max((radius for radius in sizes if radius <= braking), default=_LEAST_CHOSEN)


def sayable_blend(blend: Blend) -> tuple[Blend, str | None]:
    """The blend as RAPID has it, and what was changed."""
    if blend.radius is None:
        return Blend(), None
    changed = None
    radius, details = blend.radius, blend.details
    if blend.exit is not None and blend.exit != blend.radius:
        # The smaller size keeps the path inside both; details of the larger one do not fit it.
        changed, radius, details = "a corner of two sizes", min(radius, blend.exit), None
    if math.isinf(radius):
        changed, radius, details = "a corner without size", _LEAST_CHOSEN, None
    radius = round(radius, _SPEED_PLACES)
    if details is not None:
        return zone_of(False, [radius, *(round(v, _SPEED_PLACES) for v in details)]), changed
    return Blend(radius), changed


SPEEDS: Final = ValueNames("speed", constants.SPEEDS, speed_name)
BLENDS: Final = ValueNames("blend", constants.ZONES, zone_name)
