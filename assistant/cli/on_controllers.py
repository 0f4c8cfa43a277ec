"""The commands that speak with a controller; each is carried out in a file of its subject."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from assistant.cli.options import FormatOption, RobotOption
from assistant.cli.presentation import Format


def complete_controller(incomplete: str) -> list[str]:
    from assistant.controllers import controllers_of

    return [name for name in controllers_of(Path.cwd()) if name.startswith(incomplete)]


CellArgument = Annotated[
    str,
    typer.Argument(
        metavar="CONTROLLER",
        help="Its name in [controllers] of assistant.toml, or its address.",
        autocompletion=complete_controller,
    ),
]
YesOption = Annotated[
    bool, typer.Option("--yes", help="Do it without asking. Look that nobody is near.")
]
ReplaceOption = Annotated[bool, typer.Option("--replace", help="Also what is there already.")]


def ls(cell: CellArgument, format: FormatOption = Format.TEXT) -> None:
    """List the programs on a controller."""
    from assistant.cli.looking import run_ls

    raise typer.Exit(run_ls(cell, format))


def get(
    cell: CellArgument,
    names: Annotated[list[str], typer.Argument(help="Programs, as `ls` lists them.")],
    output: Annotated[
        str | None, typer.Option("--output", "-o", help="File, folder, or - to print.")
    ] = None,
    replace: ReplaceOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Copy programs from a controller."""
    from assistant.cli.copying import run_get

    raise typer.Exit(run_get(cell, names, output, replace, format))


