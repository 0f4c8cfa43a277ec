"""The comment lines that open a module, and the sections of an emitted module.

The header states what RAPID itself cannot express, one item a line: `program: NAME`, `robot: NAME`,
`entry: NAME`, `unit of: NAME` of a module that is loaded when it is called, `module of: NAME` of
one that its task holds beside the main one, `signal: NAME digital output [number [bits]]`,
`name: SHORT = original`, and a tool or work object that the controller has, so that the module
alone can be checked and moved through with the values that it was made for:

    ! elsewhere: PERS tooldata gripper:=[TRUE,[[0,0,60],[1,0,0,0]],[0.5,[0,0,30],[1,0,0,0],0,0,0]]

Any other line is a comment; a comment that looks like an item is written with `: ` before it.
Names are written in ASCII, as a module is.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.languages.language_types import Outline
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.text.printer import print_file
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.texts.words import ASCII_NAME, from_ascii, in_ascii
from assistant.program.program import Program, Signal, identifier

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
    """Content of the opening comments. names: short → original. unit: of the program that the
    module belongs to.

    resident: the task holds the unit, so the program does not load it. there: declarations of data
    on the controller.
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
        """Number of lines that the header occupies."""
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
        # A comment that looks like an item would be read back as one.
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
                # The pattern lets only the words of these literal types through.
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
    """Read the opening comments of a module."""
    lines = []
    for item in module.items:
        if not isinstance(item, s.CommentLine) or item.trailing:
            break
        lines.append(item.text)
    return read_header(lines)


def header_declaration(data: s.Data) -> str:
    """Return a declaration as it is written in a heading: on one line, without its semicolon."""
    printed = print_file(s.File((s.Module("m", (), (data,)),)), "\n")
    return printed.split("\n")[1].strip().removesuffix(";")


def controller_data(module: s.Module) -> Iterator[s.Data]:
    """Yield the data on the controller that the heading of a module declares."""
    for text in module_header(module).there:
        try:
            yield from (one for one in verbatim.items(text + ";") if isinstance(one, s.Data))
        except Refused:
            # The line is a comment that people may edit; what is no declaration states nothing.
            continue


def with_controller_data(files: Sequence[s.File]) -> Sequence[s.File]:
    """The files, with one beside them that declares what their headings state and none declares."""
    modules = [module for file in files for module in file.modules]
    found = {one.name.lower(): one for module in modules for one in controller_data(module)}
    if not found:
        return files
    for module in modules:
        for item in module.items:
            # Local data of a module is not visible to others, so that theirs still needs the
            # declaration.
            if isinstance(item, s.Data) and item.scope != "LOCAL":
                found.pop(item.name.lower(), None)
    if not found:
        return files
    name = identifier("elsewhere", {module.name for module in modules})
    return [*files, s.File((s.Module(name, (), tuple(found.values())),))]


_OPENING_COMMENTS: Final = re.compile(r"(?: *!.*\n)*")
_ROUTINE_LINE: Final = re.compile(
    r"^(?:\r?\n)?    (?:LOCAL )?(?:(?:PROC|FUNC \w+) \w+\(|TRAP )", re.MULTILINE
)
_TARGET_LINE: Final = re.compile(
    r"^    (?:(?:LOCAL|TASK) )?CONST (?:robtarget|jointtarget) .*;\r?\n", re.MULTILINE
)
_END: Final = "ENDMODULE"


def sections(text: str) -> Mapping[str, str]:
    """The lines between `MODULE` and `ENDMODULE`: opening comments, declarations, routines."""
    start, end = text.index("\n") + 1, text.rindex(_END)
    comments = _OPENING_COMMENTS.match(text, start, end)
    below = comments.end() if comments else start
    routine = _ROUTINE_LINE.search(text, below, end)
    first = routine.start() if routine else end
    return {
        "header": text[start:below],
        "declarations": text[below:first],
        "routines": text[first:end],
    }


def _module_name(text: str) -> str:
    found = re.match(r"MODULE (\w+)", text)
    return found[1] if found else ""


OUTLINE: Final = Outline(
    template="rapid/module.mod.j2",
    sections=sections,
    within={
        "data": ("declarations", lambda text: _TARGET_LINE.sub("", text)),
        "targets": ("declarations", lambda text: "".join(_TARGET_LINE.findall(text))),
    },
    name=_module_name,
    rank={"MODULE": 0, "header": 1, "declarations": 2, "data": 2, "targets": 2, "routines": 3}
    | {_END: 4},
    complete=(
        ("MODULE", "header", "declarations", "routines", _END),
        ("MODULE", "header", "data", "targets", "routines", _END),
    ),
    item=is_header_item,
    frame={
        # A system module has no `main`; the other attributes change nothing that the program does.
        # Their order and what excludes what: technical reference manual, RAPID kernel, modules.
        "MODULE": r"MODULE {name} ?(?:\( ?(?:NOVIEW|NOSTEPIN(?: ?, ?(?:VIEWONLY|READONLY))?"
        r"|VIEWONLY|READONLY) ?\))?",
        _END: _END,
    },
    numbered=lambda _: None,
    blank=True,
)
