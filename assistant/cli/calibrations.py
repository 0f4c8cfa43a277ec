"""`robots calibrate` and `robots poses`, as they are typed."""

from __future__ import annotations

import enum
from pathlib import Path
from typing import Annotated

import typer

from assistant.cli.options import complete_robot
from assistant.cli.presentation import Format, answer_as


class Estimated(enum.StrEnum):
    """What of an arm is estimated."""

    ZEROS = "zeros"
    LENGTHS = "lengths"
    CHAIN = "chain"


RobotArgument = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT",
        help="A robot of the catalogue, or a robot file.",
        autocompletion=complete_robot,
    ),
]
EstimateOption = Annotated[
    Estimated,
    typer.Option(
        help="Zeros of the axes; with the lengths of the robot file; or a free chain of axes."
    ),
]
InBase = Annotated[
    bool, typer.Option("--in-base", help="The points are measured in the base of the arm.")
]
CamerasOption = Annotated[
    Path | None, typer.Option(metavar="FILE", help="File of the cameras that see the point.")
]
AnswerOption = Annotated[
    Format | None, typer.Option("--format", help="For people or for programs.")
]


def calibrate(
    context: typer.Context,
    robot: RobotArgument,
    measured: Annotated[
        Path, typer.Argument(metavar="MEASURED", help="CSV: joints beside measured points.")
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="The corrected robot, as TOML.")
    ],
    estimate: EstimateOption = Estimated.LENGTHS,
    tool: Annotated[
        str | None,
        typer.Option(metavar="X,Y,Z", help="Measured point in the flange, mm, if it is known."),
    ] = None,
    in_base: InBase = False,
    noise: Annotated[
        float | None, typer.Option(metavar="MM", help="Of the measured points, if it is known.")
    ] = None,
    cameras: CamerasOption = None,
    format: AnswerOption = None,
) -> None:
    """Correct lengths and zeros of an arm by measured poses, and tell what they cannot tell."""
    from assistant.cli.calibrating import CalibrationOptions, run_calibrate

    asked = _calibration_options(context, format)
    options = CalibrationOptions(output, estimate.value, tool, in_base, noise, cameras, asked)
    raise typer.Exit(run_calibrate(robot, measured, options))


def poses(
    context: typer.Context,
    robot: RobotArgument,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="Table of the joints, as CSV.")
    ],
    count: Annotated[int, typer.Option(help="How many.")] = 40,
    estimate: EstimateOption = Estimated.LENGTHS,
    tool: Annotated[
        str | None, typer.Option(metavar="X,Y,Z", help="Point in the flange, mm, roughly.")
    ] = None,
    in_base: InBase = False,
    box: Annotated[
        str | None,
        typer.Option(metavar="X0,X1,Y0,Y1,Z0,Z1", help="Where the point may be, mm of the base."),
    ] = None,
    cameras: CamerasOption = None,
    format: AnswerOption = None,
) -> None:
    """Suggest poses to measure an arm in, which tell most of its errors."""
    from assistant.cli.calibrating import PoseOptions, run_poses

    asked = _calibration_options(context, format)
    options = PoseOptions(output, count, estimate.value, tool, in_base, box, cameras, asked)
    raise typer.Exit(run_poses(robot, options))


def _calibration_options(context: typer.Context, format: Format | None) -> Format:
    before = context.parent.params["format"] if context.parent else Format.TEXT
    return answer_as(format or Format(before))
