"""What a window is shown of a program that runs: its signals, calls and data."""

from __future__ import annotations

from typing import Any, Final

from assistant.studio.answering import plain
from assistant.virtual.kernel import Board, Signals, Task

MOST_ROWS: Final = 200
"""Data, or signals, that are shown at once."""
WIDEST: Final = 200
"""Characters of a value that are shown."""


class Inputs(dict[str, float]):
    """Inputs that nobody has set, as `Settings` has them. read: those that a program looked at."""

    def __init__(self, known: dict[str, float]) -> None:
        super().__init__(known)
        self.read: dict[str, None] = dict.fromkeys(known)

    def get(self, name: str, other: Any = 0.0) -> Any:
        self.read[name] = None
        return super().get(name, other)


def shown_signals(board: Board) -> dict[str, Any]:
    """Inputs that were set or looked at, and outputs that were set, with what they are."""
    return {"inputs": _signals(board.inputs), "outputs": _signals(board.outputs)}


def _signals(signals: Signals) -> list[dict[str, Any]]:
    source = signals.source
    looked_at = source.read if isinstance(source, Inputs) else ()
    names = sorted({*signals.values, *looked_at}, key=_by_number)[:MOST_ROWS]
    return [{"name": name, "value": plain(signals.read(name))} for name in names]


def _by_number(name: str) -> tuple[int, str]:
    return (int(name), "") if name.isascii() and name.isdecimal() else (-1, name)


def shown_data(task: Task) -> dict[str, Any]:
    """The calls that run, the innermost first, and the data that it knows."""
    levels = task.levels()
    stack = [
        {
            "name": level.name,
            "path": level.place and level.place[0],
            "line": level.place and level.place[1],
        }
        for level in levels[:MOST_ROWS]
    ]
    groups = levels[0].groups if levels else {}
    data = [
        {
            "title": title,
            "rows": [
                {"name": one.name, "type": one.type, "value": one.value[:WIDEST]}
                for one in shown()[:MOST_ROWS]
            ],
        }
        for title, shown in groups.items()
    ]
    return {"stack": stack, "data": data}
