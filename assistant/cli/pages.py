"""`--report` and `--open`: what a command did, on one page for the browser."""

from __future__ import annotations

import tempfile
import webbrowser
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.cli.compiling import STANDARD, keep_sources
from assistant.program.diagnostics import Diagnostic, Refused, Severity, error, warning

if TYPE_CHECKING:
    from assistant.cell.clearances import Closeness
    from assistant.cell.scene import Placed, Scene
    from assistant.compiler.source_map import Places
    from assistant.program.program import Program
    from assistant.report.drawn import Line
    from assistant.robots import Robot, SolvedProgram
    from assistant.robots.timing import Simulation
    from assistant.view.beside import Beside
    from assistant.view.shown import Shown

    _Marked = tuple[Diagnostic, Closeness | None]

NO_PAGE: Final = error(
    "CL034", "a page for the browser is not written as `{name}`", "end the name in .html"
)
NOT_OPENED: Final = warning(
    "CL060",
    "no browser could be opened here; the page is written",
    "open `{name}` by hand, or leave out --open",
)
TOO_MANY: Final = warning(
    "CL061",
    "the page shows {most} of {count} programs",
    "name the files that are to be shown; the findings of all of them are listed here",
)
MOST_PROGRAMS: Final = 40
"""That one page shows."""
SUFFIXES: Final = (".html", ".htm")


@dataclass(frozen=True, slots=True)
class Asked:
    """The page that is asked for: a file for it, and whether it is opened; a file for a picture."""

    report: Path | None = None
    opened: bool = False
    plot: Path | None = None

    def __post_init__(self) -> None:
        """Raises Refused (exit status 2) for a name that is no page's or no picture's."""
        if self.plot is not None:
            from assistant.report.figures import format_of

            format_of(self.plot.name)
        if self.report is not None and self.html and not self.report.stem:
            raise Refused(NO_PAGE(name=self.report), exit_status=2)

    def __bool__(self) -> bool:
        return self.report is not None or self.opened or self.plot is not None

    @property
    def html(self) -> bool:
        """Whether the report is a page."""
        return self.report is not None and self.report.suffix.lower() in SUFFIXES

    def page(self) -> Asked:
        """The same without a report that is no page."""
        return self if self.html else Asked(None, self.opened, self.plot)

    def only_page(self) -> Asked:
        """The same; raises Refused (exit status 2) for a report that is no page."""
        if self.report is not None and not self.html:
            raise Refused(NO_PAGE(name=self.report), exit_status=2)
        return self


NOBODY: Final = Asked()
"""No page is asked for."""


@dataclass(frozen=True, slots=True)
class Sheet:
    """A program for the page.

    found: what is found. program: None where it could not be read. places: of its texts. arm: that
    goes through it, None if that is not known. solution: for this arm, where there is one already.
    told, spans: the program that findings tell of and the places of its texts, where it is another,
    such as the one that it was made of. acceleration: see `simulate`. plan: seen from above and
    from the side at first; None for without a cell.
    """

    title: str
    found: Sequence[Diagnostic]
    program: Program | None = None
    places: Places | None = None
    arm: Robot | None = None
    scene: Scene | None = None
    drawn: Sequence[Line] = ()
    notes: Sequence[str] = ()
    beside: Beside | None = None
    solution: SolvedProgram | None = None
    told: Program | None = None
    spans: Places | None = None
    acceleration: float | None = None
    plan: bool | None = None


def write_page(
    asked: Asked, sheets: Sequence[Sheet], sources: Iterable[str], stem: str
) -> tuple[list[Path], list[Diagnostic]]:
    """Writes page and picture, opens the page if that is asked for; tells files and findings.

    stem: of the name that it has in the folder for temporary files, if no file is named.
    Raises Refused (exit status 2) if it would be written over a source.
    """
    from assistant.program.system.writing import write_all, write_files
    from assistant.view.page import page

    told: list[Diagnostic] = []
    if len(sheets) > MOST_PROGRAMS:
        told.append(TOO_MANY(most=MOST_PROGRAMS, count=len(sheets)))
    shown = sheets[:MOST_PROGRAMS] or [Sheet(stem, ())]
    files = dict[Path, bytes]()
    if asked.plot is not None:
        files[asked.plot] = _plot(shown, asked.plot)
    if asked.report is not None:
        files[asked.report] = page(*map(shown_sheet, shown)).encode()
    keep_sources(list(sources), list(files))
    written = list(write_all(files))
    if asked.opened and asked.report is None:
        folder = tempfile.mkdtemp(prefix="robot-assistant-view-")
        text = page(*map(shown_sheet, shown))
        written += write_files({f"{stem}.html": text.encode()}, folder)
    if asked.opened and not webbrowser.open(written[-1].absolute().as_uri()):
        told.append(NOT_OPENED(name=written[-1]))
    return written, told


