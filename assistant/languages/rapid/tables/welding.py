"""Instructions of arc welding (application manual Arc, 3HAC050988), and what they light."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

from assistant.program.program import Signal

BURNS: Final = "arc_on"
"""The output that lights the arc; what is told of it is `signals.arc_on` of the process file."""
SIGNAL: Final = Signal("digital", "output")
BESIDE: Final = frozenset(("weave", "track", "seamname", "corr", "preprocesstracking"))
"""Options of the power source and of what follows the seam."""
DATA: Final = frozenset(("seamdata", "welddata", "weavedata", "trackdata"))
"""Types of data that only these instructions use."""


@dataclass(frozen=True, slots=True)
class Weld:
    """plain: the move without the arc. points: how many places it states."""

    plain: str
    points: int
    part: Literal["start", "middle", "end"]


_PARTS: Final[Mapping[str, Literal["start", "middle", "end"]]] = {
    "": "middle", "start": "start", "end": "end",
}  # fmt: skip
MOVES: Final[Mapping[str, Weld]] = {
    f"arc{letter}{word}": Weld(f"Move{letter.upper()}", 2 if letter == "c" else 1, part)
    for letter in ("l", "c", "j")
    for word, part in _PARTS.items()
}
"""By instruction in lower case."""
