"""Options of a source as its project states them, so that the command line need not repeat them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import fields, replace
from pathlib import Path as FilePath
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.program import project_file as files
from assistant.project.build_jobs import chosen_language, order_of, shown_path
from assistant.project.project_file import Place, Project, Recipe, path_inside, project_of

_SEVERAL_WAYS: Final = error(
    "PR304",
    "the project makes `{source}` in several ways, which differ in {what}: {ways}",
    "name {options}, or build one of them",
)
_TARGET_OPTIONS: Final = ("language", "robot")
"""Options that the controller of a target may state as well."""


@dataclass(frozen=True, slots=True)
class SourceOptions:
    """Options of commands, see `compile`; None if not stated."""

    language: str | None = None
    robot: str | None = None
    process: FilePath | None = None
    unit: str | None = None
    cell: FilePath | None = None
    from_language: str | None = None
    from_robot: str | None = None
    entry: str | None = None
    most_targets: int | None = None


KEYS: Final = tuple(field.name for field in fields(SourceOptions))


def completed_options(
    source: str, given: SourceOptions, wanted: Collection[str] = KEYS
) -> SourceOptions:
    """Return the given options, completed from the project that the source is a program of.

    wanted: fields that count. Raises Refused (exit status 2) if programs or targets of the project
    differ in an option that is not given, and for an invalid project.
    """
    file = FilePath(source).absolute()
    project = _project_of_source(file)
    if project is None:
        return given
    ways = dict(_ways_of_source(project, file))
    fitting = {
        name: one
        for name, one in ways.items()
        if all(_same_options(getattr(given, key), getattr(one, key)) for key in _TARGET_OPTIONS)
    }
    if not fitting:  # another arm or language than the project's: what belongs to those is not its
        left = dict.fromkeys(_TARGET_OPTIONS)
        fitting = {name: replace(one, **left) for name, one in ways.items()}
    open_ = [key for key in wanted if getattr(given, key) is None]
    differing = [key for key in open_ if len({getattr(one, key) for one in fitting.values()}) > 1]
    if differing:
        raise Refused(_several_ways(source, differing, fitting), exit_status=2)
    one = next(iter(fitting.values()), given)
    return replace(given, **{key: getattr(one, key) for key in open_})


def _several_ways(
    source: str, differing: list[str], ways: Mapping[str, SourceOptions]
) -> Diagnostic:
    shown = (
        f"{name} ({', '.join(str(getattr(one, key) or 'none') for key in differing)})"
        for name, one in ways.items()
    )
    return _SEVERAL_WAYS(
        path=source,
        source=source,
        what=" and ".join(key.replace("_", " ") for key in differing),
        ways=", ".join(shown),
        options=" and ".join(map(_option, differing)),
    )


def _option(key: str) -> str:
    """Return the option of the command line."""
    return "--from" if key == "from_language" else f"--{key.replace('_', '-')}"


def _project_of_source(file: FilePath) -> Project | None:
    """The project of a file, if one of its programs is made of it."""
    found = files.project_of(file.parent)
    content = None if found is None else found.content
    programs = content.get(files.PROGRAMS) if isinstance(content, Mapping) else None
    if found is None or not isinstance(programs, Mapping):
        return None
    folder = FilePath(found.source.path or "").absolute().parent
    for table in programs.values():
        source = table.get("source") if isinstance(table, Mapping) else None
        named = path_inside(folder, source) if isinstance(source, str) else None
        if named is not None and named.resolve() == file.resolve():
            return project_of(file.parent)
    return None


def _ways_of_source(project: Project, file: FilePath) -> Iterator[tuple[str, SourceOptions]]:
    """Yield the options of a file by each program for each target, with readable names."""
    for recipe in project.programs.values():
        if recipe.source.resolve() != file.resolve():
            continue
        places = [place for place in project.places if recipe in place.recipes]
        for place in places:
            yield f"`{recipe.name}` for `{place.name}`", _options_of_recipe(project, recipe, place)
        if not places:
            yield f"`{recipe.name}`", _options_in_way(recipe, recipe.language, recipe.robot)


def _options_of_recipe(project: Project, recipe: Recipe, place: Place) -> SourceOptions:
    order = order_of(project.folder, place, recipe)
    try:
        language: str | None = chosen_language(order)
    except Refused:  # nobody says it
        language = None
    return _options_in_way(recipe, language, order.arm)


def _options_in_way(recipe: Recipe, language: str | None, robot: str | None) -> SourceOptions:
    return SourceOptions(
        language,
        robot,
        _near_path(recipe.process),
        recipe.unit,
        _near_path(recipe.cell),
        recipe.from_language,
        recipe.from_robot,
        recipe.entry,
        recipe.most_targets,
    )


def _near_path(file: FilePath | None) -> FilePath | None:
    return None if file is None else FilePath(shown_path(file))


def _same_options(given: str | None, stated: str | None) -> bool:
    return given is None or (stated is not None and given.lower() == stated.lower())
