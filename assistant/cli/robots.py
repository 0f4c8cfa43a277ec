"""Robots: the catalogue, one robot with its drawing, and robots corrected by measured poses.

`robots calibrate` estimates zeros of axes, lengths and the measured point from rows of joints and
positions; `robots poses` suggests poses to measure. The result is a new robot file: the file of
the measured robot is never replaced. Lengths are mm, angles degrees.
"""

from __future__ import annotations

import enum
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import click

from assistant.base.diagnostics import Refused, error
from assistant.cli.command import (
    Argument,
    Group,
    Option,
    argument,
    command_of,
    option,
    options,
    parameters,
)
from assistant.cli.options import FormatOption, complete_robot
from assistant.cli.presentation import (
    Format,
    answer_as,
    print_answer,
    print_findings,
    print_json,
    say,
)

if TYPE_CHECKING:
    from assistant.learning.parameter_fit import KnownPlacement
    from assistant.vision.cameras.camera import Camera


class _Estimated(enum.StrEnum):
    """Parameters of an arm that are estimated."""

    ZEROS = "zeros"
    LENGTHS = "lengths"
    CHAIN = "chain"


RobotArgument = Annotated[
    str,
    Argument(
        "A robot of the catalogue, or a robot file.", metavar="ROBOT", completions=complete_robot
    ),
]
EstimateOption = Annotated[
    _Estimated,
    Option(
        "Zeros of the axes; with the lengths of the robot file; or a free chain of axes.",
        default=_Estimated.LENGTHS,
    ),
]
InBase = Annotated[bool, Option("The points are measured in the base of the arm.", "--in-base")]
RobotCamerasOption = Annotated[
    Path | None, Option("File of the cameras that see the point.", metavar="FILE")
]
AnswerOption = Annotated[Format | None, Option("For people or for programs.", "--format")]


def _answer_format(format: Format | None) -> Format:
    """Return the format of a command, or the one that is stated before the command."""
    before = click.get_current_context().parent
    return answer_as(format or (before.params["format"] if before else Format.TEXT))


@options
class _ListOptions:
    """Options before the command."""

    format: FormatOption


def _robots_list(format: Format) -> None:
    if click.get_current_context().invoked_subcommand is None:
        raise click.exceptions.Exit(_list_robots(format))


robots: Final = Group(
    help="List the robots there are; `show` tells all of one, `calibrate` corrects one.",
    invoke_without_command=True,
    params=parameters(_ListOptions),
    callback=_robots_list,
)


@command_of(robots)
class Calibrate:
    """Correct lengths and zeros of an arm by measured poses, and tell what they cannot tell."""

    robot: RobotArgument
    measured: Path = argument("CSV: joints beside measured points.", metavar="MEASURED")
    output: Path = option("The corrected robot, as TOML.", "--output", "-o", metavar="FILE")
    estimate: EstimateOption
    tool: str | None = option("Measured point in the flange, mm, if it is known.", metavar="X,Y,Z")
    in_base: InBase
    noise: float | None = option("Of the measured points, if it is known.", metavar="MM")
    cameras: RobotCamerasOption
    format: AnswerOption

    def run(self) -> int:
        """1 if something is doubtful: rows that do not fit, too large errors, over-fitting."""
        from assistant.base.diagnostics import Severity
        from assistant.base.file_sets import write_files
        from assistant.compiler.arms import robot_of
        from assistant.learning import calibration_output
        from assistant.learning.arm_calibration import calibrate
        from assistant.learning.calibration_output import corrected_files
        from assistant.learning.measured_poses import read_measured

        format = _answer_format(self.format)
        output = self.output
        if output.suffix.lower() != ".toml" or not output.stem:
            raise Refused(_NOT_A_ROBOT_FILE(name=output.name), exit_status=2)
        if self.noise is not None and not self.noise > 0.0:
            raise Refused(_BAD_NOISE(given=self.noise), exit_status=2)
        known = _known_parts(self.tool, in_base=self.in_base)
        arm = robot_of(self.robot)
        assert arm is not None
        poses = read_measured(self.measured, arm, _read_given_cameras(self.cameras))
        done = calibrate(arm, poses, estimate=self.estimate.value, known=known, noise=self.noise)
        files = corrected_files(done, output.stem)
        _refuse_own_file(self.robot, [output.parent / name for name in files])
        written = write_files(files, output.parent)
        print_findings(done.findings)
        names = [str(file) for file in written]
        lines = calibration_output.calibration_lines(done)
        answer = calibration_output.calibration_record(done) | {"files": names}
        print_answer(format, answer, (*lines, f"corrected robot: {', '.join(names)}"))
        return 1 if any(one.severity is not Severity.INFO for one in done.findings) else 0


