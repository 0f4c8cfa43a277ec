"""`plan` and `deploy`: what would change, the upload, and what became of each program."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from assistant.base.diagnostics import Refused, has_errors
from assistant.cli.compiling import working
from assistant.cli.jobs import NOT_BOTH, DeploymentJob, DeploymentOptions, jobs_of
from assistant.cli.many_cells import RolloutOptions, run_rollout
from assistant.cli.plans import plan_markdown, print_plan
from assistant.cli.presentation import Format, PlanFormat, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.controllers import Programs
    from assistant.deploy import Deployment, Plan


def run_plan(
    files: Sequence[Path],
    to: str | None,
    targets: Sequence[str],
    wishes: DeploymentOptions,
    format: PlanFormat,
) -> int:
    answers = []
    status = 0
    for job in jobs_of(files, to, targets, wishes):
        with job.opened() as client, working(f"comparing with {job.one.address}"):
            plan = job.planned(client)
        plan = replace(plan, notes=(*plan.notes, *plan.unseen))
        answers.append(_print_outcome(job, plan, None, format))
        status = max(status, 1 if plan.conflicts or has_errors(plan.findings) else 0)
    _print_answers(answers, format)
    return status


def run_deploy(
    files: Sequence[Path],
    to: str | None,
    targets: Sequence[str],
    wishes: DeploymentOptions,
    manner: RolloutOptions | None,
    format: PlanFormat,
) -> int:
    """manner: of many controllers, None for what the project says."""
    from assistant import deploy

    jobs = jobs_of(files, to, targets, wishes)
    if len(jobs) > 1 or manner is not None:
        return _deploy_to_many(jobs, manner or RolloutOptions(), format)
    (job,) = jobs
    with job.opened() as client:
        with working(f"comparing with {job.one.address}"):
            plan = job.planned(client)
        with working(f"installing on {job.one.address}"):
            done = deploy.deploy(
                plan,
                history=job.history,
                files_only=wishes.files_only,
                tell=lambda finding: print_findings([finding]),
            )
    _print_answers([_print_outcome(job, plan, done, format)], format)
    return 0 if done.ok else 1


def _deploy_to_many(
    jobs: Sequence[DeploymentJob], manner: RolloutOptions, format: PlanFormat
) -> int:
    from assistant.deploy import Cell

    if format is PlanFormat.MARKDOWN:
        raise Refused(NOT_BOTH(one="--format markdown", other="many controllers"), exit_status=2)

    def planning(job: DeploymentJob, client: Programs) -> Callable[[], Plan]:
        return lambda: job.planned(client)

    with ExitStack() as stack:
        cells = []
        virtual: dict[str, Programs] = {}  # of which each runs once, for all its targets
        for job in jobs:
            client = virtual.get(job.one.name) or stack.enter_context(job.opened())
            if job.one.virtual is not None:
                virtual[job.one.name] = client
            cells.append(Cell(job.name, client.address, planning(job, client)))
        wishes = jobs[0].wishes
        answer = Format.JSON if format is PlanFormat.JSON else Format.TEXT
        project = jobs[0].target.project if jobs[0].target else None
        if project is not None:
            names = [cell.name for cell in cells]
            canary = manner.canary or (project.canary if project.canary in names else "")
            parallel = manner.parallel or project.parallel
            manner = replace(manner, canary=canary or "", parallel=parallel)
        return run_rollout(cells, manner, jobs[0].history, wishes.files_only, answer)


def _print_outcome(
    job: DeploymentJob, plan: Plan, done: Deployment | None, format: PlanFormat
) -> object:
    """Prints what is for people; what is for programs comes back."""
    findings = (*plan.findings, *(done.findings if done else ()))
    if format is PlanFormat.JSON:
        from assistant.project.deploying import plan_record

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


def _print_answers(answers: Sequence[object], format: PlanFormat) -> None:
    """One object for one controller, a list of them for several."""
    if format is PlanFormat.JSON:
        print_json(answers[0] if len(answers) == 1 else answers)
