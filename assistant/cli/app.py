"""The commands of `robot-assistant`; each imports what it needs when it runs."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Final

import typer

from assistant import __version__
from assistant.cli import deployments, on_arms, on_controllers, projects
from assistant.cli.exchanges import exchange
from assistant.cli.explorations import explore
from assistant.cli.gateways import gateway
from assistant.cli.options import (
    AccelerationOption,
    CalledOption,
    CellOption,
    DraftOption,
    DropEditOption,
    EntryOption,
    EveryOption,
    FailOnOption,
    FindingFormatOption,
    FormatOption,
    FramesOption,
    FromLanguage,
    FromRobot,
    KeepEditOption,
    LanguageOption,
    MarkOption,
    NamesOption,
    NoMainOption,
    OpenOption,
    OverwriteOption,
    PageOption,
    PlaceOption,
    PlotOption,
    ProcessOption,
    ProveOption,
    ReportOption,
    RobotOption,
    SeedOption,
    SignalsOption,
    Source,
    Sources,
    TogetherOption,
    TranslationFormatOption,
    UnitOption,
    complete_language,
    complete_robot,
    placing,
)
from assistant.cli.presentation import (
    FindingFormat,
    Format,
    FramesAs,
    TranslationFormat,
    answer_as,
)
from assistant.cli.reaching import reach
from assistant.cli.virtual_commands import virtual
from assistant.cli.virtual_runs import debug, run
from assistant.findings.fail_on import FailOn

app: Final = typer.Typer(
    help="Drawings, trajectories and robot programs to proven ABB RAPID and MELFA-BASIC.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.add_typer(virtual, name="virtual")
robots: Final = typer.Typer(
    help="List the robots there are; `show` tells all of one.",
    invoke_without_command=True,
    rich_markup_mode=None,
)
app.add_typer(robots, name="robots")
app.add_typer(exchange, name="exchange")
app.add_typer(reach, name="reach")
app.add_typer(explore, name="explore")


def _budget(text: str | None) -> None:
    """For this command, and for the processes that it starts."""
    from assistant.program.system.budgets import VARIABLE, factor, factor_of

    if text is not None:
        factor_of(text)
        os.environ[VARIABLE] = text
    factor()  # what the environment states is looked at before anything is done


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"robot-assistant {__version__}")
        raise typer.Exit


@app.callback()
def options(
    _: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Print the version."),
    ] = False,
    budget: Annotated[
        str | None,
        typer.Option(
            "--budget",
            metavar="FACTOR",
            help="Times all limits of time, memory and size.",
        ),
    ] = None,
) -> None:
    """Drawings, trajectories and robot programs to proven ABB RAPID and MELFA-BASIC."""
    _budget(budget)


@app.command()
def compile(
    sources: Sources,
    language: LanguageOption = None,
    robot: RobotOption = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    place: PlaceOption = None,
    marks: MarkOption = None,
    cell: CellOption = None,
    output: Annotated[
        str, typer.Option("--output", "-o", help="Folder for the files; - prints a single one.")
    ] = ".",
    most_targets: Annotated[
        int | None,
        typer.Option(help="Targets of one program unit; default the language's own limit."),
    ] = None,
    frames: FramesOption = FramesAs.BASE,
    from_language: FromLanguage = None,
    from_robot: FromRobot = None,
    entry: EntryOption = None,
    called: CalledOption = None,
    no_main: NoMainOption = False,
    together: TogetherOption = None,
    prove: ProveOption = False,
    signals: SignalsOption = None,
    seed: SeedOption = 0,
    overwrite: OverwriteOption = False,
    keep_edit: KeepEditOption = None,
    drop_edit: DropEditOption = None,
    report: PageOption = None,
    opened: OpenOption = False,
    plot: PlotOption = None,
    format: FindingFormatOption = FindingFormat.TEXT,
) -> None:
    """Write sources in a robot language, read back and compared before anything is written."""
    from assistant.cli.compiling import run_compile
    from assistant.cli.pages import Asked
    from assistant.cli.proving import proving
    from assistant.cli.sheets import compiled_page
    from assistant.compiler.keeping import Wishes

    raise typer.Exit(
        run_compile(
            sources,
            language,
            robot=robot,
            process=process,
            unit=unit,
            placement=placing(place, marks),
            cell=cell,
            output=output,
            most_targets=most_targets,
            frames=frames,
            from_language=from_language,
            from_robot=from_robot,
            entry=entry,
            called=called,
            main=False if no_main else None,
            together=together,
            proving=proving(prove, signals, seed),
            wishes=Wishes.of(overwrite, keep_edit or (), drop_edit or ()),
            page=compiled_page(Asked(report, opened, plot), process, unit, placing(place, marks)),
            format=format,
        )
    )


@app.command()
def translate(
    programs: Annotated[
        list[str], typer.Argument(help="Robot programs, or folders with them; - for input.")
    ],
    to: Annotated[str, typer.Option(help="Language to write.", autocompletion=complete_language)],
    robot: RobotOption = None,
    from_robot: FromRobot = None,
    process: Annotated[
        Path | None,
        typer.Option("--process", "-p", help="File with signals, tools, frames of the other cell."),
    ] = None,
    cell: Annotated[
        Path | None,
        typer.Option(
            help="File with bodies, and what programs use and do not declare; written if it lacks "
            "any."
        ),
    ] = None,
    ask: Annotated[
        bool, typer.Option("--ask", help="Ask for what the file of --cell lacks.")
    ] = False,
    output: Annotated[str, typer.Option("--output", "-o", help="Folder for the files.")] = ".",
    report: ReportOption = None,
    opened: OpenOption = False,
    names: NamesOption = None,
    every: EveryOption = False,
    draft: DraftOption = False,
    frames: FramesOption = FramesAs.BASE,
    from_language: FromLanguage = None,
    entry: EntryOption = None,
    prove: ProveOption = False,
    signals: SignalsOption = None,
    seed: SeedOption = 0,
    format: TranslationFormatOption = TranslationFormat.TEXT,
) -> None:
    """Write robot programs in another language; tell of every statement what becomes of it."""
    from assistant.cli.proving import proving
    from assistant.cli.translating import Options, run_translate

    options = Options(
        to=to,
        robot=robot,
        from_robot=from_robot,
        process=process,
        cell=cell,
        frames=frames,
        from_language=from_language,
        draft=draft,
        entry=entry,
        proving=proving(prove, signals, seed),
    )
    run = run_translate(
        programs,
        options,
        output=output,
        report=report,
        format=format,
        names=names,
        ask=ask,
        every=every,
        opened=opened,
    )
    raise typer.Exit(run)


@app.command()
def show(
    source: Source,
    robot: RobotOption = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    place: PlaceOption = None,
    marks: MarkOption = None,
    from_language: FromLanguage = None,
    entry: EntryOption = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Write a .pseudo file, long paths in tables beside."),
    ] = None,
    to: Annotated[
        str | None,
        typer.Option(help="As this language will say it.", autocompletion=complete_language),
    ] = None,
    after: Annotated[
        str | None, typer.Option(help="On the way into that language, after this pass.")
    ] = None,
) -> None:
    """Print the pseudo-program of any source or robot program."""
    from assistant.cli.showing import Wanted, run_show

    wanted = Wanted(robot, process, unit, from_language, entry, to, after, placing(place, marks))
    raise typer.Exit(run_show(source, wanted, output))


@app.command()
def check(
    sources: Annotated[
        list[str] | None,
        typer.Argument(help="Files, or folders with programs; - for input; none for the project."),
    ] = None,
    robot: RobotOption = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    place: PlaceOption = None,
    marks: MarkOption = None,
    cell: CellOption = None,
    from_language: FromLanguage = None,
    report: PageOption = None,
    opened: OpenOption = False,
    plot: PlotOption = None,
    format: FindingFormatOption = FindingFormat.TEXT,
    fail_on: FailOnOption = FailOn.WARNING,
) -> None:
    """Check sources and robot programs; with a robot also reach, limits and configurations."""
    from assistant.cli.checking import Options, run_check
    from assistant.cli.pages import Asked

    if not sources:
        from assistant.cli.building import run_project_check

        given = {
            "--robot": robot,
            "--process": process,
            "--unit": unit,
            "--place": place,
            "--mark": marks or None,
            "--cell": cell,
            "--from": from_language,
            "--report": report,
            "--open": opened or None,
            "--plot": plot,
        }
        raise typer.Exit(run_project_check(given, format, fail_on))
    options = Options(robot, process, unit, cell, from_language, placing(place, marks))
    raise typer.Exit(run_check(sources, options, format, fail_on, Asked(report, opened, plot)))


@app.command()
def explain(
    codes: Annotated[list[str], typer.Argument(help="Codes of findings, such as RA204.")],
) -> None:
    """Print what a finding means, what to do, and an example."""
    from assistant.cli.checking import run_explain

    raise typer.Exit(run_explain(codes))


@app.command()
def fmt(
    files: Annotated[
        list[str], typer.Argument(help="Robot programs, or folders with them; - for input.")
    ],
    check: Annotated[
        bool, typer.Option("--check", help="Write nothing; exit 1 if a file would change.")
    ] = False,
    diff: Annotated[
        bool, typer.Option("--diff", help="Write nothing; print what would change.")
    ] = False,
    renumber: Annotated[
        str | None,
        typer.Option(
            "--renumber", metavar="FIRST,STEP", help="Number the steps anew, jumps to them too."
        ),
    ] = None,
    from_language: FromLanguage = None,
) -> None:
    """Lay robot programs out: indentation, blanks, case of keywords. What they say stays."""
    from assistant.cli.formatting import run_fmt

    raise typer.Exit(run_fmt(files, check, diff, from_language, renumber))


@app.command()
def coverage(
    programs: Annotated[
        list[str], typer.Argument(help="Robot programs, or folders with them; - for input.")
    ],
    from_language: FromLanguage = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell, construct by construct, what of a program can be translated and what cannot."""
    from assistant.cli.coverage import run_coverage

    raise typer.Exit(run_coverage(programs, from_language, format))


