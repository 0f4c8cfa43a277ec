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

import math
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import MISSING, field, fields, is_dataclass, replace
from enum import Enum
from functools import partial
from pathlib import Path
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

import click
from click.core import ParameterSource

from assistant.base.data_classes import dataclass


class Command(Protocol):
    """A record of options that can be carried out."""

    def run(self) -> int:
        """Return the exit status."""


C = TypeVar("C", bound=Command)
T = TypeVar("T")
_ABOUT: Final = "about"
"""Key of a field's metadata."""
_SCALARS: Final[Mapping[Any, click.ParamType[Any]]] = {
    bool: click.BOOL,
    int: click.INT,
    float: click.FLOAT,
    str: click.STRING,
}


class _Choice(click.Option):
    """An option that lists its words in the help."""

    def __init__(self, choices: Callable[[], Iterable[str]], *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self._choices = choices

    def make_metavar(self, ctx: click.Context) -> str:  # noqa: ARG002
        return f"[{'|'.join(self._choices())}]"


def _begun(choices: Callable[[], Iterable[str]], typed: str) -> list[str]:
    return [word for word in choices() if word.startswith(typed)]


class Option:
    """An option of commands, for `Annotated`.

    names: as it is typed; default the name of the field. default: None, False and () need not be
    stated. project: key of `SourceOptions` that it defaults to. min, max: bounds of a number.
    callback: called with the value before the command runs; returns the value. completions: returns
    what may follow when a shell asks. choices: the words that the command takes, for help and
    shells, from a table that is loaded only then; the command refuses others. settings: of
    `click.Option`.
    """

    def __init__(
        self,
        help: str,
        *names: str,
        default: Any = MISSING,
        project: str | None = None,
        min: Any = None,
        max: Any = None,
        callback: Callable[[Any], Any] | None = None,
        completions: Callable[[str], list[str]] | None = None,
        choices: Callable[[], Iterable[str]] | None = None,
        **settings: Any,
    ) -> None:
        self.help, self.names, self.default, self.project = help, names, default, project
        self._bounds = (min, max)
        self._settings = settings
        if callback is not None:
            self._settings["callback"] = lambda _c, _p, value: callback(value)
        if choices is not None:
            self._settings["cls"] = partial(_Choice, choices)
            completions = partial(_begun, choices)
        if completions is not None:
            self._settings["shell_complete"] = lambda _c, _p, typed: completions(typed)

    def default_of(self, kind: Any) -> Any:
        """Return the stated default, or the one that the type implies."""
        if self.default is not MISSING:
            return self.default
        if type(None) in get_args(kind):
            return None
        return {bool: False, tuple: ()}.get(get_origin(kind) or kind, MISSING)

    def parameter(self, name: str, kind: Any, default: Any) -> click.Parameter:
        """Return the parameter of click. kind: type of the field; default: MISSING for none."""
        kind, several = _element(kind)
        names = self.names or (f"--{name.replace('_', '-')}",)
        settings: dict[str, Any] = {"show_default": default != ""}
        settings |= {"is_flag": True} if kind is bool else {"type": self._type(kind)}
        if several:
            settings["multiple"] = True
        elif default is MISSING:
            settings["required"] = True
        else:
            settings["default"] = default.value if isinstance(default, Enum) else default
        settings |= self._settings
        made = settings.pop("cls", click.Option)
        option: click.Option = made([name, *names], help=self.help, **settings)
        return option

    def _type(self, kind: Any) -> click.ParamType[Any]:
        if self._bounds != (None, None):
            return click.IntRange(*self._bounds) if kind is int else _Numbers(*self._bounds)
        if kind is Path:
            return click.Path(path_type=Path)
        return _SCALARS[kind] if kind in _SCALARS else _Members(kind)


class Argument(Option):
    """An argument of commands, for `Annotated`. settings: of `click.Argument`."""

    def default_of(self, kind: Any) -> Any:  # noqa: ARG002
        return self.default

    def parameter(self, name: str, kind: Any, default: Any) -> click.Parameter:
        kind, several = _element(kind)
        settings = {**self._settings, "required": default is MISSING}
        if several:
            settings["nargs"] = -1
        elif default is not MISSING:
            settings["default"] = default
        return _Argument(self.help, [name], type=self._type(kind), **settings)


def _element(kind: Any) -> tuple[Any, bool]:
    """Return the type of one value of a field, and whether there may be several."""
    if get_origin(kind) is tuple:
        return get_args(kind)[0], True
    return next((one for one in get_args(kind) if one is not type(None)), kind), False


class _Numbers(click.FloatRange):
    """Numbers between bounds, which `nan` is not."""

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        number = super().convert(value, param, ctx)
        if math.isnan(number):
            self.fail(f"{value!r} is not a number.", param, ctx)
        return number


class _Members(click.Choice[Any]):
    """Members of an enumeration by their values: click knows them by their names."""

    def __init__(self, kind: type[Enum]) -> None:
        super().__init__([one.value for one in kind])
        self._kind = kind

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        if isinstance(value, self._kind):
            return value
        return self._kind(super().convert(value, param, ctx))


class _Argument(click.Argument):
    """An argument with a help."""

    def __init__(self, about: str, names: list[str], **settings: Any) -> None:
        super().__init__(names, **settings)
        self.about = about


class _Described(click.Command):
    """A command whose help explains its arguments, which click before 8.5 does not."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        rows = [_argument_row(one) for one in self.params if isinstance(one, _Argument)]
        if rows:
            with formatter.section("Arguments"):
                formatter.write_dl(rows)
        super().format_options(ctx, formatter)


def _argument_row(one: _Argument) -> tuple[str, str]:
    """Return name and explanation, with the values among which to choose."""
    name = one.human_readable_name + ("..." if one.nargs == -1 else "")
    if isinstance(one.type, click.Choice):
        name = f"[{'|'.join(one.type.choices)}]"
    return name, one.about + ("  [required]" if one.required else "")


def option(help: str, *names: str, **settings: Any) -> Any:
    """Return a field that is an option of one command; see `Option`."""
    about = Option(help, *names, **settings)
    return field(default=about.default, metadata={_ABOUT: about})


def argument(help: str, **settings: Any) -> Any:
    """Return a field that is an argument of one command; see `Argument`."""
    about = Argument(help, **settings)
    return field(default=about.default, metadata={_ABOUT: about})


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(option, argument))
def command(cls: type[C]) -> type[C]:
    """Make a class a command; `app.COMMANDS` names its module."""
    return dataclass(frozen=True, kw_only=True)(cls)


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(option, argument))
def command_of(group: click.Group) -> Callable[[type[C]], type[C]]:
    """Make a class a command of a group."""

    def made(cls: type[C]) -> type[C]:
        record = command(cls)
        group.add_command(click_command(record, cls.__name__.lower()))
        return record

    return made


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(option, argument))
def options(cls: type[T]) -> type[T]:
    """Make a class a group of options, which commands have as one field."""
    return dataclass(frozen=True, kw_only=True)(cls)


class Group(_Described, click.Group):
    """Commands of a group, in the order in which they are written."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        return list(self.commands)


def command_group(help: str) -> click.Group:
    """Return an empty group of commands."""
    return Group(help=help, no_args_is_help=True)


def click_command(cls: type[Command], name: str, **settings: Any) -> click.Command:
    """Return a command that builds the record, runs it, and exits with its status.

    settings: of `click.Command`.
    """

    def call(**given: Any) -> None:
        raise click.exceptions.Exit(_record(cls, given).run())

    return _Described(name, callback=call, params=parameters(cls), help=cls.__doc__, **settings)


def command_line(*arguments: str, **more: str) -> str:
    """Return the running command as it was typed, for a shell, with these options as well.

    arguments: in place of those that were typed. Empty outside of a command.
    """
    context = click.get_current_context(silent=True)
    if context is None:
        return ""
    words = ["robot-assistant", *context.command_path.split()[1:]]
    words += arguments
    options: list[str] = []
    for one in context.command.params:
        name = one.name or ""
        if arguments and isinstance(one, click.Argument):
            continue
        if name in more or context.get_parameter_source(name) is not ParameterSource.COMMANDLINE:
            continue
        value = context.params[name]
        for given in value if isinstance(value, tuple) else (value,):
            if isinstance(one, click.Argument):
                words.append(str(given))
            elif isinstance(given, bool):
                options.append(one.opts[0] if given else one.secondary_opts[0])
            else:
                options += [one.opts[0], str(getattr(given, "value", given))]
    added = [word for name, value in more.items() for word in (f"--{name}", value)]
    return shlex.join([*words, *options, *added])


def with_project_values(record: T, complete: Callable[[dict[str, Any]], Mapping[str, Any]]) -> T:
    """Return the record with the values of its options that a project may state.

    complete: returns these values by their keys, from those that are given.
    """
    names = _project_options(type(record))
    done = complete({key: _value(record, path) for key, path in names.items()})
    for key, path in names.items():
        record = _with_value(record, path, done[key])
    return record


def parameters(cls: type) -> list[click.Parameter]:
    """Return the parameters of click for the options of a record, groups expanded."""
    found: list[click.Parameter] = []
    for one in _typed_fields(cls):
        if _is_group(one.kind):
            found += parameters(one.kind)
        else:
            assert one.about is not None
            found.append(one.about.parameter(one.name, one.kind, one.default))
    return found


def _record(cls: type[T], given: Mapping[str, Any]) -> T:
    values = {
        one.name: _record(one.kind, given) if _is_group(one.kind) else given[one.name]
        for one in _typed_fields(cls)
    }
    return cls(**values)


def _is_group(kind: Any) -> TypeGuard[type]:
    return isinstance(kind, type) and is_dataclass(kind)


class _TypedField(NamedTuple):
    """Field of a record. about: None for a group."""

    name: str
    kind: Any
    about: Option | None
    default: Any


def _typed_fields(cls: type) -> Iterator[_TypedField]:
    hints = get_type_hints(cls, include_extras=True)
    for one in fields(cls):
        kind, about, default = hints[one.name], one.metadata.get(_ABOUT), one.default
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
