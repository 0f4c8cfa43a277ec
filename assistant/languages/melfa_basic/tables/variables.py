"""Variables: types, names and reserved words; numbers of timers, interrupts, files
and signals.

The first letter of a name states the type. A second character `_` marks variables that all
programs of a controller share (CR1D 4.3.7).

Sources: COSIROP help and the CR controller manuals (Open, Print, Input, Close, M_Open, DEF ACT,
ACT); BFP-A3379, Ethernet function (COMDEV, CPRCE11 to 19, NETMODE, NETPORT, NETHSTIP).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.languages.melfa_basic.tables.vocabulary import functions, statement, statements
from assistant.program.program import TakenNames, ValueType, Variable
from assistant.program.statements import ChannelMode

LETTERS: Final[dict[ValueType, str]] = {
    "number": "M", "integer": "M", "truth": "M", "text": "C",
    "position": "P", "pose": "P", "joints": "J",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class DataType:
    """A type that `Def` gives a variable.

    letter: `M` (number), `C` (text), `P` (position) or `J` (joints). value: its type in a
    pseudo-program, None without equivalent. mark: suffix of names of the type. whole: least and
    greatest of integers. wider: the type with the larger range.
    """

    word: str
    letter: str
    value: ValueType | None
    title: str
    mark: str = ""
    whole: tuple[int, int] | None = None
    wider: str = ""


TYPES: Final = {
    row.word: row
    for row in (
        DataType("Inte", "M", "integer", "16-bit integers", "%", (-(2**15), 2**15 - 1), "Long"),
        DataType("Long", "M", "integer", "32-bit integers", "&", (-(2**31), 2**31 - 1), "Double"),
        DataType("Float", "M", "number", "single precision", "!"),
        DataType("Double", "M", "number", "double precision", "#"),
        DataType("Char", "C", "text", "a text", "$"),
        DataType("Pos", "P", "position", "a position"),
        DataType("Jnt", "J", "joints", "joints"),
        DataType("Work", "P", None, "a work coordinate"),
    )
}
"""By the word behind `Def`."""
TYPE_MARKS: Final = {row.mark: row for row in TYPES.values() if row.mark}
VALUE_TYPES: Final = {row.word: row.value for row in TYPES.values() if row.value}
"""Word of a type → what it is in a pseudo-program."""
MARK_VALUE_TYPES: Final = {row.mark: row.value for row in TYPE_MARKS.values() if row.value}
"""Mark behind a name → what it is in a pseudo-program."""


def is_external(name: str, variable: Variable) -> bool:
    """True for a variable that all programs of a controller share, so that its name must not
    change.

    The second character of such a name is `_` (CR1D 4.3.7); it has no initial value in a program.
    """
    written = re.fullmatch(r"[PJMC]_[A-Z0-9_]+", name.upper())
    return (
        written is not None
        and variable.storage == "persistent"
        and (variable.initial is None or re.fullmatch(r"._[01][0-9]", name) is not None)
        and name[0].upper() == LETTERS[variable.type]
    )


def is_of_controller(name: str) -> bool:
    """True if every controller has an external variable of that name, without a declaration."""
    return re.fullmatch(r"[PJMC]_([01][0-9]|10[0-4])", name.upper()) is not None


PARAMETERS: Final = {"Tool": "MEXTL{number}", "Base": "WK{number}CORD"}
"""Parameters that hold the tool and the work coordinates of a number (manual CR1D: Tool, Base)."""


LAST_SET_PARAMETERS: Final = {"Tool": "MEXTL", "Base": "MEXBS"}
"""Parameters that hold the tool and the base which a program was given last, by the statement."""
NEUTRAL_SETTINGS: Final = {"Tool": "P_NTool", "Base": "P_NBase"}
"""Arguments of the statements that set no tool and no base."""
SETTING_STATUS: Final = {"Tool": "M_TOOL", "Base": "M_BSNO"}
"""The status variable that sets the same as a statement."""


def parameter_position(parameter: str) -> str:
    """The position of a program's list that says what a parameter of its cell holds."""
    return f"P{parameter}"


TAUGHT_STATUS: Final = ("P_SAFE",)
"""Status variables that hold what somebody taught on the controller (parameter JSAFE)."""


