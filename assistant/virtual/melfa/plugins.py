"""Commands, functions and status variables that whoever runs a program gives it.

    run(tree, commands={
        "Rnd": lambda given: 0.5,                            # a function
        "M_Uar": lambda given: 1,                            # a status variable that is read
        "P_FsGn0=": lambda given: print(given.arguments),    # one that is set: indices, the value
        "Fsc On": lambda given: given.task.switch("force", 1.0),    # a command
    })

They stand before what is simulated, and any name may be one that the language lacks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from assistant.virtual.melfa.values import Value

if TYPE_CHECKING:
    from assistant.virtual.kernel import Task
    from assistant.virtual.melfa.arm import Arm


@dataclass(frozen=True, slots=True)
class Given:
    """What a plug-in is called with.

    name: upper case, without `$`. arguments: their values, None for one that is left out; a bare
    word is a text. task: to tell events, to set outputs, to wait. arm: where it stands.
    files: what is open, by its number, as `Open` named it.
    """

    name: str
    arguments: tuple[Value | None, ...]
    task: Task
    arm: Arm
    files: Mapping[int, str] = field(default_factory=dict)


Command = Callable[[Given], Value | None]
"""Runs a command, or gives the value of a function or status variable. It may raise `Failed`."""
Commands = Mapping[str, Command]


def commands_by_name(commands: Commands | None) -> dict[str, Command]:
    """Plug-ins by upper-case name without `$`; a command of two words has one blank in it."""
    found = {" ".join(name.upper().split()): command for name, command in (commands or {}).items()}
    return {name.removesuffix("$"): command for name, command in found.items()}
