"""Write kinematics and FMUs for models of other tools: `kinematics` and `fmu`.

An FMU holds an arm, the motion of a program, or a live controller. Source of kinematics needs an
arm with a closed solution.
"""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import typer

from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors
from assistant.cli.options import (
    AccelerationOption,
    CellOption,
    EntryOption,
    FormatOption,
    FromLanguage,
    FromRobot,
    ProcessOption,
    RobotOption,
    UnitOption,
    complete_robot,
)
from assistant.cli.presentation import Format, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.blocks.fmu import Model
    from assistant.cli.simulation import SimulationOptions
    from assistant.compiler.retarget import Solved


class SourceLanguage(enum.StrEnum):
    C = "c"
    PYTHON = "python"


class FmuKind(enum.StrEnum):
    ARM = "arm"
    PROGRAM = "program"
    LIVE = "live"


def kinematics(
    robot: Annotated[
        str,
        typer.Argument(
            metavar="ROBOT",
            help="A robot of the catalogue, or a robot file.",
            autocompletion=complete_robot,
        ),
    ],
    language: Annotated[
        SourceLanguage, typer.Option("--language", "-l", help="Of the source.")
    ] = SourceLanguage.C,
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the source.")] = Path(
        "out"
    ),
    format: FormatOption = Format.TEXT,
) -> None:
    """Write the kinematics of an arm as source that needs nothing else, with a check of it."""
    raise typer.Exit(_run_kinematics(robot, language.value, output, format))


def fmu(
    source: Annotated[
        str,
        typer.Argument(
            metavar="ROBOT|PROGRAM",
            help="Arm to simulate, of the catalogue or by its file, or a program.",
            autocompletion=complete_robot,
        ),
    ],
    robot: RobotOption = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE.fmu", help="Default out/NAME.fmu."),
    ] = None,
    kind: Annotated[
        FmuKind | None, typer.Option(help="What it is of; default what the source tells.")
    ] = None,
    lag: Annotated[
        float,
        typer.Option(min=0.0, max=3600.0, help="Of an arm: seconds by which its joints follow."),
    ] = 0.0,
    period: Annotated[
        float | None,
        typer.Option(help="Of a program: seconds between rows; default 0.002, or what fits."),
    ] = None,
    cycle: Annotated[
        float | None,
        typer.Option(help="Of a live controller: seconds; default those of the arm's controller."),
    ] = None,
    all_platforms: Annotated[
        bool, typer.Option("--all-platforms", help="Also for systems that a compiler is here for.")
    ] = False,
    acceleration: AccelerationOption = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    cell: CellOption = None,
    from_language: FromLanguage = None,
    from_robot: FromRobot = None,
    entry: EntryOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Write an arm, a program's motion or a live controller as an FMU for Simulink and others."""
    from assistant.cli.simulation import SimulationOptions

    given = (robot, process, unit, from_language, from_robot, acceleration, period, entry, cell)
    named = None if kind is None else kind.value
    wanted = _FmuOptions(
        source, output, named, lag, cycle, all_platforms, SimulationOptions(*given)
    )
    raise typer.Exit(_run_fmu(wanted, format))


_NOT_AN_FMU_NAME: Final = error(
    "CL560", "`{name}` is no name of an FMU", "end it in .fmu, as tools that import one expect"
)
_OPTION_OF_OTHER_KIND: Final = error(
    "CL561", "{option} is for FMUs of kind {of}, and this one is of kind {kind}", "leave it out"
)


@dataclass(frozen=True, slots=True)
class _FmuOptions:
    """Options of `fmu`. kind: None to derive it from the source. everywhere: for every platform
    that has a compiler. options: for the simulation of a program; its robot also applies to an arm.
    """

    source: str
    output: Path | None
    kind: str | None
    lag: float
    cycle: float | None
    everywhere: bool
    options: SimulationOptions


def _run_kinematics(
    name: str, language: Literal["c", "python"], folder: Path, format: Format
) -> int:
    """0 when the source is written; raises Refused for an arm without a closed form."""
    from assistant.base.file_sets import write_files
    from assistant.blocks.code import kinematics
    from assistant.compiler.arms import robot_of

    robot = robot_of(name)
    assert robot is not None
    print_findings(robot.findings)
    written = write_files(kinematics(robot, language), folder)
    if format is Format.JSON:
        print_json({"robot": robot.name, "written": list(map(str, written))})
        return 0
    for path in written:
        say(f"wrote {path}")
    return 0