@command_of(robots)
class Poses:
    """Suggest poses to measure an arm in, which tell most of its errors."""

    robot: RobotArgument
    output: Path = option("Table of the joints, as CSV.", "--output", "-o", metavar="FILE")
    count: int = option("How many.", default=40)
    estimate: EstimateOption
    tool: str | None = option("Point in the flange, mm, roughly.", metavar="X,Y,Z")
    in_base: InBase
    box: str | None = option("Where the point may be, mm of the base.", metavar="X0,X1,Y0,Y1,Z0,Z1")
    cameras: RobotCamerasOption
    format: AnswerOption

    def run(self) -> int:
        import numpy as np

        from assistant.base.file_sets import write_files
        from assistant.compiler.arms import robot_of
        from assistant.learning import calibration_output
        from assistant.learning.pose_selection import suggest_poses

        format = _answer_format(self.format)
        if self.count < _FEWEST_POSES:
            raise Refused(_FEW_POSES(count=self.count, least=_FEWEST_POSES), exit_status=2)
        arm = robot_of(self.robot)
        assert arm is not None
        a, b, c = _finite_numbers(self.tool or "0,0,0", 3, "x,y,z")
        box = None
        if self.box is not None:
            box = np.array(_finite_numbers(self.box, 6, "x0,x1,y0,y1,z0,z1")).reshape(3, 2)
        seen = tuple((_read_given_cameras(self.cameras) or {}).values())
        found = suggest_poses(
            arm,
            self.count,
            estimate=self.estimate.value,
            tool=(a, b, c),
            known=_known_parts(None, in_base=self.in_base),
            box=box,
            cameras=seen,
        )
        units = ("mm" if slides else "deg" for slides in arm.sliding)
        header = [f"{axis.lower()}_{unit}" for axis, unit in zip(arm.axes, units, strict=True)]
        rows = [",".join(f"{value:.2f}" for value in row) for row in found.joints]
        text = "\n".join([",".join(header), *rows]) + "\n"
        (written,) = write_files({self.output.name: text.encode()}, self.output.parent)
        names = [one.name for one in found.parameters]
        sigmas = dict(zip(names, found.sigmas.tolist(), strict=True))
        answer = {"poses": str(written), "count": self.count, "sigmas": sigmas}
        lines = (*calibration_output.suggestion_lines(found), f"poses: {written}")
        print_answer(format, answer, lines)
        return 0


@command_of(robots)
class Show:
    """Print the data of a robot with their source, and draw it."""

    robot: str = argument(
        "A robot of the catalogue, or a robot file.", metavar="NAME", completions=complete_robot
    )
    draw: Path | None = option("Draw the arm as well: FILE.png or FILE.svg.", metavar="FILE")
    format: AnswerOption

    def run(self) -> int:
        """Show a robot. draw: the picture that is written before any output; None for none."""
        from assistant.compiler.arms import robot_of
        from assistant.report import robots as report

        format = _answer_format(self.format)
        robot = robot_of(self.robot)
        assert robot is not None
        print_findings(robot.findings)
        drawn = None
        if self.draw is not None:
            from assistant.base.file_sets import write_files
            from assistant.report.figures import format_of
            from assistant.report.robots import arm_drawing

            picture = arm_drawing(robot, format_of(self.draw.name))
            (drawn,) = write_files({self.draw.name: picture}, self.draw.parent)
        answer = report.robot_record(robot) | ({} if drawn is None else {"drawing": str(drawn)})
        lines = (*report.robot_lines(robot), *([] if drawn is None else [f"drawing: {drawn}"]))
        print_answer(format, answer, lines)
        return 0


def _list_robots(format: Format) -> int:
    from assistant import robots
    from assistant.report import robots as report

    known = [robots.get(name) for name in robots.names()]
    if format is Format.JSON:
        print_json([report.brief_record(robot) for robot in known])
        return 0
    for line in report.robot_table(known):
        say(line)
    return 0


_NOT_A_ROBOT_FILE: Final = error("CL540", "`{name}` is no file of a robot", "name it as FILE.toml")
_NOT_NUMBERS: Final = error(
    "CL541", "`{given}` is not {wanted}", "write numbers with commas between, in mm"
)
_BAD_NOISE: Final = error("CL542", "a noise of {given:g} mm is none", "state one above 0")
_FEW_POSES: Final = error("CL543", "{count} poses are not enough to look for", "ask for {least}")
_OWN_FILE: Final = error(
    "CL544", "`{name}` is a file of the robot that was measured", "name another one"
)
_FEWEST_POSES: Final = 6


def _refuse_own_file(robot: str, files: Iterable[Path]) -> None:
    """Raises Refused for what would take the place of the measured robot, or of a URDF beside it,
    which may be its own.
    """
    own = Path(robot)
    if own.suffix.lower() not in (".toml", ".urdf") or not own.exists():
        return
    for file in files:
        beside = file.suffix == ".urdf" and file.parent.resolve() == own.parent.resolve()
        if file.exists() and (file.samefile(own) or beside):
            raise Refused(_OWN_FILE(name=file.name), exit_status=2)


def _known_parts(tool: str | None, *, in_base: bool) -> KnownPlacement:
    from assistant.learning.parameter_fit import KnownPlacement
    from assistant.program.geometry import IDENTITY

    base = IDENTITY if in_base else None
    if tool is None:
        return KnownPlacement(base)
    a, b, c = _finite_numbers(tool, 3, "x,y,z")
    return KnownPlacement(base, (a, b, c))


def _read_given_cameras(file: Path | None) -> dict[str, Camera] | None:
    if file is None:
        return None
    from assistant.vision.cameras.camera_file import read_cameras

    return dict(read_cameras(file).cameras)


def _finite_numbers(given: str, count: int, wanted: str) -> list[float]:
    import numpy as np

    try:
        found = [float(part) for part in given.split(",")]
    except ValueError:
        found = []
    if len(found) != count or not np.isfinite(found).all():
        raise Refused(_NOT_NUMBERS(given=given, wanted=wanted), exit_status=2)
    return found
