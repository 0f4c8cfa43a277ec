"""The files that channels are, by their numbers."""

from __future__ import annotations

from assistant.languages.melfa_basic.lower.names import Names
from assistant.languages.melfa_basic.lower.unsayable import Unsayable
from assistant.languages.melfa_basic.tables.channels import FILE_NUMBERS
from assistant.program import expressions as e


def channel_number(names: Names, channel: str) -> int:
    """The number of the file that a channel is; raises Unsayable for one too many."""
    found = names.channels.get(channel.lower())
    if found is None:
        raise Unsayable(f"the channel `{channel}` beside {len(FILE_NUMBERS)} others", "use fewer")
    return found


def asked_channel(names: Names, function: str, arguments: tuple[e.Expression, ...]) -> int | None:
    """The number of the file whose connection a function asks for, None for another function.

    Raises Unsayable where a text of a channel stands inside an expression.
    """
    if function in e.TAKING:
        raise Unsayable("a text of a channel inside an expression", "assign it to a variable")
    match function, arguments:
        case "connected", (e.Text(channel),):
            return channel_number(names, channel)
    return None
