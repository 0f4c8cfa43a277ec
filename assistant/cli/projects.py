"""A project as a unit: `init`, `build`, and `check` without files."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import FailOn, Refused, error, fold_files
from assistant.cli.command import argument, command, option
from assistant.cli.options import (
    EditOptions,
    FindingFormatOption,
    UnitOption,
    complete_language,
    complete_robot,
)
from assistant.cli.presentation import (
    FindingFormat,
    print_findings,
    print_for_programs,
    print_json,
    say,
    working,
)

if TYPE_CHECKING:
    from assistant.program.geometry import Pose, Vector
    from assistant.project.first_values import FirstValues
    from assistant.sources.drawing.survey import Extents

NO_UNIT: Final = "DX101"


@command
class Build:
    """Compile the programs of the project for its targets, into build/TARGET/."""

    names: tuple[str, ...] = argument(
        "Programs or targets of assistant.toml.", default=(), metavar="NAME"
    )
    jobs: int | None = option(
        "Processes at a time; default one a processor.", "--jobs", "-j", min=1
    )
    anew: bool = option("Also what has not changed since the last build.")
    edits: EditOptions
    format: FindingFormatOption

    def run(self) -> int:
        from assistant.project import State, build, project_of
        from assistant.project.builds import build_record

        done = build(
            project_of(),
            self.names,
            jobs=self.jobs,
            anew=self.anew,
            working=_build_spinner,
            wishes=self.edits.choices,
        )
        if self.format is FindingFormat.JSON:
            print_json(build_record(done, _path_from_here))
        elif self.format is not FindingFormat.TEXT:
            print_for_programs(done.findings, (), self.format)
        else:
            print_findings(done.findings)
            for one in done.programs:
                said = (
                    ", ".join(map(_path_from_here, one.files)) if one.state is State.BUILT else ""
                )
                say(f"{one.target}: {one.program} {one.state}{said and ': '}{said}")
                for line in one.proof:
                    say(f"  {line}")
                for diff in one.diffs.values():
                    say(diff.rstrip("\n"))
        return done.status


@command
class Init:
    """Start a project: an example or your drawings, and files for git, pre-commit and CI."""

    paths: tuple[Path, ...] = argument(
        "Folder of the project, made if it is missing; drawings that it is to work.",
        default=(),
        metavar="[FOLDER] [DRAWING]...",
    )
    unit: UnitOption
    robot: str | None = option(
        "Arm that it is for, or its file.",
        "--robot",
        "-r",
        default=None,
        completions=complete_robot,
    )
    language: str | None = option(
        "Of its programs; default the robot's own.",
        "--language",
        "-l",
        default=None,
        completions=complete_language,
    )
    place: str | None = option(
        "Where the drawing's origin stands in the robot's base, mm, and degrees about z, y, x.",
        default=None,
        metavar="X,Y,Z[,A,B,C]",
    )
    tip: str | None = option("Tool centre point in the flange, mm.", default=None, metavar="X,Y,Z")
    yes: bool = option("Assume what is not stated, and ask nothing.")

    def run(self) -> int:
        from assistant.project.new_project import BLANK_KEYS, PROJECT_FILE, start_project
        from assistant.sources.process.placement import DRAWING_SUFFIXES

        drawings = [
            path
            for path in self.paths
            if path.suffix.lower() in DRAWING_SUFFIXES and not path.is_dir()
        ]
        folders = [path for path in self.paths if path not in drawings]
        if len(folders) > 1:
            raise Refused(_ONE_FOLDER(name=folders[1]), exit_status=2)
        folder = folders[0] if folders else Path()
        unit, values = self._first_values(folder, drawings)
        started = start_project(folder, drawings, unit, values)
        print_findings(started.findings)
        for file in started.written:
            say(f"wrote {file}")
        for file in started.blank:
            say(f"fill in {' and '.join(BLANK_KEYS)} in {file}")
        project = folder / PROJECT_FILE
        assumed = drawings and self.robot is None and (started.blank or self.yes)
        if assumed and project in started.written:
            robot = f'robot = "{_robot_of(folder)}"'
            say(f"the arm is assumed: if it is another, change {robot} in {project}")
        inside = "" if folder.resolve() == Path.cwd() else f"in {folder}: "
        first = (
            "check, then build and deploy"
            if started.blank
            else "build, then robot-assistant deploy"
        )
        say(f"next, {inside}robot-assistant {first}")
        return 0

    def _first_values(
        self, folder: Path, drawings: Sequence[Path]
    ) -> tuple[str | None, FirstValues | None]:
        """The unit of the drawings and what the project states first; nothing without a drawing,
        or where a script states nothing. Asks on a terminal if no option is given.
        """
        from assistant.project.first_values import first_values, robot_text
        from assistant.project.new_project import has_project

        of_drawings = {"unit": self.unit, "place": self.place, "tip": self.tip}
        of_project = {"robot": self.robot, "language": self.language}
        stated = [name for name, one in (of_drawings | of_project).items() if one is not None]
        if not drawings:
            if stated:
                raise Refused(_NO_DRAWING(option=stated[0]), exit_status=2)
            return None, None
        there = has_project(folder)
        if there and any(one is not None for one in of_project.values()):
            from assistant.project import rules

            raise Refused(rules.HAS_CONTROLLER(), exit_status=2)
        if self.robot is not None:
            robot_text(self.robot, folder)
        robot = _robot_of(folder) if there else self.robot
        if not stated and not self.yes and sys.stdin.isatty():
            return _asked_values(folder, drawings, robot, there)
        if not self.yes and not set(stated) - {"unit"}:
            return self.unit, None
        given = option_values(self.place, self.tip)
        extents, millimetres = size_of(drawings, self.unit)
        return self.unit, first_values(
            *(extents, robot, self.language, *given), millimetres=millimetres
        )


def _robot_of(folder: Path) -> str | None:
    """Return the robot of the first controller of a project that names one, None without any."""
    from assistant.project.first_values import controller_robots

    return next(iter(controller_robots(folder)), None)


def size_of(drawings: Sequence[Path], unit: str | None) -> tuple[Extents | None, float]:
    """The size of the work of all drawings, and the largest of their units in mm. Raises Unreadable
    or Refused.
    """
    import numpy as np

    from assistant.project.new_project import survey_of
    from assistant.sources.drawing.survey import Extents

    seen = [survey_of(drawing, unit) for drawing in drawings]
    boxes = [np.array([one.extents.low, one.extents.high]) for one in seen if one.extents]
    return Extents.around(boxes), max(one.millimetres for one in seen)


def option_values(place: str | None, tip: str | None) -> tuple[Pose | None, Vector | None]:
    """The values of --place and --tip. Raises Refused (exit status 2)."""
    from assistant.sources.process.placement import option_numbers, placement_of_options

    placed = placement_of_options(place, ())
    if tip is None:
        return None if placed is None else placed.pose, None
    x, y, z = option_numbers(tip, "tip of a tool", (3,), "X,Y,Z")
    return None if placed is None else placed.pose, (x, y, z)


def _asked_values(
    folder: Path, drawings: Sequence[Path], robot: str | None, there: bool
) -> tuple[str | None, FirstValues]:
    """Ask for what a new project states first; Enter takes what is in brackets."""
    from assistant.base.length_units import UNITS, known_unit
    from assistant.project.first_values import (
        chosen_language,
        first_values,
        known_robot,
        robot_text,
    )
    from assistant.project.new_project import survey_of

    say("Enter takes what is in brackets.")
    seen = survey_of(drawings[0], None)
    own = next((short for short, (name, _) in UNITS.items() if name == seen.unit), "mm")
    given = _ask(f"unit of {drawings[0].name}, {seen.stated}", own, known_unit)
    unit = None if given == own and NO_UNIT not in {f.code for f in seen.findings} else given
    extents, millimetres = size_of(drawings, unit)
    if extents is not None:
        say(f"  it is {' x '.join(f'{length:.1f}' for length in extents.size)} mm")
    usual = first_values(extents, robot, millimetres=millimetres)
    language = None
    if not there:
        robot = _ask("robot", usual.robot_name, lambda text: robot_text(text, folder))
        arm = known_robot(robot)
        if len(arm.languages) > 1:
            language = _ask(
                f"language, of {', '.join(arm.languages)}",
                arm.languages[0],
                lambda text: chosen_language(arm, text),
            )
    tip = _ask(
        "tool centre point in the flange, mm",
        ",".join(f"{part:g}" for part in usual.tip),
        lambda text: option_values(None, text),
    )
    # What is taken over is not measured: it stays marked as assumed.
    given_tip = option_values(None, tip)[1]
    stated = None if given_tip == usual.tip else given_tip
    fitting = usual
    if (robot or usual.robot_name, language, stated) != (usual.robot_name, None, None):
        fitting = first_values(*(extents, robot, language, None, stated), millimetres=millimetres)
    place = _ask(
        "where the drawing's origin stands in the robot's base, mm, and degrees about z, y, x",
        fitting.place_text,
        lambda text: option_values(text, None),
    )
    if place == fitting.place_text:
        return unit, fitting
    placed = option_values(place, None)[0]
    return unit, first_values(extents, robot, language, placed, stated)


def _ask(question: str, usual: str, read: Callable[[str], object]) -> str:
    """An answer that `read` takes; what it refuses is told, and asked again."""
    while True:
        sys.stderr.write(f"{question} [{usual}]: ")
        sys.stderr.flush()
        line = sys.stdin.readline()
        if not line:
            raise Refused(_NOT_ANSWERED(question=question), exit_status=2)
        answer = line.strip() or usual
        try:
            read(answer)
        except Refused as wrong:
            print_findings(wrong.findings)
        else:
            return answer


_ONE_FOLDER = error(
    "CL051",
    "a project has one folder, and `{name}` is another one",
    "name one folder, and drawings that end in .dxf",
)
_NO_DRAWING = error(
    "CL052", "--{option} is of drawings, and none is named", "name one, or leave it out"
)
_NOT_ANSWERED = error(
    "CL055",
    "the input ended before an answer: {question}",
    "answer it, state it by an option, or give --yes to have it assumed",
)


def check_project(given: Mapping[str, object], format: FindingFormat, fail_on: FailOn) -> int:
    """`check` of the project here. given: options of files, by name."""
    from assistant.project import project_of, rules
    from assistant.project.builds import check

    stated = [option for option, value in given.items() if value is not None]
    if stated:
        raise Refused(*(rules.ONLY_WITH_FILES(option=one) for one in stated), exit_status=2)
    done = check(project_of(), working=lambda count: working(f"checking {_program_count(count)}"))
    if format is not FindingFormat.TEXT:
        print_for_programs(done.findings, done.ignored, format, fail_on, done.sources)
    else:
        print_findings(fold_files(done.findings), explained=True)
        count = len(done.findings)
        ignored = f", {len(done.ignored)} ignored" if done.ignored else ""
        say(
            f"{_program_count(done.programs)} checked, {count} finding{'s' * (count != 1)}{ignored}"
        )
    return fail_on.status(done.findings, unreadable=done.unreadable)


def _build_spinner(count: int) -> AbstractContextManager[None]:
    return working(f"building {_program_count(count)}")


def _program_count(count: int) -> str:
    return f"{count} program{'s' * (count != 1)}"


def _path_from_here(file: Path) -> str:
    here = Path.cwd()
    return str(file.relative_to(here) if file.is_relative_to(here) else file)
