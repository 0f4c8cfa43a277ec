"""What a program prints and reads on a data link: numbers, texts, positions and joints.

A position is `(x,y,z,a,b,c)(fl1,fl2)` in mm and degrees, joints are `(j1,…)` in degrees (manuals
BFP-A5993 and BFP-A3379: PRINT, INPUT). A program that prints
`M_TIMER(1), "|", P_CURR, "|", J_FBC` is read with `Form.parse("M_TIMER | P_CURR | J_FBC")`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from assistant.base.diagnostics import Refused
from assistant.controllers.mitsubishi.data_link import rules
from assistant.controllers.recording import Recording

AXES: Final = 8
"""Components of a position and of joints: six, and two additional axes."""
DECIMALS: Final = 4
"""Of a number that is sent; what a controller holds in single precision has no more."""
MOST_BYTES: Final = 255
"""Of a line that is sent: a text variable has no more."""
ENCODING: Final = "latin-1"
COMPONENTS: Final = {
    "number": (),
    "text": (),
    "position": ("X", "Y", "Z", "A", "B", "C", "L1", "L2", "FL1", "FL2"),
    "joints": tuple(f"J{axis}" for axis in range(1, AXES + 1)),
}
"""Names of the components of a value, as they are recorded."""

ValueKind = Literal["number", "text", "position", "joints"]
VALUE_KINDS: Final[dict[str, ValueKind]] = {
    "M": "number",
    "C": "text",
    "P": "position",
    "J": "joints",
}
"""First letter of a variable → what it holds."""


@dataclass(frozen=True, slots=True)
class Position:
    """A pose as the controller has it.

    values: (8,) X Y Z in mm, A B C in degrees, L1 L2; NaN for what the arm lacks.
    flags: FL1, the posture, and FL2, the turns of the joints.
    """

    values: tuple[float, ...]
    flags: tuple[int, int] = (0, 0)

    @property
    def numbers(self) -> tuple[float, ...]:
        return (*self.values, *map(float, self.flags))


@dataclass(frozen=True, slots=True)
class Joints:
    """values: (8,) degrees (mm of a linear axis), NaN for axes that the arm lacks."""

    values: tuple[float, ...]

    @property
    def numbers(self) -> tuple[float, ...]:
        return self.values


Value = float | str | Position | Joints


@dataclass(frozen=True, slots=True)
class Form:
    """The fields of a record, and what stands between them.

    names: as they are printed, such as `P_CURR` or `M_RSPD(3)`. kinds: of what they hold.
    """

    names: tuple[str, ...]
    kinds: tuple[ValueKind, ...]
    separator: str = "|"

    @staticmethod
    def parse(text: str, separator: str = "|") -> Form:
        """The form that a text such as `M_TIMER | P_CURR | J_FBC` says; raises Refused."""
        names = tuple(name.strip() for name in text.split(separator))
        for name in names:
            if not FORM_FIELD.fullmatch(name):
                raise Refused(rules.BAD_FORM(place=text, field=name), exit_status=2)
        return Form(names, tuple(VALUE_KINDS[name[0].upper()] for name in names), separator)

    def read(self, line: str) -> tuple[Value, ...]:
        """The values of a line; raises ValueError if it is of another form."""
        parts = line.split(self.separator)
        if len(parts) != len(self.names):
            raise ValueError(f"{len(parts)} fields, not {len(self.names)}")
        return tuple(
            read_value(part.strip(), kind) for part, kind in zip(parts, self.kinds, strict=True)
        )

    def recording(self, *more: str) -> Recording:
        """An empty recording of these fields but for texts, behind single numbers `more`."""
        numeric = self._numeric()
        fields = {name: COMPONENTS[kind] for name, kind in numeric}
        return Recording({**dict.fromkeys(more, ()), **fields})

    def record(self, recording: Recording, values: Sequence[Value], *more: float) -> None:
        """Adds a row to one of `recording`."""
        recording.add(
            *more, *(value_components(value) for value in values if not isinstance(value, str))
        )

    def _numeric(self) -> Iterable[tuple[str, ValueKind]]:
        pairs = zip(self.names, self.kinds, strict=True)
        return ((name, kind) for name, kind in pairs if kind != "text")


FORM_FIELD: Final = re.compile(r"[MCPJ][A-Z0-9_]*[$%&!#]?(?:\(\s*\d+\s*(?:,\s*\d+\s*)*\))?", re.I)
NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:E[+-]?\d+)?", re.I)
BRACKETS: Final = re.compile(r"\(([^()]*)\)\s*(?:\(([^()]*)\))?")
LACKING: Final = {"", "****"}
"""What stands for an axis that the arm lacks."""


def value_components(value: float | Position | Joints) -> float | tuple[float, ...]:
    """The components of a value, as a recording has them."""
    return value if isinstance(value, (int, float)) else value.numbers


def read_value(text: str, kind: ValueKind) -> Value:
    """A printed value; raises ValueError if it is of another kind."""
    match kind:
        case "text":
            return text
        case "number":
            return _read_number(text)
        case "joints" | "position":
            return _read_brackets(text, kind)


def _read_number(text: str) -> float:
    if not NUMBER.fullmatch(text):
        raise ValueError(f"{text!r} is no number")
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text!r} is too large")
    return value


def _read_brackets(text: str, kind: Literal["position", "joints"]) -> Position | Joints:
    found = BRACKETS.fullmatch(text)
    if found is None or (found[2] is None) != (kind == "joints"):
        raise ValueError(f"{text!r} is no {kind}")
    parts = [part.strip() for part in found[1].split(",")]
    if len(parts) > AXES:
        raise ValueError(f"{text!r} has more than {AXES} components")
    given = [math.nan if part in LACKING else _read_number(part) for part in parts]
    values = (*given, *[math.nan] * (AXES - len(given)))
    if found[2] is None:
        return Joints(values)
    flags = [_read_number(part.strip()) for part in found[2].split(",")]
    if len(flags) != 2 or any(flag != int(flag) for flag in flags):
        raise ValueError(f"{text!r} has no two whole flags")
    return Position(values, (int(flags[0]), int(flags[1])))


def input_line(values: Sequence[Value]) -> str:
    """A line for Input#, its items between commas; raises Refused for what no line can carry."""
    line = ",".join(map(_item_text, values))
    if len(line) > MOST_BYTES:
        reason = f"it has {len(line)} bytes, a line {MOST_BYTES}"
        raise _unsendable("the line", reason, "send fewer items at once")
    return line


