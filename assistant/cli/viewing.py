"""`view`: a program in its cell, on a page for the browser."""

from __future__ import annotations

import shutil
import tempfile
import webbrowser
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assistant.base.diagnostics import Refused, error, fold, has_errors
from assistant.cli.compiling import keep_sources, working
from assistant.cli.pages import NO_PAGE, SUFFIXES, page_name
from assistant.cli.presentation import Format, print_findings, print_json, say
from assistant.cli.sheets import solved_sheet
from assistant.cli.simulating import SimulationOptions, report_errors, solved_source
from assistant.cli.stating import with_project_defaults
from assistant.view.sheets import shown_sheet

if TYPE_CHECKING:
    from assistant.compiler.retarget import Solved
    from assistant.view.shown import Shown

NO_BROWSER = error(
    "CL035",
    "no browser could be opened here",
    "write the page with --html FILE.html, and open that",
)
LIVE_NOT_WRITTEN = error(
    "CL046",
    "a page that follows a controller is served, and cannot be written to a file",
    "leave out --html or --live",
)


def run_view(
    source: str,
    options: SimulationOptions,
    html: Path | None,
    format: Format,
    live: str | None = None,
) -> int:
    """1 if the robot cannot run the program, or not without contact, else 0.

    html: where it is written; None to open it in the browser, from a folder for temporary files.
    live: the controller that the page follows until Ctrl-C, from where it is served then.
    """
    from assistant.findings.formats import finding_record
    from assistant.view.page import page

    if html is not None and (html.suffix.lower() not in SUFFIXES or not html.stem):
        raise Refused(NO_PAGE(name=html), exit_status=2)
    if html is not None and live is not None:
        raise Refused(LIVE_NOT_WRITTEN(), exit_status=2)
    options = with_project_defaults(source, options)
    with working(f"looking at {source}"):
        ready = solved_source(source, options)
        robot = ready.solution.robot
        if has_errors(ready.findings):
            return report_errors(source, robot, ready.findings, format, "shown")
        shown = view_contents(source, options, ready)
        path = None if live is not None else _write_view(source, options.cell, html, page(shown))
    findings = [shown.places.finding(one).within(source) for one, _ in shown.findings]
    records = [finding_record(one) for one in findings]
    answer: dict[str, Any] = {"source": source, "robot": robot.name, "findings": records}
    if format is not Format.JSON:
        print_findings(fold(findings), explained=True)
    if live is not None:
        from assistant.cli.live_view import run_live

        following = partial(_live_page, shown)
        run_live(live, robot, following, answer, format)
    elif format is Format.JSON:
        print_json(answer | {"written": [str(path)]})
    else:
        say(f"wrote {path}")
    return 1 if has_errors(findings) else 0


def view_contents(source: str, options: SimulationOptions, ready: Solved) -> Shown:
    """What a page shows of a program that has no errors, with what is found on its way.

    Raises Refused for a cell without its robot.
    """
    from assistant.checks import robot_rules
    from assistant.checks.clearances import no_robot

    solution = ready.solution
    if ready.scene is not None:
        from assistant.cell.clearances import robot_of

        try:
            robot_of(ready.scene, solution.robot)
        except LookupError:
            raise Refused(no_robot(solution.robot, ready.scene), exit_status=2) from None
    sheet = solved_sheet(source, ready, options, robot_rules.check(solution))
    return shown_sheet(replace(sheet, plan=False))


def _live_page(shown: Shown, name: str) -> str:
    from assistant.view.page import page

    return page(replace(shown, live=name))


def _write_view(source: str, cell: Path | None, html: Path | None, text: str) -> Path:
    from assistant.base.file_sets import write_all, write_files

    if html is not None:
        keep_sources([source, *([] if cell is None else [str(cell)])], [html])
        (path,) = write_all({html: text.encode()})
        return path
    folder = tempfile.mkdtemp(prefix="robot-assistant-view-")
    (path,) = write_files({f"{page_name(source)}.html": text.encode()}, folder)
    if not webbrowser.open(path.as_uri()):
        shutil.rmtree(folder, ignore_errors=True)
        raise Refused(NO_BROWSER(), exit_status=2)
    return path
