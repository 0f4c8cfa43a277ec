"""Client of a Mitsubishi CR controller: its programs, by the controller link over TCP.

A program is written in the edit slot and takes the old one's place with SAVE; up to there
NEW throws the edit away.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Final, Self

from assistant.controllers import rules
from assistant.controllers.address import Address
from assistant.controllers.mitsubishi import listing
from assistant.controllers.mitsubishi.errors import error
from assistant.controllers.mitsubishi.link import MOST_BYTES, Answer, Link
from assistant.controllers.mitsubishi.listing import Line
from assistant.program.diagnostics import Diagnostic, Refused

OPEN_NAME: Final = "USERTOOL"
"""Name under which a session is opened; controllers know NARCUSR, USERTOOL and TOOLBOX."""
VT: Final = "\v"
NO_RIGHT: Final = 6020
PROGRAM_NAME: Final = re.compile(r"[A-Z0-9]{1,12}")
LANGUAGES: Final = {
    "MB4": ("melfa-basic-4",),
    "MB5": ("melfa-basic-5",),
    "MB6": ("melfa-basic-6",),
}
"""Suffix of a controller's program files → languages of the programs that it takes."""
EVERY_LANGUAGE: Final = tuple(name for names in LANGUAGES.values() for name in names)
MOST_PROGRAMS: Final = 100_000
"""Entries after which a folder that never ends is taken for a fault."""
UNCHANGED: Final = "nothing was changed by that"


@dataclass(frozen=True, slots=True)
class Identity:
    """What a controller says of itself when a session is opened; "" for what it does not say.

    suffix: of its program files. slots: number of its task slots; the edit slot follows.
    """

    robot: str = ""
    controller: str = ""
    version: str = ""
    suffix: str = ""
    slots: int = 8


class Cr:
    """A session with a CR controller; see `Controller`.

    timeout: seconds for an answer.
    """

    lists: tuple[str, ...] = ()

    def __init__(
        self, address: Address, *, timeout: float = 10.0, terminator: bytes = b"\r"
    ) -> None:
        self.address = address
        self.identity = Identity()
        self.languages: tuple[str, ...] = EVERY_LANGUAGE
        self._link = Link(address.host, address.port, timeout=timeout, terminator=terminator)
        self._has_right = False

    def __repr__(self) -> str:
        return f"Cr({str(self.address)!r})"

    def __enter__(self) -> Self:
        """Connects and opens a session."""
        self._link.open()
        try:
            answer = self._link.ask(
                f"1;1;OPEN={OPEN_NAME}", doing="opening a session", state=UNCHANGED
            )
        except BaseException:
            self._link.close()
            raise
        if answer.ok:  # a controller without OPEN still takes the other commands
            self.identity = identity(answer.text)
            self.languages = LANGUAGES.get(self.identity.suffix, EVERY_LANGUAGE)
        return self

    def __exit__(self, *error: object) -> None:
        if self._link.connected:
            with suppress(Refused):
                if self._has_right:
                    self._ask("CNTLOFF", doing="giving the operation right back")
                self._ask("CLOSE", doing="closing the session")
        self._has_right = False
        self._link.close()

    def names(self) -> tuple[str, ...]:
        """Names without suffix."""
        doing = "listing the programs"
        found = set()
        entry = self._ask("PDIRTOP", doing=doing).text
        for index in range(1, MOST_PROGRAMS):
            name, _, suffix = entry.partition(";")[0].partition(".")
            if suffix.upper() in LANGUAGES or not suffix:
                found.add(name)
            entry = self._ask(f"PDIR{index}", doing=doing).text
            if not entry.strip("; "):
                break
        return tuple(sorted(found - {""}))

    def read(self, name: str) -> bytes | None:
        """The listing: steps, then variables, each line with CR LF."""
        if checked_name(name) not in self.names():
            return None  # LOAD= would create it
        doing = f"reading `{name}`"
        with self._editing(name, doing, UNCHANGED):
            lines = [*self._steps(doing), *self._variables(doing)]
        return "".join(f"{line}\r\n" for line in lines).encode(listing.ENCODING)

    def write(self, name: str, data: bytes) -> None:
        """Replaces the program; its lines are all looked at before the first is sent."""
        checked_name(name)
        most = MOST_BYTES - len(f"1;{self._edit_slot};EMDAT")
        parcels = list(_parcels(checked_lines(name, data, most), most))
        state = f"`{name}` there is as it was"
        doing = f"writing `{name}`"
        with self._editing(name, doing, state):
            self._ask("ECLR", doing=doing, state=state, slot=self._edit_slot)
            for parcel in parcels:
                self._send(name, parcel, doing, state)
            saved = f"`{name}` there is either the old program or the new one"
            self._ask("SAVE", doing=f"saving `{name}`", state=saved)

    def remove(self, name: str) -> None:
        if checked_name(name) in self.names():
            suffix = f".{self.identity.suffix}" if self.identity.suffix else ""
            doing, state = f"deleting `{name}`", f"`{name}` is still there"
            self._ask(f"FDEL{name}{suffix}", doing=doing, state=state)

    def name_for(self, file_name: str | FilePath) -> str:
        """The file's name without suffix, in capitals."""
        return checked_name(FilePath(file_name).stem.upper())

    def stored(self, data: bytes) -> bytes:
        """As a controller lists it: steps in order, variables by name with two decimals."""
        return listing.listed(data)

    @property
    def _edit_slot(self) -> int:
        return self.identity.slots + 1

    def _ask(self, command: str, *, doing: str, state: str = UNCHANGED, slot: int = 1) -> Answer:
        """An answer that is no error; takes the operation right where it is asked for."""
        answer = self._try(command, doing, state, slot)
        if answer.number is not None:
            raise Refused(self._alarm(answer.number, doing, state))
        return answer

    def _try(self, command: str, doing: str, state: str, slot: int) -> Answer:
        answer = self._link.ask(f"1;{slot};{command}", doing=doing, state=state)
        if answer.number != NO_RIGHT or self._has_right:
            return answer
        right = self._link.ask("1;1;CNTLON", doing=doing, state=state)
        if not right.ok:
            return right
        self._has_right = True
        return self._link.ask(f"1;{slot};{command}", doing=doing, state=state)

    def _alarm(self, number: int, doing: str, state: str) -> Diagnostic:
        known = error(number)
        return rules.ALARM(
            place=str(self.address),
            number=f"{number:04}",
            text=known.text,
            cure=known.cure,
            doing=doing,
            state=state,
        )

    @contextmanager
    def _editing(self, name: str, doing: str, state: str) -> Iterator[None]:
        """With the program in the edit slot; leaves it empty again whatever happens."""
        self._ask("NEW", doing=doing, state=state)
        self._ask(f"LOAD={name}", doing=doing, state=state)
        try:
            yield
        finally:
            if self._link.connected:
                with suppress(Refused):
                    self._ask("NEW", doing=f"closing `{name}`", state=state)

    def _steps(self, doing: str) -> Iterator[str]:
        command = "LISTLTOP"
        while True:
            text = self._ask(command, doing=doing).text
            if not text.strip("; "):
                return
            parts = text.rsplit(";", 2)  # a line may hold a semicolon, the numbers may not
            if len(parts) < 3 or parts[2].strip() not in ("0", "1"):
                self._nonsense(text, doing)
            yield from (line for line in parts[0].split(VT) if line)
            if parts[2].strip() == "0":
                return
            command = "LISTL+1"

    def _variables(self, doing: str) -> Iterator[str]:
        line = self._ask("LISTPTOP", doing=doing).text
        while line:
            yield line
            line = self._ask("LISTP+1", doing=doing).text

    def _nonsense(self, text: str, doing: str) -> None:
        self._link.close()
        raise rules.Lost(
            rules.GARBLED(
                place=str(self.address), doing=doing, answer=repr(text[:80]), state=UNCHANGED
            )
        )

    def _send(self, name: str, parcel: list[Line], doing: str, state: str) -> None:
        """Some lines at once; a refused one is named with its place in the file."""
        command = "EMDAT" + VT.join(line.text for line in parcel)
        answer = self._try(command, doing, state, self._edit_slot)
        if answer.number is None:
            return
        if not answer.places:  # not a line is wrong but the moment
            raise Refused(self._alarm(answer.number, doing, state))
        nth, column = place_in_parcel(answer.places)
        line = parcel[min(max(nth, 1), len(parcel)) - 1]
        known = error(answer.number)
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


