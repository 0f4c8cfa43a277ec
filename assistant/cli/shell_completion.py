"""Scripts by which a shell completes the words of commands: `--show-completion SHELL` prints it.

The shell then runs the program with `_ROBOT_ASSISTANT_COMPLETE=<shell>_complete`. click knows how
bash, zsh and fish ask; PowerShell is added here.
"""

from __future__ import annotations

import enum
import os
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    import click

PROGRAM: Final = "robot-assistant"
VARIABLE: Final = "_ROBOT_ASSISTANT_COMPLETE"
"""By which click notices that a shell asks."""


class Shell(enum.StrEnum):
    """Shells that complete words."""

    BASH = "bash"
    ZSH = "zsh"
    FISH = "fish"
    POWERSHELL = "powershell"


def script(app: click.Command, shell: Shell) -> str:
    """Return what the shell has to run at its start."""
    from click.shell_completion import get_completion_class

    add_power_shell()
    kind = get_completion_class(shell)
    assert kind is not None
    return kind(app, {}, PROGRAM, VARIABLE).source()


_POWERSHELL: Final = """\
Register-ArgumentCompleter -Native -CommandName %(prog_name)s -ScriptBlock {
    param($word, $line, $position)
    $env:%(complete_var)s = "powershell_complete"
    $env:COMP_WORDS = $line.ToString()
    $env:COMP_WORD = $word
    try {
        %(prog_name)s | ForEach-Object {
            $text, $help = $_ -split "`t", 2
            if (-not $help) { $help = $text }
            $shown = $text, $text, "ParameterValue", $help
            New-Object System.Management.Automation.CompletionResult $shown
        }
    } finally {
        Remove-Item Env:%(complete_var)s, Env:COMP_WORDS, Env:COMP_WORD -ErrorAction Ignore
    }
}
"""
"""Source: Register-ArgumentCompleter in the reference of PowerShell 7."""


def add_power_shell() -> None:
    """Add PowerShell to the shells that click answers."""
    from click.shell_completion import (
        CompletionItem,
        ShellComplete,
        add_completion_class,
        split_arg_string,
    )

    class PowerShell(ShellComplete):
        """Completion for PowerShell: a line for each word, its help behind a tab."""

        name = Shell.POWERSHELL.value
        source_template = _POWERSHELL

        def get_completion_args(self) -> tuple[list[str], str]:
            words, typed = split_arg_string(os.environ["COMP_WORDS"]), os.environ["COMP_WORD"]
            return (words[1:-1] if typed else words[1:]), typed

        def format_completion(self, item: CompletionItem[str]) -> str:
            return f"{item.value}\t{item.help or ''}"

    add_completion_class(PowerShell)
