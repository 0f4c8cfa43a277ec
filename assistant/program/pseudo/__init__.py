"""The readable text form of the pseudo-program: `.pseudo` files, and their side tables."""

from __future__ import annotations

from assistant.program.pseudo.parser import parse, read
from assistant.program.pseudo.printer import Printed, print_program

SUFFIX = ".pseudo"

__all__ = ["SUFFIX", "Printed", "parse", "print_program", "read"]
