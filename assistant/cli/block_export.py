"""Write kinematics and FMUs for models of other tools: `kinematics` and `fmu`.

An FMU holds an arm, the motion of a program, or a live controller. Source of kinematics needs an
arm with a closed solution.
"""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors
from assistant.cli.command import argument, command, option
from assistant.cli.options import (
    AccelerationOption,
    CellOption,
    FormatOption,
    ReaderOptions,
    RobotOption,
    WrittenOptions,
    complete_robot,
)
from assistant.cli.presentation import print_answer, print_findings

if TYPE_CHECKING:
    from assistant.blocks.fmu import Model
    from assistant.compiler.retarget import Solved


class SourceLanguage(enum.StrEnum):
    C = "c"
    PYTHON = "python"


class FmuKind(enum.StrEnum):
    ARM = "arm"
    PROGRAM = "program"
    LIVE = "live"


@command
class Kinematics:
    """Write the kinematics of an arm as source that needs nothing else, with a check of it."""

    robot: str = argument(
        "A robot of the catalogue, or a robot file.", metavar="ROBOT", completions=complete_robot
    )
    language: SourceLanguage = option(
        "Of the source.", "--language", "-l", default=SourceLanguage.C
    )
    output: Path = option("Folder for the source.", "--output", "-o", default=Path("out"))
    format: FormatOption

    def run(self) -> int:
        """0 when the source is written; raises Refused for an arm without a closed form."""
        from assistant.base.file_sets import write_files
        from assistant.blocks.code import kinematics
        from assistant.compiler.arms import robot_of

        robot = robot_of(self.robot)
        assert robot is not None
        print_findings(robot.findings)
        written = write_files(kinematics(robot, self.language.value), self.output)
        print_answer(self.format, {"robot": robot.name}, (), written=written)
        return 0


@command
class Fmu:
    """Write an arm, a program's motion or a live controller as an FMU for Simulink and others."""

    source: str = argument(
        "Arm to simulate, of the catalogue or by its file, or a program.",
        metavar="ROBOT|PROGRAM",
        completions=complete_robot,
    )
    robot: RobotOption
    output: Path | None = option("Default out/NAME.fmu.", "--output", "-o", metavar="FILE.fmu")
    kind: FmuKind | None = option("What it is of; default what the source tells.")
    lag: float = option(
        "Of an arm: seconds by which its joints follow.", default=0.0, min=0.0, max=3600.0
    )
    period: float | None = option(
        "Of a program: seconds between rows; default 0.002, or what fits."
    )
    cycle: float | None = option(
        "Of a live controller: seconds; default those of the arm's controller."
    )
    all_platforms: bool = option("Also for systems that a compiler is here for.")
    acceleration: AccelerationOption
    reader: ReaderOptions
    cell: CellOption
    written: WrittenOptions
    format: FormatOption

    def run(self) -> int:
        """0 when the FMU is written, 1 if the robot cannot run the program; raises Refused."""
        from assistant.base.file_sets import write_files
        from assistant.blocks.fmu import compiled
        from assistant.cli.options import with_project_defaults
        from assistant.cli.presentation import working
        from assistant.cli.simulation import report_errors, solved_source
        from assistant.cli.source_input import keep_sources

        kind = self._kind()
        output = self.output or Path("out") / f"{Path(self.source).stem}.fmu"
        if output.suffix.lower() != ".fmu" or output.is_dir():
            raise Refused(_NOT_AN_FMU_NAME(name=str(output)), exit_status=2)
        self._check(kind)
        with working(f"writing {output}"):
            if kind != "program":
                model, findings = self._arm_model(kind)
            else:
                options = with_project_defaults(self.source, self)
                ready = solved_source(
                    self.source,
                    options.reader,
                    robot=options.robot,
                    cell=options.cell,
                    written=options.written,
                )
                if has_errors(ready.findings):
                    robot = ready.solution.robot
                    return report_errors(
                        self.source, robot, ready.findings, self.format, "written as an FMU"
                    )
                model, unplayed = self._program_model(ready)
                findings = [*ready.findings, *unplayed]
            data, more = compiled(model, everywhere=self.all_platforms)
            findings = [*findings, *more]
            keep_sources([self.source], [output])
            (written,) = write_files({output.name: data}, output.parent)
        answer = {
            "source": self.source,
            "kind": kind,
            "identifier": model.identifier,
            "guid": model.guid,
        }
        lines = (f"{model.title}: {_summary(model)}",)
        print_answer(self.format, answer, lines, findings, [written])
        return 0

    def _check(self, kind: str) -> None:
        """Raises Refused for options that would do nothing."""
        given = (
            ("--lag", "arm", self.lag > 0.0),
            ("--cycle", "live", self.cycle is not None),
            ("--period", "program", self.period is not None),
        )
        for named, of, said in given:
            if said and of != kind:
                raise Refused(_OPTION_OF_OTHER_KIND(option=named, of=of, kind=kind), exit_status=2)

    def _kind(self) -> str:
        """Return the stated kind, or that of the source: the name or file of a robot is an arm."""
        if self.kind is not None:
            return self.kind.value
        from assistant import robots
        from assistant.compiler.arms import ROBOT_FILES

        if self.source.lower() in robots.names():
            return "arm"
        is_file = Path(self.source).suffix.lower() in ROBOT_FILES
        return "arm" if is_file and self.robot is None else "program"

    def _arm_model(self, kind: str) -> tuple[Model, Sequence[Diagnostic]]:
        """Simulated, or live."""
        from assistant.blocks.fmu import arm_model, live_model
        from assistant.compiler.arms import robot_of

        robot = robot_of(self.source)
        assert robot is not None
        if kind == "live":
            return live_model(robot, cycle=self.cycle), robot.findings
        return arm_model(robot, lag=self.lag), robot.findings

    def _program_model(self, ready: Solved) -> tuple[Model, Sequence[Diagnostic]]:
        """The motion of a program, and what of it only running it would tell."""
        from assistant.blocks.fmu import program_model, usual_period
        from assistant.blocks.fmu.robot_models import Motion
        from assistant.blocks.rules import PARTLY_PLAYED
        from assistant.robots.timing import simulate

        done = simulate(ready.solution, period=self.period, acceleration=self.acceleration)
        if self.period is None:
            done = replace(done, wanted_period=usual_period(done.seconds))
        unplayed = [PARTLY_PLAYED(what=str(one)) for one in done.unknown]
        return program_model(Motion.of(done), done.robot, Path(self.source).stem), unplayed


_NOT_AN_FMU_NAME: Final = error(
    "CL560", "`{name}` is no name of an FMU", "end it in .fmu, as tools that import one expect"
)
_OPTION_OF_OTHER_KIND: Final = error(
    "CL561", "{option} is for FMUs of kind {of}, and this one is of kind {kind}", "leave it out"
)


def _summary(model: Model) -> str:
    counted = {
        what: sum(one.causality == what for one in model.variables)
        for what in ("parameter", "input", "output")
    }
    return ", ".join(
        f"{count} {what}{'s' if count != 1 else ''}" for what, count in counted.items()
    )
