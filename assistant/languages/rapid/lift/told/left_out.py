"""What is left out of a program for other languages, and what is lost with it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import JointTarget, Target
from assistant.program.program import Program
from assistant.program.rewriting import records

Loss = tuple[str, str]
"""What is lost, and what to do about it."""

_NONE: Final = "none is needed"
_OWN: Final = "set what the other controller has of the kind, or leave it"
_LIMIT: Final = "state speeds and accelerations that the part can take"
_ACCELERATIONS: Final = ("the arm accelerates as fast as its load lets it", _LIMIT)
_SOFT: Final = (
    "the axes stay stiff",
    "use the other arm's soft mode, or see that nothing presses against it",
)
_TUNED: Final = ("the servos work as the controller has them", _OWN)
_STRAIGHT: Final = (
    "the tool keeps its orientation on straight moves and arcs: near a straight wrist the arm may "
    "stop, where RAPID turns the tool a little",
    "see that no move passes a straight wrist",
)

_UNIT: Final = (
    "the unit stays as the controller has it",
    "switch it on and off at the other controller",
)
_PATHS: Final = (
    "no move is held, kept or taken up again: the arm stands where its program goes on",
    "see that nothing counts on a move that was interrupted",
)
_SHAPE: Final = ("the shape of the zone is not kept", "note its corners for the other controller")
_ZONE: Final = (
    "nobody watches the zone: the arm is not stopped at its border",
    "set the zone in the other controller, among the areas that it watches, before the first run",
)

_FOLDERS: Final = (
    "the files of the controller are in no folders: none is made or looked into",
    "see that the names of files in several folders differ",
)

NO_AXES: Final = ("no target states a place of an external axis that it would move", _NONE)
"""What is lost of an offset of external axes where there are none."""
INSTRUCTIONS: Final[Mapping[str, Loss]] = {
    "tperase": ("what stands on the teach pendant stays there", _NONE),
    "tpshow tp_latest": ("the teach pendant shows what it shows", _NONE),
    "confl off": (
        "straight moves go on in the configuration that they begin in, whatever their targets "
        "state; another controller may stop where they state another",
        "state the configurations that the arm really takes, or name it with --robot",
    ),
    "confj off": (
        "joint moves take the nearest turn of the wrist, whatever their targets state; here they "
        "take the configuration that is stated",
        "see that the targets state the configurations that the arm takes",
    ),
    "singarea wrist": _STRAIGHT,
    "singarea lockaxis4": _STRAIGHT,
    "pathacclim": _ACCELERATIONS,
    "worldacclim": _ACCELERATIONS,
    "pathresol": ("the way is worked out as finely as the controller does it", _OWN),
    "cirpathmode": ("the tool turns on arcs as the controller has it", "state more targets"),
    "motionsup": ("collisions are watched for as the controller has it", _OWN),
    "softact": _SOFT,
    "softdeact": ("the axes are as stiff as ever", _NONE),
    "tuneservo": _TUNED,
    "tunereset": _TUNED,
    "gripload": (
        "the controller goes on with the load that its tool has",
        "set the load of the hand in the other controller",
    ),
    "mechunitload": ("the load of the unit is not told", "set it in the other controller"),
    **dict.fromkeys(("actunit", "deactunit"), _UNIT),
    **dict.fromkeys(("clearpath", "storepath", "restopath", "startmove"), _PATHS),
    **dict.fromkeys(("wzboxdef", "wzcyldef", "wzsphdef"), _SHAPE),
    **dict.fromkeys(("wzlimjointdef", "wzhomejointdef"), _SHAPE),
    **dict.fromkeys(("wzlimsup", "wzenable", "wzdisable", "wzfree"), _ZONE),
    "bookerrno": ("the number of an error of the program's own is not reserved", _NONE),
    "save": (
        "no module is written to a file: the values of its data stay in the controller alone",
        "back the controller up",
    ),
    **dict.fromkeys(("makedir", "opendir", "closedir"), _FOLDERS),
    "skipwarn": ("the log of the controller has what it has", _NONE),
    "resetretrycount": ("retries are not counted", _NONE),
}
"""Instructions by their name, or by name, options and plain arguments, in lower case.

They set how the controller moves the arm, watches it or says something, but not where to it moves
(RAPID reference manual, instructions).
"""

_TO_PEOPLE: Final = ("nobody is told what the program waits for", _NONE)
_BESIDE: Final = (
    "what follows is done when the arm has arrived, not while it moves",
    "see that nothing has to happen on the way, or set it there by TriggL",
)
_LOOKS: Final = dict.fromkeys(
    (
        *("visualize", "header", "message", "msgarray", "wrap", "icon", "image"),
        *("visualizetime", "uiactivesignal"),
    ),
    _TO_PEOPLE,
)
_ASKED: Final = ("how often the condition is asked", _NONE)
_MOVED: Final[Mapping[str, Loss]] = {
    "conc": _BESIDE,
    "noeoffs": ("", ""),
    "id": (
        "the arm moves without waiting for those that would move together with it",
        "see that the arms do not meet, or move them one after the other",
    ),
    "corr": ("corrections from a sensor are not added", "see that none are written"),
}
_SYNC: Final = ("the program does not wait until the output has its value", _NONE)

OPTIONS: Final[Mapping[str, Mapping[str, Loss]]] = {
    **{f"wait{kind}": _LOOKS for kind in ("di", "do", "gi", "go", "ai", "ao")},
    "waituntil": {**_LOOKS, "pollrate": _ASKED},
    **dict.fromkeys(("movej", "movel", "movec", "moveabsj"), _MOVED),
    "accset": {"finepointramp": ("the arm brakes at stop points as fast as anywhere", _LIMIT)},
    "setdo": {"sync": _SYNC},
}
"""Options of instructions that can go, by instruction and option; without words nothing is lost."""


def has_external_axes(program: Program) -> bool:
    """Whether any target or path of a program states a place of an external axis."""
    given: list[Target | JointTarget] = [*program.targets.values()]
    given += program.joint_targets.values()
    if any(map(_stated, given)):
        return True
    for record in records((program.procedures, tuple(program.variables.values()))):
        match record:
            case e.TargetValue(target) | e.JointValue(target):
                if _stated(target):
                    return True
            case p.Follow(path):
                if np.isfinite(path.external).any():
                    return True
    return False


def _stated(target: Target | JointTarget) -> bool:
    return any(map(math.isfinite, target.external))
