"""Commands as records: the fields of a class are the options of the command.

    @command
    class Put:
        \"\"\"Copy programs to a controller.\"\"\"

        cell: CellArgument
        files: Annotated[tuple[Path, ...], typer.Argument(help="Programs.")]
        drawing: DrawingOptions
        format: FormatOption = Format.TEXT

        def run(self) -> int: ...

The docstring is the help, and the order of the fields that of the options. A field whose type is a
class made by `options` stands for all options of that class. `run` returns the exit status.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, dataclass, fields, is_dataclass, replace
from typing import Annotated, Any, Protocol, TypeVar, dataclass_transform, get_args, get_origin
from typing import get_type_hints as hints_of

import typer


class Command(Protocol):
    """A record of options that can be carried out."""

    def run(self) -> int:
        """Return the exit status."""


C = TypeVar("C", bound=Command)
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class ProjectDefault:
    """Marks an option that defaults to what the project states. key: of `SourceOptions`."""

    key: str


@dataclass_transform(kw_only_default=True, frozen_default=True)
def command(cls: type[C]) -> type[C]:
    """Make a class a command; `app.COMMANDS` names its module."""
    return dataclass(frozen=True, kw_only=True)(cls)


@dataclass_transform(kw_only_default=True, frozen_default=True)
def command_of(group: typer.Typer, name: str | None = None) -> Callable[[type[C]], type[C]]:
    """Make a class a command of a group. name: as it is typed; default that of the class."""

    def made(cls: type[C]) -> type[C]:
        record = command(cls)
        group.command(name or cls.__name__.lower())(function_of(record))
        return record

    return made


@dataclass_transform(kw_only_default=True, frozen_default=True)
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
    found = []
    for field, hint in _typed_fields(cls):
        if isinstance(hint, type) and is_dataclass(hint):
            found += _parameters(hint)
            continue
        default = inspect.Parameter.empty if field.default is MISSING else field.default
        if _is_repeatable(hint):
            first, *info = get_args(hint)
            values: Any = list[get_args(first)[0]]  # type: ignore[misc]
            optional = default == ()
            default = None if optional else default
            hint = Annotated[(values | None if optional else values, *info)]
        kind = inspect.Parameter.KEYWORD_ONLY
        found.append(inspect.Parameter(field.name, kind, default=default, annotation=hint))
    return found


def _record(cls: type[T], given: Mapping[str, Any]) -> T:
    values: dict[str, Any] = {}
    for field, hint in _typed_fields(cls):
        if isinstance(hint, type) and is_dataclass(hint):
            values[field.name] = _record(hint, given)
        elif _is_repeatable(hint):
            values[field.name] = tuple(given[field.name] or ())
        else:
            values[field.name] = given[field.name]
    return cls(**values)


def _typed_fields(cls: type) -> list[tuple[Field[Any], Any]]:
    hints = hints_of(cls, include_extras=True)
    return [(field, hints[field.name]) for field in fields(cls)]


def _is_repeatable(hint: Any) -> bool:
    """True for a tuple of any number of values, which typer knows as a list."""
    return get_origin(hint) is Annotated and get_origin(get_args(hint)[0]) is tuple


def _project_options(cls: type) -> dict[str, tuple[str, ...]]:
    """Return the names by which a field is found, by the key of the project."""
    found: dict[str, tuple[str, ...]] = {}
    for field, hint in _typed_fields(cls):
        if isinstance(hint, type) and is_dataclass(hint):
            inner = _project_options(hint)
            found |= {key: (field.name, *path) for key, path in inner.items()}
        for info in get_args(hint)[1:]:
            if isinstance(info, ProjectDefault):
                found[info.key] = (field.name,)
    return found


def _value(record: Any, path: tuple[str, ...]) -> Any:
    for name in path:
        record = getattr(record, name)
    return record


def _with_value(record: Any, path: tuple[str, ...], value: Any) -> Any:
    name, *rest = path
    inner = _with_value(getattr(record, name), tuple(rest), value) if rest else value
    return replace(record, **{name: inner})
