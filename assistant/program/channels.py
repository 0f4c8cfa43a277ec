"""The channels of a program: what its statements open, write and read; nothing declares them."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.contents import statements_with
from assistant.program.program import Program
from assistant.program.rewriting import rewrite


@dataclass(frozen=True, slots=True)
class ChannelLine:
    """Kind of a communication line of the source's controller.

    port: of TCP, its own or the other computer's; of a `serial` line the number of the port.
    address: its own on the network as `server`, the other computer's as `client`.
    """

    role: Literal["server", "client", "serial"]
    port: int
    address: str = ""


CHANNEL_FUNCTIONS: Final = ("connected", *e.TAKING)
"""Functions of a channel, which they have by its name as a text."""
_NUMBERED_CHANNEL: Final = re.compile(r"channel_([1-9][0-9]?)")


def channels(program: Program) -> tuple[str, ...]:
    """Names as they are spelled first, in order of the text."""
    found: dict[str, str] = {}
    for _, parts in statements_with(program, p.Attach, p.Detach, p.Send, e.Apply):
        for name in sorted(name for part in parts if (name := channel_named(part))):
            found.setdefault(name.lower(), name)
    return tuple(found.values())


def channel_named(part: Any) -> str:
    """The channel that a record names, empty if it names none."""
    match part:
        case p.Attach(name) | p.Detach(name) | p.Send(name):
            return name
        case e.Apply(function, (e.Text(name), *_)) if function in CHANNEL_FUNCTIONS:
            return name
    return ""


def numbered_channels(
    program: Program,
    numbers: Sequence[int],
    together: Callable[[Program], Collection[Collection[str]]],
) -> dict[str, int]:
    """A number for each channel by lower-case name; those for which there is none have none.

    A channel whose name says its number keeps it. One beyond the numbers shares that of others, if
    no two of them are `together`.
    """
    wanted = [name.lower() for name in channels(program)]
    said = ((name, _NUMBERED_CHANNEL.fullmatch(name)) for name in wanted)
    given = {name: int(match[1]) for name, match in said if match and int(match[1]) in numbers}
    free = [n for n in numbers if n not in given.values()]
    others = [name for name in wanted if name not in given]
    given.update(zip(others, free, strict=False))
    left = others[len(free) :]
    apart = together(program) if left else ()
    for name in left:
        beside = {other for pair in apart if name in pair for other in pair}
        shared = (n for n in numbers if not any(given.get(one) == n for one in beside))
        if (number := next(shared, None)) is not None:
            given[name] = number
    return given


def name_of_channel(number: int) -> str:
    """The name of a channel that has but a number."""
    return f"channel_{number}"


def with_channels_renamed(program: Program, names: Mapping[str, str]) -> Program:
    """The program with other names for its channels. names: by lower-case name."""

    def change(part: Any) -> Any:
        new = names.get(channel_named(part).lower())
        match part:
            case p.Attach() | p.Detach() | p.Send() if new is not None:
                return replace(part, channel=new)
            case e.Apply(_, (_, *rest)) if new is not None:
                return replace(part, arguments=(e.Text(new), *rest))
        return part

    return rewrite(program, change) if names else program
