"""The tools, frames and signals that a process file defines, where its other tables name them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final

from assistant.base.diagnostics import error
from assistant.program import settings_tables
from assistant.program.geometry import BASE, FLANGE, Tool
from assistant.program.program import Signal
from assistant.program.settings_tables import Read, Table, listed, nearest, shown

NOT_DEFINED = error("CT309", "there is no {kind} `{name}`", "{cure}")
NOT_AN_OUTPUT = error("CT310", "`{name}` is an input and cannot be set", "name an output")
NOT_ITS_VALUE = error("CT311", "the {kind} signal `{name}` cannot be {value}", "write {wanted}")

MOTION_KEYS: Final[Mapping[str, Read]] = {
    "speed": settings_tables.speed,
    "blend": settings_tables.blend,
    "tool": settings_tables.name,
    "frame": settings_tables.name,
}


class DefinedNames:
    """The tools, frames and signals of the file, to find those that others name."""

    def __init__(
        self,
        tools: Mapping[str, Tool],
        frames: Iterable[str],
        signals: Mapping[str, Signal],
    ) -> None:
        self._tools = tools
        self._known = {"tool": [*tools, FLANGE], "frame": [*frames, BASE]}
        self._signals = signals

    def motion(self, table: Table, keys: Mapping[str, Read]) -> dict[str, Any]:
        """The table's values, tools and frames under the names they were defined by."""
        found = table.read(keys)
        for kind, known in self._known.items():
            if kind in found:
                name = self._find(table, kind, kind, found[kind], known)
                if name is None:
                    del found[kind]
                else:
                    found[kind] = name
        return found

    def turns_freely(self, tool: str) -> bool:
        return tool in self._tools and self._tools[tool].free_turn

    def switched(self, table: Table, wanted: Mapping[str, float]) -> Iterable[tuple[str, float]]:
        for given, value in wanted.items():
            name = self._find(table, given, "signal", given, list(self._signals))
            if name is None:
                continue
            signal = self._signals[name]
            if signal.direction == "input":
                table.say(NOT_AN_OUTPUT, given, name=name)
            most = 2**signal.bits - 1
            if signal.kind != "analog" and not (value == int(value) and 0 <= value <= most):
                said = f"{value:g}"
                table.say(
                    NOT_ITS_VALUE,
                    given,
                    kind=signal.kind,
                    name=name,
                    value=said,
                    wanted=f"a whole number, 0 to {most}",
                )
            yield name, value

    @staticmethod
    def _find(table: Table, key: str, kind: str, given: str, known: list[str]) -> str | None:
        for name in known:
            if name.casefold() == given.casefold():
                return name
        near, shown_name = nearest(given, known), shown(given)
        cure = (
            f"write {near}"
            if near
            else f"define [{kind}s.{shown_name}]; there are: {listed(known)}"
        )
        table.say(NOT_DEFINED, key, kind=kind, name=shown_name, cure=cure)
        return None
