"""How a program stands among others of its controller: what they call it, what they have of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Interface:
    """What a cell that exists wants of a program's names.

    called: what others call it by, "" for the name that its entry has. main: False: it has no
    routine that runs all of it, and others call its procedures. prefix: stands before every name
    that it declares but that one. local: whatever nobody else calls is seen in its own module only.
    there: tools and frames by lower-case name that the controller has already, which are named and
    not written, with the numbers that they have where a controller counts them.
    """

    called: str = ""
    main: bool = True
    prefix: str = ""
    local: bool = False
    there: Mapping[str, int | None] = field(default_factory=dict)


STANDALONE = Interface()
"""Of a program that nobody has asked anything of."""
