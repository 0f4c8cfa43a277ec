"""The commands that may move an arm, as they are typed; each asks before.

`motors`, `jog`, `start`, `hand` and `follow` are carried out by `arm_motion`, `servo` by
`visual_servoing`.
"""

from __future__ import annotations

import enum
from pathlib import Path
from typing import Annotated

import typer

from assistant.cli.controller_commands import CellArgument, YesOption
from assistant.cli.options import FormatOption
from assistant.cli.presentation import Format


class Switch(enum.StrEnum):
    ON = "on"
    OFF = "off"


class Hand(enum.StrEnum):
    OPEN = "open"
    CLOSE = "close"


class JogFrame(enum.StrEnum):
    BASE = "base"
    TOOL = "tool"


def motors(
    cell: CellArgument,
    state: Annotated[Switch, typer.Argument(help="What they shall be.")],
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Switch the motors of an arm on or off."""
    from assistant.cli.arm_motion import run_motors

    raise typer.Exit(run_motors(cell, state is Switch.ON, yes, format))


def jog(
    cell: CellArgument,
    axis: Annotated[str, typer.Argument(help="J1 … J8, or X Y Z A B C of the frame.")],
    by: Annotated[float, typer.Argument(help="Degrees, or mm.")],
    frame: Annotated[JogFrame, typer.Option(help="Of X … C.")] = JogFrame.BASE,
    speed: Annotated[float, typer.Option(help="Percent.")] = 10.0,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Move one axis of an arm by hand. Asks before; Ctrl-C stops the arm."""
    from assistant.cli.arm_motion import run_jog
    from assistant.controllers.states import Jog

    wanted = Jog(axis.upper(), by, "tool" if frame is JogFrame.TOOL else "base", speed)
    raise typer.Exit(run_jog(cell, wanted, yes, format))


def start(
    cell: CellArgument,
    program: Annotated[
        str | None, typer.Argument(help="Program to load before; default what is loaded.")
    ] = None,
    task: Annotated[str, typer.Option(help="Task or slot; default the first.")] = "",
    forever: Annotated[bool, typer.Option("--forever", help="Again and again.")] = False,
    wait: Annotated[
        bool, typer.Option("--wait/--no-wait", help="Stay until it ends; Ctrl-C stops it then.")
    ] = True,
    override: Annotated[int | None, typer.Option(help="Percent of the speed.")] = None,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Start a program on a controller. Asks before; Ctrl-C stops it."""
    from assistant.cli.arm_motion import run_start

    status = run_start(
        cell,
        program,
        task,
        forever=forever,
        wait=wait,
        override=override,
        yes=yes,
        format=format,
    )
    raise typer.Exit(status)


def hand(
    cell: CellArgument,
    state: Annotated[Hand, typer.Argument(help="What it shall do.")],
    number: Annotated[int, typer.Option(min=1, help="Which one.")] = 1,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Open or close a hand. Asks before."""
    from assistant.cli.arm_motion import run_hand

    raise typer.Exit(run_hand(cell, state is Hand.OPEN, number, yes, format))


def complete_mode(incomplete: str) -> list[str]:
    from assistant.controllers.trajectory_execution import MODES

    return [name for name in MODES if name.startswith(incomplete)]


def follow(
    cell: CellArgument,
    trajectory: Annotated[
        str, typer.Argument(help="A table, an array, or a program that only moves.")
    ],
    by: Annotated[
        str, typer.Option(help="Way to lead it: see the docs.", autocompletion=complete_mode)
    ],
    speed: Annotated[float, typer.Option(help="Percent of what the trajectory says.")] = 100.0,
    interval: Annotated[
        float | None, typer.Option(help="Seconds between points; default what suits the way.")
    ] = None,
    log: Annotated[
        Path | None, typer.Option(help="Write what was recorded.", metavar="FILE.csv|.npz")
    ] = None,
    port: Annotated[
        int | None, typer.Option(help="UDP port; default the usual one.", min=1, max=65535)
    ] = None,
    lines: Annotated[
        list[str] | None,
        typer.Option("--line", help="HOST:PORT or serial port of a line; repeatable, in order."),
    ] = None,
    cycle: Annotated[
        float | None, typer.Option(help="Seconds of a cycle.", min=0.0005, max=1.0)
    ] = None,
    replace: Annotated[
        bool, typer.Option("--replace", help="Our programs replace others of their names.")
    ] = False,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Lead an arm along a trajectory. Checks all of it and asks before; Ctrl-C stops the arm."""
    from assistant.cli.arm_motion import FollowOptions, run_follow
    from assistant.controllers.trajectory_execution import LinkOptions

    wishes = LinkOptions(port, tuple(lines or ()), cycle, replace)
    options = FollowOptions(by, speed, interval, log, wishes, yes, format)
    raise typer.Exit(run_follow(cell, trajectory, options))


def complete_servo_mode(incomplete: str) -> list[str]:
    from assistant.controllers.setpoint_streams import MODES

    return [name for name in MODES if name.startswith(incomplete)]


def servo(
    cell: CellArgument,
    task: Annotated[Path, typer.Argument(help="File of what is led where.", metavar="SERVO.toml")],
    cameras: Annotated[Path, typer.Option(help="File of the cameras.", metavar="CAMERAS.toml")],
    by: Annotated[
        str, typer.Option(help="Way to lead it: see the docs.", autocompletion=complete_servo_mode)
    ],
    log: Annotated[
        Path | None, typer.Option(help="Write what was recorded.", metavar="FILE.csv|.npz")
    ] = None,
    port: Annotated[
        int | None, typer.Option(help="UDP port; default the usual one.", min=1, max=65535)
    ] = None,
    lines: Annotated[
        list[str] | None,
        typer.Option("--line", help="HOST:PORT or serial port of a line; repeatable, in order."),
    ] = None,
    cycle: Annotated[
        float | None, typer.Option(help="Seconds of a cycle.", min=0.0005, max=1.0)
    ] = None,
    replace: Annotated[
        bool, typer.Option("--replace", help="Our programs replace others of their names.")
    ] = False,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Lead an arm by what cameras see, to its goal. Asks before; Ctrl-C stops the arm."""
    from assistant.cli.visual_servoing import ServoOptions, run_servo
    from assistant.controllers.trajectory_execution import LinkOptions

    wishes = LinkOptions(port, tuple(lines or ()), cycle, replace)
    raise typer.Exit(run_servo(cell, task, ServoOptions(cameras, by, log, wishes, yes, format)))
