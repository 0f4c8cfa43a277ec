"""Header of a written program: comment lines that hold what the language cannot express.

    ' robot-assistant: melfa-basic-4
    ' program: seam_program
    ' robot: rv-2aj
    ' target: PHOME = home, PPARK = park
    ' path: P1-P35 = seam
    ' elsewhere: PMEXTL2=(+0.00,+0.00,+120.00,+0.00,+0.00,+0.00)
    ' robot-assistant: end

Names are written in ASCII. Malformed entries are ignored: it is only a comment. `elsewhere` holds
a tool or work coordinates that the program calls by number: the name is that of the parameter that
holds the value, after the letter of positions. An emitted program has the sections heading, code
and positions. Above the moves of a path that no other language wrote are its numbers and name,
as `path_note` writes them; that comment is no part of the program.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from functools import partial
from itertools import starmap
from typing import Any, Final, cast

from assistant.base.data_classes import dataclass
from assistant.languages.language_types import Numbering, Outline
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, EMITTED_LINE, Dialect
from assistant.languages.melfa_basic.tables.poses import FINE_PLACES
from assistant.languages.melfa_basic.tables.variables import ARC_START
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.texts.words import ASCII_NAME, from_ascii, in_ascii
from assistant.program.program import Signal, ValueType

MARK: Final = "robot-assistant: "
END: Final = MARK + "end"

THERE: Final = "elsewhere: "
"""Before what a parameter of the controller holds, see `with_stated_parameters`."""

_PRODUCTS: Final = "frames: product"
"""Says that frames are no `Base`, but what targets are multiplied by."""

_INVERSE: Final = "note: frames are inverse, as Base takes them: the robot seen from the frame"
"""For the person who compares their values with those of another robot."""

_ARC_START: Final = f"note: {ARC_START} is the present position, where an arc starts"
"""For the person who looks for the variable in the source."""

_AS_IS: Final = ("robot",)
"""Items whose values are not names of the program."""

NAME_KINDS: Final = (
    "target", "joints", "tool", "frame", "loop", "procedure", "label", "unit", "first", "timer",
    "result", "interrupt",
)  # fmt: skip
"""Kinds of `SHORT = original` entries. `first` is the procedure that a unit begins with,
the SHORT of a `timer` or an `interrupt` its number; a `result` has a type, where the letter of a
Function says another one."""


@dataclass(slots=True)
class Declared:
    """A variable: original name, type, storage, procedure it belongs to, and marks.

    storage: that of a `Variable`, or `parameter`. initial: the code begins with its first value.
    size: of an array; a parameter takes one of any extents, written as 0. listed: the list of
    positions has the values of its elements.
    """

    name: str
    type: ValueType
    storage: str
    owner: str = ""
    local: bool = False
    initial: bool = False
    size: tuple[int, ...] = ()
    listed: bool = False


@dataclass(slots=True)
class Header:
    """program, entry, robot, unit: None where not stated. names: by kind, short → original.

    products: whether targets are multiplied by frames. there: what the controller has. paths:
    (first, last, name) ranges of P numbers. inline: position and joint variables that stand for a
    value. signals in their order. variables: short → declaration. arc_start: whether the code reads
    where an arc starts.
    """

    program: str | None = None
    robot: str | None = None
    entry: str | None = None
    unit: str | None = None
    products: bool = False
    there: list[str] = field(default_factory=list)
    names: dict[str, dict[str, str]] = field(default_factory=lambda: {k: {} for k in NAME_KINDS})
    paths: list[tuple[int, int, str]] = field(default_factory=list)
    inline: dict[str, None] = field(default_factory=dict)
    signals: dict[str, Signal] = field(default_factory=dict)
    variables: dict[str, Declared] = field(default_factory=dict)
    arc_start: bool = False


def header_lines(header: Header, dialect: str) -> Iterator[str]:
    """The comment texts, without their mark."""
    yield MARK + dialect
    for key in ("program", "robot", "entry", "unit"):
        if (value := getattr(header, key)) is not None:
            yield f"{key}: {value if key in _AS_IS else in_ascii(value)}"
    if header.products:
        yield _PRODUCTS
    yield from (THERE + text for text in header.there)
    for kind in NAME_KINDS:
        yield from packed(kind, starmap(_name_entry, header.names[kind].items()))
        if kind == "frame" and header.names[kind] and not header.products and not header.there:
            yield _INVERSE
    yield from packed("path", (f"P{a}-P{b} = {in_ascii(n)}" for a, b, n in header.paths))
    yield from packed("inline", header.inline)
    for name, signal in header.signals.items():
        number = "-" if signal.number is None else signal.number
        yield f"signal: {signal.kind} {signal.direction} {number} {signal.bits} = {in_ascii(name)}"
    for short, v in header.variables.items():
        words = [v.type, v.storage, *(["x".join(map(str, v.size))] if v.size else [])]
        words += ["local"] if v.local else []
        words += ["initial"] if v.initial else ["listed"] if v.listed else []
        words += [f"of {in_ascii(v.owner)}"] if v.owner else []
        yield f"variable: {short} = {in_ascii(v.name)} {' '.join(words)}"
    if header.arc_start:
        yield _ARC_START
    yield END


def path_note(first: int, last: int, name: str) -> str:
    """Return the comment above the moves of a path: its position numbers, and its name."""
    return f"P{first} to P{last}: {in_ascii(name)}"


def _name_entry(short: str, original: str) -> str:
    """Return the entry of a name; an unchanged name is written once."""
    said = in_ascii(original)
    return short if short == said else f"{short} = {said}"


def packed(kind: str, entries: Iterable[str]) -> Iterator[str]:
    """Lines `kind: entry, entry …`, as many entries on each as there is room for."""
    line = ""
    for entry in entries:
        # Room for the step number and the mark of the comment.
        if line and len(line) + 2 + len(entry) > EMITTED_LINE - 10:
            yield line
            line = ""
        line = f"{line}, {entry}" if line else f"{kind}: {entry}"
    if line:
        yield line


def bounds(texts: Sequence[str]) -> tuple[int, int] | None:
    """Return the places of the first and last line of a header in comment texts; None without a
    header.
    """
    start = next((at for at, text in enumerate(texts) if text.startswith(MARK + "melfa")), None)
    if start is None or END not in texts[start:]:
        return None
    return start, texts.index(END, start)


# A comment can hold anything, so each pattern limits the length of its numbers and names.
_PAIR: Final = re.compile(rf"([A-Za-z0-9_-]+)(?: = ({ASCII_NAME}))?")
_PATH: Final = re.compile(rf"P([0-9]{{1,9}})-P([0-9]{{1,9}}) = ({ASCII_NAME})")
_SIGNAL: Final = re.compile(
    rf"(digital|analog|group) (input|output) (-|[0-9]{{1,6}}) ([0-9]{{1,3}}) = ({ASCII_NAME})"
)
_VARIABLE: Final = re.compile(
    rf"([A-Za-z][A-Za-z0-9_]*) = ({ASCII_NAME}) (number|integer|truth|text|position|pose|joints) "
    r"(constant|variable|persistent|parameter)( [0-9]{1,3}(?:x[0-9]{1,3}){0,2})?"
    rf"( local)?( initial| listed)?(?: of ({ASCII_NAME}))?"
)


def read(texts: Iterable[str]) -> Header:
    """The header that comment texts between the two marks hold."""
    header = Header()
    for text in texts:
        key, _, value = text.partition(": ")
        if key in ("program", "unit") and re.fullmatch(ASCII_NAME, value):
            setattr(header, key, from_ascii(value))
        elif key == "entry" and (value == "-" or re.fullmatch(ASCII_NAME, value)):
            header.entry = from_ascii(value)
        elif text == _PRODUCTS:
            header.products = True
        elif key == "robot" and re.fullmatch(r"[A-Za-z0-9._/-]{1,64}", value):
            header.robot = value
        elif key in NAME_KINDS:
            found = (_PAIR.fullmatch(entry) for entry in value.split(", "))
            header.names[key].update(
                {f[1].upper(): f[1] if f[2] is None else from_ascii(f[2]) for f in found if f}
            )
        elif key == "path":
            ranges = (_PATH.fullmatch(entry) for entry in value.split(", "))
            header.paths += [
                (int(f.group(1)), int(f.group(2)), from_ascii(f.group(3)))
                for f in ranges
                if f and int(f.group(1)) <= int(f.group(2))
            ]
        elif key == "inline":
            header.inline.update(dict.fromkeys(re.findall(r"[PJ][0-9]{1,9}", value)))
        elif key == "signal" and (signal := _SIGNAL.fullmatch(value)):
            kind, direction, number, bits, name = signal.groups()
            header.signals[from_ascii(name)] = Signal(
                cast(Any, kind),
                cast(Any, direction),
                None if number == "-" else int(number),
                int(bits),
            )
        elif key == "variable" and (v := _VARIABLE.fullmatch(value)):
            short, name, kind, storage, size, local, initial, owner = v.groups()
            header.variables[short.upper()] = Declared(
                from_ascii(name),
                cast(ValueType, kind),
                storage,
                from_ascii(owner or ""),
                bool(local),
                initial == " initial",
                tuple(int(n) for n in size.split("x")) if size else (),
                initial == " listed",
            )
    return header


_COORDINATE: Final = r"[+-]?[0-9]{1,9}(?:\.[0-9]{1,9})?"
_PARAMETER_VALUE: Final = re.compile(
    rf"(P(?:MEXTL|WK)[0-9]{{1,2}}(?:CORD)?)=\(({_COORDINATE}(?:,{_COORDINATE}){{5}})\)"
)


def parameter_value(name: str, values: tuple[float | None, ...]) -> str:
    """Return a parameter's value as written in a heading. values: x, y, z in mm, a, b, c in
    degrees.
    """
    return f"{name}=({','.join(f'{value or 0.0:+.{FINE_PLACES}f}' for value in values)})"


def with_stated_parameters(tree: s.File) -> s.File:
    """Return the tree with the controller's values from its heading, where it has no value."""
    # Values that the file has itself count more than those of the heading.
    own = {item.variable.key for item in tree.items if isinstance(item, s.Data)}
    more = tuple(data for data in _stated_positions(tree) if data.variable.key not in own)
    return replace(tree, items=(*tree.items, *more)) if more else tree


