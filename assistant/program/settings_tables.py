"""Settings files: TOML read by tables of their keys, with a finding for each wrong value.

Each reader takes what TOML gave and returns the value, or raises `Wrong` with the fault and its
cure. Lengths are in mm, angles in degrees.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Rule, Span, Unreadable, error, warning
from assistant.base.length_units import UNITS
from assistant.base.near_names import near_name
from assistant.base.source_text import SourceText
from assistant.base.toml_text import KeyPath, key_spans, parse_toml
from assistant.program.geometry import Quaternion, Vector
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import IDENTIFIER, identifier

Read = Callable[[Any], Any]
"""Convert a TOML value to the setting's value; raises Wrong."""

_REPAIRABLE: Final = 1e-3
"""Largest deviation of a quaternion's length from 1 that is repaired."""
EXACT_LENGTH: Final = 1e-6
"""Largest deviation from 1 without a finding, as digits of a file leave it."""
_MOST_TOLERANCE: Final = 10.0
"""mm; over this, contours of a work piece would lose their shape."""
MOST_BITS: Final = 32
_FEWEST_AXES: Final = 2
_MOST_AXES: Final = 7
LARGEST: Final = 1e6
"""mm, mm/s, degrees …: no robot is a kilometre long."""
MOST_VALUE: Final = 2.0**MOST_BITS - 1
"""Largest value of a signal: all bits of the widest group."""
_LEAST_DIRECTION: Final = 1e-9


class Wrong(ValueError):
    """A value that cannot be used: what it is, and what to write instead."""

    def __init__(self, what: str, cure: str) -> None:
        super().__init__(what)
        self.what: Final = what
        self.cure: Final = cure


def kind_of(value: object) -> str:
    """The TOML type of a value, in words."""
    if isinstance(value, bool):
        return "true or false"
    kinds = ((int, "a number"), (float, "a number"), (str, "a text"), (list, "an array"))
    return next((word for kind, word in kinds if isinstance(value, kind)), _other(value))