MOST_PULSES: Final = 4
"""Pulses that run at a time; one more is an error (COSIROP help: DLY)."""


def keyword_spelling(word: str) -> str:
    """A keyword of any case as the tools spell it; words that are not listed stay."""
    known = statement(word)
    return " ".join(word.split()) if known is None else known.word


RESERVED_WORDS: Final = frozenset(statements()) | frozenset(functions())
"""Words that no variable or label may be called, in upper case."""

ARC_START: Final = "PSTART"
"""Holds the present position for an arc whose start is no known position."""


def free_name(name: str, most: int, taken: set[str]) -> str:
    """A name of at most so many characters that begins like the given one; then it is taken.

    taken: in upper case, as names that differ in case alone are the same.
    """
    found = name[:most].rstrip("_")
    if found.upper() in taken:
        # A number after a digit would read as one number, so a letter separates them.
        mark = "Z" if name[-1:].isdigit() else ""
        # Counting continues from the last number of the same beginning instead of trying all again.
        counts = taken.counts if isinstance(taken, TakenNames) else {}
        key = found.upper(), mark, most
        count = counts.get(key, 2)
        while (found := name[: most - len(f"{mark}{count}")] + f"{mark}{count}").upper() in taken:
            count += 1
        counts[key] = count
    taken.add(found.upper())
    return found


OPTIMUM_SPEED: Final = 10000.0
"""mm/s that `M_NSpd` stands for: as fast as the arm can. A higher speed is this one."""


TIMER_WORD: Final = "M_Timer"
MOST_TIMERS: Final = 8
"""Number of timers of the older controllers; no source states more."""
MILLISECONDS: Final = 1000
"""Milliseconds in a second."""


INTERRUPT_NUMBERS: Final = range(1, 9)
ALL_INTERRUPTS: Final = 0
"""By which `Act` lets all of them come, or none."""


FILE_NUMBERS: Final = range(1, 9)
"""Files that may be open at once."""
FILE_MODES: Final[Mapping[str, ChannelMode]] = {
    "Input": "read",
    "Output": "write",
    "Append": "append",
}
FILE_MODE_WORDS: Final[Mapping[str, str]] = {mode: word for word, mode in FILE_MODES.items()}
LINE_NAME: Final = re.compile(r"\s*COM([1-8]):\s*", re.IGNORECASE)
ETHERNET_LINES: Final = (3, 4, 5, 6, 7, 8, 2)
"""Lines that channels of TCP/IP get, in this order: the first ones are often serial."""
LONGEST_FILE_NAME: Final = 16
"""Characters of the name of a file (COSIROP: OPEN)."""
CONNECTION_STATUS: Final = "M_Open"


_HANDS: Final = range(900, 908)
"""Signals of the hands: valves, and the switches that check them."""
REGISTER_NUMBERS: Final = "the register of the network that holds it, from 6000 on (CC-Link)"
"""For the person who fills in a cell file: those of analog signals."""
SIGNAL_NUMBERS: Final = (
    "as wired: 0 to 255 parallel, 900 to 907 hand, from 2000 PROFIBUS or EtherNet/IP, "
    "from 6000 CC-Link"
)
"""For the person who fills in a cell file. As the samples of the manuals and public programs have
them; which of the networks are there depends on the cards in the controller."""
DEDICATED_SIGNALS: Final = MappingProxyType({
    "input": MappingProxyType({
        0: "stops all programs (STOP)",
        1: "switches the motors off (SRVOFF)",
        2: "resets errors (ERRRESET)",
        3: "starts the programs (START)",
        4: "switches the motors on (SRVON)",
        5: "gives the right of operation (IOENA)",
        **dict.fromkeys(_HANDS, "checks a hand"),
    }),
    "output": MappingProxyType({
        0: "reports that a program runs (START)",
        1: "reports that the motors are on (SRVON)",
        2: "reports an error (ERRRESET)",
        3: "reports the right of operation (IOENA)",
        **dict.fromkeys(_HANDS, "drives a hand"),
    }),
})  # fmt: skip
"""What a new controller does by each number, with the parameter that changes it. Unconfirmed: the
numbers are those that users of CR1, CR750 and CR800 know, and no manual at hand states them.
"""


def line_name(number: int) -> str:
    return f"COM{number}:"
