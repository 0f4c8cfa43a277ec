"""The scene of a cell file, for what checks a program in it, and which of its robots runs that."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

from assistant.base.budgets import SETTINGS_FILE
from assistant.base.diagnostics import Diagnostic, Refused, warning
from assistant.base.source_text import SourceText, decode, path_of, read_bytes
from assistant.compiler.arms import Arms, known_robot, robot_of
from assistant.sources.process.seen import SeenSettings
from assistant.sources.sights import NOTHING_SEEN, Seeing

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.robots import Robot
    from assistant.sources.surroundings import Surroundings

EMPTY_CELL: Final = warning(
    "CO076",
    "the cell file has neither bodies nor robots, so nothing is there to be touched",
    "describe them under [bodies] and [robots]; docs/cell.md tells how",
)
SCENE_TABLES: Final = ("bodies", "robots")
"""Tables of a cell file that make it a scene."""


@dataclass(frozen=True, slots=True)
class InCell:
    """A cell that was asked for. scene: None without one. robot: whose arm runs programs, None
    if it is not said. findings: about the cell file, at it. seeing: where frames that are seen are
    taken from.
    """

    scene: Scene | None = None
    robot: Robot | None = None
    findings: tuple[Diagnostic, ...] = ()
    seeing: Seeing = NOTHING_SEEN

    def beside(self, stated: SeenSettings) -> InCell:
        """With what a process file says of frames that are seen."""
        return replace(self, seeing=self.seeing.beside(stated))

    def around(self, named: str | None) -> Surroundings | None:
        """What stands around the robot that runs a program, None where that is not known.

        named: the robot that the program names, if it names one.
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
    from assistant.sources.process.file import ENCODINGS, read_toml

    if values and not path.exists():
        return None, ()
    source: SourceText = decode(read_bytes(path, most=SETTINGS_FILE), str(path), ENCODINGS)
    if not any(name in read_toml(source).content for name in SCENE_TABLES):
        return None, () if values else (EMPTY_CELL(path=str(path)),)
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
