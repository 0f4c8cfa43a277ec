"""Expressions of the pseudo-program: numbers, booleans, strings, positions, signals.

An expression, statement or declaration that only one vendor's language can express is kept as its
text, with an `Effect`: what it reads, writes and calls. Passes ask the effect, not the words.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Set
from dataclasses import field
from typing import Final, Literal

from assistant.base.data_classes import dataclass
from assistant.base.source_text import words_of
from assistant.program.geometry import JointTarget, Pose, Target

VendorTextKind = Literal["statement", "expression", "declaration"]
"""Kind of a vendor text."""


@dataclass(frozen=True, slots=True)
class Effect:
    """Effect of a vendor statement where it is executed; an upper bound in case of doubt.

    Names are in lower case. reads: everything that it names. writes: data that it may change or
    declares. calls: routines of the user that it runs, whose effects are unknown here; the other
    fields cover those of the language. moves: True if it may move the robot. jumps: True if the
    program may continue elsewhere than after it. waits: True if it may last until an event, or for
    a time. For a declared routine, it is the effect of its body. Actions that happen only later, in
    an interrupt or an error handler, are in `reads`, but have no effect here.
    """

    reads: frozenset[str] = frozenset()
    writes: frozenset[str] = frozenset()
    calls: frozenset[str] = frozenset()
    moves: bool = False
    jumps: bool = False
    waits: bool = False

    @property
    def names(self) -> frozenset[str]:
        """Everything that it reads, changes or calls."""
        return self.reads | self.writes | self.calls

    def renamed(self, old: str, new: Set[str]) -> Effect:
        """With other names for one, where it occurs."""
        named = (self.reads, self.writes, self.calls)
        reads, writes, calls = (n - {old} | new if old in n else n for n in named)
        return Effect(reads, writes, calls, self.moves, self.jumps, self.waits)


@dataclass(slots=True)
class EffectBuilder:
    """An effect as it is put together; names in any case."""

    reads: set[str] = field(default_factory=set)
    writes: set[str] = field(default_factory=set)
    calls: set[str] = field(default_factory=set)
    moves: bool = False
    jumps: bool = False
    waits: bool = False

    def declare(self, *names: str) -> None:
        """Names of what begins to be there."""
        self.reads.update(name.lower() for name in names if name)
        self.writes.update(name.lower() for name in names if name)

    def effect(self) -> Effect:
        reads, writes, calls = (
            frozenset(name.lower() for name in names)
            for names in (self.reads, self.writes, self.calls)
        )
        return Effect(reads, writes, calls, self.moves, self.jumps, self.waits)


def combined_effect(effects: Iterable[Effect]) -> Effect:
    """Return the combined effect of several effects."""
    each = list(effects)
    return Effect(
        frozenset().union(*(one.reads for one in each)),
        frozenset().union(*(one.writes for one in each)),
        frozenset().union(*(one.calls for one in each)),
        any(one.moves for one in each),
        any(one.jumps for one in each),
        any(one.waits for one in each),
    )


def unknown_effect(text: str) -> Effect:
    """Return the effect of a text that cannot be analysed: it may do anything with the names in its
    words.
    """
    words = frozenset(words_of(text))
    return Effect(words, words, words, moves=True, jumps=True, waits=True)


BinaryOperator = Literal[
    "+", "-", "*", "/", "div", "mod", "^", "@",
    "=", "<>", "<", "<=", ">", ">=", "and", "or", "xor",
]  # fmt: skip
"""`@` composes poses; the other operators have their usual meaning, `and` … `xor` on truth
values.
"""

DEGREE: Final = math.pi / 180.0
"""Radian of a degree: an angle in radian is one in degrees multiplied by it."""
RELATIONS: Final = ("=", "<>", "<", "<=", ">", ">=")
LOGICAL: Final = ("and", "or", "xor")
_SUMS: Final = ("+", "-")
_PRODUCTS: Final = ("*", "/")
_WHOLE_QUOTIENTS: Final = ("div", "mod")
_SHIFTS: Final = ("<<", ">>")

UnaryOperator = Literal["-", "not"]


def needs_parentheses_for_readers(outer: str, inner: str) -> bool:
    """True if a reader may be mistaken on which of two operators a language works out first.

    Languages differ in it: `a MOD 3*45` is `(a MOD 3)*45` in one and `a MOD (3*45)` in the other.
    outer: the operator of the whole. inner: that of one of its operands.
    """
    if outer in LOGICAL:
        return inner in LOGICAL and inner != outer
    arithmetic = (*_SUMS, *_PRODUCTS, *_WHOLE_QUOTIENTS, *_SHIFTS)
    if outer not in arithmetic or inner not in arithmetic:
        return False
    return (
        inner in _WHOLE_QUOTIENTS
        or outer in _WHOLE_QUOTIENTS
        or (outer in _SHIFTS) != (inner in _SHIFTS)
    )


FUNCTIONS: Final[dict[str, str]] = {
    "abs": "absolute value",
    "sqrt": "square root",
    "sin": "sine of degrees",
    "cos": "cosine of degrees",
    "tan": "tangent of degrees",
    "asin": "arc sine in degrees",
    "acos": "arc cosine in degrees",
    "atan": "arc tangent in degrees",
    "atan2": "angle of (y, x) in degrees",
    "exp": "e to the power",
    "ln": "natural logarithm",
    "round": "nearest whole number",
    "trunc": "whole number towards zero",
    "floor": "whole number below",
    "min": "smallest",
    "max": "largest",
    "bitand": "bits that two whole numbers, 0 or more, both have",
    "bitor": "bits that either of two whole numbers, 0 or more, has",
    "bitxor": "bits that one alone of two whole numbers, 0 or more, has",
    "text": "a value as text",
    "fixed": "a number as text with so many decimals",
    "length": "characters in a text",
    "part": "of a text, from a place counted from 1, so many characters",
    "code": "number of the first character of a text, which has one",
    "character": "text of one character by its number from 0 to 255",
    "offset": "target moved by x, y, z mm in its frame",
    "relative": "target moved by x, y, z mm and turned by rx, ry, rz degrees in its tool frame",
    "oriented": "target with other angles about x, y and z: see `Member`",
    "distance": "mm between two targets",
    "inverse": "inverse of a pose",
    "here": "present target: of the tool in the frame, both by name",
    "joints_here": "present joint target",
    "flange_at": "where joints bring the flange, in the robot's base",
    "joints_at": "joints that bring the flange to a target in the robot's base",
    "date_today": "the date as text: 2026/01/31",
    "time_of_day": "what the clock shows as text: 13:01:30",
    "connected": "1 where somebody is at the other end of a channel, by its name, else 0",
    "received": "the next text of a channel, by its name, up to a comma or the end of a line",
    "received_number": "the same as a number",
    "broken_off": "1 where the last move with an `until` was broken off, else 0",
    "elapsed": "seconds since a timer was started",
}
"""The functions of the pseudo-program; a call of another name is a call of the user's own."""

