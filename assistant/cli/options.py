"""Options that several commands share, and their defaults from the project.

An option that is not given takes what `assistant.toml` states for the source, if the project makes
it in one way only. `--signals` and `--seed` need `--prove`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from assistant.base.diagnostics import FailOn, Refused, error
from assistant.cli.presentation import (
    FindingFormat,
    Format,
    FramesAs,
    GrammarAs,
    TranslationFormat,
    answer_as,
)

if TYPE_CHECKING:
    from assistant.compiler.motion_proof import Proving
    from assistant.sources.process.placement import DrawingPlacement


def complete_language(incomplete: str) -> list[str]:
    from assistant import languages

    return [name for name in languages.names() if name.startswith(incomplete)]


def complete_robot(incomplete: str) -> list[str]:
    from assistant import robots

    return [name for name in robots.names() if name.startswith(incomplete)]


def complete_unit(incomplete: str) -> list[str]:
    from assistant.base.length_units import UNITS

    return [name for name in UNITS if name.startswith(incomplete)]


Source = Annotated[
    str, typer.Argument(help="Drawing, table, .pseudo text or robot program; - for standard input.")
]
Sources = Annotated[list[str], typer.Argument(help="Drawings, tables or programs; - for input.")]
LanguageOption = Annotated[
    str | None,
    typer.Option("--language", "-l", help="Language to write; default the project's.",
                 autocompletion=complete_language),
]  # fmt: skip
RobotOption = Annotated[
    str | None,
    typer.Option(
        "--robot", "-r", help="Arm that runs it, or its file.", autocompletion=complete_robot
    ),
]
FromRobot = Annotated[
    str | None,
    typer.Option("--from-robot", help="Arm that a vendor program was written for.",
                 autocompletion=complete_robot),
]  # fmt: skip
FromLanguage = Annotated[
    str | None,
    typer.Option("--from", help="Language of the input if its name does not tell.",
                 autocompletion=complete_language),
]  # fmt: skip
ProcessOption = Annotated[
    Path | None,
    typer.Option("--process", "-p", help="Process file; default NAME.process.toml beside it."),
]
CellOption = Annotated[
    Path | None,
    typer.Option("--cell", help="File of the cell: its robots, and bodies not to be touched."),
]
SeenOption = Annotated[
    Path | None,
    typer.Option("--seen", metavar="FILE", help="Where objects were found, for frames that are "
                 "seen."),
]  # fmt: skip
AskAtOption = Annotated[
    str | None,
    typer.Option("--ask-at", metavar="HOST:PORT", help="Have the program ask there, as it runs, "
                 "for frames that are seen."),
]  # fmt: skip
AccelerationOption = Annotated[
    float | None,
    typer.Option(help="mm/s² of the tool on lines and arcs; default what the axes allow."),
]
EntryOption = Annotated[
    str | None,
    typer.Option("--entry", help="Procedure that the program begins with; default its main."),
]
CalledOption = Annotated[
    str | None,
    typer.Option("--as", metavar="NAME", help="What others call the program; default main."),
]
TogetherOption = Annotated[
    str | None,
    typer.Option("--together", metavar="NAME", help="All sources as one program of this name."),
]
NoMainOption = Annotated[
    bool,
    typer.Option("--no-main", help="Without a main: others call the procedures of the layers."),
]
UnitOption = Annotated[
    str | None,
    typer.Option("--unit", help="Unit that a drawing is in, whatever it says: mm, in, m …",
                 autocompletion=complete_unit),
]  # fmt: skip
PlaceOption = Annotated[
    str | None,
    typer.Option("--place", metavar="X,Y,Z[,A,B,C]",
                 help="Where a drawing's origin stands, mm, and degrees about z, y, x."),
]  # fmt: skip
MarkOption = Annotated[
    list[str] | None,
    typer.Option("--mark", metavar="X,Y=X,Y,Z",
                 help="Mark of a drawing and where it was taught, mm; three place it."),
]  # fmt: skip
FramesOption = Annotated[
    FramesAs,
    typer.Option(help="Work objects in MELFA-BASIC: as Base, or as factors of the targets."),
]
GrammarOption = Annotated[
    GrammarAs,
    typer.Option(help="What lark parses of a program of over 20,000 lines: samples, or all."),
]
ReportOption = Annotated[
    Path | None, typer.Option(help="Write the report as well: .html, .md, .json, or text.")
]
PageOption = Annotated[
    Path | None,
    typer.Option("--report", help="Write a page for the browser as well, FILE.html.",
                 metavar="FILE.html"),
]  # fmt: skip
PlotOption = Annotated[
    Path | None,
    typer.Option("--plot", help="Draw contours, their order and ways, as .svg or .png.",
                 metavar="FILE.svg"),
]  # fmt: skip
OpenOption = Annotated[
    bool, typer.Option("--open", help="Show the page in the browser; without --report from a "
                       "folder for temporary files.")
]  # fmt: skip
NamesOption = Annotated[
    Path | None, typer.Option(help="Write a table of the old and the new names, as CSV.")
]
EveryOption = Annotated[
    bool, typer.Option("--all", help="Tell of each statement, also of those that are said.")
]
DraftOption = Annotated[
    bool,
    typer.Option("--draft", help="Write programs that are not whole: a stop for each gap."),
]
TranslationFormatOption = Annotated[
    TranslationFormat,
    typer.Option("--format", help="For people, programs, code scanning or pull requests; markdown "
                 "is a comment of one.", callback=answer_as),
]  # fmt: skip
FindingFormatOption = Annotated[
    FindingFormat,
    typer.Option("--format", help="For people, programs, code scanning, pull or merge requests.",
                 callback=answer_as),
]  # fmt: skip
FailOnOption = Annotated[
    FailOn, typer.Option("--fail-on", help="What exit status 1 is for; never: it stays 0.")
]
FormatOption = Annotated[
    Format, typer.Option("--format", help="For people or for programs.", callback=answer_as)
]
ProveOption = Annotated[
    bool,
    typer.Option("--prove", help="Run the source and what is written, and compare what they do."),
]
SignalsOption = Annotated[
    Path | None,
    typer.Option(help="With --prove: a script of the inputs; default a search for all branches."),
]
SeedOption = Annotated[
    int, typer.Option(help="With --prove: of what the search draws; the same gives the same.")
]
OverwriteOption = Annotated[
    bool, typer.Option("--overwrite", help="Write over files that were edited, without the edits.")
]
KeepEditOption = Annotated[
    list[str] | None,
    typer.Option("--keep-edit", metavar="NAME", help="Keep this edit of a file although the source "
                 "has changed the same.", show_default=False),
]  # fmt: skip
DropEditOption = Annotated[
    list[str] | None,
    typer.Option("--drop-edit", metavar="NAME", help="Leave this edit of a file out.",
                 show_default=False),
]  # fmt: skip


def placement_of(place: str | None, marks: Sequence[str] | None) -> DrawingPlacement | None:
    """Return the placement given by --place or --mark, None for neither; raise Refused."""
    if place is None and not marks:
        return None
    from assistant.sources.process.placement import placement_of_options

    return placement_of_options(place, marks or ())


_SIGNALS_WITHOUT_PROOF = error(
    "CL020", "--signals says nothing without --prove", "add --prove, or leave it out"
)


def proof_settings(wanted: bool, signals: Path | None, seed: int) -> Proving | None:
    """Return the settings of a motion proof, None for no proof; raise Refused (exit status 2)."""
    from assistant.compiler.motion_proof import Proving

    if not wanted:
        if signals is not None:
            raise Refused(_SIGNALS_WITHOUT_PROOF(), exit_status=2)
        return None
    return Proving(script=signals, seed=seed)


T = TypeVar("T")


def with_project_defaults(source: str, options: T) -> T:
    """Options of a command, a record, with what the project of a source says of the rest.

    Raises Refused where it says several things.
    """
    if source == "-" or not Path(source).is_file():
        return options
    from assistant.project.source_options import OPTIONS, SourceOptions, completed_options

    assert is_dataclass(options) and not isinstance(options, type)
    names = [field.name for field in fields(options) if field.name in OPTIONS]
    given = SourceOptions(**{name: getattr(options, name) for name in names})
    done = completed_options(source, given, names)
    changed: dict[str, Any] = {name: getattr(done, name) for name in names}
    return replace(options, **changed)
