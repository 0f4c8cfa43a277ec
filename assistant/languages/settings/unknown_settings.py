"""How settings come to differ with the way that leads to a move, in words."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final

from assistant.languages.settings.flow import UNKNOWN, Held, LineEffects, State, sets_in
from assistant.languages.settings.places import ELSEWHERE
from assistant.program.expressions import Reason

MOST_NAMED_LINES: Final = 4
"""Lines that a reason names; the rest is counted."""


@dataclass(frozen=True, slots=True)
class SettingText:
    """name: in a sentence. word: what sets it. say: its values in words."""

    name: str
    word: str
    say: Callable[[Any], str]


class UnknownSettings:
    """Tells why settings are not known.

    settings: by their numbers. where: what a line is called.
    """

    def __init__(
        self, lines: LineEffects, settings: Sequence[SettingText], where: Callable[[int], str]
    ) -> None:
        self._lines, self._settings, self._where = lines, settings, where

    def reason(self, state: State, used: Iterable[int]) -> Reason | None:
        """Why the first unknown one of those that are used is not known; None if all are."""
        for number in sorted(used):
            if state[number].value is UNKNOWN:
                return self._of_setting(number, state[number])
        return None

    def _of_setting(self, number: int, held: Held) -> Reason:
        name, word = self._settings[number].name, self._settings[number].word
        if held.interrupts:
            own = [at for at in held.interrupts if at != ELSEWHERE]
            by = f"by {self._list(own)}" if own else "in another program"
            return Reason(
                f"an interrupt may set the {name} at any time, {by}",
                f"leave {word} out of what the interrupt calls, or switch the interrupt off and "
                f"set {word} above the move",
            )
        lines = list(held.by)
        made = {at: self._value(number, at) for at in lines}
        computed = [at for at, value in made.items() if value is UNKNOWN]
        if computed:
            return Reason(
                f"the {name} is worked out by the program, {self._list(computed)}",
                f"give {word} a plain value",
            )
        values = list(dict.fromkeys(map(self._settings[number].say, made.values())))
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

    def _value(self, number: int, at: int) -> Any:
        """What a line gives a setting."""
        made = (one.value for one in sets_in(self._lines.steps[at]) if one.setting == number)
        return next(made, UNKNOWN)

    def _list(self, lines: Sequence[int]) -> str:
        given = [self._where(at) for at in lines]
        if len(given) > MOST_NAMED_LINES:
            given = [*given[:MOST_NAMED_LINES], f"{len(given) - MOST_NAMED_LINES} more"]
        return " and ".join([", ".join(given[:-1]), given[-1]]) if len(given) > 1 else given[0]
