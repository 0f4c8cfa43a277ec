"""Which programs are meant for which controllers: files that are named, or targets of a project."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error
from assistant.cli.cells import named_by, new_client

if TYPE_CHECKING:
    from assistant.controllers import Named, Programs
    from assistant.deploy import Plan
    from assistant.project import Target

NO_CONTROLLER: Final = error(
    "CL270",
    "nobody says which controller is meant",
    "name it with --to, or a target of assistant.toml with --target",
)
NOT_BOTH: Final = error("CL271", "{one} and {other} do not go together", "leave one of them out")
NO_TARGET: Final = error(
    "CL272", "the project has no target {what}", "there are: {known}; or name the programs"
)


SEVERAL: Final = error(
    "CL273", "several controllers are meant: {names}", "name one of them with --target"
)


@dataclass(frozen=True, slots=True)
class DeploymentOptions:
    """What was asked for beside the files; see `deploy.plan` and `deploy.deploy`."""

    task: str = ""
    load: bool = False
    replace: tuple[str, ...] = ()
    files_only: bool = False
    history: Path | None = None


@dataclass(frozen=True, slots=True)
class DeploymentJob:
    """A controller with what it is to have.

    name: of the target, or of the controller. files: that were named. target: whose built files
    are meant if none were named.
    """

    name: str
    one: Named
    wishes: DeploymentOptions
    files: tuple[str, ...] = ()
    target: Target | None = None

    @property
    def history(self) -> Path | None:
        """The folder of deployments: that of the project, wherever in it the command is run."""
        if self.wishes.history is not None:
            return self.wishes.history
        return history_here()

    @contextmanager
    def opened(self) -> Iterator[Programs]:
        """A client, not connected yet; a virtual controller of the project runs meanwhile."""
        if self.one.virtual is None:
            yield new_client(self.one)
            return
        from assistant.project import project_of
        from assistant.project.virtual import running_client

        with running_client(self.one, project_of().kept) as client:
            yield client

    def programs(self, client: Programs) -> list[str]:
        """The files that are to be there; raises Refused and Unreadable."""
        from assistant import deploy

        if self.files or self.target is None:
            return deploy.gathered(self.files, client)
        return [_path_text(file) for file in self.target.files()]

    def planned(self, client: Programs) -> Plan:
        """The plan, after all checks; raises Refused for programs that may not be deployed."""
        from assistant.project.deploying import checked_plan

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


def jobs_of(
    files: Sequence[Path], to: str | None, targets: Sequence[str], wishes: DeploymentOptions
) -> list[DeploymentJob]:
    """What is meant for which controllers; raises Refused. targets: all of the project if empty."""
    if to is not None and targets:
        raise Refused(NOT_BOTH(one="--to", other="--target"), exit_status=2)
    named = tuple(map(str, files))
    if to is not None:
        one = named_by(to)
        if named or not one.variables:
            return [DeploymentJob(to, one, wishes, named)]
    if to is None and not targets and named:
        raise Refused(NO_CONTROLLER(), exit_status=2)
    return [
        DeploymentJob(one.name, one.controller, _target_options(one, wishes), named, one)
        for one in _named_targets(to, targets)
    ]


def controllers_of_jobs(
    to: str | None, targets: Sequence[str], wishes: DeploymentOptions
) -> list[DeploymentJob]:
    """The controllers that are meant, whatever is to be on them; raises Refused."""
    if to is not None and not targets:
        return [DeploymentJob(to, named_by(to), wishes)]
    return jobs_of((), to, targets, wishes)


def named_controllers(
    to: str | None, targets: Sequence[str], wishes: DeploymentOptions
) -> list[DeploymentJob]:
    """Each controller once; raises Refused for several that nobody has named."""
    jobs = controllers_of_jobs(to, targets, wishes)
    apart = {str(job.one.address) + job.one.address.name: job for job in reversed(jobs)}
    if len(apart) > 1 and not targets:
        names = ", ".join(f"`{job.name}`" for job in jobs)
        raise Refused(SEVERAL(names=names), exit_status=2)
    return [job for job in jobs if job in apart.values()]


def history_here() -> Path | None:
    """The history of the project that the working folder is in, None without one."""
    from assistant.deploy.history import HISTORY
    from assistant.sources.project_file import project_of

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
        raise Refused(NO_TARGET(what=what, known=known), exit_status=2)
    return wanted


def _target_options(target: Target, wishes: DeploymentOptions) -> DeploymentOptions:
    return replace(wishes, task=wishes.task or target.task, load=wishes.load or target.load)


def _relative_path(path: Path) -> Path:
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path


def _path_text(path: Path) -> str:
    return str(_relative_path(path))
