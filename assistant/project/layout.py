"""A project as its file lays it out: programs, targets, and how deployments go."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from pathlib import PurePosixPath
from typing import Any, Final

from assistant import languages, robots
from assistant.base.diagnostics import Diagnostic, Refused, has_errors, near_names
from assistant.base.source_text import is_file, is_folder
from assistant.controllers import Named, controllers_of
from assistant.controllers.address import without_password
from assistant.controllers.controller import LANGUAGES
from assistant.controllers.named import ROBOT_FILES, SECRET
from assistant.languages.language_types import Frames
from assistant.program.settings_tables import Page, Table, listed, nearest, shown
from assistant.project import rules
from assistant.project.links import refuse_links
from assistant.project.tables import (
    DEPLOY_KEYS,
    FILE_KEYS,
    PROGRAM_KEYS,
    PROJECT_NAME,
    ROBOT_KEYS,
    TARGET_KEYS,
    readers_of,
)
from assistant.sources import project_file as stated

STATE_FOLDER: Final = FilePath(".robot-assistant")
"""Below the project's folder: what commands keep from one to the next."""
BUILD_FOLDER: Final = FilePath("build")
"""Below the project's folder: what is built, a folder for each target."""


@dataclass(frozen=True, slots=True)
class Recipe:
    """How a program is made; see `compile` for its options.

    name: in [programs], or the file from the project's folder of one that stands there ready.
    Files are absolute, robots names of the catalogue or absolute files.
    """

    name: str
    source: FilePath
    language: str | None = None
    robot: str | None = None
    process: FilePath | None = None
    unit: str | None = None
    from_language: str | None = None
    from_robot: str | None = None
    entry: str | None = None
    most_targets: int | None = None
    frames: Frames = "base"
    prove: bool = False
    signals: FilePath | None = None
    seed: int = 0
    cell: FilePath | None = None
    called: str | None = None
    main: bool | None = None
    also: tuple[FilePath, ...] = ()


@dataclass(frozen=True, slots=True)
class Place:
    """A target of deployments. task: "" for the first one. load: see `deploy.plan`."""

    name: str
    controller: Named
    recipes: tuple[Recipe, ...]
    task: str = ""
    load: bool = False

    @property
    def languages(self) -> tuple[str, ...]:
        """What some controller behind that address takes."""
        return LANGUAGES[self.controller.address.scheme]


@dataclass(frozen=True, slots=True)
class Project:
    """folder: of its file. settings: digest of what its other tables say."""

    folder: FilePath
    file: FilePath
    programs: Mapping[str, Recipe] = field(default_factory=dict)
    places: tuple[Place, ...] = ()
    parallel: int | None = None
    canary: str | None = None
    settings: str = ""

    @property
    def kept(self) -> FilePath:
        return self.folder / STATE_FOLDER


def project_of(folder: FilePath | None = None) -> Project:
    """The project of a folder, default this one, or of one above it.

    Raises Unreadable and Refused (exit status 2) with all that is wrong in its file.
    """
    here = (folder or FilePath.cwd()).absolute()
    found = stated.project_of(here)
    if found is None:
        what = f"neither `{here}` nor a folder above it has an assistant.toml"
        raise Refused(rules.NO_PROJECT(what=what), exit_status=2)
    controllers = controllers_of(here)
    page = Page(found.source, found.spans)
    content = found.content
    if not isinstance(content, Mapping):
        page.say(rules.NO_TABLE, found.table, key=".".join(found.table))
        content = {}
    top = Table(page, found.table, content)
    project = _Reader(top, FilePath(found.source.path or "").absolute(), controllers).project()
    if has_errors(page.findings):
        ordered = sorted(dict.fromkeys(page.findings), key=lambda finding: finding.line or 0)
        raise Refused(*map(_without_password_line, ordered), exit_status=2)
    refuse_links(project.folder, (BUILD_FOLDER, STATE_FOLDER))
    return project


def _without_password_line(finding: Diagnostic) -> Diagnostic:
    """Without its line, if a password may stand in it."""
    secret = finding.excerpt is not None and SECRET.search(finding.excerpt)
    return replace(finding, excerpt=None) if secret else finding


def project_tables() -> tuple[str, ...]:
    """The tables that a project's file may have."""
    of_languages = {language.table for language in map(languages.get, languages.names())} - {""}
    own = (
        stated.CONTROLLERS,
        stated.PROGRAMS,
        stated.TARGETS,
        stated.DEPLOY,
        stated.STYLE,
        "severity",
    )
    return (*own, *sorted(of_languages))


