"""Programs of a virtual CR controller: numbered lines and position variables, kept in a folder."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import field
from datetime import datetime
from pathlib import Path as FilePath
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.file_access import read_file, write_whole
from assistant.base.source_text import lines_of

ENCODING: Final = "latin-1"
"""Bytes are kept one to one, whatever code page the client writes its comments in."""

_MOST_FILES: Final = 128
CAPACITY: Final = 220_160
"""Bytes for programs, as an RV-3SB reported of itself (PDIRTOP)."""
NAME: Final = re.compile(r"[A-Z0-9]{1,12}")
STEP: Final = re.compile(r"\s*(\d+)(?:[ \t]([ \t]*\S.*?))?\s*", re.DOTALL | re.ASCII)
_VARIABLE: Final = re.compile(
    r"\s*([A-Za-z]\w*(?:\([\d, ]*\))?)\s*=\s*(\([^()]*\))\s*(\([^()]*\))?\s*", re.DOTALL | re.ASCII
)
LAST_LINE: Final = 32767


class CrRefusal(Exception):
    """A command that the controller answers with an error number.

    places: what follows the number: line and character of an edit.
    """

    def __init__(self, number: int, *places: int) -> None:
        super().__init__(number, *places)
        self.number = number
        self.places = places


@dataclass
class CrProgram:
    """A program: steps by number, position variables by name in capitals, as their lines.

    values: the other variables that have a value, as `M1=+3`; they are no part of the text.
    protected: `p` for lines, `q` for variables that may not be changed.
    """

    steps: dict[int, str] = field(default_factory=dict)
    variables: dict[str, str] = field(default_factory=dict)
    changed: datetime | None = None
    values: dict[str, str] = field(default_factory=dict)
    protected: set[str] = field(default_factory=set)
    _sorted: list[str] | None = field(default=None, compare=False, repr=False)

    def copy(self) -> CrProgram:
        return CrProgram(
            dict(self.steps),
            dict(self.variables),
            self.changed,
            dict(self.values),
            set(self.protected),
        )

    def put(self, line: str) -> None:
        """Takes one line in; a step number alone deletes that step.

        Raises CrRefusal: 4420 for a number out of range, 4220 for what is neither kind of line.
        """
        self._sorted = None
        if step := STEP.fullmatch(line):
            self._may("p", 4240)
            # Six digits are more than any step number: longer ones are out of range as well.
            number = int(step[1][:6])
            if not 1 <= number <= LAST_LINE:
                raise CrRefusal(4420, 1)
            if step[2]:
                self.steps[number] = f"{number} {step[2]}"
            else:
                self.steps.pop(number, None)
        elif variable := _VARIABLE.fullmatch(line):
            self._may("q", 4320)
            name = re.sub(r"\s+", "", variable[1])
            flags = re.sub(r"\s+", "", variable[3] or "")
            self.variables[name.upper()] = f"{name}={listed_values(variable[2])}{flags}"
        else:
            raise CrRefusal(4220, 1)

    def _may(self, letter: str, error: int) -> None:
        if letter in self.protected:
            raise CrRefusal(error)

    def keep(self, name: str, value: str) -> None:
        """Gives a variable a value, written as a controller lists it."""
        self._may("q", 4320)
        self._sorted = None
        (self.variables if value.startswith("(") else self.values)[name.upper()] = f"{name}={value}"

    def renumber(self, steps: dict[int, str]) -> None:
        self._may("p", 4240)
        self.steps = steps

    def valued(self, kinds: str) -> list[str]:
        """The lines of all variables of some classes (M, C, P, J), in order of their names."""
        lines = self.variables | self.values
        return [lines[n] for n in sorted(lines, key=_in_order) if class_of(lines[n]) in kinds]

    def clear(self) -> None:
        self._may("p", 4240)
        self.values.clear()
        self.steps.clear()
        self.variables.clear()
        self._sorted = None

    def lines(self) -> list[str]:
        """The steps in order."""
        return [self.steps[number] for number in sorted(self.steps)]

    def positions(self) -> list[str]:
        """The variables in order of their names, P2 before P10."""
        if self._sorted is None:  # a listing asks for one after the other
            self._sorted = [self.variables[n] for n in sorted(self.variables, key=_in_order)]
        return self._sorted

    def text(self) -> str:
        return "".join(f"{line}\r\n" for line in [*self.lines(), *self.positions()])

    @property
    def size(self) -> int:
        return sum(map(len, self.steps.values())) + sum(map(len, self.variables.values()))


class CrStore:
    """The programs of a controller by name; in a folder each is a file `NAME.prg`.

    folder: None to keep them in memory only.
    """

    def __init__(
        self,
        folder: FilePath | None = None,
        *,
        capacity: int = CAPACITY,
        most_files: int = _MOST_FILES,
    ) -> None:
        self._folder = folder
        self._programs: dict[str, CrProgram] = {}
        self.capacity = capacity
        self.most_files = most_files
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
            for file in sorted(folder.glob("*.prg")):
                if NAME.fullmatch(file.stem.upper()):
                    self._programs[file.stem.upper()] = _program_of(file)

    def __contains__(self, name: str) -> bool:
        return name in self._programs

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._programs))

    def __len__(self) -> int:
        return len(self._programs)

    def __getitem__(self, name: str) -> CrProgram:
        return self._programs[name]

    def get(self, name: str) -> CrProgram | None:
        return self._programs.get(name)

    @property
    def used(self) -> int:
        return sum(program.size for program in self._programs.values())

    def save(self, name: str, program: CrProgram) -> None:
        """Keeps a program; raises CrRefusal 4100 or 4110 if there is no room, 4200 of the disk."""
        old = self._programs.get(name)
        if old is None and len(self._programs) >= self.most_files:
            raise CrRefusal(4100)
        if self.used - (old.size if old else 0) + program.size > self.capacity:
            raise CrRefusal(4110)
        if self._folder is not None:
            try:
                # The file first: a full disk must not leave a
                # program in memory that the next start lacks.
                write_whole(self._folder / f"{name}.prg", program.text().encode(ENCODING))
            except OSError:
                raise CrRefusal(4200) from None
        # A copy: the edit that was saved goes on changing.
        self._programs[name] = program.copy()

    def delete(self, name: str) -> None:
        """Raises CrRefusal 7010 if there is no such program."""
        if name not in self._programs:
            raise CrRefusal(7010)
        if self._folder is not None:
            try:
                (self._folder / f"{name}.prg").unlink(missing_ok=True)
            except OSError:
                raise CrRefusal(4200) from None
        del self._programs[name]


def checked_name(text: str) -> str:
    """A program's name without its suffix; raises CrRefusal 4120 or 4130."""
    name = re.sub(r"\.MB[456]$", "", text.strip())
    if len(name) > 12:
        raise CrRefusal(4120)
    if not NAME.fullmatch(name):
        raise CrRefusal(4130)
    return name


