"""`deploy --pull`: what was changed on a controller becomes what the sources here say."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from assistant.base.diagnostics import Refused
from assistant.cli.compiling import working
from assistant.cli.jobs import NOT_BOTH, DeploymentJob, DeploymentOptions, jobs_of
from assistant.cli.presentation import PlanFormat, print_findings, print_json, say


def run_pull(
    files: Sequence[Path],
    to: str | None,
    targets: Sequence[str],
    source: Path | None,
    wishes: DeploymentOptions,
    format: PlanFormat,
) -> int:
    """source: what the one program that is named was compiled from, None for itself."""
    from assistant.compiler.arms import robot_of
    from assistant.findings.formats import finding_record
    from assistant.project.pulling import pull

    if source is not None and len(files) != 1:
        raise Refused(NOT_BOTH(one="--source", other="several programs"), exit_status=2)
    answers = []
    status = 0
    for job in jobs_of(files, to, targets, wishes):
        with job.opened() as client, working(f"comparing with {job.one.address}"):
            plan = job.planned(client)
        made_of = _sources_by_path(job, source)
        sources = {f.path: made_of.get(Path(f.path).absolute(), Path(f.path)) for f in plan.files}
        done = pull(plan, sources, robot_of(job.one.robot))
        findings = (*plan.unseen, *done.findings)
        if format is PlanFormat.JSON:
            answers.append(
                {
                    "address": str(plan.address),
                    "ok": done.ok,
                    "written": {str(path): list(told) for path, told in done.sources.items()},
                    "findings": [finding_record(finding) for finding in findings],
                }
            )
        else:
            print_findings(findings)
            for path, told in done.sources.items():
                say(f"wrote {path}: {', '.join(told)}")
            if done.sources:
                say("look at the difference, build, commit, and deploy")
        status = max(status, 0 if done.ok else 1)
    if format is PlanFormat.JSON:
        print_json(answers[0] if len(answers) == 1 else answers)
    return status


def _sources_by_path(job: DeploymentJob, source: Path | None) -> dict[Path, Path]:
    """What each program was made of, by its absolute path."""
    if source is not None:
        return {Path(file).absolute(): source for file in job.files}
    if job.target is None or job.files:
        return {}
    here = Path.cwd()
    return {
        file.absolute(): one.relative_to(here) if one.is_relative_to(here) else one
        for file, one in job.target.sources().items()
    }
