"""Deployments of programs to a controller, and what became of them as plain data."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace as with_
from pathlib import Path as FilePath
from typing import Any

from assistant import deploy
from assistant.base.diagnostics import Diagnostic, Refused, fold, has_errors, worst
from assistant.controllers import Named, Programs
from assistant.controllers.named import ROBOT_FILES
from assistant.controllers.states import Identity
from assistant.deploy import Deployment, FileState, Plan, Verified
from assistant.findings.formats import finding_record


def checked_plan(
    files: Sequence[str],
    one: Named,
    client: Programs,
    *,
    task: str = "",
    load: bool = False,
    replace: Collection[str] = (),
    history: FilePath | None = None,
) -> Plan:
    """The plan after all checks, also on the robot of the controller; see `deploy.plan`.

    Raises Refused for programs that may not be deployed.
    """
    found = _robot_findings(files, one)
    robot = one.robot or ""
    meant = Identity(
        robot="" if FilePath(robot).suffix in ROBOT_FILES else robot,
        serial=one.serial or "",
    )
    plan = deploy.plan(
        files, client, task=task, load=load, replace=replace, history=history, meant=meant
    )
    told = set(plan.findings)
    more = tuple(finding for finding in found if finding not in told)
    return with_(plan, notes=(*more, *plan.notes))


def _robot_findings(files: Sequence[str], one: Named) -> tuple[Diagnostic, ...]:
    """Findings of the programs on the controller's robot; raises Refused if it cannot run them."""
    from assistant.compiler.checker import check_files
    from assistant.findings.severities import apply_severities

    if one.robot is None or not files:
        return ()
    checked = check_files(files, robot=one.robot)
    found = fold(apply_severities(checked.findings, checked.texts).left)
    if has_errors(found):
        raise Refused(*found)
    return tuple(found)


def plan_record(
    plan: Plan, done: Deployment | None, findings: Sequence[Diagnostic]
) -> dict[str, Any]:
    """Of a plan; keys are added, never renamed. done: what became of it."""
    record = plan.record
    known = None
    if record is not None:
        keys = ("name", "time", "who", "commit")
        known = {key: getattr(record, key) for key in keys}
    return {
        "address": str(plan.address),
        "ok": done.ok if done else worst(findings) != "error" and not plan.conflicts,
        "last deployment": known,
        "files": [
            {
                "file": file.path,
                "name": file.name,
                "change": str(file.change),
                "state": str(done.states[file.name]) if done else None,
                "reason": file.reason,
                "diff": file.diff,
                "taught": file.taught,
                "since": file.since,
            }
            for file in plan.files
        ],
        "foreign": list(plan.foreign),
        "left": list(plan.left),
        "kept in": str(done.folder) if done and done.folder else None,
        "findings": [finding_record(finding) for finding in findings],
    }


def states_of(done: Deployment, *, back: bool) -> dict[str, str]:
    """State of each program. back: what is installed now is what was there before."""
    taken_back = back and done.ok
    return {
        name: str(FileState.PUT_BACK if taken_back and state is FileState.INSTALLED else state)
        for name, state in done.states.items()
    }


def deployment_record(done: Deployment, *, back: bool = False) -> dict[str, Any]:
    """Of a deployment that was finished or taken back."""
    return {
        "address": str(done.address),
        "ok": done.ok,
        "files": [
            {"name": name, "state": state} for name, state in states_of(done, back=back).items()
        ],
        "kept in": str(done.folder) if done.folder else None,
        "findings": [finding_record(finding) for finding in done.findings],
    }


def verified_record(seen: Verified) -> dict[str, Any]:
    """Of what is on a controller beside what was left there."""
    return {
        "address": str(seen.address),
        "ok": seen.ok,
        "last deployment": seen.record.name if seen.record else None,
        "programs": [
            {
                "name": program.name,
                "seen": str(program.seen),
                "as built": program.as_built,
                "since": program.since,
            }
            for program in seen.programs
        ],
        "findings": [finding_record(finding) for finding in seen.findings],
    }