def _plot(sheets: Sequence[Sheet], file: Path) -> bytes:
    from assistant.report.contour_plot import Drawing, contour_plot
    from assistant.report.figures import format_of

    drawings = [Drawing(one.title, one.told or one.program, one.drawn, one.found) for one in sheets]
    return contour_plot(drawings, format_of(file.name))


def stem_of(source: str) -> str:
    """What a page is called that nobody gave a name to."""
    return "program" if source == STANDARD else Path(source).stem or "program"


def shown_sheet(sheet: Sheet) -> Shown:
    """What the page shows: the motion of a program if an arm goes through it, else its targets."""
    from assistant.cell.scene import Scene
    from assistant.compiler.source_map import Places
    from assistant.program.program import Program
    from assistant.view.shown import Shown

    scene, stands = _standing(sheet)
    marked: list[_Marked] = [(one, None) for one in sheet.found]
    solution = simulation = None
    if stands is not None and sheet.program is not None and _once(sheet.program):
        try:
            solution, simulation, contacts = _moving(sheet, sheet.program, scene, stands)
            marked = _told_once(marked, contacts)
        except Refused as refused:
            told = {one.message for one, _ in marked}
            marked += ((one, None) for one in refused.findings if one.message not in told)
    worst = list(Severity)
    marked.sort(key=lambda one: worst.index(one[0].severity))  # the page cannot hold all
    return Shown(
        sheet.title,
        solution,
        simulation,
        scene or Scene(),
        stands,
        sheet.places or Places(Program("nothing")),
        marked,
        sheet.drawn,
        program=sheet.program,
        notes=sheet.notes,
        beside=sheet.beside,
        told=sheet.told,
        spans=sheet.spans,
        plan=sheet.scene is None if sheet.plan is None else sheet.plan,
    )


def _once(program: Program) -> bool:
    """Whether each procedure has a name of its own: otherwise nobody knows which one is called."""
    names = [one.name.lower() for one in program.procedures]
    return len(set(names)) == len(names)


def _told_once(marked: Sequence[_Marked], contacts: Sequence[_Marked]) -> list[_Marked]:
    """Contacts with their places instead of the same without, unless some would be lost."""
    before = Counter(one.code for one, _ in marked)
    now = Counter(one.code for one, _ in contacts)
    instead = {code for code, count in now.items() if count >= before[code]}
    kept = (one for one in marked if one[0].code not in instead)
    return [*kept, *(one for one in contacts if one[0].code in instead)]


def _moving(
    sheet: Sheet, program: Program, scene: Scene, stands: Placed
) -> tuple[SolvedProgram, Simulation, list[_Marked]]:
    """A program as the arm goes through it, and what it touches. Raises Refused if it cannot."""
    from assistant import robots
    from assistant.cell.holding import Holding, takeable
    from assistant.checks.clearances import placed_clearances
    from assistant.robots.timing import simulate

    arm = stands.robot
    solution = sheet.solution or robots.solve_program(replace(program, robot=arm.name), arm)
    holding = Holding.at_first(scene, stands) if takeable(scene) else None
    done = simulate(solution, acceleration=sheet.acceleration, carried=holding)
    near = () if sheet.scene is None else placed_clearances(solution, scene, done)
    return solution, done, list(near)


def _standing(sheet: Sheet) -> tuple[Scene, Placed | None]:
    """The scene with the robot that runs the program, None if nobody knows it.

    It stands alone in the world if no cell is told.
    """
    from assistant.cell.arms import placed
    from assistant.cell.clearances import robot_of
    from assistant.cell.scene import Scene

    if sheet.arm is None:
        return sheet.scene or Scene(), None
    if sheet.scene is None:
        alone = placed("robot", sheet.arm)
        return Scene(robots=(alone,)), alone
    try:
        return sheet.scene, robot_of(sheet.scene, sheet.arm)
    except LookupError:  # which is a finding of whoever checked it
        return sheet.scene, None