class _Reader:
    """Reads the tables of a project. top: ours in its file."""

    def __init__(self, top: Table, file: FilePath, controllers: Mapping[str, Named]) -> None:
        self.top, self.file, self.folder = top, file, file.parent
        self.controllers = controllers

    def project(self) -> Project:
        self.top.read(dict.fromkeys(project_tables(), _unchanged))
        recipes = {
            name: recipe
            for name, table in self._named(stated.PROGRAMS, "program")
            if (recipe := self._recipe(name, table)) is not None
        }
        places = [
            place
            for name, table in self._named(stated.TARGETS, "target")
            if (place := self._place(name, table, recipes)) is not None
        ]
        self._check_apart(places)
        deploying = self._table(stated.DEPLOY).read(readers_of(DEPLOY_KEYS))
        canary = deploying.get("canary")
        there = self._table(stated.TARGETS).content
        if canary is not None and canary not in there:
            self._unknown(self._table(stated.DEPLOY), "canary", "target", canary, list(there))
        return Project(
            self.folder,
            self.file,
            recipes,
            tuple(places),
            deploying.get("parallel"),
            canary,
            self._settings(),
        )

    def _settings(self) -> str:
        own = (stated.CONTROLLERS, stated.PROGRAMS, stated.TARGETS, stated.DEPLOY)
        others = {key: value for key, value in self.top.content.items() if key not in own}
        text = json.dumps(others, sort_keys=True, default=str)
        return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()

    def _table(self, key: str) -> Table:
        content = self.top.content.get(key, {})
        return Table(self.top.page, (*self.top.path, key), content if type(content) is dict else {})

    def _named(self, key: str, kind: str) -> Sequence[tuple[str, Table]]:
        content = self.top.content.get(key, {})
        if not isinstance(content, dict):
            self.top.say(rules.NO_TABLE, key, key=".".join((*self.top.path, key)))
        table = self._table(key)
        for name in table.content:
            if PROJECT_NAME.fullmatch(name) is None:
                table.say(rules.BAD_NAME, name, name=shown(name), kind=kind)
        return [
            (name, inside)
            for name, inside in table.named(identifiers=False)
            if PROJECT_NAME.fullmatch(name) is not None
        ]

    # ------------------------------------------------------------------------------ programs

    def _recipe(self, name: str, table: Table) -> Recipe | None:
        given = table.read(readers_of(PROGRAM_KEYS))
        if "source" not in table.content:
            table.say(rules.MISSING, name=name, key="source", example='"FILE"')
        paths = {key: self._file(table, key, given[key]) for key in FILE_KEYS if key in given}
        arms = {key: self._robot(table, key, given[key]) for key in ROBOT_KEYS if key in given}
        also = [self._file(table, "also", text) for text in given.get("also", ())]
        source = paths.get("source")
        if source is None:
            return None
        return Recipe(
            name,
            source,
            given.get("language"),
            arms.get("robot"),
            paths.get("process"),
            given.get("unit"),
            given.get("from"),
            arms.get("from_robot"),
            given.get("entry"),
            given.get("most_targets"),
            given.get("frames", "base"),
            given.get("prove", False),
            paths.get("signals"),
            given.get("seed", 0),
            paths.get("cell"),
            given.get("as"),
            given.get("main"),
            tuple(one for one in also if one is not None),
        )

    def _file(self, table: Table, key: str, text: str) -> FilePath | None:
        """A file of the project, None with a finding if it is none."""
        file = path_inside(self.folder, text)
        if file is None:
            table.say(rules.OUTSIDE, key, file=shown(text))
        elif not is_file(file):
            cure = self._near_file(file)
            table.say(rules.NO_FILE, key, file=shown(text), cure=cure)
        else:
            return file
        return None

    def _near_file(self, file: FilePath) -> str:
        """What to write instead of a file that is not there."""
        beside = file.parent if is_folder(file.parent) else self.folder
        names = sorted(one.name for one in beside.iterdir() if one.is_file())
        near = nearest(file.name, names)
        if near is None:
            return "put it there, or correct its name"
        return f"write `{(beside / near).relative_to(self.folder).as_posix()}`"

    def _robot(self, table: Table, key: str, text: str) -> str | None:
        if text.lower().endswith(ROBOT_FILES):
            file = self._file(table, key, text)
            return None if file is None else str(file)
        known = {name.lower(): name for name in robots.names()}
        if text.lower() not in known:
            self._unknown(table, key, "robot", text, robots.names())
            return None
        return known[text.lower()]

    # ------------------------------------------------------------------------------- targets

    def _place(self, name: str, table: Table, recipes: Mapping[str, Recipe]) -> Place | None:
        given = table.read(readers_of(TARGET_KEYS))
        wanted = given.get("controller", name)
        controller = self.controllers.get(wanted)
        if controller is None and ("controller" in given or "controller" not in table.content):
            at = "controller" if "controller" in given else None
            self._unknown(table, at, "controller", wanted, list(self.controllers))
        if controller is not None:
            self._check_files(controller)
        named = given.get("programs", ())
        if not named and ("programs" in given or "programs" not in table.content):
            table.say(rules.NO_PROGRAMS, "programs" if "programs" in given else None, name=name)
        entries = Table(table.page, (*table.path, "programs"), {})
        made = dict.fromkeys(
            self._wanted(entries, str(number), one, recipes) for number, one in enumerate(named)
        )
        if controller is None:
            return None
        there = tuple(recipe for recipe in made if recipe is not None)
        place = Place(name, controller, there, given.get("task", ""), given.get("load", False))
        for recipe in there:
            if recipe.language is not None and recipe.language not in place.languages:
                taken = listed(place.languages)
                fields = {"name": recipe.name, "given": recipe.language, "taken": taken}
                table.say(rules.NOT_TAKEN, "programs", **fields)
        return place

    def _check_files(self, controller: Named) -> None:
        """The files of a controller are files of the project as well."""
        of_robot = controller.robot or ""
        files = {"robot": of_robot if of_robot.lower().endswith(ROBOT_FILES) else ""}
        files["certificate"] = str(controller.certificate or "")
        at = (*self.top.path, stated.CONTROLLERS, controller.name)
        for key, file in files.items():
            if file and path_inside(self.folder, os.path.relpath(file, self.folder)) is None:
                self.top.page.say(rules.OUTSIDE, (*at, key), file=shown(file))
            elif file and not is_file(file):
                cure = self._near_file(FilePath(file))
                self.top.page.say(rules.NO_FILE, (*at, key), file=shown(file), cure=cure)
        if of_robot and not files["robot"] and not _is_catalogue_robot(of_robot):
            table = Table(self.top.page, at, {})
            self._unknown(table, "robot", "robot", of_robot, robots.names())

    def _wanted(
        self, table: Table, at: str, text: str, recipes: Mapping[str, Recipe]
    ) -> Recipe | None:
        """A program by its name, or a file of the project. at: its number in the table."""
        if text in recipes:
            return recipes[text]
        known = list(self._table(stated.PROGRAMS).content)
        if text in known:
            return None  # what is wrong with it is said there
        if FilePath(text).suffix or "/" in text:
            file = self._file(table, at, text)
            return None if file is None else Recipe(PurePosixPath(text).as_posix(), file)
        self._unknown(table, at, "program", text, known)
        return None

    def _check_apart(self, places: Sequence[Place]) -> None:
        seen: dict[tuple[str, str], str] = {}
        for place in places:
            key = (str(place.controller.address) + place.controller.address.name, place.task)
            other = seen.setdefault(key, place.name)
            if other != place.name:
                table = self._table(stated.TARGETS)
                table.say(rules.SAME_TARGET, place.name, name=place.name, other=other)

    def _unknown(
        self, table: Table, key: str | None, kind: str, name: str, known: Sequence[str]
    ) -> None:
        near = near_names(name, known)
        cure = f"there are: {listed(list(known))}"
        if near:
            cure = f"write {' or '.join(f'`{one}`' for one in near)}"
        said = without_password(name) if set(name) & set(":?=@#") else name
        table.say(rules.UNKNOWN, key, kind=kind, name=shown(said), cure=cure)


def _is_catalogue_robot(name: str) -> bool:
    return name.lower() in {one.lower() for one in robots.names()}


def path_inside(folder: FilePath, text: str) -> FilePath | None:
    """A path from a folder, None if it leads out of it, by a link as well."""
    parts = PurePosixPath(text.replace("\\", "/"))
    if "\0" in text or not parts.parts or parts.is_absolute() or ".." in parts.parts:
        return None
    if ":" in parts.parts[0]:
        return None
    file = folder.joinpath(*parts.parts)
    return file if file.resolve().is_relative_to(folder.resolve()) else None


_unchanged: Final[Callable[[Any], Any]] = lambda value: value  # noqa: E731
