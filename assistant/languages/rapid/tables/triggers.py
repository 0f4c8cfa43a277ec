r"""The instructions that say what moves do on their way, and where their arguments stand.

Source: RAPID reference manual, TriggIO, TriggEquip, TriggL, TriggJ, TriggC (argument lists as in
`signatures.txt`). A distance is in mm before the end of the move, or from its start with `\Start`;
with `\Time` it is in seconds before the end, at most 0.5. A positive EquipLag sets the output that
many seconds before the tool is there, a negative one behind it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

from assistant.program.statements import Measure

TRIGGER_TYPE: Final = "triggdata"
MOST_TRIGGERS: Final = 8
"""Of one move: Trigg_1 and `\\T2` to `\\T8`."""
LONGEST_TRIGGER_TIME: Final = 0.5
"""Seconds of `\\Time`."""
TRIGGER_OUTPUTS: Final[Mapping[str, Literal["digital", "analog", "group"]]] = {
    "dop": "digital",
    "gop": "group",
    "aop": "analog",
}
"""Kinds of signals by the option that names one."""
TRIGGER_MEASURES: Final[Mapping[str, Measure]] = {"": "end", "start": "start", "time": "time"}
"""What a distance is, by the option that stands with it."""


@dataclass(frozen=True, slots=True)
class TriggerSetup:
    """An instruction that sets a triggdata up: its name, and how its arguments are understood.

    count: of its positional ones: the variable, the distance, a delay if there is one, the value.
    """

    word: str
    count: int
    measures: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TriggerMove:
    """A move with triggdata. plain: the same without. place: of its first triggdata, from 0."""

    word: str
    plain: str
    place: int


TRIGG_IO: Final = TriggerSetup("TriggIO", 3, ("", "start", "time"))
TRIGG_EQUIP: Final = TriggerSetup("TriggEquip", 4, ("", "start"))
TRIGGER_SETUPS: Final[Mapping[str, TriggerSetup]] = {
    x.word.lower(): x for x in (TRIGG_IO, TRIGG_EQUIP)
}
TRIGGER_MOVES: Final[Mapping[str, TriggerMove]] = {
    x.word.lower(): x
    for x in (
        TriggerMove("TriggJ", "MoveJ", 2),
        TriggerMove("TriggL", "MoveL", 2),
        TriggerMove("TriggC", "MoveC", 3),
    )
}
FURTHER_TRIGGERS: Final = tuple(f"t{number}" for number in range(2, MOST_TRIGGERS + 1))
"""Options with the further triggdata of a move, in lower case."""