def put(
    cell: CellArgument,
    files: Annotated[list[Path], typer.Argument(help="Programs.")],
    replace: ReplaceOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Copy programs to a controller as they are; `deploy` also checks, keeps and compares."""
    from assistant.cli.copying import run_put

    raise typer.Exit(run_put(cell, files, replace, format))


def rm(
    cell: CellArgument,
    names: Annotated[list[str], typer.Argument(help="Programs or other files, as `ls` lists.")],
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Delete programs on a controller that nothing there has loaded. Asks before."""
    from assistant.cli.copying import run_rm

    raise typer.Exit(run_rm(cell, names, yes, format))


def backup(
    cell: CellArgument,
    folder: Annotated[Path, typer.Argument(help="A folder that is not there yet.")],
    format: FormatOption = Format.TEXT,
) -> None:
    """Write programs, parameters and variables of a controller into a folder."""
    from assistant.cli.copying import run_backup

    raise typer.Exit(run_backup(cell, folder, format))


def restore(
    cell: CellArgument,
    folder: Annotated[Path, typer.Argument(help="A folder that `backup` has written.")],
    only: Annotated[
        list[str] | None,
        typer.Option(help="Only this file or parameter, also of those left out; repeatable."),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only show what would change.")
    ] = False,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Show what differs from a backup, and bring it back; origin, safety, network only by name."""
    from assistant.cli.copying import run_restore

    raise typer.Exit(run_restore(cell, folder, only or (), dry_run, yes, format))


def monitor(
    cell: CellArgument,
    log: Annotated[
        Path | None, typer.Option("--log", help="Write a row each.", metavar="FILE.csv")
    ] = None,
    signals: Annotated[
        list[str] | None, typer.Option("--signals", help="A signal to show; repeatable.")
    ] = None,
    interval: Annotated[float, typer.Option(help="Seconds between two looks.")] = 0.5,
    seconds: Annotated[float | None, typer.Option(help="How long; default until Ctrl-C.")] = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Show again and again what a controller does and where its arm is. Changes nothing."""
    from assistant.cli.monitoring import MonitorOptions, run_monitor

    names = [name for given in signals or () for name in given.split(",") if name]
    raise typer.Exit(run_monitor(cell, MonitorOptions(names, interval, seconds, log, format)))


def log(
    cell: CellArgument,
    most: Annotated[int, typer.Option(min=1, help="How many.")] = 50,
    format: FormatOption = Format.TEXT,
) -> None:
    """Print the latest errors and events of a controller, the newest first."""
    from assistant.cli.looking import run_log

    raise typer.Exit(run_log(cell, most, format))


def inputs(
    cell: CellArgument,
    names: Annotated[list[str], typer.Argument(help="Names or numbers of inputs.")],
    format: FormatOption = Format.TEXT,
) -> None:
    """Print what inputs read."""
    from assistant.cli.looking import run_inputs

    raise typer.Exit(run_inputs(cell, names, format))


def outputs(
    cell: CellArgument,
    names: Annotated[list[str], typer.Argument(metavar="NAME[=VALUE]...", help="Outputs.")],
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Print outputs, or set them; what hangs on them may move, so setting is asked for."""
    from assistant.cli.looking import run_outputs

    raise typer.Exit(run_outputs(cell, names, yes, format))


def parameters(
    cell: CellArgument,
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME[=VALUE]]...", help="Default: those that were changed."),
    ] = None,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Print parameters, or set them."""
    from assistant.cli.looking import run_parameters

    raise typer.Exit(run_parameters(cell, names or (), yes, format))


def variables(
    cell: CellArgument,
    names: Annotated[list[str], typer.Argument(metavar="NAME[=VALUE]...", help="Variables.")],
    program: Annotated[str, typer.Option(help="Program or module that they are in.")] = "",
    task: Annotated[str, typer.Option(help="Task or slot; default the first.")] = "",
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Print variables of programs, or set them, as the controller's language writes values."""
    from assistant.cli.looking import run_variables

    raise typer.Exit(run_variables(cell, names, program, task, yes, format))


def reset(cell: CellArgument, format: FormatOption = Format.TEXT) -> None:
    """Acknowledge the errors of a controller. Nothing moves."""
    from assistant.cli.looking import run_reset

    raise typer.Exit(run_reset(cell, format))


def stop(cell: CellArgument, format: FormatOption = Format.TEXT) -> None:
    """Stop all programs where they are. Never asks; no emergency stop."""
    from assistant.cli.looking import run_stop

    raise typer.Exit(run_stop(cell, format))


def teach(
    cell: Annotated[
        str | None,
        typer.Argument(
            metavar="CONTROLLER",
            help="Its name in [controllers] of assistant.toml, or its address; --point needs none.",
            autocompletion=complete_controller,
        ),
    ] = None,
    names: Annotated[
        list[str] | None, typer.Argument(help="Targets, in this order; default p1, p2 …")
    ] = None,
    into: Annotated[
        Path, typer.Option(help="File of taught targets, which keeps all else.", metavar="FILE")
    ] = Path("taught.toml"),
    on: Annotated[
        str | None, typer.Option(help="Store when this input comes, not at a key.", metavar="INPUT")
    ] = None,
    now: Annotated[bool, typer.Option("--now", help="Store one target at once.")] = False,
    joints: Annotated[bool, typer.Option("--joints", help="As joint angles.")] = False,
    tool: Annotated[
        str | None, typer.Option(help="Tool of the file that the controller shows the pose of.")
    ] = None,
    frame: Annotated[str | None, typer.Option(help="Frame that it shows it in.")] = None,
    replace: ReplaceOption = False,
    point: Annotated[
        Path | None,
        typer.Option(help="Store places that are shown to these cameras.", metavar="CAMERAS.toml"),
    ] = None,
    camera: Annotated[
        list[str] | None, typer.Option(help="Camera that looks; repeatable, default all.")
    ] = None,
    device: Annotated[
        str, typer.Option(help="wand, ball, light, or a file.", metavar="DEVICE")
    ] = "wand",
    frames: Annotated[int, typer.Option(help="Pictures for which a place is held.")] = 30,
    rate: Annotated[float, typer.Option(help="Pictures a second of files.")] = 30.0,
    residual: Annotated[float, typer.Option(help="Pixels by which pictures may disagree.")] = 0.5,
    fastest: Annotated[float, typer.Option(help="mm/s that a hand moves.")] = 1500.0,
    robot: RobotOption = None,
    world: Annotated[
        str | None, typer.Option(help="Frame of the file in which the cameras stand.")
    ] = None,
    stroke: Annotated[
        bool, typer.Option("--stroke", help="Store the way between two places, as a .csv.")
    ] = False,
    step: Annotated[float, typer.Option(help="mm between waypoints of a stroke.")] = 5.0,
    go: Annotated[
        bool, typer.Option("--go", help="Lead the arm there; store what it reached.")
    ] = False,
    by: Annotated[str, typer.Option(help="Way to lead it, as of `follow`.")] = "data-link",
    port: Annotated[
        int | None, typer.Option(help="UDP port of that way.", min=1, max=65535)
    ] = None,
    lines: Annotated[
        list[str] | None, typer.Option("--line", help="Line of that way; repeatable.")
    ] = None,
    above: Annotated[
        float, typer.Option(help="mm before a place from which it is led straight.")
    ] = 50.0,
    servo: Annotated[
        Path | None,
        typer.Option(help="Lead it from there by what is seen of its tool.", metavar="TASK.toml"),
    ] = None,
    speed: Annotated[float, typer.Option(help="Percent of what the file says.")] = 10.0,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Store where the arm is, or places that are shown to cameras, under names.

    At a key press, when an input comes, or when a device is held still. Nothing moves but with
    --go, which asks before.
    """
    from assistant.compiler.taught_targets import TargetOptions

    wanted = TargetOptions(joints, tool, frame, replace)
    if point is not None:
        from assistant.cli.pointing import run_point
        from assistant.cli.shown import PointingOptions as Pointing
        from assistant.controllers.trajectory_execution import LinkOptions

        words = [cell, *(names or ())] if cell is not None else []
        pointing = Pointing(
            cameras=point,
            into=into,
            wanted=wanted,
            use=tuple(camera or ()),
            device=device,
            frames=frames,
            rate=rate,
            residual=residual,
            fastest=fastest,
            robot=robot,
            world=world,
            stroke=stroke,
            step=step,
            go=go,
            by=by,
            wishes=LinkOptions(port, tuple(lines or ()), None, replace),
            above=above,
            speed=speed,
            servo=servo,
            yes=yes,
            format=format,
        )
        raise typer.Exit(run_point(words, on, now, pointing))
    from assistant.cli.teaching import TeachOptions, run_teach

    options = TeachOptions(into, on, now, wanted, format)
    raise typer.Exit(run_teach(cell, names or (), options, {"--go": go, "--stroke": stroke}))
