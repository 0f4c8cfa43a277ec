"""What an editor is shown of a program that is held: tasks, calls, data and signals."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import Final

from assistant.virtual.debugging.expressions import read_expression, shown
from assistant.virtual.debugging.messages import Object, number, text
from assistant.virtual.kernel import Board, Kernel, Signals, Task
from assistant.virtual.kernel.looking import Level, Shown

_SIGNAL_BIT: Final = re.compile(r"m_(in|out)\((\d+)\)")
"""A bit of the inputs or outputs in MELFA-BASIC."""


class View:
    """Numbers stand for calls and for data with parts, from one stop of the run to the next."""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self._threads: dict[str, int] = {}
        self.begin()

    def begin(self) -> None:
        """The run is held anew: what was numbered before is no more."""
        self._levels: list[Level] = []
        self._shown: list[Callable[[], Sequence[Shown]]] = []
        self._inputs: set[int] = set()

    def thread(self, task: Task) -> int:
        return self._threads.setdefault(task.name, len(self._threads) + 1)

    def threads(self, _: Object) -> Object:
        tasks = self.kernel.tasks
        return {"threads": [{"id": self.thread(task), "name": task.name} for task in tasks]}

    def stack(self, arguments: Object) -> Object:
        wanted = number(arguments, "threadId")
        tasks = self.kernel.tasks
        levels = [x for task in tasks if self.thread(task) == wanted for x in task.levels()]
        frames = [self._frame(level) for level in levels]
        return {"stackFrames": frames, "totalFrames": len(frames)}

    def _frame(self, level: Level) -> Object:
        self._levels.append(level)
        frame: Object = {"id": len(self._levels), "name": level.name, "line": 0, "column": 1}
        if level.place is not None:
            path, line = level.place
            name = path.replace("\\", "/").rpartition("/")[2]
            frame |= {"source": {"name": name, "path": path}, "line": line}
        return frame

    def scopes(self, arguments: Object) -> Object:
        level = self._level(number(arguments, "frameId"))
        scopes = [self._scope(name, shown) for name, shown in level.groups.items()]
        board = self.kernel.board
        scopes.append(self._scope("Inputs", partial(_shown_signals, board.inputs)))
        self._inputs.add(len(self._shown))
        scopes.append(self._scope("Outputs", partial(_shown_signals, board.outputs)))
        return {"scopes": scopes}

    def _level(self, frame: int) -> Level:
        if not 1 <= frame <= len(self._levels):
            raise LookupError("there is no such call")
        return self._levels[frame - 1]

    def _scope(self, name: str, shown: Callable[[], Sequence[Shown]]) -> Object:
        return {"name": name, "variablesReference": self._reference(shown), "expensive": False}

    def _reference(self, shown: Callable[[], Sequence[Shown]] | None) -> int:
        if shown is None:
            return 0
        self._shown.append(shown)
        return len(self._shown)

    def variables(self, arguments: Object) -> Object:
        reference = number(arguments, "variablesReference")
        if not 1 <= reference <= len(self._shown):
            raise LookupError("there are no such data")
        return {"variables": [self._variable(one) for one in self._shown[reference - 1]()]}

    def _variable(self, one: Shown) -> Object:
        reference = self._reference(one.parts)
        return {
            "name": one.name, "value": one.value, "type": one.type, "variablesReference": reference,
        }  # fmt: skip

    def set_variable(self, arguments: Object) -> Object:
        """Of inputs only: what the program itself holds is not changed behind its back."""
        if number(arguments, "variablesReference") not in self._inputs:
            raise LookupError("only inputs can be set")
        try:
            value = float(text(arguments, "value"))
        except ValueError:
            raise LookupError("the value of a signal is a number") from None
        self.kernel.board.inputs.set(text(arguments, "name"), value)
        return {"value": f"{value:g}"}

    def evaluate(self, arguments: Object) -> Object:
        """A name, with components and elements after it, or an expression of such names."""
        wanted = text(arguments, "expression").strip()
        frame = number(arguments, "frameId")
        levels = [self._level(frame)] if frame else self._levels[:1]
        for level in levels:
            for group in level.groups.values():
                found = _find_shown(group(), wanted.lower())
                if found is not None:
                    variable = self._variable(found)
                    return {"result": variable.pop("value"), **variable}
        value = read_expression(wanted)(partial(_read_name, self.kernel.board, levels))
        return {"result": shown(value), "variablesReference": 0}

    def read(self, task: Task, name: str) -> str:
        """The value of data that a task knows, as it is shown; raises LookupError."""
        return _read_name(self.kernel.board, task.levels()[:1], name)


def _read_name(board: Board, levels: Sequence[Level], name: str) -> str:
    wanted = name.lower()
    for level in levels:
        for group in level.groups.values():
            found = _find_shown(group(), wanted)
            if found is not None:
                return found.value
    if (port := _SIGNAL_BIT.fullmatch(wanted)) is not None:
        return f"{(board.inputs if port[1] == 'in' else board.outputs).read(port[2]):g}"
    for signals in (board.inputs, board.outputs):
        for one in _shown_signals(signals):
            if one.name.lower() == wanted:
                return one.value
    raise LookupError(f"`{name}` is no data that is known here")


def _shown_signals(signals: Signals) -> Sequence[Shown]:
    source = signals.source
    names = set(signals.values) | (set() if callable(source) else set(source))
    return [Shown(name, f"{signals.read(name):g}") for name in sorted(names)]


def _find_shown(shown: Sequence[Shown], wanted: str) -> Shown | None:
    """The data of a name in lower case; components follow a point, elements in their brackets."""
    for one in shown:
        name = one.name.lower()
        if wanted == name:
            return one
        rest = wanted[len(name) :]
        if wanted.startswith(name) and rest[:1] in (".", "{", "(") and one.parts is not None:
            return _find_shown(one.parts(), rest.removeprefix("."))
    return None
