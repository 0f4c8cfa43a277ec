"""The words of `learn` as what is asked for."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar, cast

from assistant.base.diagnostics import Refused, Rule, error
from assistant.cli.presentation import Format

if TYPE_CHECKING:
    from assistant.base.arrays import Floats
    from assistant.learning.maps.asked import Asked
    from assistant.learning.maps.goals import Rule as Held
    from assistant.vision.cameras.camera import Camera

BAD_RANGE: Final = error(
    "CL521", "`{given}` is no range of a joint", "write JOINT=LOW:HIGH, as J1=-50:50"
)
BAD_HOLD: Final = error("CL522", "`{given}` holds no joint", "write JOINT=DEGREES, as J5=0")
BAD_BOX: Final = error(
    "CL523", "`{given}` is no box", "write LOW:HIGH,LOW:HIGH,LOW:HIGH, mm of x, y and z"
)
BAD_POINT: Final = error("CL524", "`{given}` is no point", "write x,y,z in mm, as 0,0,60")
BAD_LATTICE: Final = error("CL525", "`{given}` is no lattice", "write counts, as 7x12x4")
BAD_FACTOR: Final = error(
    "CL526", "`{given}` makes no link longer", "write LENGTH=FACTOR, as a2=1.1, from 0.5 to 2"
)
FEW_CAMERAS: Final = error(
    "CL527",
    "{count} of the cameras of {file} stand still, and two are needed",
    "name a file with two that stand about the robot; those in its hand do not count",
)
BAD_TURN: Final = error(
    "CL528", "`{given}` is no range of turns", "write LOW:HIGH in degrees, the lower first"
)
FARTHEST_COORDINATE: Final = 100_000.0
"""mm that a coordinate has at most: beyond, it is no place about a robot."""
FREE_TOOL: Final = "free"
"""Value of --tool for a tool of which only the position is learnt."""
SHORTEST_LINK_FACTOR: Final = 0.5
LONGEST_LINK_FACTOR: Final = 2.0
"""Times the length of a link."""
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class LearnOptions:
    """The words of the command."""

    robot: str
    steps: int
    hold: Sequence[str]
    range: Sequence[str]
    box: str | None
    tool: str
    turn: str
    point: Sequence[str]
    cameras: Path | None
    lattice: str | None
    noise: float
    seed: int
    go_on: Path | None
    longer: Sequence[str]
    rivals: bool
    format: Format
    recorded: Sequence[Path] = ()


def learning_task(options: LearnOptions) -> Asked:
    import numpy as np

    from assistant.compiler.arms import robot_of
    from assistant.learning.maps.asked import Asked

    robot = robot_of(options.robot)
    assert robot is not None
    points = [_numbers_of(text, ",", 3, BAD_POINT) for text in options.point]
    box = None
    if options.box is not None:
        box = box_of(options.box)
    low, high = _numbers_of(options.turn, ":", 2, BAD_TURN)
    if not -360.0 <= low <= high <= 360.0:
        raise Refused(BAD_TURN(given=options.turn), exit_status=2)
    return Asked(
        robot,
        dict(_name_and_value(text, _number_or_none, BAD_HOLD) for text in options.hold),
        np.array(points) if points else None,
        dict(map(range_of, options.range)),
        box,
        cast("Held", "any" if options.tool == FREE_TOOL else options.tool),
        (low, high),
        () if options.cameras is None else _fixed_cameras(options.cameras),
        options.tool == FREE_TOOL,
    )


def box_of(text: str) -> Floats:
    """Return the box (3, 2) in mm of its words; raises Refused."""
    import numpy as np

    sides = text.split(",")
    if len(sides) != 3:
        raise Refused(BAD_BOX(given=text), exit_status=2)
    return np.array([_numbers_of(side, ":", 2, BAD_BOX, text) for side in sides])


def range_of(text: str) -> tuple[str, tuple[float, float]]:
    """Return a joint with the ends of its range; raises Refused."""
    return _name_and_value(text, _low_and_high, BAD_RANGE)


def _fixed_cameras(file: Path) -> tuple[Camera, ...]:
    """Those that stand still, in the frame of the base."""
    from assistant.vision.cameras.camera import WORLD
    from assistant.vision.cameras.camera_file import read_cameras

    rig = read_cameras(file)
    still = tuple(one for one in rig.cameras.values() if one.parent == WORLD)
    if len(still) < 2:
        raise Refused(FEW_CAMERAS(count=len(still), file=file), exit_status=2)
    return still


def lattice_of(text: str) -> tuple[int, ...]:
    counts = text.lower().split("x")
    if not all(count.isascii() and count.isdigit() for count in counts):
        raise Refused(BAD_LATTICE(given=text), exit_status=2)
    return tuple(int(count[:9]) for count in counts)


def link_factors(texts: Sequence[str]) -> list[tuple[str, float]]:
    """Names of lengths with their factors."""
    found = [_name_and_value(text, _number_or_none, BAD_FACTOR) for text in texts]
    for text, (_, factor) in zip(texts, found, strict=True):
        if not SHORTEST_LINK_FACTOR <= factor <= LONGEST_LINK_FACTOR:
            raise Refused(BAD_FACTOR(given=text), exit_status=2)
    return found


def _name_and_value(text: str, value: Callable[[str], T | None], rule: Rule) -> tuple[str, T]:
    """NAME=VALUE."""
    name, equals, said = text.partition("=")
    found = value(said) if equals and name else None
    if found is None:
        raise Refused(rule(given=text), exit_status=2)
    return name, found


def _number_or_none(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _low_and_high(text: str) -> tuple[float, float] | None:
    low, _, high = text.partition(":")
    found = _number_or_none(low), _number_or_none(high)
    return None if found[0] is None or found[1] is None else (found[0], found[1])


def _numbers_of(text: str, mark: str, count: int, rule: Rule, whole: str = "") -> list[float]:
    parts = [_number_or_none(part) for part in text.split(mark)]
    if len(parts) != count or any(
        part is None or abs(part) > FARTHEST_COORDINATE for part in parts
    ):
        raise Refused(rule(given=whole or text), exit_status=2)
    return [part for part in parts if part is not None]