@app.command()
def simulate(
    program: Source,
    robot: RobotOption = None,
    output: Annotated[
        list[str] | None,
        typer.Option(
            "--output",
            "-o",
            help="Folder for all files, or a .csv, .npz, .png or .svg; repeatable.",
        ),
    ] = None,
    acceleration: AccelerationOption = None,
    period: Annotated[
        float | None, typer.Option(help="Seconds between samples; default 0.01, or what fits.")
    ] = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    place: PlaceOption = None,
    marks: MarkOption = None,
    cell: CellOption = None,
    from_language: FromLanguage = None,
    from_robot: FromRobot = None,
    entry: EntryOption = None,
    report: PageOption = None,
    opened: OpenOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell how long a program takes on a robot, and write its motion over time. Nothing moves."""
    from assistant.cli.pages import Asked
    from assistant.cli.sheets import simulated_page
    from assistant.cli.simulating import Options, run_simulate

    options = Options(
        robot,
        process,
        unit,
        from_language,
        from_robot,
        acceleration,
        period,
        entry,
        cell,
        placing(place, marks),
    )
    page = simulated_page(Asked(report, opened))
    raise typer.Exit(run_simulate(program, options, output or (), format, page))


@app.command()
def view(
    program: Source,
    robot: RobotOption = None,
    cell: CellOption = None,
    html: Annotated[
        Path | None,
        typer.Option(help="File for the page, which needs no other; default it is opened."),
    ] = None,
    live: Annotated[
        str | None,
        typer.Option(
            help="Controller that the page follows until Ctrl-C; it is only looked at.",
            metavar="CONTROLLER",
        ),
    ] = None,
    acceleration: AccelerationOption = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    place: PlaceOption = None,
    marks: MarkOption = None,
    from_language: FromLanguage = None,
    from_robot: FromRobot = None,
    entry: EntryOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Show a program in its cell: arm, bodies, path and contacts over time. Nothing moves."""
    from assistant.cli.simulating import Options
    from assistant.cli.viewing import run_view

    options = Options(
        robot,
        process,
        unit,
        from_language,
        from_robot,
        acceleration,
        None,
        entry,
        cell,
        placing(place, marks),
    )
    raise typer.Exit(run_view(program, options, html, format, live))


@app.command()
def info(
    drawing: Annotated[Path, typer.Argument(help="A DXF drawing.")],
    process: ProcessOption = None,
    unit: UnitOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell what is in a drawing: unit, size, layers, contours, blocks, and what would be used."""
    from assistant.cli.drawings import run_info

    raise typer.Exit(run_info(drawing, process, unit, format))


@app.command()
def scene(
    file: Annotated[Path, typer.Argument(help="Cell file, or a drawing of the cell.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Cell file (.toml) or glTF (.glb) to write instead."),
    ] = None,
    unit: UnitOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell what stands in a cell, body by body, or write it as another file."""
    from assistant.cli.scenes import run_scene

    raise typer.Exit(run_scene(file, unit, output, format))


app.command()(run)
app.command()(debug)
app.command()(gateway)


for command in (
    *(*projects.COMMANDS, *deployments.COMMANDS),
    *(*on_controllers.COMMANDS, *on_arms.COMMANDS),
):
    minus = {"ignore_unknown_options": True} if command.__name__ in on_arms.NUMBERS else None
    app.command(context_settings=minus)(command)


@robots.callback()
def robots_list(context: typer.Context, format: FormatOption = Format.TEXT) -> None:
    """List the robots of the catalogue; `robots show NAME` tells all of one."""
    from assistant.cli.robots import run_list

    if context.invoked_subcommand is None:
        raise typer.Exit(run_list(format))


@robots.command("show")
def robots_show(
    context: typer.Context,
    robot: Annotated[
        str,
        typer.Argument(
            metavar="NAME",
            help="A robot of the catalogue, or a robot file.",
            autocompletion=complete_robot,
        ),
    ],
    draw: Annotated[
        Path | None,
        typer.Option(help="Draw the arm as well: FILE.png or FILE.svg.", metavar="FILE"),
    ] = None,
    format: Annotated[
        Format | None, typer.Option("--format", help="For people or for programs.")
    ] = None,
) -> None:
    """Print the data of a robot with their source, and draw it."""
    from assistant.cli.robots import run_show

    before = context.parent.params["format"] if context.parent else Format.TEXT
    asked = answer_as(format or Format(before))
    raise typer.Exit(run_show(robot, draw, Format(asked)))


@app.command()
def demo(
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for what it makes.")
    ] = Path("out/demo"),
) -> None:
    """A drawing and a trajectory to programs on two embedded virtual controllers, with a report."""
    from assistant.cli.demo import run_demo

    raise typer.Exit(run_demo(output))
