"""The commands that read, write and check programs, as they are typed.

`compile` is carried out by `compilation`, `translate` and `coverage` by `translation`, `check`,
`explain` and `compare` by `program_checks`, `show` and `fmt` by `program_text`; each is imported
when its command runs.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from assistant.base.diagnostics import FailOn
from assistant.cli.options import (
    AskAtOption,
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
    GrammarOption,
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
    SeenOption,
    SignalsOption,
    Source,
    Sources,
    TogetherOption,
    TranslationFormatOption,
    UnitOption,
    complete_language,
    complete_robot,
    placement_of,
)
from assistant.cli.presentation import FindingFormat, Format, FramesAs, GrammarAs, TranslationFormat


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
    grammar: GrammarOption = GrammarAs.SAMPLES,
    from_language: FromLanguage = None,
    from_robot: FromRobot = None,
    entry: EntryOption = None,
    called: CalledOption = None,
    no_main: NoMainOption = False,
    together: TogetherOption = None,
    seen: SeenOption = None,
    ask_at: AskAtOption = None,
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
    from assistant.cli.compilation import run_compile
    from assistant.cli.options import proof_settings
    from assistant.cli.report_pages import PageRequest, compiled_page
    from assistant.compiler.merge_edits import MergeChoices
    from assistant.sources.sights import seeing

    raise typer.Exit(
        run_compile(
            sources,
            language,
            robot=robot,
            process=process,
            unit=unit,
            placement=placement_of(place, marks),
            cell=cell,
            output=output,
            most_targets=most_targets,
            frames=frames,
            grammar=grammar,
            from_language=from_language,
            from_robot=from_robot,
            entry=entry,
            called=called,
            main=False if no_main else None,
            together=together,
            seeing=seeing(seen, ask_at),
            proving=proof_settings(prove, signals, seed),
            wishes=MergeChoices.of(overwrite, keep_edit or (), drop_edit or ()),
            page=compiled_page(
                PageRequest(report, opened, plot), process, unit, placement_of(place, marks)
            ),
            format=format,
        )
    )


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
    grammar: GrammarOption = GrammarAs.SAMPLES,
    from_language: FromLanguage = None,
    entry: EntryOption = None,
    seen: SeenOption = None,
    ask_at: AskAtOption = None,
    prove: ProveOption = False,
    signals: SignalsOption = None,
    seed: SeedOption = 0,
    format: TranslationFormatOption = TranslationFormat.TEXT,
) -> None:
    """Write robot programs in another language, and report the result for every statement."""
    from assistant.cli.options import proof_settings
    from assistant.cli.translation import TranslateOptions, run_translate
    from assistant.sources.sights import seeing

    options = TranslateOptions(
        to=to,
        robot=robot,
        from_robot=from_robot,
        process=process,
        cell=cell,
        frames=frames,
        grammar=grammar,
        from_language=from_language,
        draft=draft,
        entry=entry,
        proving=proof_settings(prove, signals, seed),
        seeing=seeing(seen, ask_at),
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


def compare(
    first: Annotated[str, typer.Argument(help="Program, or folder with programs.")],
    second: Annotated[str, typer.Argument(help="What is to do the same, in any language.")],
    robot: Annotated[
        str | None,
        typer.Option("--robot", "-r", help="Arm of the second one.", autocompletion=complete_robot),
    ] = None,
    from_robot: Annotated[
        str | None,
        typer.Option("--from-robot", help="Arm of the first one.", autocompletion=complete_robot),
    ] = None,
    process: Annotated[
        list[Path] | None,
        typer.Option(
            "--process", "-p", help="File with signals, tools, frames of the first; then the other."
        ),
    ] = None,
    cell: Annotated[
        Path | None, typer.Option(help="File of what either uses and does not declare.")
    ] = None,
    names: Annotated[
        Path | None,
        typer.Option(help="File of what the second calls signals and data of the first."),
    ] = None,
    from_language: FromLanguage = None,
    entry: EntryOption = None,
    signals: Annotated[
        Path | None,
        typer.Option(help="Script of the inputs; default a search for all branches."),
    ] = None,
    seed: Annotated[
        int, typer.Option(help="Of what the search draws; the same gives the same.")
    ] = 0,
    seconds: Annotated[
        float, typer.Option(help="Of the processor, that the search may take.", min=0.1)
    ] = 10.0,
    text: Annotated[
        bool, typer.Option("--text", help="Pair their statements, and run nothing.")
    ] = False,
    report: PageOption = None,
    opened: OpenOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Run two programs and tell what they do otherwise: motions, outputs, waits, shared data."""
    from assistant.cli.program_checks import CompareOptions, run_compare
    from assistant.cli.report_pages import PageRequest
    from assistant.compiler.motion_proof import Proving

    options = CompareOptions(
        robot=robot,
        from_robot=from_robot,
        process=tuple(process or ()),
        cell=cell,
        names=names,
        language=from_language,
        entry=entry,
        proving=Proving(script=signals, seed=seed, seconds=seconds),
        text=text,
    )
    raise typer.Exit(run_compare(first, second, options, format, PageRequest(report, opened)))


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
    from assistant.cli.program_text import ShowOptions, run_show

    wanted = ShowOptions(
        robot, process, unit, from_language, entry, to, after, placement_of(place, marks)
    )
    raise typer.Exit(run_show(source, wanted, output))


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
    seen: SeenOption = None,
    ask_at: AskAtOption = None,
    report: PageOption = None,
    opened: OpenOption = False,
    plot: PlotOption = None,
    format: FindingFormatOption = FindingFormat.TEXT,
    fail_on: FailOnOption = FailOn.WARNING,
) -> None:
    """Check sources and robot programs; with a robot also reach, limits and configurations."""
    from assistant.cli.program_checks import CheckOptions, run_check
    from assistant.cli.report_pages import PageRequest
    from assistant.sources.sights import seeing

    if not sources:
        from assistant.cli.projects import check_project

        given = {
            "--robot": robot,
            "--process": process,
            "--unit": unit,
            "--place": place,
            "--mark": marks or None,
            "--cell": cell,
            "--from": from_language,
            "--seen": seen,
            "--ask-at": ask_at,
            "--report": report,
            "--open": opened or None,
            "--plot": plot,
        }
        raise typer.Exit(check_project(given, format, fail_on))
    placed, sights = placement_of(place, marks), seeing(seen, ask_at)
    options = CheckOptions(robot, process, unit, cell, from_language, placed, sights)
    raise typer.Exit(
        run_check(sources, options, format, fail_on, PageRequest(report, opened, plot))
    )


def explain(
    codes: Annotated[list[str], typer.Argument(help="Codes of findings, such as RA204.")],
) -> None:
    """Print what a finding means, what to do, and an example."""
    from assistant.cli.program_checks import run_explain

    raise typer.Exit(run_explain(codes))


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
    """Lay robot programs out: indentation, blanks, case of keywords. Their meaning stays the
    same.
    """
    from assistant.cli.program_text import run_fmt

    raise typer.Exit(run_fmt(files, check, diff, from_language, renumber))


def coverage(
    programs: Annotated[
        list[str], typer.Argument(help="Robot programs, or folders with them; - for input.")
    ],
    from_language: FromLanguage = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell, construct by construct, what of a program can be translated and what cannot."""
    from assistant.cli.translation import run_coverage

    raise typer.Exit(run_coverage(programs, from_language, format))
