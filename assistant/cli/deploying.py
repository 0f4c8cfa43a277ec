"""`deploy`: what would change, the upload, and what became of each file."""

from __future__ import annotations

import getpass
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from assistant.cli.compiling import working
from assistant.cli.presentation import Format, print_findings, print_json, say
from assistant.deploy import Deployment, Plan
from assistant.findings.formats import finding_record
from assistant.program.diagnostics import worst


@dataclass(frozen=True, slots=True)
class Wishes:
    """What was asked for beside the files; see `deploy.plan` and `deploy.deploy`."""

    task: str = ""
    load: bool = False
    replace: tuple[str, ...] = ()
    files_only: bool = False
    history: Path | None = None


def run_deploy(
    files: Sequence[Path], to: str, dry_run: bool, wishes: Wishes, format: Format
) -> int:
    from assistant import deploy
    from assistant.controllers import connect

    controller = connect(to, ask=_ask if sys.stdin.isatty() else None)
    with working(f"comparing with {controller.address}"):
        plan = deploy.plan(
            files,
            controller,
            task=wishes.task,
            load=wishes.load,
            replace=wishes.replace,
            history=wishes.history,
        )
    if dry_run:
        _show_plan(plan, format)
        return 1 if plan.conflicts else 0
    with working(f"installing on {controller.address}"):
        done = deploy.deploy(plan, history=wishes.history, files_only=wishes.files_only)
    if format is Format.JSON:
        print_json(_answer(plan, done))
    else:
        print_findings((*plan.findings, *done.findings))
        for name, state in done.states.items():
            say(f"{name}: {state}")
        if done.folder is not None:
            say(f"what was there is in {done.folder}")
        say(done.summary)
    return 0 if done.ok else 1


def _ask(prompt: str) -> str | None:
    return getpass.getpass(prompt)


def _show_plan(plan: Plan, format: Format) -> None:
    if format is Format.JSON:
        print_json(_answer(plan, None))
        return
    print_findings(plan.findings)
    for file in plan.files:
        say(f"{file.name}: {file.change}")
        sys.stdout.write(file.diff)
        sys.stdout.write(file.taught)
    say(f"{plan.address}: nothing has been changed")


def _answer(plan: Plan, done: Deployment | None) -> dict[str, object]:
    findings = [*plan.findings, *(done.findings if done else ())]
    return {
        "address": str(plan.address),
        "ok": done.ok if done else worst(findings) != "error",
        "files": [
            {
                "file": file.path,
                "name": file.name,
                "change": str(file.change),
                "state": str(done.states[file.name]) if done else None,
                "diff": file.diff,
            }
            for file in plan.files
        ],
        "kept in": str(done.folder) if done and done.folder else None,
        "findings": [finding_record(finding) for finding in findings],
    }
