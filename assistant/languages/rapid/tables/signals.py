"""Signals and what sets them: signal types, grippers, triggers of moves, process equipment.

RAPID has no statement for a gripper: an output opens it when 1 and closes it when 0.

Triggers: RAPID reference manual, TriggIO, TriggEquip, TriggL, TriggJ, TriggC (argument lists as in
`signatures.txt`). A distance is in mm before the end of the move, or from its start with the option
`Start`; with `Time` it is in seconds before the end, at most 0.5. A positive EquipLag sets the
output that many seconds before the tool is there, a negative one after it.

Process moves: Arc as in its application manual (3HAC050988). The arguments of spot welding,
dispensing and painting, and their order, are by memory of their manuals and by excerpts of public
programs; they were not compared with the manuals themselves.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final, Literal

from assistant.base.data_classes import dataclass
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Signal
from assistant.program.statements import Measure

SIGNAL_TYPES: Final[Mapping[str, Signal]] = {
    "signaldo": Signal("digital", "output"), "signaldi": Signal("digital", "input"),
    "signalgo": Signal("group", "output"), "signalgi": Signal("group", "input"),
    "signalao": Signal("analog", "output"), "signalai": Signal("analog", "input"),
}  # fmt: skip
"""By type of data, in lower case, what it stands for."""
VALUE_FUNCTIONS: Final[Mapping[str, str]] = {
    "signaldo": "DOutput", "signaldi": "DInput", "signalgo": "GOutput", "signalgi": "GInput",
    "signalao": "AOutput", "signalai": "AInput",
}  # fmt: skip
"""By the same, the function that gives its value."""
SIGNAL_READ_BY: Final[Mapping[str, Signal]] = {
    VALUE_FUNCTIONS[type].lower(): SIGNAL_TYPES[type] for type in VALUE_FUNCTIONS
}
"""By the name of such a function, in lower case, what it reads."""


_HAND_SIGNAL: Final = "hand{hand}_open"
# RAPID compares names without regard to case.
_HAND_SIGNAL_NAME: Final = re.compile(_HAND_SIGNAL.format(hand="([1-9][0-9]?)"), re.IGNORECASE)
_HAND_ACTIONS: Final[dict[float, Literal["open", "close"]]] = {1: "open", 0: "close"}


def hand_of(signal: str) -> int | None:
    """The hand that a signal of that name opens, None if it is another signal."""
    name = _HAND_SIGNAL_NAME.fullmatch(signal)
    return None if name is None else int(name[1])


def hand_signal(hand: int) -> str:
    return _HAND_SIGNAL.format(hand=hand)


def gripper(signal: str, value: e.Expression) -> p.Gripper | None:
    """The hand that setting a signal opens or closes, if it is one of a hand."""
    hand = hand_of(signal)
    if hand is None or not isinstance(value, e.Number) or value.value not in _HAND_ACTIONS:
        return None
    return p.Gripper(_HAND_ACTIONS[value.value], hand)


TRIGGER_TYPE: Final = "triggdata"
MOST_TRIGGERS: Final = 8
r"""Maximum triggers of one move: Trigg_1 and `\T2` to `\T8`."""
LONGEST_TRIGGER_TIME: Final = 0.5
"""Seconds of `\\Time`."""
TRIGGER_OUTPUTS: Final[Mapping[str, Literal["digital", "analog", "group"]]] = {
    "dop": "digital",
    "gop": "group",
    "aop": "analog",
}
"""Kinds of signals by the option that names one."""
TRIGGER_MEASURES: Final[Mapping[str, Measure]] = {"": "end", "start": "start", "time": "time"}
"""Meaning of a trigger distance, by the option given with it."""


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


ARC_OUTPUT: Final = "arc_on"
"""The output that ignites the arc; `signals.arc_on` of the process file describes it."""
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
"""Suffixes of the signals of a spot welding gun."""
DIGITAL_OUTPUT: Final = Signal("digital", "output")
DIGITAL_INPUT: Final = Signal("digital", "input")
GROUP_OUTPUT: Final = Signal("group", "output")

ProcessKind = Literal["arc", "spot", "bead", "paint"]


@dataclass(frozen=True, slots=True)
class ProcessMove:
    """A move with a process. plain: the move without the process. points: number of targets that it
    states.

    given: number of arguments between the speed and the zone, or before the tool if the move states
    no zone. part: of a weld. beside: options for the equipment only.
    """

    kind: ProcessKind
    plain: str
    points: int = 1
    given: int = 0
    part: Literal["start", "middle", "end"] = "middle"
    beside: frozenset[str] = frozenset()


_ARC_OPTIONS: Final = frozenset(("weave", "track", "seamname", "corr", "preprocesstracking"))
_SPOT_OPTIONS: Final = frozenset(("inpos", "noconc"))
GUN_OPTIONS: Final = tuple(f"g{number}" for number in range(1, 5))
"""Options of a weld with several guns: what each of them welds."""
_WELD_PARTS: Final[Mapping[str, Literal["start", "middle", "end"]]] = {
    "": "middle", "start": "start", "end": "end",
}  # fmt: skip
PROCESS_MOVES: Final[Mapping[str, ProcessMove]] = {
    **{
        f"arc{x}{word}": ProcessMove("arc", f"Move{x.upper()}", points, 2, part, _ARC_OPTIONS)
        for x, points in (("l", 1), ("c", 2), ("j", 1))
        for word, part in _WELD_PARTS.items()
    },
    **{
        f"spot{m}{x}": ProcessMove("spot", f"Move{x.upper()}", 1, given, beside=_SPOT_OPTIONS)
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
"""Types of arguments that are not lowered for other languages, except perhaps as a name."""
PROCESS_DATA_TYPES: Final = UNTRANSLATED_TYPES - {"anytype"} | {
    WELD_DATA,
    SPOT_DATA,
    BEAD_DATA,
    "equipdata",
    "forcedata",
    "simdata",
}
"""Types of data that only these instructions use."""
