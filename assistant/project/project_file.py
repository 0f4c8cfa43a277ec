"""The file of a project, `assistant.toml`: its tables, what it defines, and its JSON schema.

Each key has a reader and a schema in one table; `schema_text` prints the schema for editors. Names
of programs and targets become names of folders. What a project writes stays in its folder: links
on the way are refused.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path as FilePath
from pathlib import PurePosixPath
from typing import Any, Final, get_args

from assistant import languages, robots
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.length_units import UNITS
from assistant.base.near_names import near_name, near_names
from assistant.base.source_text import is_file, is_folder
from assistant.compiler.style import STYLE_KEYS
from assistant.controllers import Named, controllers_of
from assistant.controllers.address import without_password
from assistant.controllers.controller import LANGUAGES
from assistant.controllers.named import LONGEST_TIMEOUT, ROBOT_FILES, SECRET, keys
from assistant.controllers.named import NAME as CONTROLLER_NAME
from assistant.findings.severities import LEVELS, TABLE
from assistant.languages.language_types import Choice, Frames, Setting
from assistant.program import project_file as stated
from assistant.program import settings_tables
from assistant.program.program import IDENTIFIER
from assistant.program.project_file import CONTROLLERS, DEPLOY, PROGRAMS, TARGETS
from assistant.program.project_file import STYLE as STYLE_TABLE
from assistant.program.settings_tables import Page, Read, Table, Wrong, listed, shown
from assistant.project import rules

PROJECT_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,59}")
"""Pattern of program and target names, which become names of folders."""
_TASK_NAME: Final = re.compile(r"[A-Za-z]\w{0,31}", re.ASCII)
_MOST_TARGETS: Final = 10_000_000
_MOST_AT_ONCE: Final = 256
_MOST_SEED: Final = 2**31 - 1
_TEXT_FORM: Final[Mapping[str, object]] = {"type": "string", "pattern": r"\S"}


@dataclass(frozen=True, slots=True)
class ProjectKey:
    """A key of a table. form: JSON schema of its values. about: its description, for editors."""

    read: Read
    form: Mapping[str, object]
    about: str


def _task_name(value: Any) -> str:
    given = settings_tables.text(value)
    if _TASK_NAME.fullmatch(given) is None:
        raise Wrong(
            f'is "{settings_tables.shown(given)}", which is no task', 'write a name, as "T_ROB1"'
        )
    return given


def _text_key(about: str) -> ProjectKey:
    return ProjectKey(settings_tables.text, _TEXT_FORM, about)


def _choice_key(words: tuple[str, ...], about: str) -> ProjectKey:
    return ProjectKey(settings_tables.choice(*words), {"enum": list(words)}, about)


def _language_key(about: str) -> ProjectKey:
    """In any case, although editors offer the names as they are."""
    return ProjectKey(
        settings_tables.caseless(*_LANGUAGE_NAMES), {"enum": list(_LANGUAGE_NAMES)}, about
    )


def _whole_number_key(least: int, most: int, about: str) -> ProjectKey:
    form = {"type": "integer", "minimum": least, "maximum": most}
    return ProjectKey(settings_tables.whole(least, most), form, about)


def _truth_key(about: str) -> ProjectKey:
    return ProjectKey(settings_tables.truth, {"type": "boolean"}, about)


_LANGUAGE_NAMES: Final = languages.names()

PROGRAM_KEYS: Final[Mapping[str, ProjectKey]] = {
    "source": _text_key(
        "Drawing, table, pseudo-program or robot program, from the project's folder."
    ),
    "also": ProjectKey(
        settings_tables.texts,
        {"type": "array", "items": _TEXT_FORM},
        "Drawings and tables that are in the same program, each with a routine of its own.",
    ),
    "language": _language_key("To write; default what the target's controller takes."),
    "robot": _text_key("Arm that runs it, by name or file; default that of the controller."),
    "process": _text_key("Process file; default NAME.process.toml beside the source."),
    "cell": _text_key(
        "File of the cell that it runs in: nothing is made that touches anything there."
    ),
    "unit": _choice_key(tuple(UNITS), "That a drawing is in, whatever it says itself."),
    "from": _language_key("Language of the source, if its name does not tell."),
    "from_robot": _text_key("Arm that a robot program was written for, by name or file."),
    "entry": _text_key("Procedure that the program begins with; default its main."),
    "as": ProjectKey(
        settings_tables.name,
        {"type": "string", "pattern": f"^{IDENTIFIER.pattern}$"},
        "What others call the program; default main, or what its process file says.",
    ),
    "main": _truth_key("false: no main; others call the procedures of the layers."),
    "most_targets": _whole_number_key(
        10, _MOST_TARGETS, "Of one unit; default the language's own limit."
    ),
    "frames": _choice_key(get_args(Frames), "How a language without work objects says them."),
    "prove": _truth_key("Run the source and what is written, and compare what they do."),
    "signals": _text_key("With prove: a script of the inputs; default a search for all branches."),
    "seed": _whole_number_key(0, _MOST_SEED, "With prove: of what the search draws."),
}
TARGET_KEYS: Final[Mapping[str, ProjectKey]] = {
    "controller": _text_key("Name in [controllers]; default the name of the target."),
    "programs": ProjectKey(
        settings_tables.texts,
        {"type": "array", "items": _TEXT_FORM, "minItems": 1},
        "Names of [programs], or program files from the project's folder.",
    ),
    "task": ProjectKey(
        _task_name,
        {"type": "string", "pattern": f"^{_TASK_NAME.pattern}$"},
        "That modules are loaded in; default the first one.",
    ),
    "load": _truth_key("Also load modules that are not loaded yet."),
}
_CONTROLLER_FORMS: Final[Mapping[str, tuple[Mapping[str, object], str]]] = {
    "address": (_TEXT_FORM, "Such as rws://192.168.125.1, or virtual:irc5 for a virtual one."),
    "robot": (_TEXT_FORM, "That it moves: a robot of the catalogue, or its file."),
    "user": (_TEXT_FORM, "Of its file server or services; never write a password into this file."),
    "certificate": (_TEXT_FORM, "File of the certificate that it is trusted by."),
    "timeout": (
        {"type": "number", "exclusiveMinimum": 0, "maximum": LONGEST_TIMEOUT},
        "Seconds to wait for an answer.",
    ),
    "serial": (_TEXT_FORM, "Number that it must tell of itself; another one is refused."),
}
DEPLOY_KEYS: Final[Mapping[str, ProjectKey]] = {
    "parallel": _whole_number_key(1, _MOST_AT_ONCE, "Controllers at a time."),
    "canary": _text_key("Target that goes first, alone; the others follow if it goes well."),
}
STYLE_TABLE_KEYS: Final[Mapping[str, ProjectKey]] = {
    "template": ProjectKey(
        STYLE_KEYS["template"], _TEXT_FORM, "Folder with the templates of written programs."
    ),
    "project": ProjectKey(STYLE_KEYS["project"], _TEXT_FORM, "Name of the project, for templates."),
    "author": ProjectKey(
        STYLE_KEYS["author"], _TEXT_FORM, "Who is responsible for the programs, for templates."
    ),
    "revision": ProjectKey(
        STYLE_KEYS["revision"], _TEXT_FORM, "Revision of the programs, for templates."
    ),
    "procedures": ProjectKey(
        STYLE_KEYS["procedures"],
        {"enum": ["contour", "layer", "none"]},
        "Procedures of a drawing's program: one for each contour, one for each layer, or none but"
        " the main one.",
    ),
    "comments": ProjectKey(
        STYLE_KEYS["comments"],
        {"type": "boolean"},
        "Whether programs of drawings and tables say what each layer, contour and table is.",
    ),
    "points": ProjectKey(
        STYLE_KEYS["points"],
        {"enum": ["targets", "offsets", "arrays"]},
        "Points of the paths of a drawing or table: targets, offsets of where a contour starts, or"
        " elements of arrays.",
    ),
    "constants": ProjectKey(
        STYLE_KEYS["constants"],
        {"type": "boolean"},
        "Whether heights, speeds and blends that are used often have names.",
    ),
}
CONTROLLER_KEYS: Final[Mapping[str, ProjectKey]] = {
    name: ProjectKey(read, *_CONTROLLER_FORMS[name]) for name, read in keys().items()
}
_FILE_KEYS: Final = ("source", "process", "cell", "signals")
"""Keys of a program that name files."""
_ROBOT_KEYS: Final = ("robot", "from_robot")
"""Keys that name a robot of the catalogue, or its file."""


def _readers_of(keys: Mapping[str, ProjectKey]) -> dict[str, Read]:
    return {name: key.read for name, key in keys.items()}


def _refuse_links(folder: FilePath, written: Sequence[FilePath]) -> None:
    """Raise Refused (exit status 2) if one of these paths, relative to the folder, contains a link.

    Only commands write there: another program or user made the link, and it may lead anywhere.
    """
    for one in written:
        link = next(_links_below(folder / one), None)
        if link is not None:
            file = link.relative_to(folder).as_posix()
            raise Refused(rules.LINK(path=str(folder), file=file), exit_status=2)


def _links_below(folder: FilePath) -> Iterator[FilePath]:
    if folder.is_symlink():
        yield folder
        return
    for place, folders, files in os.walk(folder):
        paths = (FilePath(place, name) for name in (*folders, *files))
        yield from (path for path in paths if path.is_symlink())


STATE_FOLDER: Final = FilePath(".robot-assistant")
"""Below the project's folder: what commands keep from one to the next."""
BUILD_FOLDER: Final = FilePath("build")
"""Below the project's folder: what is built, a folder for each target."""


