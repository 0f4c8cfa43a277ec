"""Differences between MELFA-BASIC IV, V and VI: one table, read by all other modules.

The statements, functions and status variables of each version are in `vocabulary`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from assistant.base.data_classes import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """One version of the language; what is not stated is as in V and VI.

    A source in brackets is a manual or tool of the maker.
    """

    name: str
    title: str
    level: int
    """A program of a lower one is accepted by a higher one as it stands [CR1D 4-130]."""

    # ------------------------------------------------------------------------- lines
    upper: bool = False
    """Keywords are written in upper case; all three read both cases [COSIROP, CR1D 4.3.6]."""
    step: int = 1
    """Between step numbers that are written: the first one, too [COSIROP, RT ToolBox]."""
    steps_needed: bool = False
    """A source without step numbers is refused; RT ToolBox numbers the lines that it is given."""
    line: int = 240
    """Most bytes of a step without its line end [COSIROP, CR1D: 127]. For V and VI no limit is
    published: programs with 204 bytes exist, and the link to the controller carries 255."""
    labelled_statements: bool = True
    """`*NAME:statement` on one step [CR1D 4.3.5]."""
    line_targets: bool = False
    """Jumps may name a step number. V and VI read it, their tools renumber steps [CR1D 4-208]."""

    # ------------------------------------------------------------------------- names
    names: int = 16
    """Most characters of a variable's name that is written [CR1D: 8; CR750 4-136]."""
    labels: int = 16
    """Most characters of a label that is written [CR1D 4.3.5: 8]."""
    mixed: bool = False
    """Names are written as they are spelled, in both cases and with `_`; else in upper case, as a
    controller may store them [CR1D 4.3.6]."""
    longest: int = 40
    """Most characters of names and labels that others wrote. No manual states it for V and VI."""
    label_underscores: bool = True
    """`_` from the third character of a label [CR750]; before only as `L_`, a shared label."""
    suffixes: str = "$%&!#"
    """Type marks behind a name: text, 16 bit, 32 bit, single, double [CR750 4-394]."""

    # -------------------------------------------------------------------- statements
    blocks: bool = True
    """`If … Then` may open a block that ends with `EndIf` [CR1D 4-208]."""
    breaks: bool = True
    """`Break` leaves If, For and While; out of a Select it leads in every version [CR1D 4-208]."""
    wide_wait: bool = True
    """`Wait` takes any condition, not only `variable = constant` [COSIROP, RT ToolBox]."""
    nested_select: bool = True
    """A `Select` may stand inside another [COSIROP]."""
    singular_type: bool = True
    """`Type c,2`: through a singular point [RT ToolBox]."""
    fine_distance: bool = True
    """`Fine mm,P` and `Fine deg,J` beside pulses [RT ToolBox]."""
    numbered_frames: bool = True
    """`Tool 1` and `Base 1` pick stored ones [RT ToolBox]."""
    shortest_wait: float = 0.01
    """Seconds that `Dly` waits at least [COSIROP]; V counts in hundredths."""

    # -------------------------------------------------------------------- procedures
    functions: bool = False
    """`Function … FEnd`, called by name [RT ToolBox]."""

    # ------------------------------------------------------------------------ values
    groups: Mapping[int, tuple[str, str]]
    """Bits of a signal group → (input, output) status variable."""

    # How deep each construct may stand inside its like [CR1D 4-151, 4-159, 4-208, COSIROP]
    loops: int = 16
    """`For` and `While` together."""
    ifs: int = 8
    """`If … EndIf`."""
    calls: int = 8
    """`CallP` that has not come back."""


LAST_STEP: Final = 32767
"""Highest step number and so most lines of a program (COSIMIR help, CR1D 4.3.4)."""

PROGRAM_NAME: Final = 12
"""Most characters of a program name (CR750 manual 4-136)."""

EMITTED_LINE: Final = 120
"""Bytes that a written line stays under, in every dialect."""

_FOUR: Final = Dialect(
    name="melfa-basic-4",
    title="MELFA-BASIC IV",
    level=4,
    upper=True,
    step=10,
    steps_needed=True,
    line=127,
    labelled_statements=False,
    line_targets=True,
    names=8,
    labels=8,
    longest=8,
    label_underscores=False,
    suffixes="$%!#",
    blocks=False,
    breaks=False,
    wide_wait=False,
    nested_select=False,
    singular_type=False,
    fine_distance=False,
    numbered_frames=False,
    shortest_wait=0.05,
    groups={8: ("M_INB", "M_OUTB"), 16: ("M_INW", "M_OUTW")},
    calls=7,
)
"""Controllers CR1 to CR9 (CRn-500)."""

_FIVE: Final = Dialect(
    name="melfa-basic-5",
    title="MELFA-BASIC V",
    level=5,
    groups={8: ("M_In8", "M_Out8"), 16: ("M_In16", "M_Out16"), 32: ("M_In32", "M_Out32")},
)
"""Controllers CRnD-700, CRnQ-700, CR750, CR751."""

_SIX: Final = replace(
    _FIVE,
    name="melfa-basic-6",
    title="MELFA-BASIC VI",
    level=6,
    names=20,  # programs that others wrote have such in plenty, and longer ones
    labels=20,
    mixed=True,
    functions=True,
)
"""Controller CR800."""

DIALECTS: Final = {dialect.name: dialect for dialect in (_FOUR, _FIVE, _SIX)}
