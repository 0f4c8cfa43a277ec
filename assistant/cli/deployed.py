"""`deploy --resume`, `rollback`, `deployments`, `verify`: what was deployed and is there."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused
from assistant.cli.cells import named_by
from assistant.cli.compiling import working
from assistant.cli.jobs import (
    NOT_BOTH,
    DeploymentOptions,
    controllers_of_jobs,
    history_here,
    jobs_of,
    named_controllers,
)
from assistant.cli.presentation import Format, PlanFormat, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.deploy import Deployment, Verified

COMMIT_LENGTH: Final = 12
"""Characters of a commit in a table."""


def run_resume(
    files: Sequence[Path],
    to: str | None,
    targets: Sequence[str],
    wishes: DeploymentOptions,
    format: PlanFormat,
) -> int:
    from assistant import deploy

    if files:
        raise Refused(NOT_BOTH(one="--resume", other="a program"), exit_status=2)
    status = 0
    for job in named_controllers(to, targets, wishes):
        with job.opened() as client, working(f"finishing on {job.one.address}"):
            done = deploy.resume(client, history=job.history, replace=wishes.replace)
        status = max(status, report_finished(done, as_json=format is PlanFormat.JSON))
    return status


def run_rollback(
    number: int | None,
    to: str | None,
    targets: Sequence[str],
    replace: tuple[str, ...],
    history: Path | None,
    format: Format,
) -> int:
    from assistant import deploy

    status = 0
    for job in named_controllers(to, targets, DeploymentOptions(history=history)):
        with job.opened() as client, working(f"taking back on {job.one.address}"):
            done = deploy.rollback(
                client,
                number,
                history=job.history,
                replace=replace,
                tell=lambda finding: print_findings([finding]),
            )
        status = max(status, report_finished(done, as_json=format is Format.JSON, back=True))
    return status


def report_finished(done: Deployment, *, as_json: bool, back: bool = False) -> int:
    """Tells what became of a deployment that was finished or taken back; its exit status.

    back: what is installed then is what was there before.
    """
    from assistant.project.deploying import deployment_record, states_of

    if as_json:
        print_json(deployment_record(done, back=back))
        return 0 if done.ok else 1
    print_findings(done.findings)
    for name, state in states_of(done, back=back).items():
        say(f"{name}: {state}")
    if back and done.ok:
        say(f"every program of it on {done.address} is what it was before, verified")
    else:
        say(done.summary)
    return 0 if done.ok else 1


def run_deployments(to: str | None, history: Path | None, format: Format) -> int:
    from assistant.deploy import all_journals, journals, place_of

    history = history or history_here()
    if to is None:
        found = all_journals(history)
    else:
        found = journals(place_of(named_by(to).address, history))
    rows = [
        {
            "number": one.number,
            "address": one.record.address,
            "time": one.record.time,
            "who": one.record.who,
            "commit": one.record.commit,
            "programs": [entry.name for entry in one.entries],
            "result": one.result,
            "name": one.record.name,
            "folder": str(one.folder),
        }
        for one in found
    ]
    if format is Format.JSON:
        print_json({"deployments": rows})
        return 0
    if not rows:
        say("no deployments here")
    address = None
    for row, one in zip(rows, found, strict=True):
        if row["address"] != address:
            address = one.record.address
            say(address)
        commit, _, dirty = one.record.commit.partition("-")
        words = f"{commit[:COMMIT_LENGTH]}{'+' if dirty else ''}" or "-"
        programs = ", ".join(entry.name for entry in one.entries) or "-"
        say(
            f"{one.number:>6}  {one.record.time}  {one.result:<11}  {words:<13}  "
            f"{one.record.who}  {programs}"
        )
    return 0


def run_verify(
    files: Sequence[Path],
    to: str | None,
    targets: Sequence[str],
    history: Path | None,
    format: Format,
) -> int:
    from assistant import deploy
    from assistant.project.deploying import verified_record

    answers = []
    status = 0
    wishes = DeploymentOptions(history=history)
    if files or to is None:
        jobs = jobs_of(files, to, targets, wishes)
    else:
        jobs = controllers_of_jobs(to, targets, wishes)
    for job in jobs:
        with job.opened() as client, working(f"comparing with {job.one.address}"):
            programs = job.programs(client) if job.files or job.target else []
            seen = deploy.verify(client, programs, history=job.history)
        if format is Format.JSON:
            answers.append(verified_record(seen))
        else:
            _print_verified(seen)
        status = max(status, 0 if seen.ok else 1)
    if format is Format.JSON:
        print_json(answers[0] if len(answers) == 1 else answers)
    return status


def _print_verified(seen: Verified) -> None:
    print_findings(seen.findings)
    for program in seen.programs:
        other = ", and not what the file here says" if program.as_built is False else ""
        say(f"{program.name}: {program.seen}{other}")
        sys.stdout.write(program.since)
    if seen.record is not None:
        told = "is as it was left" if seen.ok else "is not as it was left"
        say(f"{seen.address} {told} by the deployment {seen.record.name} of {seen.record.who}")
