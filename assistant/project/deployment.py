"""Targets of deployments, and deployments as plain data.

A `Target` has the built files of a project for one controller, and opens that controller. A plan is
made after all checks, also on the robot that the controller reports. Keys of records are added,
never renamed.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace as with_
from pathlib import Path as FilePath
from typing import Any

from assistant import deploy
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, fold, has_errors, worst
from assistant.controllers import Named, Programs, connect
from assistant.controllers.address import Question
from assistant.controllers.named import ROBOT_FILES
from assistant.controllers.states import Identity
from assistant.deploy import Deployment, FileState, Plan, Verified
from assistant.deploy.history import HISTORY
from assistant.findings.formats import records_of
from assistant.project import builds, rules, virtual_controllers
from assistant.project.build_jobs import order_of
from assistant.project.project_file import BUILD_FOLDER, Place, Project, path_inside, project_of


@dataclass(frozen=True, slots=True)
class Target:
    """Programs of a project for one controller; see `Place`."""

    project: Project
    place: Place

    @property
    def name(self) -> str:
        return self.place.name

    @property
    def controller(self) -> Named:
        return self.place.controller

    @property
    def task(self) -> str:
        return self.place.task

    @property
    def load(self) -> bool:
        return self.place.load

    @property
    def serial(self) -> str | None:
        """Serial number that the controller must report, None for any."""
        return self.controller.serial

    @property
    def history(self) -> FilePath:
        """The folder of deployments, wherever in the project a command is run."""
        return self.project.folder / HISTORY

    def files(self) -> tuple[FilePath, ...]:
        """Its built files, sorted by name, with those that programs call.

        Raises Refused if one of its programs is not built, or has changed since.
        """
        entries = builds.read_build(self.project)
        found: dict[str, FilePath] = {}
        stale: list[Diagnostic] = []
        for recipe in self.place.recipes:
            order = order_of(self.project.folder, self.place, recipe)
            entry = entries.get(builds.entry_key(self.name, recipe.name))
            reason = builds.why_stale(self.project, self.name, order, entry)
            if reason is not None or entry is None:
                stale.append(
                    rules.NOT_BUILT(
                        place=self.name, name=recipe.name, target=self.name, reason=reason
                    )
                )
                continue
            folder = self.project.folder / BUILD_FOLDER / self.name
            found.update({name: folder / name for name in entry.files})
        if stale:
            raise Refused(*stale)
        return tuple(found[name] for name in sorted(found))

    def sources(self) -> dict[FilePath, FilePath]:
        """Return the source of each built file; for a file copied unchanged, the original file."""
        entries = builds.read_build(self.project)
        found: dict[FilePath, FilePath] = {}
        for recipe in self.place.recipes:
            entry = entries.get(builds.entry_key(self.name, recipe.name))
            folder = self.project.folder / BUILD_FOLDER / self.name
            for name in entry.files if entry is not None else ():
                own = (
                    path_inside(self.project.folder, entry.origins.get(name, "")) if entry else None
                )
                found[folder / name] = own or recipe.source
        return found

    @contextmanager
    def opened(
        self, ask: Question | None = None, *, timeout: float | None = None
    ) -> Iterator[Programs]:
        """Yield a client of its controller, which connects in a separate `with`.

        A virtual controller of the project runs as long as the context. Raises Refused.
        """
        if self.controller.virtual is not None:
            with virtual_controllers.running_client(
                self.controller, self.project.kept, timeout=timeout
            ) as client:
                yield client
        else:
            yield connect(self.controller, ask=ask, timeout=timeout)


def targets_of(folder: FilePath | None = None) -> tuple[Target, ...]:
    """The targets of the project of a folder, default this one; see `project_of`."""
    project = project_of(folder)
    if not project.places:
        what = f"`{project.file}` names no targets"
        raise Refused(rules.NO_PROJECT(what=what), exit_status=2)
    return tuple(Target(project, place) for place in project.places)


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
    """Return a plan as plain data; keys are added, never renamed. done: its deployment."""
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
        "findings": records_of(findings),
    }


def states_of(done: Deployment, *, back: bool) -> dict[str, str]:
    """Return the state of each program. back: the programs installed now are the earlier ones."""
    taken_back = back and done.ok
    return {
        name: str(FileState.PUT_BACK if taken_back and state is FileState.INSTALLED else state)
        for name, state in done.states.items()
    }


def deployment_record(done: Deployment, *, back: bool = False) -> dict[str, Any]:
    """Return a finished or rolled-back deployment as plain data."""
    return {
        "address": str(done.address),
        "ok": done.ok,
        "files": [
            {"name": name, "state": state} for name, state in states_of(done, back=back).items()
        ],
        "kept in": str(done.folder) if done.folder else None,
        "findings": records_of(done.findings),
    }


def verified_record(seen: Verified) -> dict[str, Any]:
    """Return a comparison of a controller with its last deployment as plain data."""
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
        "findings": records_of(seen.findings),
    }
