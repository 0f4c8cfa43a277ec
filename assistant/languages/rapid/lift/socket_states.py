"""States of sockets, which RAPID knows by what was done with them last, as numbers.

Reference manual of functions: SocketGetStatus; of data types: socketstatus.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any, Final

from assistant.languages.rapid.tables.words import SOCKET_STATES
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program, TakenNames, Variable, identifier
from assistant.program.rewriting import records, rewrite

STATUS_FUNCTION: Final = "socketgetstatus"
_STATE_CHANGES: Final = {
    "socketcreate": (0, 1), "socketconnect": (0, 2), "socketaccept": (1, 2),
    "socketbind": (0, 3), "socketlisten": (0, 4), "socketclose": (0, 5),
}  # fmt: skip
"""By lower-case instruction the place of its socket, and the state that this has behind it."""


class SocketStates:
    """names: of the variables of sockets by their lower-case names, where a program asks for more
    than whether one is connected.
    """

    def __init__(self, program: Program) -> None:
        asked: dict[str, str] = {}
        times: Counter[str] = Counter()
        plain: Counter[str] = Counter()
        for part in records((program.procedures, program.variables)):
            match part:
                case e.Apply(function, (e.Name(name),)) if function.lower() == STATUS_FUNCTION:
                    asked.setdefault(name.lower(), name)
                    times[name.lower()] += 1
                case e.Binary("=" | "<>", e.Apply(function, (e.Name(name),)), e.Name(state)) if (
                    function.lower() == STATUS_FUNCTION and state.lower() == "socket_connected"
                ):
                    plain[name.lower()] += 1
        other = {name for name, count in times.items() if count > plain[name]}
        taken = TakenNames((*program.variables, *program.signals, *program.targets))
        self.names = {
            low: identifier(f"{asked[low]}_state", taken) for low in asked if low in other
        }

    def variables(self) -> dict[str, Variable]:
        closed = e.Number(SOCKET_STATES["socket_closed"])
        return {name: Variable("number", closed) for name in self.names.values()}

    def behind(self, word: str, names: list[str]) -> Iterator[p.Statement]:
        """What an instruction makes of a state. names: that it is given, empty for others."""
        place, state = _STATE_CHANGES.get(word, (0, 0))
        own = self.names.get(names[place].lower()) if state and place < len(names) else None
        if own is not None:
            yield p.Assign(e.Name(own), e.Number(state))

    def asked(self, program: Program) -> Program:
        """The program with these variables where it asks for states."""

        def change(part: Any) -> Any:
            match part:
                case e.Apply(function, (e.Name(name),)) if function.lower() == STATUS_FUNCTION:
                    own = self.names.get(name.lower())
                    return part if own is None else e.Name(own)
            return part

        return rewrite(program, change) if self.names else program
