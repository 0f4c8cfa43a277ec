"""Variables: their types, the letters that their names begin with, and those of all programs."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from assistant.program.program import ValueType, Variable

LETTERS: Final[dict[ValueType, str]] = {
    "number": "M", "integer": "M", "truth": "M", "text": "C",
    "position": "P", "pose": "P", "joints": "J",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class DataType:
    """A type that `Def` gives a variable.

    letter: `M` (number), `C` (text), `P` (position) or `J` (joints). value: what it is in a
    pseudo-program, None for nothing. mark: what stands behind names of the type. whole: least and
    greatest of whole numbers. wider: the type that reaches further.
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
    """Whether it is one variable of all programs of a controller, which its name must stay for.

    The second character of such a name is `_` (CR1D 4.3.7); first values of its own it has none.
    """
    written = re.fullmatch(r"[PJMC]_[A-Z0-9_]+", name.upper())
    return (
        written is not None
        and variable.storage == "persistent"
        and (variable.initial is None or re.fullmatch(r"._[01][0-9]", name) is not None)
        and name[0].upper() == LETTERS[variable.type]
    )


def is_of_controller(name: str) -> bool:
    """Whether every controller has an external variable of that name, which nobody declares."""
    return re.fullmatch(r"[PJMC]_([01][0-9]|10[0-4])", name.upper()) is not None


PARAMETERS: Final = {"Tool": "MEXTL{number}", "Base": "WK{number}CORD"}
"""Parameters that hold the tool and the work coordinates of a number (manual CR1D: Tool, Base)."""


LAST_SET_PARAMETERS: Final = {"Tool": "MEXTL", "Base": "MEXBS"}
"""Parameters that hold the tool and the base which a program was given last, by the statement."""
NEUTRAL_SETTINGS: Final = {"Tool": "P_NTool", "Base": "P_NBase"}
"""What a statement is given to set none."""
SETTING_STATUS: Final = {"Tool": "M_TOOL", "Base": "M_BSNO"}
"""The status variable that sets the same as a statement."""


def parameter_position(parameter: str) -> str:
    """The position of a program's list that says what a parameter of its cell holds."""
    return f"P{parameter}"


TAUGHT_STATUS: Final = ("P_SAFE",)
"""Status variables that hold what somebody taught on the controller (parameter JSAFE)."""
