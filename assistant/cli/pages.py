"""`--report` and `--open`: what a command did, on one page for the browser."""

from __future__ import annotations

import tempfile
import webbrowser
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from assistant.base.diagnostics import Diagnostic, Refused, error, warning
from assistant.cli.compiling import STANDARD, keep_sources
from assistant.view.sheets import Sheet, shown_sheet

NO_PAGE: Final = error(
    "CL034", "a page for the browser is not written as `{name}`", "end the name in .html"
)
NOT_OPENED: Final = warning(
    "CL060",
    "no browser could be opened here; the page is written",
    "open `{name}` by hand, or leave out --open",
)
TOO_MANY_PROGRAMS: Final = warning(
    "CL061",
    "the page shows {most} of {count} programs",
    "name the files that are to be shown; the findings of all of them are listed here",
)
MOST_PROGRAMS: Final = 40
"""That one page shows."""
SUFFIXES: Final = (".html", ".htm")


@dataclass(frozen=True, slots=True)
class PageRequest:
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

    def page(self) -> PageRequest:
        """The same without a report that is no page."""
        return self if self.html else PageRequest(None, self.opened, self.plot)

    def only_page(self) -> PageRequest:
        """The same; raises Refused (exit status 2) for a report that is no page."""
        if self.report is not None and not self.html:
            raise Refused(NO_PAGE(name=self.report), exit_status=2)
        return self


NO_PAGE_WANTED: Final = PageRequest()
"""No page is asked for."""


def write_page(
    asked: PageRequest, sheets: Sequence[Sheet], sources: Iterable[str], stem: str
) -> tuple[list[Path], list[Diagnostic]]:
    """Writes page and picture, opens the page if that is asked for; tells files and findings.

    stem: of the name that it has in the folder for temporary files, if no file is named.
    Raises Refused (exit status 2) if it would be written over a source.
    """
    from assistant.base.file_sets import write_all, write_files
    from assistant.view.page import page

    told: list[Diagnostic] = []
    if len(sheets) > MOST_PROGRAMS:
        told.append(TOO_MANY_PROGRAMS(most=MOST_PROGRAMS, count=len(sheets)))
    shown = sheets[:MOST_PROGRAMS] or [Sheet(stem, ())]
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
        told.append(NOT_OPENED(name=written[-1]))
    return written, told


def _write_plot(sheets: Sequence[Sheet], file: Path) -> bytes:
    from assistant.report.contour_plot import Drawing, contour_plot
    from assistant.report.figures import format_of

    drawings = [Drawing(one.title, one.told or one.program, one.drawn, one.found) for one in sheets]
    return contour_plot(drawings, format_of(file.name))


def page_name(source: str) -> str:
    """What a page is called that nobody gave a name to."""
    return "program" if source == STANDARD else Path(source).stem or "program"
