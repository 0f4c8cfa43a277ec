"""Names of a program's objects in MELFA-BASIC: short, by type.

A variable's first letter is its type: P positions, J joints, M numbers, C texts. Names share one
space with the controller's own words; labels have a separate space. Where the version preserves
upper and lower case, a name keeps its spelling as far as that goes.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import field
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.languages.melfa_basic.tables.dialects import PROGRAM_NAME, Dialect
from assistant.languages.melfa_basic.tables.variables import (
    ARC_START,
    FILE_NUMBERS,
    LETTERS,
    MOST_TIMERS,
    PARAMETERS,
    RESERVED_WORDS,
    free_name,
    is_external,
    parameter_position,
)
from assistant.languages.melfa_basic.tables.variables import INTERRUPT_NUMBERS as INTERRUPTS
from assistant.program.analysis.io_use import channels_open_together
from assistant.program.passes.names import free_counters
from assistant.program.program import Parameter, Procedure, Program, TakenNames, Variable, walk
from assistant.program.statements import Label
from assistant.program.undeclared_names import (
    interrupts,
    numbered_channels,
    numbered_interrupts,
    numbered_timers,
)

MAIN: Final = "MAIN"
"""The `Function` that a program of MELFA-BASIC VI begins with."""

_MADE_LABEL: Final = re.compile(r"[IW][0-9]+([TN][0-9]+|Z)?|AC[0-9]+")
"""Labels that a lowered `If` and `Wait` make, and what interrupts call."""


@dataclass(slots=True)
class Names:
    """MELFA-BASIC names by original name (lower case); variables also by procedure.

    products: a target is multiplied by its frame; else `Base` is set to the frame.

    timers, channels, interrupts: their numbers by lower-case name. defined: every interrupt, also
    those that have no number. wait_timer: of those that time limits make.
    numbers: of tools and frames that the controller has, by what they are called.
    position: the first number that `P<number>` and `J<number>` may have.
    """

    targets: dict[str, str] = field(default_factory=dict)
    joints: dict[str, str] = field(default_factory=dict)
    tools: dict[str, str] = field(default_factory=dict)
    frames: dict[str, str] = field(default_factory=dict)
    variables: dict[tuple[str, str], str] = field(default_factory=dict)
    loops: dict[tuple[str, str], str] = field(default_factory=dict)
    procedures: dict[str, str] = field(default_factory=dict)
    labels: dict[tuple[str, str], str] = field(default_factory=dict)
    units: dict[str | None, str] = field(default_factory=dict)
    original_labels: dict[str, str] = field(default_factory=dict)
    original_loops: dict[str, str] = field(default_factory=dict)
    timers: dict[str, int] = field(default_factory=dict)
    channels: dict[str, int] = field(default_factory=dict)
    interrupts: dict[str, int] = field(default_factory=dict)
    defined: frozenset[str] = frozenset()
    wait_timer: int = 1
    position: int = 1
    products: bool = False
    numbers: dict[str, int] = field(default_factory=dict)

    def variable(self, owner: str, name: str) -> str | None:
        """Return the short name of a variable in a procedure; None if the name is not a
        variable.
        """
        owner, key = owner.lower(), name.lower()
        tables = self.variables, self.loops
        own = next((table[owner, key] for table in tables if (owner, key) in table), None)
        return own or self.variables.get(("", key))

    def value(self, owner: str, name: str) -> str | None:
        """The same of a variable, target, tool or frame."""
        tables = self.targets, self.joints, self.tools, self.frames
        given = next((t[name.lower()] for t in tables if name.lower() in t), None)
        return self.variable(owner, name) or given

    def label(self, owner: str, name: str) -> str | None:
        """The same of a label, or of a procedure that is called as one."""
        key = name.lower()
        return self.labels.get((owner.lower(), key)) or self.procedures.get(key)


def naming(program: Program, dialect: Dialect, products: bool = False) -> Names:
    """The names of a whole program; the same program always gets the same."""
    names, taken = Names(products=products), TakenNames((ARC_START, *RESERVED_WORDS))
    for word, table, number, name in counted(program, dialect, products):
        short = parameter_position(PARAMETERS[word].format(number=number))
        (names.tools if table is program.tools else names.frames)[name.lower()] = short
        names.numbers[short] = number
        taken.add(short)
    positions = {name.lower() for name in program.targets}
    for group, letter, given, kind in (
        (names.targets, "P", program.targets, ""),
        (names.joints, "J", program.joint_targets, ""),
        (names.tools, "P", program.tools, "tool"),
        (names.frames, "P", program.frames, "base"),
    ):
        for name in given:
            if name.lower() not in group:
                # A number behind it would make it one more position of the same kind.
                alike = kind and name.lower() in positions
                called = f"{name}_{kind}" if alike else name
                group[name.lower()] = _variable(called, letter, dialect, taken)
    for procedure, owner in _owners(program):
        variables: Iterable[tuple[str, Variable | Parameter]] = program.variables.items()
        if procedure is not None:
            variables = [*((q.name, q) for q in procedure.parameters), *procedure.variables.items()]
        for name, variable in variables:
            letter = LETTERS[variable.type]
            # Other programs know an external variable by its name, which must not change.
            if isinstance(variable, Variable) and is_external(name, variable):
                names.variables[owner, name.lower()] = name.upper()
                taken.add(name.upper())
                continue
            names.variables[owner, name.lower()] = _variable(name, letter, dialect, taken)
        for name in () if procedure is None else free_counters(program, procedure):
            short = _variable(name, "M", dialect, taken)
            names.loops[owner, name.lower()] = short
            names.original_loops[short] = name
    # Functions and variables share one space of names, subroutines have one with the labels.
    labels = taken if dialect.functions else TakenNames(RESERVED_WORDS)
    labels.add(MAIN)
    for entry in program.procedures:
        names.procedures[entry.name.lower()] = _label(entry.name, dialect, labels)
    for entry in program.procedures:
        for statement in walk(entry.body):
            if isinstance(statement, Label):
                key = (entry.name.lower(), statement.name.lower())
                if key not in names.labels:
                    short = _label(statement.name, dialect, labels)
                    names.labels[key] = short
                    names.original_labels[short] = statement.name
    names.units = unit_names(program)
    names.timers, names.wait_timer = numbered_timers(program, range(1, MOST_TIMERS + 1), _TIMER)
    names.channels = numbered_channels(program, FILE_NUMBERS, channels_open_together)
    names.interrupts = numbered_interrupts(program, INTERRUPTS)
    names.defined = frozenset(one.name.lower() for one in interrupts(program))
    # Numbered positions that are made get numbers above all that the program has.
    numbers = (re.fullmatch(r"[PJ]([0-9]{1,8})", name) for name in taken)
    names.position = 1 + max((int(n.group(1)) for n in numbers if n), default=0)
    return names


def counted(
    program: Program, dialect: Dialect, products: bool
) -> Iterator[tuple[str, Mapping[str, object], int, str]]:
    """The tools and frames that the controller has by number: statement, table, number, name.

    A frame that targets are multiplied by is a position of the program's own.
    """
    there = {} if program.interface is None else program.interface.there
    for word, table in (("Tool", program.tools), ("Base", program.frames)):
        most = _MOST_COUNTED[word] if dialect.numbered_frames else 0
        for name in table if word == "Tool" or not products else ():
            number = there.get(name.lower())
            if number is not None and number <= most:
                yield word, table, number, name


_MOST_COUNTED: Final = {"Tool": 16, "Base": 8}
"""Highest numbers (parameters MEXTL1 to MEXTL16, WK1CORD to WK8CORD of CR750)."""


def unit_names(program: Program) -> dict[str | None, str]:
    """Return the names of a program's units, the main one under None."""
    files = TakenNames()
    units: dict[str | None, str] = {None: _program_name(program.name, files)}
    for entry in program.procedures:
        if entry.unit is not None and entry.unit not in units:
            units[entry.unit] = _program_name(entry.unit, files)
    return units


