"""Options that several commands share: each is written here once.

An option with a key of the `project` that is not given takes what `assistant.toml` states for the
source, if the project makes it in one way only. Options that belong together are groups.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from assistant.base.diagnostics import Refused, error
from assistant.cli.command import Argument, Option, option, options, with_project_values
from assistant.cli.presentation import FindingFormat, Format, FramesAs, GrammarAs, answer_as

if TYPE_CHECKING:
    from assistant.compiler.merge_edits import MergeChoices
    from assistant.compiler.motion_proof import Proving
    from assistant.sources.process.placement import DrawingPlacement
    from assistant.sources.sights import Seeing


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
    str, Argument("Drawing, table, .pseudo text or robot program; - for standard input.")
]
Sources = Annotated[tuple[str, ...], Argument("Drawings, tables or programs; - for input.")]
RobotOption = Annotated[
    str | None,
    Option(
        "Arm that runs it, or its file.",
        "--robot",
        "-r",
        project="robot",
        completions=complete_robot,
    ),
]
FromRobot = Annotated[
    str | None,
    Option(
        "Arm that a vendor program was written for.",
        "--from-robot",
        project="from_robot",
        completions=complete_robot,
    ),
]
FromLanguage = Annotated[
    str | None,
    Option(
        "Language of the input if its name does not tell.",
        "--from",
        project="from_language",
        completions=complete_language,
    ),
]
CellOption = Annotated[
    Path | None,
    Option("File of the cell: its robots, and bodies not to be touched.", "--cell", project="cell"),
]
AccelerationOption = Annotated[
    float | None, Option("mm/s² of the tool on lines and arcs; default what the axes allow.")
]
EntryOption = Annotated[
    str | None,
    Option("Procedure that the program begins with; default its main.", "--entry", project="entry"),
]
UnitOption = Annotated[
    str | None,
    Option(
        "Unit that a drawing is in, whatever it says: mm, in, m …",
        "--unit",
        project="unit",
        completions=complete_unit,
    ),
]
FramesOption = Annotated[
    FramesAs,
    Option(
        "Work objects in MELFA-BASIC: as Base, or as factors of the targets.", default=FramesAs.BASE
    ),
]
GrammarOption = Annotated[
    GrammarAs,
    Option(
        "What lark parses of a program of over 20,000 lines: samples, or all.",
        default=GrammarAs.SAMPLES,
    ),
]
JobsOption = Annotated[
    int | None,
    Option(
        "Processes that share the work; default one for each processor if there are more than 20 "
        "files, or units of one program, else one.",
        min=1,
    ),
]
_NO_CLUSTER = error(
    "CL078",
    "`{given}` is no cluster",
    "write `dask://HOST:PORT` for the scheduler of one, or `dask` for one in this command",
)
_JOBS_OF_CLUSTER = error(
    "CL079",
    "--jobs has no effect on the cluster of a scheduler, which has its own workers",
    "leave --jobs out, or write `--on dask` for a cluster of so many workers in this command",
)
_CLUSTER = re.compile(r"dask(://[^/@\s]+:\d+)?")


@options
class SharingOptions:
    """Options for sharing the work on many files."""

    jobs: JobsOption = None
    on: str | None = option(
        "Work on a Dask cluster: of a scheduler, or `dask` for one here of --jobs workers.",
        default=None,
        metavar="dask[://HOST:PORT]",
    )

    @contextmanager
    def used(self) -> Iterator[int | None]:
        """Have a cluster of --on do the work inside; yield the number of processes without one.

        Raises Refused for a cluster that cannot be used.
        """
        if self.on is None:
            yield self.jobs
            return
        if not _CLUSTER.fullmatch(self.on):
            raise Refused(_NO_CLUSTER(given=self.on), exit_status=2)
        if self.jobs is not None and ":" in self.on:
            raise Refused(_JOBS_OF_CLUSTER(), exit_status=2)
        from assistant.base.cluster import on_address

        with on_address(self.on, self.jobs):
            yield None


FindingFormatOption = Annotated[
    FindingFormat,
    Option(
        "For people, programs, code scanning, pull or merge requests.",
        "--format",
        default=FindingFormat.TEXT,
        callback=answer_as,
    ),
]
FormatOption = Annotated[
    Format,
    Option("For people or for programs.", "--format", default=Format.TEXT, callback=answer_as),
]


@options
class ReaderOptions:
    """Options for reading a source."""

    process: Path | None = option(
        "Process file; default NAME.process.toml beside it.",
        "--process",
        "-p",
        default=None,
        project="process",
    )
    unit: UnitOption = None

    @property
    def placement(self) -> DrawingPlacement | None:
        """Return where a drawing's origin is, None if it is not moved."""
        return None

    def check(self) -> None:
        """Raise Refused for options that mean nothing."""
        _ = self.placement


