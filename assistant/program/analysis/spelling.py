"""Names as their declarations spell them: a program writes them in any case."""

from __future__ import annotations

from assistant.program import statements as p
from assistant.program.program import Procedure, Program, Signal, walk
from assistant.program.timers import timers


class Spelling:
    """What names mean in one procedure after the other; those of the program until one is entered.

    A name that is declared nowhere is spelled as it is given.
    """

    def __init__(self, program: Program) -> None:
        tables = (program.signals, program.joint_targets, program.targets, program.variables)
        self._shared = {name.lower(): name for table in tables for name in table}
        self._procedures = {q.name.lower(): q for q in program.procedures}
        self._timers = {name.lower(): name for name in timers(program)}
        self._signals = {name.lower(): signal for name, signal in program.signals.items()}
        self._own: dict[str, str] = {}

    def enter(self, procedure: Procedure) -> None:
        """Names mean from here on what they mean in the procedure."""
        loops = [node.variable for node in walk(procedure.body) if isinstance(node, p.For)]
        own = (*(q.name for q in procedure.parameters), *procedure.variables)
        self._own = {name.lower(): name for name in reversed((*own, *loops))}
        for name in loops:  # a loop over a variable of the program counts that one
            if name.lower() in self._shared and name.lower() not in {n.lower() for n in own}:
                self._own.pop(name.lower(), None)

    def name(self, name: str) -> str:
        """Of a variable, target or signal."""
        return self._own.get(name.lower()) or self._shared.get(name.lower(), name)

    def timer(self, name: str) -> str:
        return self._timers.get(name.lower(), name)

    def procedure(self, name: str) -> Procedure | None:
        return self._procedures.get(name.lower())

    def signal(self, name: str) -> Signal | None:
        """What a name stands for if it is that of a signal."""
        return None if name.lower() in self._own else self._signals.get(name.lower())
