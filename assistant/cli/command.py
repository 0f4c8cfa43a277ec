"""Commands as records: the fields of a class are the options of the command.

    @command
    class Put:
        \"\"\"Copy programs to a controller.\"\"\"

        cell: CellArgument
        files: tuple[Path, ...] = argument("Programs.")
        task: str = option("Task or slot; default the first.", default="")
        reader: DrawingOptions
        format: FormatOption

        def run(self) -> int: ...

The docstring is the help, and the order of the fields that of the options. An option that several
commands have is an alias, `Annotated[Path | None, Option("Process file.", "--process", "-p")]`. A
field whose type is a class made by `options` stands for all options of that class. `run` returns
the exit status.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass, replace
from typing import (
    Annotated,
    Any,
    Final,
    NamedTuple,
    Protocol,
    TypeGuard,
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


class Option:
    """An option of commands, for `Annotated`.

    names: as it is typed; default the name of the field. default: None, False and () need not be
    stated. project: key of `SourceOptions` that it defaults to. settings: of `typer.Option`.
    """

    def __init__(
        self,
        help: str,
        *names: str,
        default: Any = MISSING,
        project: str | None = None,
        **settings: Any,
    ) -> None:
        self.names, self.default, self.project = names, default, project
        self.settings = {"help": help, **settings}

    def default_of(self, kind: Any) -> Any:
        """Return the stated default, or the one that the type implies."""
        if self.default is not MISSING:
            return self.default
        if type(None) in get_args(kind):
            return None
        return {bool: False, tuple: ()}.get(get_origin(kind) or kind, MISSING)

    def info(self, name: str, kind: Any) -> Any:
        """Return the description for typer. kind: type of the field."""
        flag = (f"--{name.replace('_', '-')}",) if kind is bool else ()
        return typer.Option(*(self.names or flag), **self.settings)


class Argument(Option):
    """An argument of commands, for `Annotated`. settings: of `typer.Argument`."""

    def default_of(self, kind: Any) -> Any:  # noqa: ARG002
        return self.default

    def info(self, name: str, kind: Any) -> Any:  # noqa: ARG002
        return typer.Argument(**self.settings)


def option(help: str, *names: str, **settings: Any) -> Any:
    """Return a field that is an option of one command; see `Option`."""
    about = Option(help, *names, **settings)
    return field(default=about.default, metadata={_INFO: about})


def argument(help: str, **settings: Any) -> Any:
    """Return a field that is an argument of one command; see `Argument`."""
    about = Argument(help, **settings)
    return field(default=about.default, metadata={_INFO: about})


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(option, argument))
def command(cls: type[C]) -> type[C]:
    """Make a class a command; `app.COMMANDS` names its module."""
    return dataclass(frozen=True, kw_only=True)(cls)


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(option, argument))
def command_of(group: typer.Typer) -> Callable[[type[C]], type[C]]:
    """Make a class a command of a group."""

    def made(cls: type[C]) -> type[C]:
        record = command(cls)
        group.command(cls.__name__.lower())(function_of(record))
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
    for one in _typed_fields(cls):
        hint, default = one.kind, one.default
        if _is_group(hint):
            found += _parameters(hint)
            continue
        if get_origin(hint) is tuple:  # typer knows lists, and None for an empty one
            hint = list[get_args(hint)[0]]  # type: ignore[misc]
            default, hint = (None, hint | None) if default == () else (default, hint)
        if one.about is not None:
            hint = Annotated[hint, one.about.info(one.name, one.kind)]
        default = inspect.Parameter.empty if default is MISSING else default
        kind = inspect.Parameter.KEYWORD_ONLY
        found.append(inspect.Parameter(one.name, kind, default=default, annotation=hint))
    return found


def _record(cls: type[T], given: Mapping[str, Any]) -> T:
    values: dict[str, Any] = {}
    for one in _typed_fields(cls):
        if _is_group(one.kind):
            values[one.name] = _record(one.kind, given)
        else:
            value = given[one.name]
            values[one.name] = tuple(value or ()) if get_origin(one.kind) is tuple else value
    return cls(**values)


def _is_group(kind: Any) -> TypeGuard[type]:
    return isinstance(kind, type) and is_dataclass(kind)


class _TypedField(NamedTuple):
    """Field of a record. about: None for a group, and for typer's context."""

    name: str
    kind: Any
    about: Option | None
    default: Any


def _typed_fields(cls: type) -> Iterator[_TypedField]:
    hints = get_type_hints(cls, include_extras=True)
    for one in fields(cls):
        kind, about, default = hints[one.name], one.metadata.get(_INFO), one.default
        if get_origin(kind) is Annotated:
            kind, about, *_ = get_args(kind)
        if default is MISSING and about is not None:
            default = about.default_of(kind)
        yield _TypedField(one.name, kind, about, default)


def _project_options(cls: type) -> dict[str, tuple[str, ...]]:
    """Return the names by which a field is found, by the key of the project."""
    found: dict[str, tuple[str, ...]] = {}
    for one in _typed_fields(cls):
        if _is_group(one.kind):
            inner = _project_options(one.kind)
            found |= {key: (one.name, *path) for key, path in inner.items()}
        elif one.about is not None and one.about.project:
            found[one.about.project] = (one.name,)
    return found


def _value(record: Any, path: tuple[str, ...]) -> Any:
    for name in path:
        record = getattr(record, name)
    return record


def _with_value(record: Any, path: tuple[str, ...], value: Any) -> Any:
    name, *rest = path
    inner = _with_value(getattr(record, name), tuple(rest), value) if rest else value
    return replace(record, **{name: inner})