@dataclass(frozen=True, slots=True)
class Recipe:
    """Recipe for a program; see `compile` for its options.

    name: in [programs], or the path relative to the project's folder for a file used as it is.
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
        """Languages that controllers at that kind of address accept."""
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
    _refuse_links(project.folder, (BUILD_FOLDER, STATE_FOLDER))
    return project


def _without_password_line(finding: Diagnostic) -> Diagnostic:
    """Return the finding without its source line if that may contain a password."""
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
        deploying = self._table(stated.DEPLOY).read(_readers_of(DEPLOY_KEYS))
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
        given = table.read(_readers_of(PROGRAM_KEYS))
        if "source" not in table.content:
            table.say(rules.MISSING, name=name, key="source", example='"FILE"')
        paths = {key: self._file(table, key, given[key]) for key in _FILE_KEYS if key in given}
        arms = {key: self._robot(table, key, given[key]) for key in _ROBOT_KEYS if key in given}
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
        """Return a file of the project, None with a finding if it is invalid."""
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
        near = near_name(file.name, names)
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
        given = table.read(_readers_of(TARGET_KEYS))
        wanted = given.get("controller", name)
        controller = self.controllers.get(wanted)
        # A value that its reader refuses has a finding already.
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
        # A name with such characters may be an address with a password.
        said = without_password(name) if set(name) & set(":?=@#") else name
        table.say(rules.UNKNOWN, key, kind=kind, name=shown(said), cure=cure)


def _is_catalogue_robot(name: str) -> bool:
    return name.lower() in {one.lower() for one in robots.names()}


def path_inside(folder: FilePath, text: str) -> FilePath | None:
    """A path from a folder, None if it leads out of it, by a link as well."""
    parts = PurePosixPath(text.replace("\\", "/"))
    if "\0" in text or not parts.parts or parts.is_absolute() or ".." in parts.parts:
        return None
    # Drive letters and streams of Windows.
    if ":" in parts.parts[0]:
        return None
    file = folder.joinpath(*parts.parts)
    return file if file.resolve().is_relative_to(folder.resolve()) else None


_unchanged: Final[Callable[[Any], Any]] = lambda value: value  # noqa: E731


SCHEMA_FILE: Final = "assistant.schema.json"
_SCHEMA_DRAFT: Final = "http://json-schema.org/draft-07/schema#"
Schema = dict[str, object]


def project_schema() -> Schema:
    """Return the JSON schema of a complete project file."""
    controller = _table_schema(CONTROLLER_KEYS, "address")
    of_languages = {}
    for language in map(languages.get, languages.names()):
        if language.table:
            of_languages[language.table] = _settings_schema(language.settings)
    return {
        "$schema": _SCHEMA_DRAFT,
        "title": "assistant.toml of robot-assistant",
        "type": "object",
        "properties": {
            CONTROLLERS: _named_schema(
                CONTROLLER_NAME.pattern, {"anyOf": [CONTROLLER_KEYS["address"].form, controller]}
            ),
            PROGRAMS: _named_schema(PROJECT_NAME.pattern, _table_schema(PROGRAM_KEYS, "source")),
            TARGETS: _named_schema(PROJECT_NAME.pattern, _table_schema(TARGET_KEYS, "programs")),
            DEPLOY: _table_schema(DEPLOY_KEYS),
            STYLE_TABLE: _table_schema(STYLE_TABLE_KEYS),
            TABLE: {"type": "object", "additionalProperties": {"enum": list(LEVELS)}},
            **of_languages,
        },
        "additionalProperties": False,
    }


def schema_text() -> str:
    return json.dumps(project_schema(), indent=2, ensure_ascii=False) + "\n"


def _table_schema(keys: Mapping[str, ProjectKey], *required: str) -> Schema:
    rows = {name: {**key.form, "description": key.about} for name, key in keys.items()}
    table: Schema = {"type": "object", "properties": rows, "additionalProperties": False}
    return {**table, "required": list(required)} if required else table


def _named_schema(pattern: str, content: Schema) -> Schema:
    names = {"pattern": f"^(?:{pattern})$"}
    return {"type": "object", "propertyNames": names, "additionalProperties": content}


def _settings_schema(settings: Mapping[str, Setting | Choice]) -> Schema:
    rows: Schema = {}
    for name, one in settings.items():
        if isinstance(one, Choice):
            form: Schema = {"enum": list(one.words)}
        else:
            form = {"type": "integer", "minimum": one.least, "maximum": one.most}
        rows[name] = {**form, "description": one.meaning}
    return {"type": "object", "properties": rows, "additionalProperties": False}
