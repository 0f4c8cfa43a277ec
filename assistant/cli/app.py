"""Commands of `robot-assistant`, and arguments refused before any of them runs.

`COMMANDS` names the module of each command, which is imported when the command is used. An argument
that looks like an address with a password in it is refused before anything can repeat it: passwords
come from the environment, the keyring or a prompt.
"""

from __future__ import annotations

import importlib
import os
import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

import click

from assistant import __version__
from assistant.base.diagnostics import Refused, error
from assistant.base.near_names import spelled_like
from assistant.base.termination import INTERRUPTED
from assistant.cli.command import Group, click_command, option, options, parameters
from assistant.cli.shell_completion import VARIABLE, Shell, add_power_shell, script

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


_WRONG_USAGE: Final = error("CL902", "{fault}", "{cure}")
_WORDS: Final = "assistant.words"
"""Key of the arguments as they were typed, in the context of a command."""
_MOST_NAMED: Final = 12
"""Commands of a group that a cure lists."""
_NO_COMMAND: Final = re.compile(r"No such command '[^']*'")
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
    "pose": "pose_conversion",
    "explore": "exploration_charts",
    "camera": "cameras",
    "objects": "known_objects",
}
"""Command, in the order of the help → the module of this folder that has it: a class of its name
with a capital, or a group.
"""
_NEGATIVE_ARGUMENTS: Final = frozenset({"jog", "pose"})
"""Commands with an argument that may begin with a minus."""


@cache
def _command(name: str) -> click.Command:
    module = importlib.import_module(f"assistant.cli.{COMMANDS[name]}")
    found = getattr(module, name, None)
    if isinstance(found, click.Group):
        found.name = name
        return found
    minus = {"ignore_unknown_options": True} if name in _NEGATIVE_ARGUMENTS else None
    return click_command(getattr(module, name.capitalize()), name, context_settings=minus)


class _Commands(Group):
    """All commands. Each is imported and built on first use: all of them together take a fifth of
    the time that `check` takes for a small program.
    """

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        return _command(cmd_name) if cmd_name in COMMANDS else None

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        ctx.meta[_WORDS] = list(args)
        try:
            return super().parse_args(ctx, args)
        except click.UsageError as wrong:
            if ctx.resilient_parsing:  # a shell asks what may follow
                raise
            raise _refused_usage(wrong, ctx) from None

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as interrupted:  # of which click would say "Aborted!"
            raise click.exceptions.Exit(INTERRUPTED) from interrupted
        except click.UsageError as wrong:
            raise _refused_usage(wrong, ctx) from None


def _refused_usage(wrong: click.UsageError, everything: click.Context) -> Exception:
    """Return wrong usage as a refusal with a finding; a request for help stays as it is."""
    if isinstance(wrong, click.exceptions.NoArgsIsHelpError):
        return wrong
    context = wrong.ctx or everything
    path = context.command_path
    if wrong.ctx is None and everything.invoked_subcommand:
        path = f"{path} {everything.invoked_subcommand}"
    fault, names = wrong.format_message(), list[str]()
    if isinstance(wrong, click.NoSuchOption):
        fault = wrong.message
        names = [name for one in context.command.params for name in one.opts]
    elif isinstance(context.command, click.Group) and (found := _NO_COMMAND.search(fault)):
        fault, names = found[0], context.command.list_commands(context)
    typed = re.search(r"'([^']+)'", fault)
    near = spelled_like(typed[1], names, 2) if typed else []
    fault = re.sub(r"'([^']+)'", r"`\1`", " ".join(fault.split()).rstrip("."))
    usage = " ".join(context.get_usage().split()[1:]) if wrong.ctx else f"{path} …"
    cure = f"write `{usage}`; `{path} --help` explains it"
    if names and isinstance(context.command, click.Group) and len(names) <= _MOST_NAMED:
        cure = f"write one of {', '.join(names)}; `{path} --help` explains them"
    parameter = getattr(wrong, "param", None)
    if near:
        cure = f"did you mean {' or '.join(f'`{one}`' for one in near)}?"
    elif isinstance(wrong, click.MissingParameter) and isinstance(parameter, click.Option):
        cure = f"add `{parameter.opts[0]}` ({(parameter.help or '').rstrip('.')}); {cure}"
    _adopt_format(everything.meta[_WORDS])
    fault = fault[:1].lower() + fault[1:]
    return Refused(_WRONG_USAGE(about=path, fault=fault, cure=cure), exit_status=2)


def _set_budget(text: str | None) -> None:
    """For this command, and for the processes that it starts."""
    from assistant.base.budgets import FACTOR_VARIABLE, budget_factor, read_budget_factor

    if text is not None:
        read_budget_factor(text)
        os.environ[FACTOR_VARIABLE] = text
    budget_factor()  # what the environment states is looked at before anything is done


def _print_completion(shell: Shell | None) -> None:
    if shell is not None:
        click.echo(script(app, shell))
        raise click.exceptions.Exit


def _print_version(wanted: bool) -> None:
    if wanted:
        click.echo(f"robot-assistant {__version__}")
        raise click.exceptions.Exit


@options
class _CommonOptions:
    """Options before the command."""

    version: bool = option("Print the version.", is_eager=True, callback=_print_version)
    budget: str | None = option(
        "Times all limits of time, memory and size.", metavar="FACTOR", callback=_set_budget
    )
    show_completion: Shell | None = option(
        "Print what makes a shell complete commands.", is_eager=True, callback=_print_completion
    )


if VARIABLE in os.environ:
    add_power_shell()

app: Final = _Commands(
    params=parameters(_CommonOptions),
    callback=lambda **_: None,
    help="Drawings, trajectories and robot programs to proven ABB RAPID and MELFA-BASIC.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