@options
class DrawingOptions(ReaderOptions):
    """Options for reading a source and placing a drawing."""

    place: str | None = option(
        "Where a drawing's origin stands, mm, and degrees about z, y, x.",
        default=None,
        metavar="X,Y,Z[,A,B,C]",
    )
    marks: tuple[str, ...] = option(
        "Mark of a drawing and where it was taught, mm; three place it.",
        "--mark",
        default=(),
        metavar="X,Y=X,Y,Z",
    )

    @cached_property
    def placement(self) -> DrawingPlacement | None:
        """Return the placement of --place or --mark, None for neither; raise Refused."""
        if self.place is None and not self.marks:
            return None
        from assistant.sources.process.placement import placement_of_options

        return placement_of_options(self.place, self.marks)


@options
class WrittenOptions:
    """Language and arm that a robot program was written for, and where it begins."""

    from_language: FromLanguage = None
    from_robot: FromRobot = None
    entry: EntryOption = None


@options
class SightOptions:
    """Options for locating the objects that frames depend on."""

    seen: Path | None = option(
        "Where objects were found, for frames that are seen.", default=None, metavar="FILE"
    )
    ask_at: str | None = option(
        "Have the program ask there, as it runs, for frames that are seen.",
        default=None,
        metavar="HOST:PORT",
    )

    @cached_property
    def seeing(self) -> Seeing:
        """Return the objects found and the server to ask; raise Unreadable or Refused."""
        from assistant.sources.sights import seeing

        return seeing(self.seen, self.ask_at)

    def check(self) -> None:
        """Raise Unreadable or Refused for options that mean nothing."""
        _ = self.seeing


_SIGNALS_WITHOUT_PROOF = error(
    "CL020", "--signals says nothing without --prove", "add --prove, or leave it out"
)


@options
class ProofOptions:
    """Proof by motion."""

    prove: bool = option(
        "Run the source and what is written, and compare what they do.", default=False
    )
    signals: Path | None = option(
        "With --prove: a script of the inputs; default a search for all branches.", default=None
    )
    seed: int = option(
        "With --prove: of what the search draws; the same gives the same.", default=0
    )

    @property
    def proving(self) -> Proving | None:
        """Return the settings of a motion proof, None for no proof; raise Refused."""
        from assistant.compiler.motion_proof import Proving

        if self.prove:
            return Proving(script=self.signals, seed=self.seed)
        if self.signals is not None:
            raise Refused(_SIGNALS_WITHOUT_PROOF(), exit_status=2)
        return None

    def check(self) -> None:
        """Raise Refused for options that mean nothing."""
        _ = self.proving


@options
class EditOptions:
    """Decisions about edits of written files."""

    overwrite: bool = option("Write over files that were edited, without the edits.", default=False)
    keep_edit: tuple[str, ...] = option(
        "Keep this edit of a file although the source has changed the same.",
        default=(),
        metavar="NAME",
        show_default=False,
    )
    drop_edit: tuple[str, ...] = option(
        "Leave this edit of a file out.", default=(), metavar="NAME", show_default=False
    )

    @property
    def choices(self) -> MergeChoices:
        from assistant.compiler.merge_edits import MergeChoices

        return MergeChoices.of(self.overwrite, self.keep_edit, self.drop_edit)


NO_PAGE = error(
    "CL034", "a page for the browser is not written as `{name}`", "end the name in .html"
)
PAGE_SUFFIXES = (".html", ".htm")


@options
class PageOptions:
    """A page of the result for the browser."""

    report: Path | None = option(
        "Write a page for the browser as well, FILE.html.", default=None, metavar="FILE.html"
    )
    opened: bool = option(
        "Show the page in the browser; without --report from a folder for temporary files.",
        "--open",
        default=False,
    )

    @property
    def plot(self) -> Path | None:
        """Return the file of a picture."""
        return None

    def __bool__(self) -> bool:
        return self.report is not None or self.opened or self.plot is not None

    @property
    def html(self) -> bool:
        """True if the report is a page."""
        return self.report is not None and self.report.suffix.lower() in PAGE_SUFFIXES

    def check_names(self) -> None:
        """Raise Refused (exit status 2) for a file that is not named as a page or a picture."""
        if self.plot is not None:
            from assistant.report.figures import format_of

            format_of(self.plot.name)
        if self.report is not None and self.html and not self.report.stem:
            raise Refused(NO_PAGE(name=self.report), exit_status=2)

    def check(self) -> None:
        """Raise Refused (exit status 2) for a file that is not a page or a picture."""
        self.check_names()
        if self.report is not None and not self.html:
            raise Refused(NO_PAGE(name=self.report), exit_status=2)


@options
class PlottedPageOptions(PageOptions):
    """A page of the result, and a picture of a drawing's contours."""

    plot: Path | None = option(
        "Draw contours, their order and ways, as .svg or .png.", default=None, metavar="FILE.svg"
    )


T = TypeVar("T")


def with_project_defaults(source: str, record: T) -> T:
    """Return the options of a command, with what the project of a source states for the rest.

    Raises Refused if it states several values.
    """
    if source == "-" or not Path(source).is_file():
        return record
    from assistant.project.source_options import SourceOptions, completed_options

    def complete(given: Mapping[str, Any]) -> dict[str, Any]:
        done = completed_options(source, SourceOptions(**given), given)
        return {key: getattr(done, key) for key in given}

    return with_project_values(record, complete)