def _stated_positions(tree: s.File) -> Iterator[s.Data]:
    for item in tree.code:
        if not isinstance(item, s.Line) or item.statement or item.label or not item.comment:
            return
        text = item.comment.removeprefix("'").strip()
        if text == END:
            return
        found = _PARAMETER_VALUE.fullmatch(text.removeprefix(THERE))
        if found is not None and text.startswith(THERE):
            values = tuple(float(value) for value in found[2].split(","))
            yield s.Data(s.Variable(found[1]), s.Constant(values, (0, 0)))


_HEADING: Final = re.compile(rf"(?:(?:[0-9]+ )?'.*\n)*?(?:[0-9]+ )?' {END}\r?\n")
_HEADER_LINE: Final = re.compile(rf"^(?:[0-9]+ )?' {MARK}melfa", re.MULTILINE)
_POSITIONS: Final = re.compile(r"^(?![0-9])", re.MULTILINE)
_STEP_NUMBER: Final = re.compile(r"[0-9]+ ")


def _sections(text: str) -> Mapping[str, str]:
    """The comments of the heading, the code, and the values of positions below it."""
    heading = _HEADING.match(text)
    below = heading.end() if heading else 0
    positions = _POSITIONS.search(text, below)
    first = positions.start() if positions else len(text)
    return {"header": text[:below], "code": text[below:first], "positions": text[first:]}


