"""The commands of `robot-assistant`; each imports what it needs when it runs."""

from __future__ import annotations

import importlib
import os
from collections.abc import Iterator, Mapping, MutableMapping
from typing import Annotated, Any, Final

import typer
from typer.core import TyperGroup

from assistant import __version__

COMMANDS: Final[Mapping[str, str]] = {
    **dict.fromkeys(
        ("compile", "translate", "compare", "show", "check", "explain", "fmt", "coverage"),
        "on_programs",
    ),
    **dict.fromkeys(("simulate", "view", "info", "scene"), "on_cells"),
    **dict.fromkeys(("kinematics", "fmu"), "on_blocks"),
    "see": "object_commands",
    "learn": "learning_commands",
    **dict.fromkeys(("run", "debug"), "virtual_runs"),
    "lsp": "editors",
    "gateway": "gateways",
    "studio": "studios",
    "answer": "answering_sights",
    **dict.fromkeys(("init", "build"), "projects"),
    **dict.fromkeys(("plan", "deploy", "rollback", "deployments", "verify"), "deployments"),
    **dict.fromkeys(("ls", "get", "put", "rm", "backup", "restore"), "on_controllers"),
    **dict.fromkeys(("monitor", "log", "inputs", "outputs", "parameters"), "on_controllers"),
    **dict.fromkeys(("variables", "reset", "stop", "teach"), "on_controllers"),
    **dict.fromkeys(("motors", "jog", "start", "hand", "follow", "servo"), "on_arms"),
    "demo": "demo_command",
    "virtual": "virtual_commands",
    "robots": "robot_commands",
    "exchange": "exchanges",
    "reach": "reaching",
    "explore": "explorations",
    "camera": "camera_commands",
    "objects": "object_commands",
}
"""Command, in the order of the help → the module of this folder that has it under its name: a
function, or the `Typer` of a group.
"""
NEGATIVE_ARGUMENTS: Final = frozenset({"jog"})
"""Commands with an argument that may begin with a minus."""


class _Commands(MutableMapping[str, Any]):
    """Commands by their names. Each is imported and built when it is asked for: all of them
    together take a fifth of the time that `check` takes for a small program.
    """

    def __init__(self) -> None:
        self._made: dict[str, Any] = dict.fromkeys(COMMANDS)

    def __getitem__(self, name: str) -> Any:
        if self._made[name] is None:
            self._made[name] = _command(name)
        return self._made[name]

    def __setitem__(self, name: str, command: Any) -> None:
        self._made[name] = command

    def __delitem__(self, name: str) -> None:
        del self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._made)

    def __len__(self) -> int:
        return len(self._made)


def _command(name: str) -> Any:
    module = importlib.import_module(f"assistant.cli.{COMMANDS[name]}")
    found = getattr(module, name)
    if not isinstance(found, typer.Typer):
        function, found = found, typer.Typer(add_completion=False, rich_markup_mode=None)
        minus = {"ignore_unknown_options": True} if name in NEGATIVE_ARGUMENTS else None
        found.command(name, context_settings=minus)(function)
    command = typer.main.get_command(found)
    command.name = name
    return command


class _Group(TyperGroup):
    """All commands."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.commands = _Commands()


app: Final = typer.Typer(
    cls=_Group,
    help="Drawings, trajectories and robot programs to proven ABB RAPID and MELFA-BASIC.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _set_budget(text: str | None) -> None:
    """For this command, and for the processes that it starts."""
    from assistant.base.budgets import FACTOR_VARIABLE, budget_factor, read_budget_factor

    if text is not None:
        read_budget_factor(text)
        os.environ[FACTOR_VARIABLE] = text
    budget_factor()  # what the environment states is looked at before anything is done


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"robot-assistant {__version__}")
        raise typer.Exit


@app.callback()
def options(
    _: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
    budget: Annotated[
        str | None,
        typer.Option(
            "--budget",
            metavar="FACTOR",
            help="Times all limits of time, memory and size.",
        ),
    ] = None,
) -> None:
    """Drawings, trajectories and robot programs to proven ABB RAPID and MELFA-BASIC."""
    _set_budget(budget)