def _run_fmu(wanted: _FmuOptions, format: Format) -> int:
    """0 when the FMU is written, 1 if the robot cannot run the program; raises Refused."""
    from assistant.base.file_sets import write_files
    from assistant.blocks.fmu import compiled
    from assistant.cli.compilation import keep_sources, working
    from assistant.cli.options import with_project_defaults
    from assistant.cli.simulation import report_errors, solved_source

    kind = wanted.kind or _fmu_kind(wanted)
    output = wanted.output or Path("out") / f"{Path(wanted.source).stem}.fmu"
    if output.suffix.lower() != ".fmu" or output.is_dir():
        raise Refused(_NOT_AN_FMU_NAME(name=str(output)), exit_status=2)
    _check_options(wanted, kind)
    with working(f"writing {output}"):
        if kind != "program":
            model, findings = _arm_model(wanted, kind)
        else:
            options = with_project_defaults(wanted.source, wanted.options)
            ready = solved_source(wanted.source, options)
            if has_errors(ready.findings):
                robot = ready.solution.robot
                return report_errors(
                    wanted.source, robot, ready.findings, format, "written as an FMU"
                )
            model, unplayed = _program_model(wanted, options, ready)
            findings = [*ready.findings, *unplayed]
        data, more = compiled(model, everywhere=wanted.everywhere)
        findings = [*findings, *more]
        keep_sources([wanted.source], [output])
        (written,) = write_files({output.name: data}, output.parent)
    if format is Format.JSON:
        from assistant.findings.formats import finding_record

        told = [finding_record(finding) for finding in findings]
        answer = {"source": wanted.source, "kind": kind, "identifier": model.identifier}
        print_json({**answer, "guid": model.guid, "findings": told, "written": [str(written)]})
        return 0
    print_findings(findings, explained=True)
    say(f"{model.title}: {_summary(model)}")
    say(f"wrote {written}")
    return 0


def _check_options(wanted: _FmuOptions, kind: str) -> None:
    """Raises Refused for options that would do nothing."""
    given = (
        ("--lag", "arm", wanted.lag > 0.0),
        ("--cycle", "live", wanted.cycle is not None),
        ("--period", "program", wanted.options.period is not None),
    )
    for option, of, said in given:
        if said and of != kind:
            raise Refused(_OPTION_OF_OTHER_KIND(option=option, of=of, kind=kind), exit_status=2)


def _fmu_kind(wanted: _FmuOptions) -> str:
    """Return the kind of a source if no option states it: the name or file of a robot is an arm."""
    from assistant import robots
    from assistant.compiler.arms import ROBOT_FILES

    if wanted.source.lower() in robots.names():
        return "arm"
    is_file = Path(wanted.source).suffix.lower() in ROBOT_FILES
    return "arm" if is_file and wanted.options.robot is None else "program"


def _arm_model(wanted: _FmuOptions, kind: str) -> tuple[Model, Sequence[Diagnostic]]:
    """Simulated, or live."""
    from assistant.blocks.fmu import arm_model, live_model
    from assistant.compiler.arms import robot_of

    robot = robot_of(wanted.source)
    assert robot is not None
    if kind == "live":
        return live_model(robot, cycle=wanted.cycle), robot.findings
    return arm_model(robot, lag=wanted.lag), robot.findings


def _program_model(
    wanted: _FmuOptions, options: SimulationOptions, ready: Solved
) -> tuple[Model, Sequence[Diagnostic]]:
    """The motion of a program, and what of it only running it would tell."""
    from assistant.blocks.fmu import program_model, usual_period
    from assistant.blocks.fmu.robot_models import Motion
    from assistant.blocks.rules import PARTLY_PLAYED
    from assistant.robots.timing import simulate

    done = simulate(ready.solution, period=options.period, acceleration=options.acceleration)
    if options.period is None:
        done = replace(done, wanted_period=usual_period(done.seconds))
    unplayed = [PARTLY_PLAYED(what=str(one)) for one in done.unknown]
    return program_model(Motion.of(done), done.robot, Path(wanted.source).stem), unplayed


def _summary(model: Model) -> str:
    counted = {
        what: sum(one.causality == what for one in model.variables)
        for what in ("parameter", "input", "output")
    }
    return ", ".join(
        f"{count} {what}{'s' if count != 1 else ''}" for what, count in counted.items()
    )
