"""Programs of a CR controller: listed, read, written, copied, renamed, protected, removed.

A program is written in the edit slot and takes the old one's place with SAVE; until then NEW
discards the edit. A listing has steps, then variables; it is compared by its lines alone, so that
two texts are equal even where the controller writes other blanks, case or decimals.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from decimal import ROUND_HALF_EVEN, Decimal, InvalidOperation
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.source_text import check_sent
from assistant.base.source_text import lines_of as split_lines
from assistant.controllers import rules
from assistant.controllers.mitsubishi.link import BARE_ANSWER
from assistant.controllers.mitsubishi.session import UNCHANGED, Session, cr_error

ENCODING: Final = "latin-1"
"""Bytes are passed through one to one: a controller's code page stays what it is."""

BLANKS: Final = " \t"
"""The only ones: other bytes that Python calls blank are halves of Japanese characters."""
_STEP_LINE: Final = re.compile(r"\s*(\d+)(?:[ \t]+(.*))?$", re.DOTALL | re.ASCII)
_VARIABLE_LINE: Final = re.compile(
    r"\s*([A-Za-z]\w*[$%&!#]?(?:\([\d, ]*\))?)\s*=\s*(\(.*)$", re.DOTALL | re.ASCII
)
_DECIMAL_NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[Ee][+-]?\d+)?", re.ASCII)
_QUOTED: Final = re.compile(
    r"""("[^"]*"?)|('.*$|\bREM\b.*$)""", re.IGNORECASE | re.DOTALL | re.ASCII
)
_DECIMALS: Final = Decimal("0.01")
"""A controller lists positions with two decimals."""


@dataclass(frozen=True, slots=True)
class ProgramLine:
    """A line of a program and its number in the file, counted from 1."""

    number: int
    text: str


def program_lines(data: bytes) -> list[ProgramLine]:
    """The lines that say something; a step number or a variable may lead them."""
    split = enumerate(split_lines(data.decode(ENCODING)), start=1)
    return [ProgramLine(number, text) for number, text in split if text.strip(BLANKS)]


def listed_form(data: bytes) -> bytes:
    """Return the program in one form: steps in order, variables by name, two decimals, CR LF.

    For a step or a variable that appears twice the last one counts, as on the controller.
    """
    steps: dict[int, str] = {}
    variables: dict[str, str] = {}
    others: list[str] = []
    for line in program_lines(data):
        if step := _STEP_LINE.match(line.text):
            steps[int(step[1])] = statement_form(step[2] or "")
        elif variable := _VARIABLE_LINE.match(line.text):
            name = re.sub(r"[ \t]+", "", variable[1]).upper()
            variables[name] = f"{name}={rounded_values(variable[2])}"
        else:
            others.append(statement_form(line.text))
    body = [f"{n} {steps[n]}".rstrip(BLANKS) for n in sorted(steps)]
    body += [variables[name] for name in sorted(variables, key=natural_order)] + others
    return "".join(f"{text}\r\n" for text in body).encode(ENCODING)


def statement_form(statement: str) -> str:
    """A statement in capitals with single blanks, strings and comments as they are."""
    parts, at = [], 0
    for quoted in _QUOTED.finditer(statement):
        parts += [_capitals(statement[at : quoted.start()]), quoted[0]]
        at = quoted.end()
    parts.append(_capitals(statement[at:]))
    return "".join(parts).strip(BLANKS)


def rounded_values(text: str) -> str:
    """A bracketed list of numbers with two decimals each; flags in the second stay whole."""
    # Flags after the bracket are whole numbers and keep their digits.
    head, bracket, flags = re.sub(r"[ \t]+", "", text).partition(")")
    return _DECIMAL_NUMBER.sub(_rounded, head) + bracket + flags


def _rounded(number: re.Match[str]) -> str:
    try:
        value = Decimal(number[0]).quantize(_DECIMALS, ROUND_HALF_EVEN)
    except InvalidOperation:  # more digits than any robot has millimetres
        return number[0]
    # A value that rounds to 0 may carry a minus sign, which a controller does not list.
    return f"{value + 0 if value else Decimal('0.00'):+.2f}"