def _header_offset(text: str) -> int:
    """Offset at which the heading begins, after the comments of the program."""
    mark = _HEADER_LINE.search(text)
    return mark.start() if mark else len(text)


def _recounted_lines(dialect: Dialect, lines: Sequence[str]) -> list[str]:
    """The lines with steps counted anew: jumps of emitted programs name labels.

    A comment that has no number yet gets one; values of positions have none.
    """
    made, step = [], 0
    for line in lines:
        match = _STEP_NUMBER.match(line)
        if match is None and not line.startswith("'"):
            made.append(line)
            continue
        step += dialect.step
        made.append(f"{step} {line[match.end() :] if match else line}")
    return made


def _step_numbering(name: str) -> Numbering | None:
    return partial(_recounted_lines, DIALECTS[name])


OUTLINE: Final = Outline(
    template="melfa/program.prg.j2",
    sections=_sections,
    within={
        "comments": ("header", lambda text: text[: _header_offset(text)]),
        "heading": ("header", lambda text: text[_header_offset(text) :]),
    },
    name=lambda _: "",
    rank={"comments": 0, "header": 1, "heading": 1, "code": 2, "positions": 3},
    complete=(("header", "code", "positions"), ("comments", "heading", "code", "positions")),
    item=lambda text: text.strip().startswith(MARK.strip()),
    frame={},
    numbered=_step_numbering,
    blank=False,
    ends="header",
)
