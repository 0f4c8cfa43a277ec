"""What MELFA-BASIC IV, V and VI do differently: one table, read by everything else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Dialect:
    """One version of the language.

    level: a program of a lower one is accepted by a higher one as it stands.
    upper: keywords are written in upper case. step: between step numbers that are written.
    names, labels: most characters of a variable name and a label that is written.
    longest: most characters that are accepted in what others wrote.
    line: most bytes of a step without its line end.
    blocks: `If … Then` may stand alone, up to `EndIf`. breaks: `Break` exists.
    wide_wait: `Wait` takes any condition, not only `variable = constant`.
    nested_select: a `Select` may stand inside another. functions: `Function … FEnd` exists.
    inverse_sines: `ASin` and `ACos` exist.
    groups: bits of a signal group → (input, output) status variable.
    """

    name: str
    title: str
    level: int
    upper: bool
    step: int
    names: int
    labels: int
    longest: int
    line: int
    blocks: bool
    breaks: bool
    wide_wait: bool
    nested_select: bool
    functions: bool
    inverse_sines: bool
    groups: Mapping[int, tuple[str, str]]


LAST_STEP: Final = 32767
"""Highest step number and so most lines of a program (COSIMIR help, CR1D 4.3.4)."""

PROGRAM_NAME: Final = 12
"""Most characters of a program name (CR750 manual 4-136)."""

EMITTED_LINE: Final = 120
"""Bytes that a written line stays under, in every dialect."""

_OLD = {8: ("M_INB", "M_OUTB"), 16: ("M_INW", "M_OUTW")}
_NEW = {8: ("M_In8", "M_Out8"), 16: ("M_In16", "M_Out16"), 32: ("M_In32", "M_Out32")}

DIALECTS: Final = {
    d.name: d
    for d in (
        Dialect(
            "melfa-basic-4", "MELFA-BASIC IV", 4, True, 10, 8, 8, 8, 127,
            False, False, False, False, False, False, _OLD,
        ),
        Dialect(
            "melfa-basic-5", "MELFA-BASIC V", 5, False, 1, 16, 16, 40, 240,
            True, True, True, True, False, True, _NEW,
        ),
        Dialect(
            "melfa-basic-6", "MELFA-BASIC VI", 6, False, 1, 16, 16, 40, 240,
            True, True, True, True, True, True, _NEW,
        ),
    )
}  # fmt: skip
