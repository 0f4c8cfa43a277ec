"""What a window is shown of a program that runs: its signals, calls and data."""

from __future__ import annotations

from typing import Any, Final

from assistant.studio.answering import plain_value
from assistant.virtual.kernel import Board, Signals, Task

MOST_VALUES: Final = 200
"""Data, or signals, that are shown at once."""
WIDEST_VALUE: Final = 200
"""Characters of a value that are shown."""


class WatchedInputs(dict[str, float]):
    """Inputs that nobody has set, as `Settings` has them. read: those that a program looked at."""

    def __init__(self, known: dict[str, float]) -> None:
        super().__init__(known)
        self.read: dict[str, None] = dict.fromkeys(known)

    def get(self, name: str, other: Any = 0.0) -> Any:
        self.read[name] = None
        return super().get(name, other)


def signal_records(board: Board) -> dict[str, Any]:
    """Inputs that were set or looked at, and outputs that were set, with what they are."""
    return {"inputs": _signal_rows(board.inputs), "outputs": _signal_rows(board.outputs)}


def _signal_rows(signals: Signals) -> list[dict[str, Any]]:
    source = signals.source
    looked_at = source.read if isinstance(source, WatchedInputs) else ()
    names = sorted({*signals.values, *looked_at}, key=_number_order)[:MOST_VALUES]
    return [{"name": name, "value": plain_value(signals.read(name))} for name in names]


def _number_order(name: str) -> tuple[int, str]:
    return (int(name), "") if name.isascii() and name.isdecimal() else (-1, name)


def data_records(task: Task) -> dict[str, Any]:
    """The calls that run, the innermost first, and the data that it knows."""
    levels = task.levels()
    stack = [
        {
            "name": level.name,
            "path": level.place and level.place[0],
            "line": level.place and level.place[1],
        }
        for level in levels[:MOST_VALUES]
    ]
    groups = levels[0].groups if levels else {}
    data = [
        {
            "title": title,
            "rows": [
                {"name": one.name, "type": one.type, "value": one.value[:WIDEST_VALUE]}
                for one in shown()[:MOST_VALUES]
            ],
        }
        for title, shown in groups.items()
    ]
    return {"stack": stack, "data": data}
