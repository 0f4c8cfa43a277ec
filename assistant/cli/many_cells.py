"""Deployments to many controllers: carried out, and told as a table, as JSON and as JUnit XML."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.cli.compiling import working
from assistant.cli.presentation import (
    Format,
    console,
    print_findings,
    print_json,
    say,
    visible_on_one_line,
)
from assistant.findings.formats import finding_record

if TYPE_CHECKING:
    from assistant.deploy import Cell, Halt, Outcome, Rollout

STATE_STYLES: Final = {"done": "green", "failed": "bold red", "not begun": "yellow"}


@dataclass(frozen=True, slots=True)
class RolloutOptions:
    """How many are deployed to; see `deploy.deploy_to_all`.

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
        print_json(rollout_record(rollout))
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
    from assistant.cli.junit import junit_report

    write_files({path.name: junit_report(rollout)}, path.parent)


def rollout_record(rollout: Rollout) -> dict[str, object]:
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
        "findings": [finding_record(finding) for finding in (*notes, *one.findings)],
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
    """Name, address, state, and what is there of its programs."""
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
        table.add_row(Text(name), Text(address), Text(state, style=STATE_STYLES[state]), Text(what))
    Console(highlight=False, emoji=False).print(table)
