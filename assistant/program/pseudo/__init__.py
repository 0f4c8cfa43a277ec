"""The readable text form of the pseudo-program: `.pseudo` files, and their side tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.lazy import offered

if TYPE_CHECKING:
    from assistant.program.pseudo.parser import parse, read
    from assistant.program.pseudo.printer import Printed, print_program

SUFFIX = ".pseudo"

_LAZY: Final = {
    "parse": ("assistant.program.pseudo.parser", "parse"),
    "read": ("assistant.program.pseudo.parser", "read"),
    "Printed": ("assistant.program.pseudo.printer", "Printed"),
    "print_program": ("assistant.program.pseudo.printer", "print_program"),
}

__all__ = ["SUFFIX", "Printed", "parse", "print_program", "read"]

__getattr__ = offered(__name__, _LAZY)
