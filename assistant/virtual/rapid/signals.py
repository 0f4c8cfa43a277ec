"""Inputs as they were given, outputs as the program sets them."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass, field

from assistant.virtual.events import OnWay, Switched
from assistant.virtual.kernel.task import Task
from assistant.virtual.kernel.timers import Timer


@dataclass(slots=True)
class Signals:
    """outputs: names, in lower case, of the signals that programs set; the others are inputs.

    known: names of signals, whichever; what else has no meaning in the program is none of them.
    """

    task: Task
    outputs: Set[str]
    known: Set[str]
    later: dict[str, Timer] = field(default_factory=dict)

    def knows(self, name: str) -> bool:
        inputs = self.task.kernel.board.inputs
        source = inputs.source
        return callable(source) or name in self.known or name in source or name in inputs.values

    def read(self, name: str) -> float:
        board = self.task.kernel.board
        return (board.outputs if name in self.outputs else board.inputs).read(name)

    def set(
        self, name: str, value: float, at: OnWay | None = None, after: float | None = None
    ) -> None:
        """at, after: see `Switched`."""
        self.task.switch(name, value, at, after)

    def set_later(self, name: str, value: float, seconds: float) -> None:
        """While the program goes on; instead of what still is to become of the signal."""
        if name in self.later:
            self.later[name].cancelled = True
        kernel, task, place = self.task.kernel, self.task, self.task.where()

        def change() -> None:
            kernel.tell(task, Switched(name, value), place)
            kernel.board.outputs.set(name, value)

        self.later[name] = kernel.at(kernel.now + seconds, change)
