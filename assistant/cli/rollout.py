"""A rollout: deploy to several controllers, and report it as a table, JSON and JUnit XML.

Ctrl-C ends it in order: installations that have begun are finished, others are not begun. In the
JUnit report a controller is a suite, with a test for each program and one for the deployment.
"""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Severity
from assistant.base.source_text import visible
from assistant.cli.presentation import (
    Format,
    console,
    print_findings,
    print_json,
    say,
    visible_on_one_line,
    working,
)
from assistant.deploy import CellState, FileState, Outcome, Rollout
from assistant.findings.formats import (
    junit_case,
    junit_document,
    mark_failed,
    mark_skipped,
    records_of,
)

if TYPE_CHECKING:
    from assistant.deploy import Cell, Halt


_STATE_STYLES: Final = {"done": "green", "failed": "bold red", "not begun": "yellow"}


@dataclass(frozen=True, slots=True)
class RolloutOptions:
    """Options for the order and number of deployments; see `deploy.deploy_to_all`.

    parallel: None for its default. junit: file of the report.
    """

    canary: str = ""
    parallel: int | None = None
    junit: Path | None = None


def run_rollout(
    cells: Sequence[Cell],
    manner: RolloutOptions,
    history: Path | None,
    files_only: bool,
    format: Format,
) -> int:
    """Deploys to all, and tells what became of each; the report is written in any case."""
    from assistant.deploy import PARALLEL, deploy_to_all

    with working(f"installing on {len(cells)} controllers"), end_in_order() as halt:
        rollout = deploy_to_all(
            cells,
            canary=manner.canary,
            parallel=manner.parallel or PARALLEL,
            history=history,
            files_only=files_only,
            halt=halt,
            tell=lambda finding: print_findings([finding]),
        )
    if format is Format.JSON:
        print_json(_rollout_record(rollout))
    else:
        print_rollout(rollout)
    if manner.junit is not None:
        write_junit(rollout, manner.junit)
    return rollout.status


@contextmanager
def end_in_order() -> Iterator[Halt]:
    """Meanwhile Ctrl-C, and whatever else ends this program from outside, asks for an end in order.

    Nothing is interrupted where it stands: every deployment takes back what it changed, which is
    over within the time-outs of its connection. Asking twice makes no difference.
    """
    from assistant.base.termination import signals_handled
    from assistant.deploy import Halt

    halt = Halt(noticed=lambda: console().print("ending in order: what was begun is taken back"))

    def asked(_number: int, _frame: object) -> None:
        halt.asked = True

    with signals_handled(asked):
        yield halt


def write_junit(rollout: Rollout, path: Path) -> None:
    """The file appears whole, or the one that is there stays; raises Refused."""
    from assistant.base.file_sets import write_files

    write_files({path.name: junit_report(rollout)}, path.parent)


def _rollout_record(rollout: Rollout) -> dict[str, object]:
    """The JSON of a rollout."""
    return {
        "ok": rollout.ok,
        "summary": rollout.summary,
        "controllers": [_outcome_record(one) for one in rollout.outcomes],
    }


def _outcome_record(one: Outcome) -> dict[str, object]:
    states = one.deployment.states if one.deployment else {}
    notes = one.plan.findings if one.plan else ()
    folder = one.deployment.folder if one.deployment else None
    return {
        "name": one.name,
        "address": str(one.address),
        "state": str(one.state),
        "seconds": round(one.seconds, 3),
        "files": [
            {
                "file": file.path,
                "name": file.name,
                "change": str(file.change),
                "state": str(states[file.name]) if file.name in states else None,
            }
            for file in (one.plan.files if one.plan else ())
        ],
        "kept in": str(folder) if folder else None,
        "findings": records_of((*notes, *one.findings)),
    }


def print_rollout(rollout: Rollout) -> None:
    """Findings of each, a table on a terminal and a line each elsewhere, and a sentence on all."""
    for one in rollout.outcomes:
        findings = (*(one.plan.findings if one.plan else ()), *one.findings)
        if findings:
            console().print(
                f"{visible_on_one_line(one.name)} ({visible_on_one_line(str(one.address))})",
                style="bold",
            )
            print_findings(findings)
    rows = [_outcome_row(one) for one in rollout.outcomes]
    if sys.stdout.isatty():
        _print_table(rows)
    else:
        for name, address, state, what in rows:
            say(f"{name}: {state}; {what} ({address})")
    say(visible_on_one_line(rollout.summary))


def _outcome_row(one: Outcome) -> tuple[str, str, str, str]:
    """Return name, address, state, and the state of its programs."""
    if one.deployment is None:
        what = "nothing was changed"
    else:
        states = [str(state) for state in one.deployment.states.values()]
        what = ", ".join(f"{states.count(state)} {state}" for state in dict.fromkeys(states))
    return (
        visible_on_one_line(one.name),
        visible_on_one_line(str(one.address)),
        str(one.state),
        what or "no programs",
    )


def _print_table(rows: Sequence[tuple[str, str, str, str]]) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table("controller", "address", "result", "programs", box=None, pad_edge=False)
    for name, address, state, what in rows:
        table.add_row(
            Text(name), Text(address), Text(state, style=_STATE_STYLES[state]), Text(what)
        )
    Console(highlight=False, emoji=False).print(table)


_SUITE_NAME: Final = "robot-assistant deploy"
_DEPLOYMENT_TEST: Final = "deployment"
"""The test that a deployment as a whole is."""
_INSTALLED_STATES: Final = (FileState.SAME, FileState.INSTALLED)


def junit_report(rollout: Rollout) -> bytes:
    """The report, whole; well-formed whatever names and messages hold."""
    return junit_document(
        _SUITE_NAME,
        [_controller_suite(one) for one in rollout.outcomes],
        _total_seconds(rollout.outcomes),
    )


def _controller_suite(one: Outcome) -> ET.Element:
    suite = ET.Element("testsuite", {"name": visible(one.name), "time": _total_seconds([one])})
    properties = ET.SubElement(suite, "properties")
    told = {"address": str(one.address), "state": str(one.state)}
    if one.deployment is not None and one.deployment.folder is not None:
        told["kept in"] = str(one.deployment.folder)
    for key, value in told.items():
        ET.SubElement(properties, "property", {"name": key, "value": visible(value)})
    for program in one.plan.files if one.plan else ():
        state = one.deployment.states.get(program.name) if one.deployment else None
        test = junit_case(suite, program.name)
        if one.state is CellState.NOT_BEGUN or (state is None and one.deployment is None):
            mark_skipped(test, str(CellState.NOT_BEGUN))
        elif state not in _INSTALLED_STATES:
            about = [f for f in one.findings if f.place == program.name]
            _add_failure(test, "failure", str(state), about)
    test = junit_case(suite, _DEPLOYMENT_TEST)
    if one.state is CellState.NOT_BEGUN:
        mark_skipped(test, "; ".join(finding.message for finding in one.findings))
    elif one.state is CellState.FAILED:
        errors = [f for f in one.findings if f.severity is Severity.ERROR]
        said = errors[0].message if errors else str(one.state)
        _add_failure(test, "error" if one.status > 1 else "failure", said, one.findings)
    return suite


def _add_failure(test: ET.Element, kind: str, said: str, findings: Sequence[Diagnostic]) -> None:
    codes = [f.code for f in findings if f.severity is Severity.ERROR]
    mark_failed(test, kind, codes[0] if codes else "deployment", said, findings)


def _total_seconds(outcomes: Iterable[Outcome]) -> str:
    return f"{sum(one.seconds for one in outcomes):.3f}"
