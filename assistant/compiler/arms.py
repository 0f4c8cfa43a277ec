"""Arms and cell of a compilation: the robots that names, files and cell files stand for.

`Arms` are the arm that runs a program and the arm that its joint angles were taught on. `InCell`
is the scene of a cell file, which checks a program, and which of its robots runs the program.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

from assistant.base.budgets import SETTINGS_FILE
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error, info, warning
from assistant.base.source_text import SourceText, decode, path_of, read_bytes
from assistant.program.program import Program
from assistant.program.undeclared_names import SAME_ARM
from assistant.sources.seen_settings import SeenSettings
from assistant.sources.sights import NOTHING_SEEN, Seeing

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.compiler.loader import Loaded
    from assistant.robots import Robot
    from assistant.sources.process import Surroundings


_WHICH_ARM = error(
    "CO075",
    "nothing says which robot runs the program; the cell has {names}",
    "name it with --robot",
)
ROBOT_FILES: Final = (".toml", ".urdf")
"""File suffixes of a user's robot."""


@dataclass(frozen=True, slots=True)
class Arms:
    """Arms that a program is for, and their cell.

    robot: the arm named to run a program. written_for: if the program does not state it, the one
    that it was written for; each None if not named. joint_speed: mm/s of joint moves that state a
    percentage with no other conversion to a speed, None for none. joint_percent: of joint moves
    that state mm/s, for a controller that takes percents. same: joint angles are those of the arm
    that runs the program, whichever it is. scene: the cell of the arm, None without one. seeing:
    source of frames located by cameras.
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

    return None if name is None else robots.get(name)


def with_robot_of_cell(program: Program, arms: Arms) -> Arms:
    """The arms with the only robot of the cell as the one that runs a program which names none.

    Raises Refused if the cell has not one robot only.
    """
    if arms.robot is not None or program.robot is not None or arms.scene is None:
        return arms
    if len(arms.scene.robots) != 1:
        names = ", ".join(f"`{placed.name}`" for placed in arms.scene.robots) or "no robot"
        raise Refused(_WHICH_ARM(names=names), exit_status=2)
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
    """The arms of a program that was read, with what a cell file says of them.

    Raises Refused if it says that joint angles are of an arm which runs no program of their
    language.
    """
    _check_same_arm(loaded, arms.robot)
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


_OTHER_ARM_STATED: Final = warning(
    "CO085",
    "the program is read as one for {named}, but the files of its controller state the robot "
    "`{told}`{known}",
    "name that one with --from-robot, by a robot file if the catalogue lacks it",
)
_ARM_NOT_KNOWN: Final = info(
    "CO086",
    "the files of the controller state the robot `{told}`, which the catalogue lacks: joint "
    "targets and configurations are not converted from it",
    "describe it in a robot file and name that with --from-robot",
)


def stated_arm_findings(loaded: Loaded, arms: Arms) -> Iterator[Diagnostic]:
    """Compare the arm that a program was written for with the one in its controller's files.

    arms: as they are named. A robot file of the user is taken for one that the catalogue lacks.
    """
    from assistant import robots

    told, known, named = loaded.told_arm, loaded.known_arm, arms.written_for
    if not told:
        return
    if named is None:
        if known is None and loaded.program.robot is None:
            yield _ARM_NOT_KNOWN(told=told)
    elif named.name != known and (known is not None or named.name in robots.names()):
        also = "" if known is None else f", which is `{known}`"
        yield _OTHER_ARM_STATED(named=f"`{named.name}`", told=told, known=also)


_NOT_SAME: Final = error(
    "CO080",
    "the joint angles are of an arm that runs {language}, which {arm} does not: on it they lead to "
    'other places, so `arm = "same"` in the cell file cannot be',
    "write the arm that they were taught on, by its name in `robot-assistant robots`",
)


def _check_same_arm(loaded: Loaded, robot: Robot | None) -> None:
    from assistant import languages

    origin = loaded.program.origin
    stated = not any(one.kind == "arm" for one in loaded.wanting)
    if robot is None or origin is None or loaded.arm != SAME_ARM or not stated:
        return
    language = languages.get(origin.language)
    if language.family not in {languages.get(name).family for name in robot.languages}:
        raise Refused(_NOT_SAME(language=language.title, arm=robot.name))


_EMPTY_CELL: Final = warning(
    "CO076",
    "the cell file has neither bodies nor robots, so nothing is there to be touched",
    "describe them under [bodies] and [robots]; docs/cell.md tells how",
)
_SCENE_TABLES: Final = ("bodies", "robots")
"""Tables of a cell file that make it a scene."""


@dataclass(frozen=True, slots=True)
class InCell:
    """An opened cell. scene: None without one. robot: whose arm runs programs, None if not stated.
    findings: about the cell file, at it. seeing: source of frames located by cameras.
    """

    scene: Scene | None = None
    robot: Robot | None = None
    findings: tuple[Diagnostic, ...] = ()
    seeing: Seeing = NOTHING_SEEN

    def beside(self, stated: SeenSettings) -> InCell:
        """With what a process file says of frames that are seen."""
        return replace(self, seeing=self.seeing.beside(stated))

    def around(self, named: str | None) -> Surroundings | None:
        """Return the surroundings of the robot that runs a program, None if unknown.

        named: the robot that the program names, if any.
        """
        if self.scene is None:
            return None
        from assistant.cell.clearances import robot_of as robot_in
        from assistant.cell.planning.approaches import CellSurroundings

        robot = self.robot or known_robot(named)
        if robot is None and len(self.scene.robots) == 1:
            robot = self.scene.robots[0].robot
        try:
            return (
                None if robot is None else CellSurroundings(self.scene, robot_in(self.scene, robot))
            )
        except LookupError:  # told by whoever checks the program
            return None

    def arms(self, written_for: Robot | None = None) -> Arms:
        return Arms(self.robot, written_for, scene=self.scene, seeing=self.seeing)


def open_cell(
    cell: str | FilePath | None, robot: str | Robot | None = None, *, values: bool = False
) -> InCell:
    """The scene of a cell file, and the robot that is named, of the catalogue, by its file, or as
    the cell calls it.

    values: the file may be there for its values alone, and need not be there yet. Raises
    Unreadable for a file that cannot be read, Refused for what is wrong in it, for a robot that
    nobody knows, or, naming the extra, without the library for collisions.
    """
    scene, findings = (None, ()) if cell is None else _scene_of(path_of(cell), values)
    if scene is not None and isinstance(robot, str):
        for placed in scene.robots:
            if placed.name == robot:
                return InCell(replace(scene, runs=robot), placed.robot, findings)
    return InCell(scene, robot_of(robot), findings)


def _scene_of(path: FilePath, values: bool) -> tuple[Scene | None, tuple[Diagnostic, ...]]:
    from assistant.program.settings_tables import ENCODINGS, read_toml

    if values and not path.exists():
        return None, ()
    source: SourceText = decode(read_bytes(path, most=SETTINGS_FILE), str(path), ENCODINGS)
    if not any(name in read_toml(source).content for name in _SCENE_TABLES):
        return None, () if values else (_EMPTY_CELL(path=str(path)),)
    from assistant.cell.cell_file import parse_scene
    from assistant.cell.collision.model import Model

    try:
        scene, found = parse_scene(source, path.parent)
        Model(scene)  # refuses a body that stands in nothing
    except Refused as refused:
        at = _findings_in_file(path, refused.findings)
        raise Refused(*at, exit_status=refused.exit_status) from None
    return scene, _findings_in_file(path, found)


def _findings_in_file(path: FilePath, findings: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    return tuple(finding.within(str(path)) for finding in findings)
