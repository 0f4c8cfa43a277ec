"""`plan` and `deploy`: what would change, the upload, and what became of each program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.cli.cells import client_of, named_by
from assistant.cli.compiling import working
from assistant.cli.plans import plan_markdown, plan_record, print_plan
from assistant.cli.presentation import PlanFormat, print_findings, print_json, say
from assistant.program.diagnostics import Diagnostic, Refused, error, has_errors

if TYPE_CHECKING:
    from assistant.controllers import Named, Programs
    from assistant.deploy import Deployment, Plan

NO_CONTROLLER: Final = error(
    "CL270",
    "nobody says which controller is meant",
    "name it with --to, or a target in assistant.toml with --target",
)
NOT_BOTH: Final = error("CL271", "{one} and {other} do not go together", "leave one of them out")


@dataclass(frozen=True, slots=True)
class Wishes:
    """What was asked for beside the files; see `deploy.plan` and `deploy.deploy`."""

    task: str = ""
    load: bool = False
    replace: tuple[str, ...] = ()
    files_only: bool = False
    history: Path | None = None


@dataclass(frozen=True, slots=True)
class Job:
    """A controller with the programs that it is to have. name: of the target, or its own."""

    name: str
    one: Named
    files: tuple[str, ...]
    wishes: Wishes


def jobs_of(files: Sequence[Path], to: str | None, target: str | None, wishes: Wishes) -> list[Job]:
    """What is to be deployed where; raises Refused."""
    if to is not None and target is not None:
        raise Refused(NOT_BOTH(one="--to", other="--target"), exit_status=2)
    if to is None:
        raise Refused(NO_CONTROLLER(), exit_status=2)
    return [Job(to, named_by(to), tuple(map(str, files)), wishes)]


def run_plan(
    files: Sequence[Path], to: str | None, target: str | None, wishes: Wishes, format: PlanFormat
) -> int:
    answers = []
    status = 0
    for job in jobs_of(files, to, target, wishes):
        with working(f"comparing with {job.one.address}"):
            made, found = planned(job, client_of(job.one))
        answers.append(show(job, made, found, None, format))
        findings = (*found, *made.findings)
        status = max(status, 1 if made.conflicts or has_errors(findings) else 0)
    _print(answers, format)
    return status


def run_deploy(
    files: Sequence[Path], to: str | None, target: str | None, wishes: Wishes, format: PlanFormat
) -> int:
    from assistant import deploy

    answers = []
    status = 0
    for job in jobs_of(files, to, target, wishes):
        client = client_of(job.one)
        with working(f"comparing with {job.one.address}"):
            made, found = planned(job, client)
        with working(f"installing on {job.one.address}"):
            done = deploy.deploy(made, history=wishes.history, files_only=job.wishes.files_only)
        answers.append(show(job, made, found, done, format))
        status = max(status, 0 if done.ok else 1)
        if not done.ok:
            break
    _print(answers, format)
    return status


def planned(job: Job, client: Programs) -> tuple[Plan, tuple[Diagnostic, ...]]:
    """The plan of a job, and what the check for the controller's robot has found.

    Raises Refused for programs that may not be deployed.
    """
    from assistant import deploy

    files = deploy.gathered(job.files, client)
    found = _for_robot(files, job.one)
    made = deploy.plan(
        files,
        client,
        task=job.wishes.task,
        load=job.wishes.load,
        replace=job.wishes.replace,
        history=job.wishes.history,
    )
    told = set(made.findings)
    return made, tuple(finding for finding in found if finding not in told)


def _for_robot(files: Sequence[str], one: Named) -> tuple[Diagnostic, ...]:
    """Findings of the programs on the controller's robot; raises Refused if it cannot run them."""
    from assistant.compiler.checking import check_files
    from assistant.findings.project_severities import settle
    from assistant.program.diagnostics import fold

    if one.robot is None or not files:
        return ()
    checked = check_files(files, robot=one.robot)
    found = fold(settle(checked.findings, checked.texts).left)
    if has_errors(found):
        raise Refused(*found)
    return tuple(found)


def show(
    job: Job,
    plan: Plan,
    found: Sequence[Diagnostic],
    done: Deployment | None,
    format: PlanFormat,
) -> object:
    """Prints what is for people; what is for programs comes back."""
    findings = (*found, *plan.findings, *(done.findings if done else ()))
    if format is PlanFormat.JSON:
        return plan_record(plan, done, findings)
    if format is PlanFormat.MARKDOWN:
        say(plan_markdown(job.name, plan, done, findings))
        return None
    print_findings(findings)
    if done is None:
        print_plan(plan)
        return None
    for name, state in done.states.items():
        say(f"{name}: {state}")
    if done.folder is not None:
        say(f"what was there is in {done.folder}")
    say(done.summary)
    return None


def _print(answers: Sequence[object], format: PlanFormat) -> None:
    """One object for one controller, a list of them for several."""
    if format is PlanFormat.JSON:
        print_json(answers[0] if len(answers) == 1 else answers)