def class_of(line: str) -> str:
    """M, C, P or J of a variable with its value: `P1=(…)(7,0)`."""
    _, _, value = line.partition("=")
    if value.startswith("("):
        return "P" if value.count("(") == 2 else "J"
    return "C" if value.startswith('"') else "M"


def program_of(text: str, *, strict: bool = False) -> CrProgram:
    """Return a program from its text. strict: raises CrRefusal 4160 for lines that are not of a
    program; otherwise they are left out.
    """
    program = CrProgram()
    for line in lines_of(text):
        if STEP.fullmatch(line) or _VARIABLE.fullmatch(line):
            program.put(line)
        elif strict and line.strip():
            raise CrRefusal(4160)
    return program


def _program_of(file: FilePath) -> CrProgram:
    """A file of an earlier run."""
    program = program_of(read_file(file).decode(ENCODING))
    program.changed = datetime.fromtimestamp(file.stat().st_mtime)
    return program


def listed_values(text: str) -> str:
    """Bracketed numbers as the controller lists them: a sign, two decimals."""
    items = [item.strip() for item in text.strip("()").split(",")]
    # + 0.0 turns -0.00 into 0.00.
    return "(" + ",".join(f"{float(item) + 0.0:+.2f}" if item else "" for item in items) + ")"


def _in_order(name: str) -> list[tuple[int, str]]:
    return [(int(p), "") if p.isdigit() else (-1, p) for p in re.split(r"(\d+)", name)]