def _capitals(text: str) -> str:
    return re.sub(r"[ \t]+", " ", text).encode(ENCODING).upper().decode(ENCODING)  # A to Z only


def natural_order(name: str) -> list[str | int]:
    """P2 before P10."""
    return [int(p) if p.isdigit() else p for p in re.split(r"(\d+)", name)]


VT: Final = "\v"
_PROGRAM_NAME: Final = re.compile(r"[A-Z0-9]{1,12}")
LANGUAGES: Final = {
    "MB4": ("melfa-basic-4",),
    "MB5": ("melfa-basic-5",),
    "MB6": ("melfa-basic-6",),
}
"""Suffix of a controller's program files → languages of the programs that it takes."""
_NO_PROGRAM: Final = 4140
_MOST_PROGRAMS: Final = 100_000
"""Entries after which an endless folder counts as a fault."""
_MOST_DIGITS: Final = 15
"""Digits of a size in bytes."""
_MOST_LINES: Final = 100_000
"""Answers after which a program counts as endless: steps go up to 32767."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A program as the controller lists it; attributes: its protections, as it writes them."""

    name: str
    size: int | None = None
    changed: datetime | None = None
    attributes: str = ""


def entries(session: Session) -> tuple[Entry, ...]:
    """All programs by name; raises rules.Lost for a list that does not end."""
    return directory(session)[0]


def directory(session: Session) -> tuple[tuple[Entry, ...], tuple[str, ...]]:
    """Return all programs by name, and the names of other files; raises rules.Lost as `entries`.

    A file whose suffix belongs to no known language cannot be listed as steps.
    """
    doing = "listing the programs"
    found: dict[str, Entry] = {}
    others: list[str] = []
    told: set[str] = set()
    text = session.ask("PDIRTOP", doing=doing).text
    for index in range(1, _MOST_PROGRAMS):
        # An entry that comes twice: the list would never end.
        if text in told:
            session.garbled(doing, text)
        told.add(text)
        fields = text.split(";")
        name, _, suffix = fields[0].partition(".")
        if name and (suffix.upper() in LANGUAGES or not suffix):
            found[name] = _entry(name, fields, first=index == 1)
        elif fields[0]:
            others.append(fields[0])
        text = session.ask(f"PDIR{index}", doing=doing).text
        if not text.strip("; "):
            break
    else:
        session.garbled(doing, text)
    return tuple(found[name] for name in sorted(found)), tuple(sorted(others))


def _entry(name: str, fields: list[str], *, first: bool) -> Entry:
    """`name;size;time;…`; the first entry has count and free bytes before its attributes."""
    rest = fields[5:] if first else fields[3:]
    size = fields[1] if len(fields) > 1 else ""
    return Entry(
        name,
        int(size) if size.isdecimal() and len(size) <= _MOST_DIGITS else None,
        time_of(fields[2]) if len(fields) > 2 else None,
        rest[0].strip() if rest else "",
    )


def time_of(text: str) -> datetime | None:
    """`yy-mm-ddhh:mm:ss`, with or without something between day and hour; None for no time."""
    digits = re.findall(r"\d\d", text)
    if len(digits) != 6:
        return None
    with suppress(ValueError):
        return datetime.strptime("".join(digits), "%y%m%d%H%M%S")
    return None


def names(session: Session) -> tuple[str, ...]:
    """Names without suffix."""
    return tuple(entry.name for entry in entries(session))


def read(session: Session, name: str) -> bytes | None:
    """The listing: steps, then variables, each line with CR LF."""
    if checked_name(name) not in names(session):
        return None  # LOAD= would create it
    return listed(session, name)


def listed(session: Session, name: str) -> bytes:
    """The same of a program that is there."""
    doing = f"reading `{checked_name(name)}`"
    with editing(session, name, doing, UNCHANGED):
        lines = [*_steps(session, doing), *_positions(session, doing)]
    return "".join(f"{line}\r\n" for line in lines).encode(ENCODING)