def spelled(program: Program, dialect: Dialect) -> Callable[[str, str, str], str]:
    """Return a function that gives the spelling of a name in the text, see `Language.spelled`;
    signals have numbers.
    """
    names = naming(program, dialect)
    tables = {
        "target": names.targets,
        "joint target": names.joints,
        "tool": names.tools,
        "frame": names.frames,
    }

    def of(kind: str, owner: str, name: str) -> str:
        key = name.lower()
        if kind == "signal":
            return str(program.signals[name].number or "")
        if kind == "procedure":
            first = name == program.entry
            return (MAIN.title() if dialect.functions else "") if first else names.procedures[key]
        if kind == "label":
            return names.labels.get((owner.lower(), key), "")
        if kind in tables:
            return tables[kind].get(key, "")
        short = names.variables.get((owner.lower(), key), "")
        return short + mark(short)

    return of


_TIMER: Final = re.compile(r"M_TIMER\s*\(\s*([0-9]+)", re.IGNORECASE)


def _owners(program: Program) -> Iterable[tuple[Procedure | None, str]]:
    yield None, ""
    for procedure in program.procedures:
        yield procedure, procedure.name.lower()


def mark(short: str) -> str:
    """Return the suffix of a variable where it is used: it marks texts."""
    return "$" if short[:1] in ("C", "c") else ""


