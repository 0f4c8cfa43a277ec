"""Statements of interrupts: what calls a procedure in the midst of others.

An interrupt is looked for between two statements, and while one waits or moves. While its condition
holds and it is on, its procedure is called, again and again; the arm stands still meanwhile, and
goes on with its move behind it. No interrupt comes while the procedure of one runs. Those that come
at once are answered in the order in which they were defined.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from assistant.program.calls import Call
from assistant.program.expressions import Expression
from assistant.program.spanned import Spanned

State = Literal["on", "off"]


@dataclass(frozen=True, slots=True)
class Interrupt(Spanned):
    """From here on what an interrupt is: `call` is made while `condition` holds and it is on.

    It is off until it is switched on. call: of a procedure without parameters. ends: if that holds
    behind the call, the cycle of the program ends there, and the arm stays where it is.
    """

    name: str
    condition: Expression
    call: Call
    ends: Expression | None = None


@dataclass(frozen=True, slots=True)
class SwitchInterrupt(Spanned):
    """Lets one interrupt come, or not; what held meanwhile and does no more, is lost."""

    name: str
    state: State


@dataclass(frozen=True, slots=True)
class SwitchInterrupts(Spanned):
    """Lets those come that are on, or none of them; they may at the start of a program."""

    state: State


Interrupting = Interrupt | SwitchInterrupt | SwitchInterrupts
