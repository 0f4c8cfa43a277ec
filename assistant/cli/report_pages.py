"""Pages that report the result of a command: `--report`, `--open` and `--plot`.

A page is one HTML file with a sheet for each program, at most `_MOST_PROGRAMS`.
"""

from __future__ import annotations

import tempfile
import webbrowser
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Diagnostic, Refused, fold, warning
from assistant.cli.source_input import STANDARD, keep_sources
from assistant.view.sheets import Sheet, compared_sheet, shown_sheet

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.cli.options import PageOptions, ReaderOptions
    from assistant.compiler import Compiled
    from assistant.compiler.arms import InCell
    from assistant.compiler.checker import CheckedProgram
    from assistant.compiler.comparison import Comparison
    from assistant.compiler.retarget import Solved
    from assistant.report.contour_plot import DrawnLine
    from assistant.report.translation import Translated
    from assistant.robots import Robot


_NOT_OPENED: Final = warning(
    "CL060",
    "no browser could be opened here; the page is written",
    "open `{name}` by hand, or leave out --open",
)
_TOO_MANY_PROGRAMS: Final = warning(
    "CL061",
    "the page shows {most} of {count} programs",
    "name the files that are to be shown; the findings of all of them are listed here",
)
_MOST_PROGRAMS: Final = 40
"""That one page shows."""


def write_page(
    asked: PageOptions, sheets: Sequence[Sheet], sources: Iterable[str], stem: str
) -> tuple[list[Path], list[Diagnostic]]:
    """Write page and picture, open the page if requested; return files and findings.

    stem: of the name in the folder for temporary files, if no file is named. Raises Refused (exit
    status 2) if it would overwrite a source.
    """
    from assistant.base.file_sets import write_all, write_files
    from assistant.view.page import page

    told: list[Diagnostic] = []
    if len(sheets) > _MOST_PROGRAMS:
        told.append(_TOO_MANY_PROGRAMS(most=_MOST_PROGRAMS, count=len(sheets)))
    shown = sheets[:_MOST_PROGRAMS] or [Sheet(stem, ())]
    files = dict[Path, bytes]()
    if asked.plot is not None:
        files[asked.plot] = _write_plot(shown, asked.plot)
    if asked.report is not None:
        files[asked.report] = page(*map(shown_sheet, shown)).encode()
    keep_sources(list(sources), list(files))
    written = list(write_all(files))
    if asked.opened and asked.report is None:
        folder = tempfile.mkdtemp(prefix="robot-assistant-view-")
        text = page(*map(shown_sheet, shown))
        written += write_files({f"{stem}.html": text.encode()}, folder)
    if asked.opened and not webbrowser.open(written[-1].absolute().as_uri()):
        told.append(_NOT_OPENED(name=written[-1]))
    return written, told


def _write_plot(sheets: Sequence[Sheet], file: Path) -> bytes:
    from assistant.report.contour_plot import Drawing, contour_plot
    from assistant.report.figures import format_of

    drawings = [Drawing(one.title, one.told or one.program, one.drawn, one.found) for one in sheets]
    return contour_plot(drawings, format_of(file.name))


def page_name(source: str) -> str:
    """Return the name of a page that the user has not named."""
    return "program" if source == STANDARD else Path(source).stem or "program"


_OTHER_ON_DISK: Final = warning(
    "CL062",
    "the page shows what was compiled, and the files on disk are others: edits are kept in them",
    "look at the files themselves as well",
)


def compiled_sheet(
    source: str,
    compiled: Compiled,
    scene: Scene | None,
    robot: Robot | None,
    drawn: Sequence[DrawnLine] = (),
) -> Sheet:
    """Return the sheet of a compiled program as written; if it is not written, as it would have
    been.
    """
    from assistant.compiler.source_map import Places
    from assistant.findings.severities import apply_severities

    lifted = compiled.proof.lifted
    found = fold(apply_severities([finding.within(source) for finding in compiled.found]).left)
    arm = robot or _robot_in_cell(compiled.program.robot, scene)
    sheet = Sheet(
        f"{_source_name(source)} in {compiled.language}"
        + ("" if arm is None else f" for {arm.name}"),
        found,
        compiled.program,
        compiled.places,
        arm,
        scene,
        drawn,
        tuple(compiled.proof_lines()) if compiled.ok else ("nothing was written",),
        told=compiled.source,
    )
    if not compiled.ok or lifted is None:
        return sheet
    return replace(sheet, program=lifted, places=Places(lifted), spans=compiled.places)


