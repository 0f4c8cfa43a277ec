"""Statements, functions and operators of MELFA-BASIC and their equivalents in the pseudo-program.

Each is one row that is read both ways: by the lift and by the writers. Functions that the
pseudo-program lacks are procedures in `library.txt`, written as pseudo text. Where a manual does
not state the result, such as for a text without a number in it, the procedure ends the program.

Sources of the triggers: COSIROP help (MELFA-BASIC IV commands), WTH: the statement after it runs
as the motion begins; WTHIF: the condition is evaluated from the start of the motion on, and no
`Dly` may follow. M_RDst: mm left to the target, M_Ratio: percent of the path that is done (list of
status variables, and the example of the rate of arrival in the help). No manual at hand states how
M_RDst measures the path of a joint move, of an arc, or in a rounded corner.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib.resources import files
from typing import Any, Final

from assistant.languages.patterns import Row, Rows
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure
from assistant.program.rewriting import records, rewrite
from assistant.program.statements import Measure

STATEMENT_ROWS: Final = Rows(
    Row("Dly {seconds}", p.Wait),
    Row("Ovrd {percent}", p.SetOverride),
    Row("Accel {acceleration=100}, {deceleration=100}", p.SetAcceleration),
    Row("HOpen {hand}", p.Gripper, action="open"),
    Row("HClose {hand}", p.Gripper, action="close"),
    Row("Hlt", p.Stop),
)


SAME_UNIT_FUNCTIONS: Final = {
    "abs": "Abs", "sqrt": "Sqr", "exp": "Exp", "ln": "Ln", "round": "CInt", "trunc": "Fix",
    "floor": "Int", "min": "Min", "max": "Max", "length": "Len", "distance": "Dist",
    "inverse": "Inv", "text": "Str", "part": "Mid", "code": "Asc", "character": "Chr",
}  # fmt: skip
"""Functions that take and give the same units."""
STATUS_FUNCTIONS: Final = {
    "joints_here": "J_Curr", "broken_off": "M_SkipCq",
    "date_today": "C_Date", "time_of_day": "C_Time",
}  # fmt: skip
"""Functions without arguments, which are status variables."""
ARM_FUNCTIONS: Final = {"flange_at": "JtoP", "joints_at": "PtoJ"}
"""Functions that count without a tool and a base: with these, manuals leave open what they give."""
TEXT_FUNCTIONS: Final = frozenset({"Str", "Mid", "Chr"})
"""Those that give a text: their names end in `$`."""
BIT_FUNCTIONS: Final = {"bitand": "AND", "bitor": "OR", "bitxor": "XOR"}
"""Functions of bits, which are operators."""
FUNCTIONS_OF_ANGLES: Final = {"sin": "Sin", "cos": "Cos", "tan": "Tan"}
FUNCTIONS_TO_ANGLES: Final = {"atan": "Atn", "atan2": "Atn2", "asin": "ASin", "acos": "ACos"}

ANALOG_REGISTERS: Final = ("M_DIn", "M_DOut")
"""Registers of the network that hold an analog signal: input, output."""
FIRST_ANALOG_REGISTER: Final = 6000
"""Number of the first of them (CC-Link)."""
FIRST_HAND_CHECK: Final = 900
"""Number of the input that M_HndCq(1) reads (COSIROP: HOPEN)."""
HAND_CHECKS: Final = 8
"""Inputs that it reads, one after the other."""


XOR, OR, AND, NOT, _RELATION, SHIFT, SUM, _REMAINDER, _QUOTIENT, TERM, SIGN, POWER = range(1, 13)
"""Higher binds tighter (CR1D detailed specifications, order of operations)."""

_BINARY_OPERATORS: Final[dict[str, tuple[int, str]]] = {
    "xor": (XOR, "XOR"),
    "or": (OR, "OR"),
    "and": (AND, "AND"),
    "=": (_RELATION, "="),
    "<>": (_RELATION, "<> ><"),
    "<": (_RELATION, "<"),
    "<=": (_RELATION, "<= =<"),
    ">": (_RELATION, ">"),
    ">=": (_RELATION, ">= =>"),
    "<<": (SHIFT, "<<"),
    ">>": (SHIFT, ">>"),
    "+": (SUM, "+"),
    "-": (SUM, "-"),
    "mod": (_REMAINDER, "MOD"),
    "div": (_QUOTIENT, "\\"),
    "*": (TERM, "*"),
    "/": (TERM, "/"),
    "^": (POWER, "^"),
}
"""Operator of the pseudo-program → its level and its word, then other spellings of it.

Shifts are not operators of the pseudo-program; they become vendor text.
"""

_PRODUCT: Final = "*"
"""Composes positions, as `@` does."""
OPERATOR_WORDS: Final = {
    name: words.split()[0] for name, (_, words) in _BINARY_OPERATORS.items()
} | {"@": _PRODUCT}
"""Operator of the pseudo-program → its word."""
OPERATOR_NAMES: Final = {
    word: name for name, (_, words) in _BINARY_OPERATORS.items() for word in words.split()
}
OPERATOR_PRECEDENCE: Final = {
    word: _BINARY_OPERATORS[name][0] for word, name in OPERATOR_NAMES.items()
}
"""By the word."""


TRIGGER_MEASURES: Final[Mapping[str, tuple[Measure, str]]] = {
    "M_RDst": ("end", "<="),
    "M_Ratio": ("share", ">="),
}
"""Status variable → what it measures, and the comparison that holds once a place is reached."""


LIBRARY_FUNCTIONS: Final[Mapping[str, Mapping[int, str]]] = {
    "SGN": {1: "sign_of"},
    "LEFT": {2: "left_part"},
    "RIGHT": {2: "right_part"},
    "STRPOS": {2: "place_in"},
    "STRUPR": {1: "upper_letters"},
    "STRLWR": {1: "lower_letters"},
    "CKSUM": {3: "sum_of_codes"},
    "HEX": {1: "hex_digits", 2: "last_hex_digits"},
    "BIN": {1: "binary_digits"},
    "VAL": {1: "number_in"},
    "ZONE2": {4: "in_capsule"},
}
"""Functions of MELFA-BASIC, by their number of arguments, and the equivalent procedures."""


@cache
def library() -> Mapping[str, Procedure]:
    """All of them by their names, without places in a text."""
    from assistant.program.pseudo.parser import parse

    tables = files("assistant.languages.melfa_basic.tables")
    text = tables.joinpath("library.txt").read_text("utf-8")

    def unplaced(node: Any) -> Any:
        return replace(node, span=None) if getattr(node, "span", None) else node

    procedures = rewrite(parse(text).procedures, unplaced, ())
    return {one.name: one for one in procedures}


def library_calls(procedure: Procedure) -> set[str]:
    """The names of the others that one calls."""
    made = (one.function for one in records(procedure.body) if isinstance(one, e.Apply))
    return {name for name in made if name in library()}