def _variable(given: str, letter: str, dialect: Dialect, taken: set[str]) -> str:
    plain = _plain(given, dialect.mixed)
    before = "" if plain[:1].upper() == letter and len(plain) > 1 else letter
    plain = _plain(_shortened(given, dialect.names - len(before), dialect.mixed), dialect.mixed)
    return free_name(_unshared(before + plain), dialect.names, taken)


def _label(given: str, dialect: Dialect, taken: set[str]) -> str:
    plain = _plain(_shortened(given, dialect.labels, dialect.mixed), dialect.mixed)
    # Labels that the compiler makes must not clash with others, and labels begin with a letter.
    if not plain[:1].isalpha() or _MADE_LABEL.fullmatch(plain.upper()):
        plain = "L" + plain
    return free_name(_unshared(plain), dialect.labels, taken)


_WORDS: Final = re.compile(r"[0-9]+|[A-Z]?[a-z]+|[A-Z]+(?![a-z])|.")
"""The words of a name, and what stands between them."""


def _shortened(given: str, most: int, mixed: bool) -> str:
    """A name with at most so many letters and digits: its longest words lose letters at their
    ends, so that each word is still recognised.
    """
    too_many = len(_plain(given, mixed)) - most
    if too_many <= 0:
        return given
    whole = _WORDS.findall(_ascii(given))
    words = list(whole)
    for _ in range(too_many):
        # Of words of equal length, the one that has lost more is cut: its start says more.
        lengths = [
            (len(word), len(whole[at]), -at) for at, word in enumerate(words) if word.isalpha()
        ]
        length, _, at = max(lengths, default=(0, 0, 0))
        if length < 2:
            break
        words[-at] = words[-at][:-1]
    return "".join(words)


def _unshared(name: str) -> str:
    """Without `_` in the second place, which marks what programs share."""
    return name[0] + name[1:].lstrip("_")


def _program_name(given: str, taken: set[str]) -> str:
    """A program name: upper-case letters and digits, at most twelve."""
    plain = _plain(given)
    return free_name(plain or "MAIN", PROGRAM_NAME, taken)


def _plain(given: str, mixed: bool = False) -> str:
    """Letters and digits of a name, in upper case; letters beyond ASCII as those below them.

    mixed: as they are spelled, and with `_` between them.
    """
    ascii = _ascii(given)
    if mixed:
        return re.sub(r"[^A-Za-z0-9_]", "", ascii).strip("_")
    return re.sub(r"[^A-Z0-9]", "", ascii.upper())


def _ascii(given: str) -> str:
    """A name without accents and the letters that have no other form."""
    return unicodedata.normalize("NFKD", given).encode("ascii", "ignore").decode()
