"""Commands of `robot-assistant`, and arguments refused before any of them runs.

`COMMANDS` names the module of each command, which is imported when the command is used. An argument
that looks like an address with a password in it is refused before anything can repeat it: passwords
come from the environment, the keyring or a prompt.
"""

from __future__ import annotations

import importlib
import os
import re
from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Final

import typer
from typer.core import TyperGroup

from assistant import __version__
from assistant.base.diagnostics import Refused
from assistant.cli.command import function_of

_NOT_AN_ADDRESS: Final = re.compile(r"[A-Za-z_$][^=:@/]*=|[A-Za-z]:[\\/]")
"""Assignments, `text="a:b@c"`, and paths on a Windows drive."""


def refuse_passwords(words: Sequence[str]) -> None:
    """Raises Refused, of exit status 2, if one looks like an address that holds a password.

    Whichever command and option it belongs to: what takes no address would take it for a file.
    """
    for word in words:
        if not ("@" in word or "%" in word) or _NOT_AN_ADDRESS.match(word) or _path_exists(word):
            continue
        from assistant.controllers import rules
        from assistant.controllers.address import holds_password, without_password

        if holds_password(word):
            _adopt_format(words)
            finding = rules.PASSWORD_IN_ADDRESS(place=without_password(word))
            raise Refused(finding, exit_status=2)


def _path_exists(word: str) -> bool:
    """True if the word names a file or a folder."""
    try:
        return Path(word).exists()
    except (OSError, ValueError):
        return False


def _adopt_format(words: Sequence[str]) -> None:
    """Adopt the answer format from the arguments, as the options are not parsed yet."""
    from assistant.cli.presentation import FindingFormat, PlanFormat, answer_as

    text = " ".join(words)
    for format in (one for one in FindingFormat if one is not FindingFormat.TEXT):
        if re.search(rf"--format[ =]{format}\b", text):
            answer_as(format)
    if re.search(rf"--format[ =]{PlanFormat.MARKDOWN}\b", text):
        answer_as(PlanFormat.MARKDOWN)


COMMANDS: Final[Mapping[str, str]] = {
    "compile": "compilation",
    "translate": "translation",
    "compare": "program_checks",
    "show": "program_text",
    "check": "program_checks",
    "explain": "program_checks",
    "fmt": "program_text",
    "coverage": "translation",
    "simulate": "simulation",
    **dict.fromkeys(("view", "info", "scene"), "cell_views"),
    **dict.fromkeys(("kinematics", "fmu"), "block_export"),
    "see": "known_objects",
    "learn": "learning",
    **dict.fromkeys(("run", "debug"), "virtual_runs"),
    "lsp": "services",
    "gateway": "services",
    "studio": "services",
    "answer": "services",
    **dict.fromkeys(("init", "build"), "projects"),
    **dict.fromkeys(("plan", "deploy", "rollback", "deployments", "verify"), "deployment"),
    "ls": "controller_state",
    **dict.fromkeys(("get", "put", "rm", "backup", "restore"), "controller_files"),
    **dict.fromkeys(("monitor", "log", "inputs", "outputs", "parameters"), "controller_state"),
    **dict.fromkeys(("variables", "reset", "stop"), "controller_state"),
    "teach": "teaching",
    **dict.fromkeys(("motors", "jog", "start", "hand", "follow"), "arm_motion"),
    "servo": "visual_servoing",
    "demo": "demo",
    "virtual": "virtual_controllers",
    "robots": "robots",
    "exchange": "pose_exchange",
    "reach": "reach",
    "explore": "exploration_charts",
    "camera": "cameras",
    "objects": "known_objects",
}
"""Command, in the order of the help → the module of this folder that has it: a class of its name
with a capital, or the `Typer` of a group.
"""
_NEGATIVE_ARGUMENTS: Final = frozenset({"jog"})
"""Commands with an argument that may begin with a minus."""


class _Commands(MutableMapping[str, Any]):
    """Commands by name. Each is imported and built on first use: all of them together take a fifth
    of the time that `check` takes for a small program.
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
    found = getattr(module, name, None)
    if not isinstance(found, typer.Typer):
        found = typer.Typer(add_completion=False, rich_markup_mode=None)
        minus = {"ignore_unknown_options": True} if name in _NEGATIVE_ARGUMENTS else None
        function = function_of(getattr(module, name.capitalize()))
        found.command(name, context_settings=minus)(function)
    command = typer.main.get_command(found)
    command.name = name
    return command


_BUILT: Final = _Commands()
"""A process may run several commands: each is built once."""


class _Group(TyperGroup):
    """All commands."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.commands = _BUILT


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
