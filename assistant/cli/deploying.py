"""`deploy`: what would change, the upload, and what became of each file."""

from __future__ import annotations

import getpass
import sys
from collections.abc import Sequence
from pathlib import Path

from assistant.cli.compiling import working
from assistant.cli.presentation import Format, print_findings, print_json, say
from assistant.deploy import Deployment, Plan
from assistant.findings.formats import finding_record
from assistant.program.diagnostics import worst


def run_deploy(
    files: Sequence[Path], to: str, dry_run: bool, backup: Path | None, format: Format
) -> int:
    from assistant import deploy
    from assistant.controllers import connect

    controller = connect(to, ask=_ask if sys.stdin.isatty() else None)
    with working(f"comparing with {controller.address}"):
        plan = deploy.plan(files, controller)
    if dry_run:
        _show_plan(plan, format)
        return 0
    with working(f"installing on {controller.address}"):
        done = deploy.deploy(plan, backup=backup)
    if format is Format.JSON:
        print_json(_answer(plan, done))
    else:
        print_findings((*plan.findings, *done.findings))
        for name, state in done.states.items():
            say(f"{name}: {state}")
        if done.backup is not None:
            say(f"what was there is in {done.backup}")
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
        "backup": str(done.backup) if done and done.backup else None,
        "findings": [finding_record(finding) for finding in findings],
    }
