"""A target of deployments: its built files, and its controller, opened."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path as FilePath

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import Named, Programs, connect
from assistant.controllers.address import Question
from assistant.deploy.history import HISTORY
from assistant.project import kept, rules, virtual
from assistant.project.layout import BUILD_FOLDER, Place, Project, path_inside, project_of
from assistant.project.making import order_of


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
        """The number that the controller must tell of itself, None for any."""
        return self.controller.serial

    @property
    def history(self) -> FilePath:
        """The folder of deployments, wherever in the project a command is run."""
        return self.project.folder / HISTORY

    def files(self) -> tuple[FilePath, ...]:
        """Its built files, sorted by name, with those that programs call.

        Raises Refused if one of its programs is not built, or has changed since.
        """
        entries = kept.read_build(self.project)
        found: dict[str, FilePath] = {}
        stale: list[Diagnostic] = []
        for recipe in self.place.recipes:
            order = order_of(self.project.folder, self.place, recipe)
            entry = entries.get(kept.entry_key(self.name, recipe.name))
            reason = kept.why_stale(self.project, self.name, order, entry)
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
        """What each built file was made of: its own source where it was taken as it is."""
        entries = kept.read_build(self.project)
        found: dict[FilePath, FilePath] = {}
        for recipe in self.place.recipes:
            entry = entries.get(kept.entry_key(self.name, recipe.name))
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
        """A client of its controller, which connects in a `with` of its own.

        A virtual controller of the project runs as long as the context. Raises Refused.
        """
        if self.controller.virtual is not None:
            with virtual.running_client(
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
