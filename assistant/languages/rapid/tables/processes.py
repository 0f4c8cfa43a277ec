"""Instructions that move the arm and work with equipment: what each moves, and its signals.

Arc as in its application manual (3HAC050988). What spot welding, dispensing and painting take, and
in which order, is by memory of their manuals and by excerpts of public programs; it was not
compared with the manuals themselves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

from assistant.program.program import Signal

ARC_OUTPUT: Final = "arc_on"
"""The output that lights the arc; what is told of it is `signals.arc_on` of the process file."""
DISPENSE_OUTPUT, BEAD_OUTPUT = "dispense_on", "dispense_bead"
"""Outputs: that the gun dispenses, and the number of the bead that it is set up for."""
BRUSH_OUTPUT: Final = "paint_brush"
"""The group of outputs with the number of the brush."""
START_SUFFIX, READY_SUFFIX, PROGRAM_SUFFIX, RETRACT_SUFFIX = (
    "_start",
    "_ready",
    "_program",
    "_retract",
)
"""What the signals of a spot welding gun have behind its name."""
DIGITAL_OUTPUT: Final = Signal("digital", "output")
DIGITAL_INPUT: Final = Signal("digital", "input")
GROUP_OUTPUT: Final = Signal("group", "output")

ProcessKind = Literal["arc", "spot", "bead", "paint"]


@dataclass(frozen=True, slots=True)
class ProcessMove:
    """plain: the move without the process. points: how many places it states.

    given: how many arguments stand between the speed and the zone, or before the tool where
    the move states no zone. part: of a weld. beside: options that the equipment alone is told.
    """

    kind: ProcessKind
    plain: str
    points: int = 1
    given: int = 0
    part: Literal["start", "middle", "end"] = "middle"
    beside: frozenset[str] = frozenset()


ARC_OPTIONS: Final = frozenset(("weave", "track", "seamname", "corr", "preprocesstracking"))
SPOT_OPTIONS: Final = frozenset(("inpos", "noconc"))
GUN_OPTIONS: Final = tuple(f"g{number}" for number in range(1, 5))
"""Options of a weld with several guns: what each of them welds."""
_WELD_PARTS: Final[Mapping[str, Literal["start", "middle", "end"]]] = {
    "": "middle", "start": "start", "end": "end",
}  # fmt: skip
PROCESS_MOVES: Final[Mapping[str, ProcessMove]] = {
    **{
        f"arc{x}{word}": ProcessMove("arc", f"Move{x.upper()}", points, 2, part, ARC_OPTIONS)
        for x, points in (("l", 1), ("c", 2), ("j", 1))
        for word, part in _WELD_PARTS.items()
    },
    **{
        f"spot{m}{x}": ProcessMove("spot", f"Move{x.upper()}", 1, given, beside=SPOT_OPTIONS)
        for x in ("l", "j")
        for m, given in (("", 2), ("m", 0))
    },
    "displ": ProcessMove("bead", "MoveL", 1, 1),
    "dispc": ProcessMove("bead", "MoveC", 2, 1),
    "paintl": ProcessMove("paint", "MoveL"),
    "paintc": ProcessMove("paint", "MoveC", 2),
}
"""By instruction in lower case."""
BRUSH_INSTRUCTION: Final = "setbrush"
"""The instruction that takes another brush at once."""
WELD_SPEED: Final = "weld_speed"
"""The component of the data of an arc weld that its moves have as their speed."""
WELD_DATA: Final = "welddata"
SPOT_DATA: Final = "spotdata"
BEAD_DATA: Final = "beaddata"
UNTRANSLATED_TYPES: Final = frozenset(
    ("seamdata", "weavedata", "trackdata", "gundata", "gunnum", "anytype")
)
"""Types of arguments of which other languages are told nothing, a name at most."""
PROCESS_DATA_TYPES: Final = UNTRANSLATED_TYPES - {"anytype"} | {
    WELD_DATA,
    SPOT_DATA,
    BEAD_DATA,
    "equipdata",
    "forcedata",
    "simdata",
}
"""Types of data that only these instructions use."""
