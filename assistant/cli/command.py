"""Commands as records: the fields of a class are the options of the command.

    @command
    class Put:
        \"\"\"Copy programs to a controller.\"\"\"

        cell: CellArgument
        files: tuple[Path, ...] = argument("Programs.")
        task: str = option("Task or slot; default the first.", default="")
        reader: DrawingOptions
        format: FormatOption = Format.TEXT

        def run(self) -> int: ...

The docstring is the help, and the order of the fields that of the options. An option that several
commands have is an alias for a type, as `CellArgument`; with a `Default` if it has one. A field
whose type is a class made by `options` stands for all options of that class. `run` returns the exit
status.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass, replace
from typing import (
    Annotated,
    Any,
    Final,
    Protocol,
    TypeVar,
    dataclass_transform,
    get_args,
    get_origin,
    get_type_hints,
)

import typer


class Command(Protocol):
    """A record of options that can be carried out."""

    def run(self) -> int:
        """Return the exit status."""


C = TypeVar("C", bound=Command)
T = TypeVar("T")
_INFO: Final = "typer"
"""Key of a field's metadata."""


@dataclass(frozen=True, slots=True)
class ProjectDefault:
    """Marks an option that defaults to what the project states. key: of `SourceOptions`."""

    key: str


@dataclass(frozen=True, slots=True)
class Default:
    """Default of an option that several commands have."""

    value: Any


def option(help: str, *names: str, project: str | None = None, **settings: Any) -> Any:
    """Return a field that is an option.

    names: as it is typed; default the name of the field. project: key of `SourceOptions` that it
    defaults to. settings: its default, if it is not None, False or (), and those of `typer.Option`.
    """
    default = settings.pop("default", MISSING)
    marks = () if project is None else (ProjectDefault(project),)

    def typed(name: str, hint: Any) -> Any:
        flag = (f"--{name.replace('_', '-')}",) if hint is bool else ()
        return Annotated[(hint, typer.Option(*(names or flag), help=help, **settings), *marks)]

    return field(default=default, metadata={_INFO: typed})


def argument(help: str, **settings: Any) -> Any:
    """Return a field that is an argument. settings: its default, and those of `typer.Argument`."""
    default = settings.pop("default", MISSING)

    def typed(_: str, hint: Any) -> Any:
        return Annotated[hint, typer.Argument(help=help, **settings)]

    return field(default=default, metadata={_INFO: typed})


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(option, argument))
def command(cls: type[C]) -> type[C]:
    """Make a class a command; `app.COMMANDS` names its module."""
    return dataclass(frozen=True, kw_only=True)(cls)


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(option, argument))
def command_of(group: typer.Typer, name: str | None = None) -> Callable[[type[C]], type[C]]:
    """Make a class a command of a group. name: as it is typed; default that of the class."""

    def made(cls: type[C]) -> type[C]:
        record = command(cls)
        group.command(name or cls.__name__.lower())(function_of(record))
        return record

    return made


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(option, argument))
def options(cls: type[T]) -> type[T]:
    """Make a class a group of options, which commands have as one field."""
    return dataclass(frozen=True, kw_only=True)(cls)


def command_group(help: str) -> typer.Typer:
    """Return an empty group of commands."""
    return typer.Typer(help=help, no_args_is_help=True, rich_markup_mode=None, add_completion=False)


def function_of(cls: type[Command]) -> Callable[..., None]:
    """Return a function for typer that builds the record, runs it, and exits with its status."""

    def call(**given: Any) -> None:
        raise typer.Exit(_record(cls, given).run())

    call.__signature__ = inspect.Signature(_parameters(cls))  # type: ignore[attr-defined]
    call.__doc__ = cls.__doc__
    return call


def with_project_values(record: T, complete: Callable[[dict[str, Any]], Mapping[str, Any]]) -> T:
    """Return the record with the values of its options that a project may state.

    complete: returns these values by their keys, from those that are given.
    """
    names = _project_options(type(record))
    done = complete({key: _value(record, path) for key, path in names.items()})
    for key, path in names.items():
        record = _with_value(record, path, done[key])
    return record


def _parameters(cls: type) -> list[inspect.Parameter]:
    """Return the parameters of a function with the options of a record, groups expanded."""
    found: list[inspect.Parameter] = []
    for one, hint in _typed_fields(cls):
        if isinstance(hint, type) and is_dataclass(hint):
            found += _parameters(hint)
            continue
        default = _default(one, hint)
        if _is_repeatable(hint):
            values, *info = get_args(hint)
            listed: Any = list[get_args(values)[0]]  # type: ignore[misc]
            if default == ():
                listed, default = listed | None, None
            hint = Annotated[(listed, *info)]
        kind = inspect.Parameter.KEYWORD_ONLY
        found.append(inspect.Parameter(one.name, kind, default=default, annotation=hint))
    return found


def _default(one: Field[Any], hint: Any) -> Any:
    """Return the default of a field, or what its type implies for an option."""
    if one.default is not MISSING:
        return one.default
    type_, *info = get_args(hint) or (None,)
    for each in info:
        if isinstance(each, Default):
            return each.value
    if any(isinstance(each, typer.models.OptionInfo) for each in info):
        if type(None) in get_args(type_):
            return None
        if type_ is bool:
            return False
        if _is_repeatable(hint):
            return ()
    return inspect.Parameter.empty


def _record(cls: type[T], given: Mapping[str, Any]) -> T:
    values: dict[str, Any] = {}
    for one, hint in _typed_fields(cls):
        if isinstance(hint, type) and is_dataclass(hint):
            values[one.name] = _record(hint, given)
        elif _is_repeatable(hint):
            values[one.name] = tuple(given[one.name] or ())
        else:
            values[one.name] = given[one.name]
    return cls(**values)


def _typed_fields(cls: type) -> list[tuple[Field[Any], Any]]:
    """Return the fields of a record with their types, which hold what typer is told about them."""
    hints = get_type_hints(cls, include_extras=True)
    found = []
    for one in fields(cls):
        typed = one.metadata.get(_INFO)
        found.append((one, typed(one.name, hints[one.name]) if typed else hints[one.name]))
    return found


def _is_repeatable(hint: Any) -> bool:
    """True for a tuple of any number of values, which typer knows as a list."""
    return get_origin(hint) is Annotated and get_origin(get_args(hint)[0]) is tuple


def _project_options(cls: type) -> dict[str, tuple[str, ...]]:
    """Return the names by which a field is found, by the key of the project."""
    found: dict[str, tuple[str, ...]] = {}
    for one, hint in _typed_fields(cls):
        if isinstance(hint, type) and is_dataclass(hint):
            inner = _project_options(hint)
            found |= {key: (one.name, *path) for key, path in inner.items()}
        for info in get_args(hint)[1:]:
            if isinstance(info, ProjectDefault):
                found[info.key] = (one.name,)
    return found


def _value(record: Any, path: tuple[str, ...]) -> Any:
    for name in path:
        record = getattr(record, name)
    return record


def _with_value(record: Any, path: tuple[str, ...], value: Any) -> Any:
    name, *rest = path
    inner = _with_value(getattr(record, name), tuple(rest), value) if rest else value
    return replace(record, **{name: inner})
