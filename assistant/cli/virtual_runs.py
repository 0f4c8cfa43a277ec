"""The commands that run programs on a virtual controller: `run` and `debug`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from assistant.cli.options import (
    AskAtOption,
    EntryOption,
    FormatOption,
    FromLanguage,
    MarkOption,
    PlaceOption,
    ProcessOption,
    RobotOption,
    SeenOption,
    UnitOption,
    placement_of,
)
from assistant.cli.presentation import Format


def run(
    programs: Annotated[
        list[str],
        typer.Argument(
            help="A program, the programs of several slots, the modules or folder of a task, a "
            "backup, or any other source; - for standard input."
        ),
    ],
    robot: RobotOption = None,
    signals: Annotated[
        Path | None,
        typer.Option("--signals", help="Script of inputs and answers, in TOML.", metavar="FILE"),
    ] = None,
    until: Annotated[
        str | None,
        typer.Option(help="End the run there: seconds, or FILE:LINE.", metavar="TIME|FILE:LINE"),
    ] = None,
    breaks: Annotated[
        list[str] | None,
        typer.Option("--break", help="Hold the run there; repeatable.", metavar="FILE:LINE"),
    ] = None,
    step: Annotated[
        bool, typer.Option("--step", help="Hold the run at its first statement.")
    ] = False,
    trace: Annotated[
        Path | None,
        typer.Option(help="Write the run in columns.", metavar="FILE.npz"),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw the run over time.", metavar="FILE.png|.svg")
    ] = None,
    period: Annotated[
        float | None, typer.Option(help="Seconds between samples; default 0.01, or what fits.")
    ] = None,
    max_steps: Annotated[
        int, typer.Option(help="Statements after which the run is broken off.")
    ] = 1_000_000,
    max_time: Annotated[
        float, typer.Option(help="Simulated seconds after which the run is broken off.")
    ] = 3600.0,
    real_time: Annotated[
        bool, typer.Option("--real-time", help="As slowly as it would really be.")
    ] = False,
    disk: Annotated[
        Path | None,
        typer.Option(
            help="Folder with the files of the controller, which others may change meanwhile.",
            metavar="FOLDER",
        ),
    ] = None,
    hosts: Annotated[
        list[str] | None,
        typer.Option(
            "--host",
            help="Host that an address of the programs stands for; repeatable.",
            metavar="ADDRESS=HOST",
        ),
    ] = None,
    lines: Annotated[
        list[str] | None,
        typer.Option(
            "--line",
            help="What a line of the programs leads to: a port for others to call, the "
            "HOST:PORT of a server, the path of a serial port, or `pty:FILE` to make one; "
            "repeatable.",
            metavar="NAME=TARGET",
        ),
    ] = None,
    ask: Annotated[
        bool, typer.Option("--ask", help="Have what the programs ask answered on standard input.")
    ] = False,
    process: ProcessOption = None,
    unit: UnitOption = None,
    place: PlaceOption = None,
    marks: MarkOption = None,
    from_language: FromLanguage = None,
    entry: EntryOption = None,
    seen: SeenOption = None,
    ask_at: AskAtOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Run programs on a virtual controller and tell what they do. No robot moves."""
    from assistant.cli.running import RunOptions, run_run
    from assistant.sources.sights import seeing

    options = RunOptions(
        robot=robot,
        process=process,
        unit=unit,
        placement=placement_of(place, marks),
        from_language=from_language,
        entry=entry,
        signals=signals,
        until=until,
        breaks=breaks or (),
        step=step,
        trace=trace,
        plot=plot,
        max_steps=max_steps,
        max_time=max_time,
        period=period,
        real_time=real_time,
        disk=disk,
        hosts=hosts or (),
        lines=lines or (),
        ask=ask,
        seeing=seeing(seen, ask_at),
    )
    raise typer.Exit(run_run(programs, options, format))


def debug() -> None:
    """Run a program as an editor says, over the Debug Adapter Protocol; see docs/debugging.md."""
    from assistant.cli.debugging import run_debug

    raise typer.Exit(run_debug())
