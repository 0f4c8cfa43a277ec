"""The arms of a compilation: which robots their names and files are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, did_you_mean, error
from assistant.program.program import Program
from assistant.program.undeclared_names import SAME_ARM
from assistant.sources.sights import NOTHING_SEEN, Seeing

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.compiler.loading import Loaded
    from assistant.robots import Robot

UNKNOWN_ROBOT = error(
    "CO002",
    "there is no robot `{name}`",
    "{cure}",
)
WHICH_ARM = error(
    "CO075",
    "nothing says which robot runs the program; the cell has {names}",
    "name it with --robot",
)
ROBOT_FILES: Final = (".toml", ".urdf")
"""How the file of a user's own robot ends."""


@dataclass(frozen=True, slots=True)
class Arms:
    """robot: the arm that was named to run a program. written_for: where the program does not
    say it, the one that it was written for; each None if nobody has named it. joint_speed: mm/s
    of joint moves that state a percentage which nothing else makes a speed of, None for none.
    joint_percent: of those that state mm/s, for a controller that takes percents.
    same: joint angles count for the arm that runs the program, whichever it is. scene: the cell
    that it stands in, None if none is told. seeing: where frames that are seen are taken from.
    """

    robot: Robot | None = None
    written_for: Robot | None = None
    joint_speed: float | None = None
    joint_percent: float | None = None
    same: bool = False
    scene: Scene | None = None
    seeing: Seeing = NOTHING_SEEN


def robot_of(robot: str | Robot | None) -> Robot | None:
    """A robot by its name in the catalogue, or by its own file; raises Unreadable or Refused."""
    if isinstance(robot, str) and FilePath(robot).suffix.lower() in ROBOT_FILES:
        from assistant import robots

        return robots.load(robot)
    if robot is None or isinstance(robot, str):
        return known_robot(robot)
    return robot if hasattr(robot, "axes") else known_robot(str(robot))


def known_robot(name: str | None) -> Robot | None:
    """The robot that a program names, by which no file is opened; raises Refused if unknown."""
    from assistant import robots

    if name is None:
        return None
    try:
        return robots.get(name)
    except KeyError:
        known = robots.names()
        other = f"choose one of {', '.join(known)}, or name a robot file (TOML or URDF)"
        finding = UNKNOWN_ROBOT(name=name, cure=did_you_mean(name, known, other))
        raise Refused(finding, exit_status=2) from None


def with_robot_of_cell(program: Program, arms: Arms) -> Arms:
    """The arms with the only robot of the cell as the one that runs a program which names none.

    Raises Refused if the cell has not one robot only.
    """
    if arms.robot is not None or program.robot is not None or arms.scene is None:
        return arms
    if len(arms.scene.robots) != 1:
        names = ", ".join(f"`{placed.name}`" for placed in arms.scene.robots) or "no robot"
        raise Refused(WHICH_ARM(names=names), exit_status=2)
    return replace(arms, robot=arms.scene.robots[0].robot)


def teaching_arm(program: Program, arms: Arms) -> Robot | None:
    """The arm of a program's joint angles and branches: its own, else the one it was written for.

    Raises Refused if nobody knows the one that it names.
    """
    if program.robot is None:
        return arms.written_for
    given = (arm for arm in (arms.robot, arms.written_for) if arm and arm.name == program.robot)
    return next(given, None) or known_robot(program.robot)


def arms_of_loaded(loaded: Loaded, arms: Arms) -> Arms:
    """The arms of a program that was read, with what a cell file says of them."""
    taught = None if loaded.arm in (None, SAME_ARM) else robot_of(loaded.arm)
    same, written_for = loaded.arm == SAME_ARM, arms.written_for or taught
    return replace(
        arms,
        written_for=written_for,
        joint_speed=loaded.joint_speed,
        joint_percent=loaded.joint_percent,
        same=same,
        seeing=arms.seeing.beside(loaded.seen),
    )
