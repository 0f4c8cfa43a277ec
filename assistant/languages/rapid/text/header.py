"""The comment lines that open a module: what RAPID itself has no words for.

One item a line: `program: NAME`, `robot: NAME`, `entry: NAME`, `unit of: NAME` of a module that is
loaded when it is called, `module of: NAME` of one that its task holds beside the main one,
`signal: NAME digital output [number [bits]]`, `name: SHORT = original`, `elsewhere: PERS …` of a
tool or work object that the controller has, see `elsewhere.py`. Anything else is a
comment; one that looks like an item is written with `: ` before it. Names are written in ASCII,
for a module is.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.texts.words import ASCII_NAME, from_ascii, in_ascii
from assistant.program.program import Program, Signal

_HEADER_ITEM: Final = re.compile(
    rf"program: (?P<program>{ASCII_NAME})"
    r"|robot: (?P<robot>[A-Za-z0-9][A-Za-z0-9_.-]*)"
    rf"|entry: (?P<entry>{ASCII_NAME})"
    rf"|(?P<kept>unit|module) of: (?P<unit>{ASCII_NAME})"
    rf"|signal: (?P<signal>{ASCII_NAME}) (?P<kind>digital|analog|group) (?P<direction>input|output)"
    r"(?: (?P<number>[0-9]{1,9})?(?: x(?P<bits>[0-9]{1,3}))?)?"
    r"|elsewhere: (?P<there>PERS (?:tooldata|wobjdata) [A-Za-z][A-Za-z0-9_]*:=\[[^;]+\])"
    rf"|name: (?P<short>{ASCII_NAME}) = (?P<original>{ASCII_NAME})",
    re.ASCII,
)
_COMMENT_MARK: Final = ": "


@dataclass(slots=True)
class Header:
    """What the opening comments say. names: short → original. unit: of the program it is of.

    resident: the task holds the unit, so that nobody loads it. there: declarations of what the
    controller has.
    """

    program: str = ""
    robot: str | None = None
    entry: str | None = None
    unit: str = ""
    resident: bool = False
    signals: dict[str, Signal] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)
    there: list[str] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)

    @property
    def lines(self) -> int:
        """How many lines it stands in."""
        single = sum(map(bool, (self.program, self.robot, self.entry, self.unit)))
        return single + len(self.signals) + len(self.names) + len(self.there) + len(self.comments)


def header_lines(
    program: Program,
    unit: str | None,
    names: Sequence[tuple[str, str]],
    *,
    resident: bool = False,
    there: Sequence[str] = (),
) -> list[str]:
    """The lines of a module's header. names: (short, original) each. Others: see `Header`."""
    if unit is None:
        lines = [f"program: {in_ascii(program.name)}"]
        if program.robot:
            lines.append(f"robot: {program.robot}")
        if program.entry:
            lines.append(f"entry: {in_ascii(program.entry)}")
        lines += [_signal_item(name, signal) for name, signal in program.signals.items()]
    else:
        lines = [f"{'module' if resident else 'unit'} of: {in_ascii(program.name)}"]
    lines += [f"elsewhere: {declaration}" for declaration in there]
    lines += [f"name: {short} = {in_ascii(original)}" for short, original in names]
    if unit is None:
        lines += [
            _COMMENT_MARK + c
            if _HEADER_ITEM.fullmatch(c) or c.startswith(_COMMENT_MARK.strip())
            else c
            for c in program.comments
        ]
    return lines


def is_header_item(text: str) -> bool:
    """True if a comment states something about the program."""
    return _HEADER_ITEM.fullmatch(text.strip()) is not None


def _signal_item(name: str, signal: Signal) -> str:
    number = f" {signal.number}" if signal.number is not None else ""
    bits = f" x{signal.bits}" if signal.bits != 1 else ""
    gap = " " if bits and not number else ""
    return f"signal: {in_ascii(name)} {signal.kind} {signal.direction}{gap}{number}{bits}"


def read_header(comments: Sequence[str]) -> Header:
    header = Header()
    for comment in comments:
        match = _HEADER_ITEM.fullmatch(comment)
        if match is None:
            header.comments.append(
                comment.removeprefix(_COMMENT_MARK)
                if comment.startswith(_COMMENT_MARK)
                else comment
            )
        elif match["program"]:
            header.program = from_ascii(match["program"])
        elif match["robot"]:
            header.robot = match["robot"]
        elif match["entry"]:
            header.entry = from_ascii(match["entry"])
        elif match["unit"]:
            header.unit, header.resident = from_ascii(match["unit"]), match["kept"] == "module"
        elif match["signal"]:
            number = int(match["number"]) if match["number"] else None
            header.signals[from_ascii(match["signal"])] = Signal(
                match["kind"],  # type: ignore[arg-type]
                match["direction"],  # type: ignore[arg-type]
                number,
                int(match["bits"] or 1),
            )
        elif match["there"]:
            header.there.append(match["there"])
        else:
            header.names[match["short"].lower()] = from_ascii(match["original"])
    return header


def module_header(module: s.Module) -> Header:
    """What the comments say that a module begins with."""
    lines = []
    for item in module.items:
        if not isinstance(item, s.CommentLine) or item.trailing:
            break
        lines.append(item.text)
    return read_header(lines)
