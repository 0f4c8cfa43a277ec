"""How a program stands among others of its controller, as a process file says it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.base.diagnostics import error
from assistant.program import settings_tables
from assistant.program.program import Interface
from assistant.program.settings_tables import Read, Table

NUMBER_WITHOUT_CONTROLLER = error(
    "CO328",
    "`{name}` has a number, but is written with the program",
    "write `on_controller = true` too, or leave out `number`",
)
MOST_TOOL_NUMBER: Final = 16
"""Highest number of a tool on controllers that count them (parameters MEXTL1 to MEXTL16)."""

PROGRAM_KEYS: Final[Mapping[str, Read]] = {
    "as": settings_tables.name,
    "main": settings_tables.truth,
    "prefix": settings_tables.name,
    "local": settings_tables.truth,
}
ON_CONTROLLER_KEYS: Final[Mapping[str, Read]] = {
    "on_controller": settings_tables.truth,
    "number": settings_tables.whole(1, MOST_TOOL_NUMBER),
}
"""Keys of a tool or a frame."""


def interface_of(top: Table) -> Interface | None:
    """What [program] says, with the tools and frames that the controller has; None for nothing."""
    found = top.table("program").read(PROGRAM_KEYS)
    there: dict[str, int | None] = {}
    for kind in ("tools", "frames"):
        given = top.content.get(kind)
        for name, said in given.items() if isinstance(given, dict) else ():
            if not isinstance(said, dict):
                continue
            if said.get("on_controller") is True:
                there[name.lower()] = said.get("number")
            elif "number" in said:
                top.page.say(
                    NUMBER_WITHOUT_CONTROLLER, (*top.path, kind, name, "number"), name=name
                )
    if not found and not there:
        return None
    return Interface(
        found.get("as", ""),
        found.get("main", True),
        found.get("prefix", ""),
        found.get("local", False),
        there,
    )
