"""Functions of the pseudo-program under the names that MELFA-BASIC has for them."""

from __future__ import annotations

from typing import Final

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
"""Registers of the network that an analog signal stands in: input, output."""
FIRST_ANALOG_REGISTER: Final = 6000
"""Number of the first of them (CC-Link)."""
FIRST_HAND_CHECK: Final = 900
"""Number of the input that M_HndCq(1) reads (COSIROP: HOPEN)."""
HAND_CHECKS: Final = 8
"""Inputs that it reads, one after the other."""