def translated_sheet(one: Translated, scene: Scene | None, robot: Robot | None) -> Sheet:
    """A translated program beside what it was made of."""
    from assistant.report.translation import share_in_words
    from assistant.view.side_by_side import translation_side_by_side

    translation = one.translation
    sheet = compiled_sheet(one.source, translation.written, scene, robot)
    said = share_in_words(translation)
    found = [*translation.whole, *(f for row in translation.rows.noted for f in row.reasons)]
    placed = map(translation.compiled.places.finding, found)
    return replace(
        sheet,
        found=tuple(dict.fromkeys(placed)),
        notes=(said, *(sheet.notes if translation.files else ())),
        beside=translation_side_by_side(translation),
    )


def checked_sheet(
    one: CheckedProgram, found: Sequence[Diagnostic], drawn: Sequence[DrawnLine] = ()
) -> Sheet:
    """A program that was checked."""
    first, *others = map(_source_name, one.files)
    return Sheet(
        first if not others else f"{first} and {len(others)} more",
        found,
        one.program,
        one.places,
        one.arm,
        one.scene,
        drawn,
        solution=one.solution,
    )


def solved_sheet(
    source: str,
    ready: Solved,
    reader: ReaderOptions,
    acceleration: float | None,
    found: Sequence[Diagnostic] = (),
) -> Sheet:
    """A program that an arm goes through. found: besides what was found while it was read."""
    return Sheet(
        _source_name(source),
        (*ready.findings, *found),
        ready.solution.program,
        ready.places,
        ready.solution.robot,
        ready.scene,
        drawing_lines(source, reader),
        solution=ready.solution,
        acceleration=acceleration,
    )


def write_compiled_page(
    asked: PageOptions,
    reader: ReaderOptions,
    stands: InCell,
    done: Sequence[tuple[str, Compiled]],
    findings: Sequence[Diagnostic],
    unlike: Sequence[str],
) -> tuple[list[Path], list[Diagnostic]]:
    """Write the page of a compilation; return its file and the findings about it.

    unlike: sources whose files on disk differ from the compiled ones.
    """

    def lines(source: str) -> Sequence[DrawnLine]:
        return drawing_lines(source, reader)

    other = [_OTHER_ON_DISK(path=source) for source, _ in done if source in unlike]
    sheets = []
    for source, compiled in done:
        sheet = compiled_sheet(source, compiled, stands.scene, stands.robot, lines(source))
        own = [finding for finding in other if finding.path == source]
        sheets.append(replace(sheet, found=(*own, *sheet.found)))
    sources = [source for source, _ in done]
    known = {*sources, *(f.path for _, compiled in done for f in compiled.found)}
    sheets += refused_sheets((f for f in findings if f.path not in known), lines)
    written, told = write_page(asked, sheets, sources, page_name(*sources[:1] or ["program"]))
    return written, [*other, *told]


def compared_page(
    asked: PageOptions,
    done: Sequence[Comparison],
    refusals: Sequence[Diagnostic],
    sources: Iterable[str],
) -> tuple[list[Path], list[Diagnostic]]:
    """Write the page of some comparisons and return its file and the findings.

    refusals: of programs that were not compared. sources: the files that were read; none of them is
    overwritten.
    """
    sheets = [*map(compared_sheet, done), *refused_sheets(refusals)]
    stem = page_name(done[0].names[0]) if done else "comparison"
    return write_page(asked, sheets, sources, stem)


def _robot_in_cell(name: str | None, scene: Scene | None) -> Robot | None:
    """The robot that a program names, as the cell has it if it does; None for an unknown one."""
    from assistant.compiler.arms import known_robot

    for placed in () if scene is None else scene.robots:
        if placed.robot.name == name:
            return placed.robot
    try:
        return known_robot(name)
    except Refused:
        return None


def refused_sheets(
    findings: Iterable[Diagnostic], lines: Callable[[str], Sequence[DrawnLine]] = lambda _: ()
) -> list[Sheet]:
    """Return a sheet for each file that could not be read, with the reasons. lines: of a drawing,
    by its path.
    """
    by_file: dict[str, list[Diagnostic]] = {}
    for finding in findings:
        by_file.setdefault(finding.path or "findings", []).append(finding)
    return [
        Sheet(
            _source_name(path), found, drawn=lines(path), notes=("nothing could be done with it",)
        )
        for path, found in by_file.items()
    ]


def drawing_lines(source: str, reader: ReaderOptions) -> Sequence[DrawnLine]:
    """The lines of a drawing; none of another source, nor of one that cannot be read."""
    from assistant.report.contour_plot import drawn_lines

    try:
        if source == STANDARD:
            return ()
        return drawn_lines(source, reader.process, reader.unit, reader.placement)
    except Refused:
        return ()


def _source_name(source: str) -> str:
    """Return the name of a source on a page."""
    return "standard input" if source == STANDARD else Path(source).name
