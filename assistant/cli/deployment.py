"""Deployments: plan, install, import changes, finish, roll back, list and verify.

The arguments are files for a controller, or targets of the project. `deploy` reads everything back
and never starts a program. Exit status 1 means conflicts or errors. `rollout` deploys to several
controllers.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors
from assistant.cli.command import Argument, Option, argument, command, option, options
from assistant.cli.controller_session import complete_controller, named_by, new_client
from assistant.cli.options import FormatOption
from assistant.cli.presentation import (
    Format,
    PlanFormat,
    answer_as,
    print_findings,
    print_json,
    say,
    working,
)
from assistant.report.markdown import cell, code, findings_markdown, folded, plain

if TYPE_CHECKING:
    from assistant.controllers import Named, Programs
    from assistant.deploy import Deployment, PlannedFile, Verified
    from assistant.deploy import Plan as CheckedPlan
    from assistant.project import Target


FilesArgument = Annotated[
    tuple[Path, ...],
    Argument("Robot programs, or folders with them; default what the project deploys.", default=()),
]
ToOption = Annotated[
    str | None,
    Option(
        "Its name in assistant.toml, or its address.",
        "--to",
        metavar="CONTROLLER",
        completions=complete_controller,
    ),
]
HistoryOption = Annotated[
    Path | None, Option("Folder of the deployments; default .robot-assistant/deployments.")
]
TaskOption = Annotated[str, Option("Task whose memory counts; default the first.", default="")]
LoadOption = Annotated[bool, Option("Also load modules that are not loaded yet.", "--load")]
ReplaceNamesOption = Annotated[
    tuple[str, ...],
    Option(
        "Program to replace although no deployment left it as it is; * for all.", metavar="NAME"
    ),
]
PlanFormatOption = Annotated[
    PlanFormat,
    Option(
        "For people, programs or pull requests.",
        "--format",
        default=PlanFormat.TEXT,
        callback=answer_as,
    ),
]


@options
class WhereOptions:
    """The controllers that are meant."""

    to: ToOption
    target: tuple[str, ...] = option("Target of the project; repeatable, default all there are.")

    def jobs(self, files: Sequence[Path], wishes: _DeploymentOptions) -> list[_DeploymentJob]:
        """Return the deployments to each controller; raise Refused."""
        if self.to is not None and self.target:
            raise Refused(_NOT_BOTH(one="--to", other="--target"), exit_status=2)
        named = tuple(map(str, files))
        if self.to is not None:
            one = named_by(self.to)
            if named or not one.variables:
                return [_DeploymentJob(self.to, one, wishes, named)]
        if self.to is None and not self.target and named:
            raise Refused(_NO_CONTROLLER(), exit_status=2)
        return [
            _DeploymentJob(one.name, one.controller, _target_options(one, wishes), named, one)
            for one in _named_targets(self.to, self.target)
        ]

    def controllers(self, wishes: _DeploymentOptions) -> list[_DeploymentJob]:
        """The controllers that are meant, whatever is to be on them; raises Refused."""
        if self.to is not None and not self.target:
            return [_DeploymentJob(self.to, named_by(self.to), wishes)]
        return self.jobs((), wishes)

    def each_controller(self, wishes: _DeploymentOptions) -> list[_DeploymentJob]:
        """Return each controller once; raise Refused for several that the user has not named."""
        jobs = self.controllers(wishes)
        apart = {str(job.one.address) + job.one.address.name: job for job in reversed(jobs)}
        if len(apart) > 1 and not self.target:
            names = ", ".join(f"`{job.name}`" for job in jobs)
            raise Refused(_SEVERAL(names=names), exit_status=2)
        return [job for job in jobs if job in apart.values()]


@command
class Plan:
    """Show what a deployment would do to each program on a controller. Changes nothing."""

    files: FilesArgument
    where: WhereOptions
    task: TaskOption
    load: LoadOption
    replace: ReplaceNamesOption
    history: HistoryOption
    format: PlanFormatOption

    def run(self) -> int:
        wishes = _DeploymentOptions(self.task, self.load, self.replace, False, self.history)
        return _show_plans(self.where.jobs(self.files, wishes), self.format)


def _show_plans(jobs: Sequence[_DeploymentJob], format: PlanFormat) -> int:
    answers = []
    status = 0
    for job in jobs:
        with job.opened() as client, working(f"comparing with {job.one.address}"):
            plan = job.planned(client)
        plan = replace(plan, notes=(*plan.notes, *plan.unseen))
        answers.append(_print_outcome(job, plan, None, format))
        status = max(status, 1 if plan.conflicts or has_errors(plan.findings) else 0)
    _print_answers(answers, format)
    return status


@command
class Deploy:
    """Install programs on a controller, read them back and compare. Never starts motion."""

    files: FilesArgument
    where: WhereOptions
    dry_run: bool = option("Only show what would change, as `plan` does.")
    resume: bool = option("Finish the deployment that was interrupted.")
    pull: bool = option(
        "Deploy nothing; bring what was changed on the controller into the sources here."
    )
    source: Path | None = option("With --pull: what the program was compiled from; default itself.")
    replace: ReplaceNamesOption
    files_only: bool = option("Replace files though what was taught in memory is not seen.")
    task: TaskOption
    load: LoadOption
    canary: str = option(
        "Goes first, alone; default as the project says.", default="", metavar="TARGET"
    )
    parallel: int | None = option("Controllers at a time; default 4.", min=1)
    junit: Path | None = option("Write a JUnit report as well.", metavar="FILE.xml")
    history: HistoryOption
    format: PlanFormatOption

    def run(self) -> int:
        if self.resume:
            return self._resume()
        if self.pull:
            return self._pull()
        if not self.dry_run:
            return self._install()
        return _show_plans(self.where.jobs(self.files, self._wishes), self.format)

    @property
    def _wishes(self) -> _DeploymentOptions:
        return _DeploymentOptions(self.task, self.load, self.replace, self.files_only, self.history)

    def _install(self) -> int:
        from assistant import deploy

        jobs = self.where.jobs(self.files, self._wishes)
        if len(jobs) > 1 or self.canary or self.parallel or self.junit:
            return self._install_on_all(jobs)
        (job,) = jobs
        with job.opened() as client:
            with working(f"comparing with {job.one.address}"):
                plan = job.planned(client)
            with working(f"installing on {job.one.address}"):
                done = deploy.deploy(
                    plan,
                    history=job.history,
                    files_only=self.files_only,
                    tell=lambda finding: print_findings([finding]),
                )
        _print_answers([_print_outcome(job, plan, done, self.format)], self.format)
        return 0 if done.ok else 1

    def _install_on_all(self, jobs: Sequence[_DeploymentJob]) -> int:
        from assistant.cli.rollout import RolloutOptions, run_rollout
        from assistant.deploy import Cell

        if self.format is PlanFormat.MARKDOWN:
            raise Refused(
                _NOT_BOTH(one="--format markdown", other="many controllers"), exit_status=2
            )

        def planning(job: _DeploymentJob, client: Programs) -> Callable[[], CheckedPlan]:
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
            answer = Format.JSON if self.format is PlanFormat.JSON else Format.TEXT
            manner = RolloutOptions(self.canary, self.parallel, self.junit)
            project = jobs[0].target.project if jobs[0].target else None
            if project is not None:
                names = [cell.name for cell in cells]
                canary = manner.canary or (project.canary if project.canary in names else "")
                parallel = manner.parallel or project.parallel
                manner = replace(manner, canary=canary or "", parallel=parallel)
            return run_rollout(cells, manner, jobs[0].history, wishes.files_only, answer)

    def _resume(self) -> int:
        from assistant import deploy

        if self.files:
            raise Refused(_NOT_BOTH(one="--resume", other="a program"), exit_status=2)
        status = 0
        for job in self.where.each_controller(self._wishes):
            with job.opened() as client, working(f"finishing on {job.one.address}"):
                done = deploy.resume(client, history=job.history, replace=self._wishes.replace)
            status = max(status, _report_finished(done, as_json=self.format is PlanFormat.JSON))
        return status

    def _pull(self) -> int:
        """source: what the one program that is named was compiled from, None for itself."""
        from assistant.compiler.arms import robot_of
        from assistant.findings.formats import records_of
        from assistant.project.pulled_changes import pull

        if self.source is not None and len(self.files) != 1:
            raise Refused(_NOT_BOTH(one="--source", other="several programs"), exit_status=2)
        answers = []
        status = 0
        for job in self.where.jobs(self.files, self._wishes):
            with job.opened() as client, working(f"comparing with {job.one.address}"):
                plan = job.planned(client)
            made_of = _sources_by_path(job, self.source)
            sources = {
                f.path: made_of.get(Path(f.path).absolute(), Path(f.path)) for f in plan.files
            }
            done = pull(plan, sources, robot_of(job.one.robot))
            findings = (*plan.unseen, *done.findings)
            if self.format is PlanFormat.JSON:
                answers.append(
                    {
                        "address": str(plan.address),
                        "ok": done.ok,
                        "written": {str(path): list(told) for path, told in done.sources.items()},
                        "findings": records_of(findings),
                    }
                )
            else:
                print_findings(findings)
                for path, told in done.sources.items():
                    say(f"wrote {path}: {', '.join(told)}")
                if done.sources:
                    say("look at the difference, build, commit, and deploy")
            status = max(status, 0 if done.ok else 1)
        if self.format is PlanFormat.JSON:
            print_json(answers[0] if len(answers) == 1 else answers)
        return status


@command
class Rollback:
    """Take a deployment back: every program of it is again what it was before."""

    number: int | None = argument(
        "Deployment to take back with all after it; default the last",
        default=None,
        min=1,
        metavar="[N]",
    )
    where: WhereOptions
    replace: ReplaceNamesOption
    history: HistoryOption
    format: FormatOption

    def run(self) -> int:
        from assistant import deploy

        status = 0
        for job in self.where.each_controller(_DeploymentOptions(history=self.history)):
            with job.opened() as client, working(f"taking back on {job.one.address}"):
                done = deploy.rollback(
                    client,
                    self.number,
                    history=job.history,
                    replace=self.replace,
                    tell=lambda finding: print_findings([finding]),
                )
            status = max(
                status, _report_finished(done, as_json=self.format is Format.JSON, back=True)
            )
        return status


@command
class Deployments:
    """List the deployments that this computer made: when, who, of which commit, what became."""

    to: ToOption
    history: HistoryOption
    format: FormatOption

    def run(self) -> int:
        from assistant.deploy import all_journals, journals, place_of

        history = self.history or _history_here()
        if self.to is None:
            found = all_journals(history)
        else:
            found = journals(place_of(named_by(self.to).address, history))
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
        if self.format is Format.JSON:
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
            words = f"{commit[:_COMMIT_LENGTH]}{'+' if dirty else ''}" or "-"
            programs = ", ".join(entry.name for entry in one.entries) or "-"
            say(
                f"{one.number:>6}  {one.record.time}  {one.result:<11}  {words:<13}  "
                f"{one.record.who}  {programs}"
            )
        return 0


@command
class Verify:
    """Tell whether a controller still has what the last deployment left there. Changes nothing."""

    files: tuple[Path, ...] = argument(
        "Robot programs, or folders with them, to compare as well.", default=()
    )
    where: WhereOptions
    history: HistoryOption
    format: FormatOption

    def run(self) -> int:
        from assistant import deploy
        from assistant.project.deployment import verified_record

        answers = []
        status = 0
        wishes = _DeploymentOptions(history=self.history)
        if self.files or self.where.to is None:
            jobs = self.where.jobs(self.files, wishes)
        else:
            jobs = self.where.controllers(wishes)
        for job in jobs:
            with job.opened() as client, working(f"comparing with {job.one.address}"):
                programs = job.programs(client) if job.files or job.target else []
                seen = deploy.verify(client, programs, history=job.history)
            if self.format is Format.JSON:
                answers.append(verified_record(seen))
            else:
                _print_verified(seen)
            status = max(status, 0 if seen.ok else 1)
        if self.format is Format.JSON:
            print_json(answers[0] if len(answers) == 1 else answers)
        return status


_NO_CONTROLLER: Final = error(
    "CL270",
    "nobody says which controller is meant",
    "name it with --to, or a target of assistant.toml with --target",
)
_NOT_BOTH: Final = error("CL271", "{one} and {other} do not go together", "leave one of them out")
_NO_TARGET: Final = error(
    "CL272", "the project has no target {what}", "there are: {known}; or name the programs"
)


_SEVERAL: Final = error(
    "CL273", "several controllers are meant: {names}", "name one of them with --target"
)


@dataclass(frozen=True, slots=True)
class _DeploymentOptions:
    """Options given beside the files; see `deploy.plan` and `deploy.deploy`."""

    task: str = ""
    load: bool = False
    replace: tuple[str, ...] = ()
    files_only: bool = False
    history: Path | None = None


@dataclass(frozen=True, slots=True)
class _DeploymentJob:
    """A controller with what it is to have.

    name: of the target, or of the controller. files: that were named. target: whose built files
    are meant if none were named.
    """

    name: str
    one: Named
    wishes: _DeploymentOptions
    files: tuple[str, ...] = ()
    target: Target | None = None

    @property
    def history(self) -> Path | None:
        """The folder of deployments: that of the project, wherever in it the command is run."""
        if self.wishes.history is not None:
            return self.wishes.history
        return _history_here()

    @contextmanager
    def opened(self) -> Iterator[Programs]:
        """A client, not connected yet; a virtual controller of the project runs meanwhile."""
        if self.one.virtual is None:
            yield new_client(self.one)
            return
        from assistant.project import project_of
        from assistant.project.virtual_controllers import running_client

        with running_client(self.one, project_of().kept) as client:
            yield client

    def programs(self, client: Programs) -> list[str]:
        """The files that are to be there; raises Refused and Unreadable."""
        from assistant import deploy

        if self.files or self.target is None:
            return deploy.gathered(self.files, client)
        return [_path_text(file) for file in self.target.files()]

    def planned(self, client: Programs) -> CheckedPlan:
        """The plan, after all checks; raises Refused for programs that may not be deployed."""
        from assistant.project.deployment import checked_plan

        wishes = self.wishes
        return checked_plan(
            self.programs(client),
            self.one,
            client,
            task=wishes.task,
            load=wishes.load,
            replace=wishes.replace,
            history=self.history,
        )


def _history_here() -> Path | None:
    """The history of the project that the working folder is in, None without one."""
    from assistant.deploy.history import HISTORY
    from assistant.program.project_file import project_of

    project = project_of(Path.cwd())
    if project is None:
        return None
    return _relative_path(Path(project.source.path or "").absolute().parent / HISTORY)


def _named_targets(to: str | None, names: Sequence[str]) -> Sequence[Target]:
    from assistant.project import targets_of

    there = targets_of()
    wanted = [
        one
        for one in there
        if (not names or one.name in names) and to in (None, one.controller.name, one.name)
    ]
    missing = [f"`{name}`" for name in names if name not in {one.name for one in there}]
    if missing or not wanted:
        known = ", ".join(f"`{one.name}`" for one in there)
        what = ", ".join(missing) or f"on `{to}`"
        raise Refused(_NO_TARGET(what=what, known=known), exit_status=2)
    return wanted


def _target_options(target: Target, wishes: _DeploymentOptions) -> _DeploymentOptions:
    return replace(wishes, task=wishes.task or target.task, load=wishes.load or target.load)


def _relative_path(path: Path) -> Path:
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path


def _path_text(path: Path) -> str:
    return str(_relative_path(path))


_NOTHING_CHANGED: Final = "nothing has been changed"


def _print_plan(plan: CheckedPlan) -> None:
    for file in plan.files:
        say(f"{file.name}: {file.change}" + (f" ({file.reason})" if file.reason else ""))
        for text in _what_differs(file).values():
            sys.stdout.write(text)
    for word, names in (("foreign", plan.foreign), ("left", plan.left)):
        if names:
            say(f"{word}: {', '.join(names)}")
    say(f"{plan.address}: {_NOTHING_CHANGED}")


def _plan_markdown(
    name: str, plan: CheckedPlan, done: Deployment | None, findings: Sequence[Diagnostic]
) -> str:
    """Return a plan as a Markdown comment. Text of a controller or a program is code, which it
    cannot escape.
    """
    lines = [f"### {code(name)} ({code(str(plan.address))})", ""]
    lines += [
        "| program | change |" + (" state |" if done else ""),
        "|---|---|" + "---|" * bool(done),
    ]
    for file in plan.files:
        change = f"**{file.change}**" if file.reason else str(file.change)
        state = f" {done.states[file.name]} |" if done else ""
        lines.append(f"| {cell(file.name)} | {change} |{state}")
    lines += [f"| {cell(one)} | left |{' |' * bool(done)}" for one in plan.left]
    if plan.foreign:
        lines += ["", f"Foreign, never touched: {', '.join(map(code, plan.foreign))}"]
    for file in plan.files:
        for title, text in _what_differs(file).items():
            lines += ["", *folded(f"{plain(file.name)}: {title}", text)]
    if findings:
        lines.append("")
        lines += findings_markdown(findings)
    lines += ["", code(done.summary) if done else f"{_NOTHING_CHANGED.capitalize()}."]
    return "\n".join(lines)


def _what_differs(file: PlannedFile) -> dict[str, str]:
    """Return the differences by title; taught points are listed only once."""
    found = {
        "changed on the controller since the last deployment": file.since,
        "otherwise in memory than in the file": "" if file.since else file.taught,
        "what would be sent": file.diff,
    }
    return {title: text for title, text in found.items() if text}


def _print_outcome(
    job: _DeploymentJob, plan: CheckedPlan, done: Deployment | None, format: PlanFormat
) -> object:
    """Prints what is for people; what is for programs comes back."""
    findings = (*plan.findings, *(done.findings if done else ()))
    if format is PlanFormat.JSON:
        from assistant.project.deployment import plan_record

        return plan_record(plan, done, findings)
    if format is PlanFormat.MARKDOWN:
        say(_plan_markdown(job.name, plan, done, findings))
        return None
    print_findings(findings)
    if done is None:
        _print_plan(plan)
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


_COMMIT_LENGTH: Final = 12
"""Characters of a commit in a table."""


def _report_finished(done: Deployment, *, as_json: bool, back: bool = False) -> int:
    """Report the result of a deployment that was finished or rolled back; return its exit status.

    back: the programs installed are then the earlier ones.
    """
    from assistant.project.deployment import deployment_record, states_of

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


def _print_verified(seen: Verified) -> None:
    print_findings(seen.findings)
    for program in seen.programs:
        other = ", and not what the file here says" if program.as_built is False else ""
        say(f"{program.name}: {program.seen}{other}")
        sys.stdout.write(program.since)
    if seen.record is not None:
        told = "is as it was left" if seen.ok else "is not as it was left"
        say(f"{seen.address} {told} by the deployment {seen.record.name} of {seen.record.who}")


def _sources_by_path(job: _DeploymentJob, source: Path | None) -> dict[Path, Path]:
    """Return the source of each program by the program's absolute path."""
    if source is not None:
        return {Path(file).absolute(): source for file in job.files}
    if job.target is None or job.files:
        return {}
    here = Path.cwd()
    return {
        file.absolute(): one.relative_to(here) if one.is_relative_to(here) else one
        for file, one in job.target.sources().items()
    }