def write(session: Session, name: str, data: bytes) -> None:
    """Replaces the program; its lines are all looked at before the first is sent."""
    checked_name(name)
    # Everything is checked before NEW: a refused line must not leave half a program behind.
    most = _room(session)
    parcels = list(_parcels(_checked_lines(name, data, most), most))
    state = f"`{name}` there is as it was"
    doing = f"writing `{name}`"
    with editing(session, name, doing, state):
        # ECLR empties the edit slot; the program itself changes at SAVE only.
        session.ask("ECLR", doing=doing, state=state, slot=session.edit_slot, shape=BARE_ANSWER)
        for parcel in parcels:
            _send(session, name, parcel, doing, state)
        saved = f"`{name}` there is either the old program or the new one"
        session.ask("SAVE", doing=f"saving `{name}`", state=saved, shape=BARE_ANSWER)


def check_text(session: Session, name: str, data: bytes) -> None:
    """Raises Refused for lines that the link cannot carry, or that others see elsewhere."""
    _checked_lines(name, data, _room(session))
    check_sent(data, name, by_line=True)


def _room(session: Session) -> int:
    """Bytes of lines that one command can carry."""
    return session.most - len(f"1;{session.edit_slot};EMDAT")


def remove(session: Session, name: str) -> None:
    if checked_name(name) in names(session):
        doing, state = f"deleting `{name}`", f"`{name}` is still there"
        session.ask(f"FDEL{file_name(session, name)}", doing=doing, state=state, shape=BARE_ANSWER)


def copy(session: Session, name: str, new: str) -> None:
    """A second program of the same text; raises Refused if there is one of that name."""
    doing = f"copying `{name}` to `{new}`"
    files = _two(session, name, new, doing)
    session.ask(f"FCOPY{files}", doing=doing, shape=BARE_ANSWER)


def rename(session: Session, name: str, new: str) -> None:
    doing = f"renaming `{name}` to `{new}`"
    files = _two(session, name, new, doing)
    session.ask(f"FRENAME{files}", doing=doing, shape=BARE_ANSWER)


def protect(session: Session, name: str, *, lines: bool | None, variables: bool | None) -> None:
    """Protects lines and variables against changes, or allows them; None leaves it as it is."""
    file = file_name(session, checked_name(name))
    doing = f"protecting `{name}`"
    for letter, on in (("p", lines), ("q", variables)):
        if on is not None:
            sign = "+" if on else "-"
            session.ask(f"FATTRIB{file};{sign}{letter}", doing=doing, shape=BARE_ANSWER)


def file_name(session: Session, name: str) -> str:
    """With its suffix: without one some controllers take it for an .MB5."""
    return f"{name}.{session.about.suffix}" if session.about.suffix else name


def _two(session: Session, name: str, new: str, doing: str) -> str:
    """A file that there is and one that there is not, as an argument; raises Refused."""
    checked_name(name)
    checked_name(new)
    there = names(session)
    if name not in there:
        raise Refused(session.alarm(_NO_PROGRAM, doing))
    if new in there:
        reason = "there is a program of that name already"
        raise Refused(rules.FILE_NAME(place=new, name=new, reason=reason))
    return f"{file_name(session, name)};{file_name(session, new)}"


@contextmanager
def editing(session: Session, name: str, doing: str, state: str) -> Iterator[None]:
    """With the program in the edit slot; leaves it empty again whatever happens."""
    with session.scope():
        session.ask("NEW", doing=doing, state=state, shape=BARE_ANSWER)
        session.ask(f"LOAD={name}", doing=doing, state=state, shape=BARE_ANSWER)
        try:
            yield
        finally:
            if session.connected:
                with suppress(Refused):
                    session.ask("NEW", doing=f"closing `{name}`", state=state, shape=BARE_ANSWER)


