"""How settings come to differ with the way that leads to a move, in words."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, Final

from assistant.languages.melfa_basic.lift.settings.flow import Effect
from assistant.languages.melfa_basic.lift.settings.held import JOINT, TCP, UNKNOWN, Held, State
from assistant.languages.melfa_basic.lift.structure.blocks import Code
from assistant.languages.melfa_basic.lift.values.reasons import WAYS, text_of
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.program.motion import Blend
from assistant.program.statements import Reason
from assistant.program.text import SourceText

MOST_LINES: Final = 4
"""Lines that a reason names; the rest is counted."""


def _speed(value: float) -> str:
    return f"{value:g} mm/s" if value < float("inf") else "the robot's own"


def _blend(value: Blend) -> str:
    if value.radius is None:
        return "none"
    return f"{value.radius:g} mm" if value.radius < float("inf") else "the controller's own"


_SLOTS: Final[tuple[tuple[str, str, Callable[[Any], str]], ...]] = (
    ("speed", "Spd", _speed),
    ("speed of joint moves", "JOvrd", lambda value: f"{value:g} %"),
    ("corner", "Cnt", _blend),
    ("tool", "Tool", lambda value: f"`{value}`"),
    ("frame", "Base", lambda value: f"`{value}`"),
)


class UnknownSettings:
    """Tells why settings are not known. effect: the setting that a statement makes."""

    def __init__(self, code: Code, effect: Effect, dialect: str, source: SourceText | None) -> None:
        self.code, self.effect, self.dialect, self.source = code, effect, dialect, source

    def differing(self, node: s.Statement, state: State) -> Reason:
        """Why the settings of the first move in a statement are not known."""
        moves = [part for part in nodes(node) if isinstance(part, s.Motion)]
        spared = JOINT if not moves or moves[0].keyword != "Mov" else TCP
        for slot, held in enumerate(state):
            if held.value is UNKNOWN and slot != spared:
                return self._of_setting(slot, held)
        return WAYS

    def _of_setting(self, slot: int, held: Held) -> Reason:
        name, word, say = _SLOTS[slot]
        lines = sorted(held.by)
        computed = [line for line in lines if self.value(line) is UNKNOWN]
        if computed:
            return Reason(
                f"the {name} is worked out by the program, {self._list(computed)}",
                f"give {word} a plain value",
            )
        values = list(dict.fromkeys(say(self.value(line)) for line in lines))
        if not values:
            return Reason(
                f"the {name} is what the caller has set, or another program",
                f"set {word} above the move",
            )
        values += ["what was set before"] if len(values) == 1 else []
        return Reason(
            f"the {name} may be {' or '.join(values)} here, by {self._list(lines)}",
            f"set {word} where the ways meet, below the label or the end of the block",
        )

    def value(self, at: int) -> Any:
        """The value of the setting that a line makes, or that a branch in it does."""
        item = self.code[at]
        for part in nodes(item.statement) if isinstance(item, s.Line) else ():
            effect = self.effect(part) if isinstance(part, s.Command | s.Assign) else None
            if effect is not None:
                return effect[1]
        return UNKNOWN

    def _list(self, lines: Iterable[int]) -> str:
        given = [self.where(at) for at in lines]
        if len(given) > MOST_LINES:
            given = [*given[:MOST_LINES], f"{len(given) - MOST_LINES} more"]
        return " and ".join([", ".join(given[:-1]), given[-1]]) if len(given) > 1 else given[0]

    def where(self, at: int) -> str:
        """What a line is called in a finding."""
        item = self.code[at]
        if not isinstance(item, s.Line) or item.statement is None:
            return "a block of moves"
        text = f"`{text_of(item.statement, self.dialect)}`"
        if item.number is not None:
            return f"{item.number} {text}"
        if self.source is None or item.span is None:
            return text
        return f"{text} in line {self.source.line_column(item.span.start)[0]}"