def number(
    unit: str, *, least: float = -LARGEST, above: float = -math.inf, most: float = LARGEST
) -> Read:
    """A number of a unit: not below `least`, over `above`, not over `most`."""
    wanted = f"a number of {unit}" if unit else "a number"

    def read(value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise Wrong(f"is {kind_of(value)}", f"write {wanted}, without quotes or unit")
        try:
            result = float(value)
        except OverflowError:
            result = math.inf
        if not math.isfinite(result):
            raise Wrong("is not a finite number", f"write {wanted}")
        if not (least <= result <= most and result > above):
            raise Wrong(f"is {result:g}, out of range", f"write {wanted}, {_range()}")
        return result + 0.0

    def _range() -> str:
        low = f"over {above:g}" if above > -math.inf else f"{least:.10g} or more"
        return f"{low}, at most {most:.10g}"

    return read


def whole(least: int, most: int) -> Read:
    def read(value: Any) -> int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise Wrong(f"is {kind_of(value)}", f"write a whole number, {least} to {most}")
        if not least <= value <= most:
            raise Wrong("is out of range", f"write a whole number, {least} to {most}")
        return value

    return read


def choice(*words: str) -> Read:
    def read(value: Any) -> str:
        if not isinstance(value, str) or value not in words:
            said = f'is "{shown(value)}"' if isinstance(value, str) else f"is {kind_of(value)}"
            raise Wrong(said, "write " + " or ".join(f'"{w}"' for w in words))
        return value

    return read


def caseless(*words: str) -> Read:
    """Return a reader like `choice` for words in any case; it returns the word as in the list."""
    known, exact = {word.casefold(): word for word in words}, choice(*words)

    def read(value: Any) -> str:
        return str(exact(known.get(value.casefold(), value) if isinstance(value, str) else value))

    return read


def truth(value: Any) -> bool:
    if not isinstance(value, bool):
        raise Wrong(f"is {kind_of(value)}", "write true or false, without quotes")
    return value


def text(value: Any) -> str:
    if not isinstance(value, str) or not value.strip():
        raise Wrong(f"is {kind_of(value)}" if value != "" else "is empty", "write a text in quotes")
    return value


def texts(value: Any) -> tuple[str, ...]:
    if not isinstance(value, list):
        raise Wrong(f"is {kind_of(value)}", 'write texts in brackets: ["A", "B"]')
    return tuple(map(text, value))


def axes(value: Any) -> tuple[float, ...]:
    """A number for each axis of an arm, degrees or mm."""
    if not isinstance(value, list) or not _FEWEST_AXES <= len(value) <= _MOST_AXES:
        what = f"has {len(value)} entries" if isinstance(value, list) else f"is {kind_of(value)}"
        raise Wrong(what, "write a number for each axis of the arm, in degrees, in brackets")
    return _vector(" of degrees", len(value))(value)


def name(value: Any) -> str:
    """An identifier."""
    given = text(value)
    if IDENTIFIER.fullmatch(given) is None:
        raise Wrong(f'is "{shown(given)}", which is no name', f"write {identifier(given)}")
    return given


def _vector(unit: str, count: int = 3, most: float = LARGEST) -> Callable[[Any], tuple[float, ...]]:
    component = number("", least=-most, most=most)

    def read(value: Any) -> tuple[float, ...]:
        cure = f"write {count} numbers{unit} in brackets"
        if not isinstance(value, list):
            raise Wrong(f"is {kind_of(value)}", cure)
        if len(value) != count:
            raise Wrong(f"has {len(value)} entries", cure)
        numbers: list[float] = []
        for i, entry in enumerate(value, 1):
            try:
                numbers.append(component(entry))
            except Wrong as wrong:
                raise Wrong(f"{wrong.what} in entry {i}", cure) from None
        return tuple(numbers)

    return read


def position(value: Any) -> Vector:
    x, y, z = _vector(" in mm")(value)
    return (x, y, z)


def point(value: Any) -> tuple[float, float]:
    """A point of a plane."""
    x, y = _vector(" mm", 2)(value)
    return (x, y)


def direction(value: Any) -> Vector:
    """A vector of any length but none, made a unit one."""
    vector = np.array(_vector("", most=math.inf)(value))
    largest = np.abs(vector).max()
    if largest < _LEAST_DIRECTION:
        raise Wrong("points nowhere", "write three numbers that are not all zero")
    vector = vector / largest
    x, y, z = (vector / np.linalg.norm(vector) + 0.0).tolist()
    return (x, y, z)


def euler_zyx(value: Any) -> Quaternion:
    angles = _vector(" of degrees, about z, y, x,")(value)
    w, x, y, z = rotations.from_euler(angles, "ZYX").tolist()
    return (w, x, y, z)


def quaternion(value: Any) -> tuple[Quaternion, float]:
    """The unit quaternion, and how long the one was that was given."""
    parts = np.array(_vector(", w, x, y, z,", 4, math.inf)(value))
    with np.errstate(over="ignore"):
        length = float(np.linalg.norm(parts))
    if not abs(length - 1.0) <= _REPAIRABLE:
        raise Wrong(f"has length {length:.6g}", "write w, x, y, z of a quaternion of length 1")
    w, x, y, z = rotations.canonical(parts).tolist()
    return (w, x, y, z), length


def speed(value: Any) -> Speed:
    return Speed(number("mm/s", above=0.0)(value))


def blend(value: Any) -> Blend:
    if value == "fine":
        return FINE
    if isinstance(value, str):
        raise Wrong(f'is "{shown(value)}"', 'write "fine", or a number of mm without quotes')
    radius: float = number("mm", least=0.0)(value)
    return Blend(radius) if radius else FINE


def tolerance(value: Any) -> float:
    result: float = number("mm", above=0.0, most=_MOST_TOLERANCE)(value)
    return result


unit: Final = choice(*UNITS)
"""The short name of a unit of length."""


def switches(value: Any) -> dict[str, float]:
    """Signals by name, each with its value; true and false are 1 and 0."""
    if not isinstance(value, dict):
        raise Wrong(f"is {kind_of(value)}", "write {signal = 1} with the signal's name")
    read = number("", least=-MOST_VALUE, most=MOST_VALUE)
    found: dict[str, float] = {}
    for signal, given in value.items():
        try:
            found[signal] = float(given) if isinstance(given, bool) else read(given)
        except Wrong as wrong:
            what = f"of signal {shown(signal)} {wrong.what}"
            raise Wrong(what, "write its value as a number") from None
    return found


def shown(given: str, most: int = 40) -> str:
    """Return a text from outside in a form fit for a sentence."""
    plain = "".join(c if c.isprintable() else "?" for c in given)
    return plain if len(plain) <= most else plain[: most - 1] + "…"


def listed(words: Sequence[str]) -> str:
    return ", ".join(words) if words else "none"


def _other(value: object) -> str:
    return "a table" if isinstance(value, dict) else "a date or time"


_UNKNOWN_KEY = error("CT302", "there is no key `{key}` {where}", "{cure}")
_BAD_VALUE = error("CT303", "`{key}` {what}", "{cure}")
_NO_TABLE = error("CT304", "`{key}` is {what}, not a table", "write {cure}")
_BAD_NAME = error(
    "CT305", '"{given}" is no name: letters, digits and `_`, a letter first', "write {name}"
)
_SAME_NAME = error(
    "CT313", "{given} and {other} differ only in upper and lower case", "keep one of them"
)
REPAIRED = warning(
    "CT351", "`{key}` has length {length:.6f} and is brought to 1", "give more digits"
)


@dataclass(frozen=True, slots=True)
class Page:
    """The text of a process file, where its keys stand, and what was found in it."""

    source: SourceText
    spans: Mapping[KeyPath, Span]
    findings: list[Diagnostic] = field(default_factory=list)

    @staticmethod
    def of(source: SourceText) -> Page:
        return Page(source, key_spans(source.text))

    def say(self, rule: Rule, path: KeyPath, /, **fields: Any) -> None:
        """A finding at the key of that path, or at the nearest table around it."""
        known = next(path[:n] for n in range(len(path), -1, -1) if not n or path[:n] in self.spans)
        span = self.spans.get(known, Span(0, 0))
        self.findings.append(self.source.finding(rule, span, **fields))


@dataclass(frozen=True, slots=True)
class Table:
    """A table of the file by its path."""

    page: Page
    path: KeyPath
    content: Mapping[str, Any]

    def read(self, keys: Mapping[str, Read]) -> dict[str, Any]:
        """The values of the keys that are there and right; the others become findings."""
        found: dict[str, Any] = {}
        for key, value in self.content.items():
            if key not in keys:
                self._unknown(key, keys)
                continue
            try:
                found[key] = keys[key](value)
            except Wrong as wrong:
                self.say(_BAD_VALUE, key, key=key, what=wrong.what, cure=wrong.cure)
        return found

    def table(self, key: str) -> Table:
        """Return the table under a key; an empty one if it is missing."""
        value = self.content.get(key, {})
        if not isinstance(value, dict):
            example = f"[{'.'.join((*self.path, key))}] with a line for each entry"
            self.say(_NO_TABLE, key, key=shown(key), what=kind_of(value), cure=example)
            value = {}
        return Table(self.page, (*self.path, key), value)

    def named(self, *, identifiers: bool = True) -> Iterator[tuple[str, Table]]:
        """Yield the tables in this one by name; invalid and repeated names are findings."""
        seen: dict[str, str] = {}
        for key in self.content:
            other = seen.setdefault(key.casefold(), key)
            if identifiers and IDENTIFIER.fullmatch(key) is None:
                self.say(_BAD_NAME, key, given=shown(key), name=identifier(key))
            elif other != key:
                self.say(_SAME_NAME, key, given=shown(key), other=shown(other))
            yield key, self.table(key)

    def say(self, rule: Rule, at: str | None = None, /, **fields: Any) -> None:
        """A finding at a key of the table, or at the table itself."""
        self.page.say(rule, self.path if at is None else (*self.path, at), **fields)

    def _unknown(self, key: str, keys: Mapping[str, Read]) -> None:
        where = f"in [{'.'.join(shown(p) for p in self.path)}]" if self.path else "here"
        near = near_name(key, keys)
        cure = f"write `{near}`" if near else f"use one of {listed(list(keys))}"
        self.say(_UNKNOWN_KEY, key, key=shown(key), where=where, cure=cure)


_NOT_TOML = error("CT301", "this is no TOML: {reason}", "correct it there")


ENCODINGS: Final = ("utf-8-sig", "utf-8")


_ERROR_POSITION: Final = re.compile(r"\s*\(at (?:line (\d+), column (\d+)|end of document)\)$")


def read_toml(source: SourceText) -> Table:
    """A document, every key with its place; raises Unreadable if it is no TOML.

    Raises Refused if reading takes more than its budget.
    """
    try:
        content = parse_toml(source.text, source.path)
    except Refused:
        raise
    except tomllib.TOMLDecodeError as error:
        raise Unreadable(_not_toml(source, str(error))) from None
    except ValueError:  # as `int` refuses it, without a place
        finding = source.finding(
            _NOT_TOML, _long_number(source.text), reason="a number is too long"
        )
        raise Unreadable(finding) from None
    except RecursionError:
        raise Unreadable(_not_toml(source, "brackets are nested too deeply")) from None
    return Table(Page.of(source), (), content)


def _long_number(text: str) -> Span:
    """The longest number of a text."""
    numbers = (Span(*found.span()) for found in re.finditer(r"\d[\d_]*", text))
    return max(numbers, key=lambda span: span.end - span.start)


def _not_toml(source: SourceText, reason: str) -> Diagnostic:
    place = _ERROR_POSITION.search(reason)
    said = _ERROR_POSITION.sub("", reason)
    said = shown(said[:1].lower() + said[1:], 200)
    lines = source.text.count("\n") + 1
    line, column = (int(place[1]), int(place[2])) if place and place[1] else (lines, None)
    excerpt = source.line_text(line)
    return _NOT_TOML(path=source.path, line=line, column=column, excerpt=excerpt, reason=said)