def _steps(session: Session, doing: str) -> Iterator[str]:
    command = "LISTLTOP"
    for _ in range(_MOST_LINES):
        text = session.ask(command, doing=doing).text
        if not text.strip("; "):
            return
        body, _, more = counted(session, text, doing)
        yield from (line for line in body.split(VT) if line)
        if not more:
            return
        command = "LISTL+1"
    session.garbled(doing, "its steps do not end")


def counted(session: Session, text: str, doing: str) -> tuple[str, int, bool]:
    """`…;<count>;<1 more/0>` of a list: its lines, how many, whether more follow."""
    parts = text.rsplit(";", 2)  # a line may hold a semicolon, the numbers may not
    if len(parts) < 3 or parts[2].strip() not in ("0", "1") or not parts[1].strip().isdecimal():
        session.garbled(doing, text)
    return parts[0], int(parts[1]), parts[2].strip() == "1"


def _positions(session: Session, doing: str) -> Iterator[str]:
    command = "LISTPTOP"
    for _ in range(_MOST_LINES):
        line = session.ask(command, doing=doing).text
        if not line:
            return
        yield line
        command = "LISTP+1"
    session.garbled(doing, "its positions do not end")


def _send(session: Session, name: str, parcel: list[ProgramLine], doing: str, state: str) -> None:
    """Some lines at once; a refused one is named with its place in the file."""
    command = "EMDAT" + VT.join(line.text for line in parcel)
    slot = session.edit_slot
    answer = session.attempt(command, doing=doing, state=state, slot=slot, shape=BARE_ANSWER)
    if answer.number is None:
        return
    if not answer.places:  # not a line is wrong but the moment
        raise session.refusal(answer.number, doing, state)
    nth, column = _place_in_parcel(answer.places)
    line = parcel[min(max(nth, 1), len(parcel)) - 1]
    known = cr_error(answer.number)
    raise Refused(
        rules.LINE_REFUSED(
            path=name,
            line=line.number,
            column=column,
            excerpt=line.text,
            name=name,
            number=f"{answer.number:04}",
            text=known.text,
            cure=known.cure,
            state=state,
        )
    )


def checked_name(name: str) -> str:
    """The name, if a program of a CR controller can have it; raises Refused."""
    if _PROGRAM_NAME.fullmatch(name):
        return name
    reason = "1 to 12 capital letters A-Z and digits are allowed"
    raise Refused(rules.FILE_NAME(place=name, name=name, reason=reason))


def _checked_lines(name: str, data: bytes, most: int) -> list[ProgramLine]:
    """The lines of a program, if the link can carry each of its `most` bytes; raises Refused."""
    lines = program_lines(data)
    findings = [finding for line in lines if (finding := _unsendable(name, line, most))]
    if findings:
        raise Refused(*findings)
    return lines


def _unsendable(name: str, line: ProgramLine, most: int) -> Diagnostic | None:
    text, number = line.text, line.number
    if strange := re.search(r"[\x00-\x08\x0b-\x1f\x7f]", text):
        column, code = strange.start() + 1, ord(strange[0])
        return rules.LINE_CHARACTER(path=name, line=number, column=column, excerpt=text, code=code)
    if len(text) > most:
        return rules.LINE_TOO_LONG(
            path=name, line=number, excerpt=text, length=len(text), most=most
        )
    return None


def _place_in_parcel(places: tuple[int, ...]) -> tuple[int, int | None]:
    """Line of a parcel and character in it, from `<nth line>;<character>` of an answer."""
    return places[0], (places[1] if len(places) > 1 else None)


def _parcels(lines: list[ProgramLine], most: int) -> Iterator[list[ProgramLine]]:
    """Runs of lines that fit into one EMDAT, separators included."""
    parcel: list[ProgramLine] = []
    size = 0
    for line in lines:
        # One byte for the separator before each line but the first.
        size += len(line.text) + bool(parcel)
        if parcel and size > most:
            yield parcel
            parcel, size = [], len(line.text)
        parcel.append(line)
    if parcel:
        yield parcel