def _item_text(value: Value) -> str:
    match value:
        case str():
            if strange := re.search(r"[\x00-\x1f\x7f-\x9f,()\"]|[^\x00-\xff]", value):
                reason = f"it holds {strange[0]!r}, which would end it or is not known there"
                raise _unsendable(repr(value), reason, "send a text without it")
            return value
        case Position(values, (one, two)):
            return f"{_bracket_text(values)}({one},{two})"
        case Joints(values):
            return _bracket_text(values)
    return _decimal_text(value)


def _bracket_text(values: Sequence[float]) -> str:
    """Components up to the last one that there is; 0 for one that the arm lacks."""
    count = max((place for place, value in enumerate(values, 1) if value == value), default=0)
    if not 0 < count <= AXES:
        raise _unsendable(str(tuple(values)), f"it has {count} components", f"give 1 to {AXES}")
    return f"({','.join('0' if math.isnan(v) else _decimal_text(v) for v in values[:count])})"


def _decimal_text(value: float) -> str:
    if not math.isfinite(value):
        raise _unsendable(str(value), "it is not finite", "send a finite number")
    text = f"{value:.{DECIMALS}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _unsendable(what: str, reason: str, cure: str) -> Refused:
    return Refused(rules.UNSENDABLE(what=what, reason=reason, cure=cure), exit_status=2)
