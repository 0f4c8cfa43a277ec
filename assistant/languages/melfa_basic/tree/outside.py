"""What every maker has in an own way, and a cell says by routines of its own: force control.

Other languages call a routine of the cell where a program has such a command, and keep the states
that belong to it as data, which those routines read and write.
"""

from __future__ import annotations

from typing import Final

from assistant.languages.melfa_basic.tree import syntax as s

FORCE_COMMANDS: Final = ("Fsc", "FsGChg", "FsLog", "FsOutLog", "FsCTrg")
"""Commands of the force sensor (manual of the force sense function)."""
FORCE_STATES: Final = ("P_FS", "M_FS")
"""How the status variables begin that they read and write."""


def supplied_routine(command: s.Command) -> tuple[str, tuple[s.Expression, ...]] | None:
    """The routine that a command asks for and what it is given; None for any other command."""
    if command.keyword not in FORCE_COMMANDS:
        return None
    first, rest = command.arguments[:1], command.arguments[1:]
    match first:
        case (s.Word(text=way) | s.Variable(name=way, arguments=None),) if (
            way.upper() in SWITCH_WORDS
        ):
            name, given = f"{command.keyword}{way.capitalize()}", rest
        case _:
            name, given = command.keyword, command.arguments
    plain = tuple(argument for argument in given if argument is not None)
    return (name, plain) if len(plain) == len(given) else None


SWITCH_WORDS: Final = ("ON", "OFF")


def is_force_state(key: str) -> bool:
    """Whether a name in upper case is a status variable of such."""
    return key.startswith(FORCE_STATES)


def supplied_data_name(name: str) -> str:
    """The variable that such a state is elsewhere: `PFsStf0` of `P_FsStf0`."""
    return name.replace("_", "", 1)