def identity(text: str) -> Identity:
    """What the answer to OPEN= says; fields that are missing stay empty."""
    fields = dict(enumerate(text.split(";")))
    slots = fields.get(15, "").strip()
    return Identity(
        robot=fields.get(6, "").strip(),
        controller=fields.get(7, "").strip(),
        version=fields.get(10, "").strip(),
        suffix=fields.get(4, "").strip().upper(),
        slots=int(slots) if re.fullmatch(r"[1-9]\d?", slots) else 8,
    )


def checked_name(name: str) -> str:
    """The name, if a program of a CR controller can have it; raises Refused."""
    if PROGRAM_NAME.fullmatch(name):
        return name
    reason = "1 to 12 capital letters A-Z and digits are allowed"
    raise Refused(rules.FILE_NAME(place=name, name=name, reason=reason))


def checked_lines(name: str, data: bytes, most: int) -> list[Line]:
    """The lines of a program, if the link can carry each of its `most` bytes; raises Refused."""
    lines = listing.lines_of(data)
    findings = [finding for line in lines if (finding := _unsendable(name, line, most))]
    if findings:
        raise Refused(*findings)
    return lines


def _unsendable(name: str, line: Line, most: int) -> Diagnostic | None:
    text, number = line.text, line.number
    if strange := re.search(r"[\x00-\x08\x0b-\x1f\x7f]", text):
        column, code = strange.start() + 1, ord(strange[0])
        return rules.LINE_CHARACTER(path=name, line=number, column=column, excerpt=text, code=code)
    if len(text) > most:
        return rules.LINE_TOO_LONG(
            path=name, line=number, excerpt=text, length=len(text), most=most
        )
    return None


def place_in_parcel(places: tuple[int, ...]) -> tuple[int, int | None]:
    """Line of a parcel and character in it, from `<nth line>;<character>` of an answer."""
    return places[0], (places[1] if len(places) > 1 else None)


def _parcels(lines: list[Line], most: int) -> Iterator[list[Line]]:
    """Runs of lines that fit into one EMDAT, separators included."""
    parcel: list[Line] = []
    size = 0
    for line in lines:
        size += len(line.text) + bool(parcel)
        if parcel and size > most:
            yield parcel
            parcel, size = [], len(line.text)
        parcel.append(line)
    if parcel:
        yield parcel