CHANGING: Final = (
    *("here", "joints_here", "date_today", "time_of_day", "connected", "broken_off", "elapsed"),
)
"""Functions that may give something else each time, though nothing is assigned."""
TAKING: Final = ("received", "received_number")
"""Functions that wait, and give something else each time."""


@dataclass(frozen=True, slots=True)
class Number:
    value: float | int


def number_of(value: float) -> Number:
    """A number, without a point where it is whole."""
    return Number(int(value) if float(value).is_integer() else value)


def plain_number(value: Expression) -> float | None:
    """The number that is written out, with or without a sign; None for anything else."""
    match value:
        case Number(number):
            return float(number)
        case Unary("-", Number(number)):
            return -float(number)
    return None


@dataclass(frozen=True, slots=True)
class Truth:
    value: bool


@dataclass(frozen=True, slots=True)
class Text:
    value: str


@dataclass(frozen=True, slots=True)
class Name:
    """A variable, constant, target, joint target, speed, blend or signal of that name."""

    name: str


@dataclass(frozen=True, slots=True)
class TargetValue:
    target: Target


@dataclass(frozen=True, slots=True)
class JointValue:
    target: JointTarget


@dataclass(frozen=True, slots=True)
class PoseValue:
    pose: Pose


@dataclass(frozen=True, slots=True)
class Aggregate:
    """Values in brackets: an array, or a record whose type the context says."""

    items: tuple[Expression, ...]


ANGLES: Final = ("about_x", "about_y", "about_z")
"""Components of a position that are angles, see `Member`."""
EXTERNAL: Final = tuple(f"external_{number}" for number in range(1, 7))
"""Components of targets and joints that are places of external axes, see `Member`."""
NEVER_GIVEN: Final = Aggregate(())
"""Missing first value of an array element: to use it before it is set is an error."""


@dataclass(frozen=True, slots=True)
class Member:
    """A component: `x y z` of a position, `j1` … of joints, or a record's own.

    `about_x about_y about_z` are the degrees that a position is turned about z, then about the new
    y, then about the new x. To read them gives -180 to 180, and -90 to 90 for y.
    `external_1` … `external_6` are the places of external axes, of targets and joints: mm, or
    degrees of one that turns.
    """

    value: Expression
    field: str


@dataclass(frozen=True, slots=True)
class Index:
    """An array element; indices count from 1."""

    value: Expression
    indices: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Unary:
    operator: UnaryOperator
    operand: Expression


@dataclass(frozen=True, slots=True)
class Binary:
    operator: BinaryOperator
    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class Apply:
    """A function call: one of `FUNCTIONS` or a function of the program."""

    function: str
    arguments: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class Elapsed:
    """Seconds since the timer of that name was started; undefined before."""

    timer: str


@dataclass(frozen=True, slots=True)
class Here:
    """The present target: of the tool in the frame, both by name."""

    tool: str
    frame: str


@dataclass(frozen=True, slots=True)
class Reason:
    """why: a clause on what keeps a statement from being said otherwise. cure: what to do.

    serves: it stays for the sake of others that stay, and would not be there without them.
    """

    why: str
    cure: str
    serves: bool = False


@dataclass(frozen=True, slots=True)
class Verbatim:
    """An expression that only one vendor language can express, as its text.

    reason: why it is not translated, None if unknown. effect: its effect, None if it was not
    analysed. told: its form for other languages. These three are not part of its meaning.
    """

    language: str
    text: str
    reason: Reason | None = field(default=None, compare=False, repr=False, kw_only=True)
    effect: Effect | None = field(default=None, compare=False, repr=False, kw_only=True)
    told: Expression | None = field(default=None, compare=False, repr=False, kw_only=True)


Expression = (
    Number
    | Truth
    | Text
    | Name
    | TargetValue
    | JointValue
    | PoseValue
    | Aggregate
    | Member
    | Index
    | Unary
    | Binary
    | Apply
    | Elapsed
    | Here
    | Verbatim
)


def inverse(pose: Expression) -> Expression:
    """The inverse of a pose; what an inverse is one of."""
    match pose:
        case Apply("inverse", (inner,)):
            return inner
        case PoseValue(value):
            return PoseValue(value.inverse())
    return Apply("inverse", (pose,))
