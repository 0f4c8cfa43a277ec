"""The timers of a program: what its statements start and read; nothing declares them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.contents import statements_with, statements_with_vendor_text
from assistant.program.program import Program


def timers(program: Program) -> tuple[str, ...]:
    """Names as they are spelled first, in order of the text."""
    found: dict[str, str] = {}
    for _, parts in statements_with(program, *_TIMER_RECORDS):
        for name in sorted(part.timer for part in parts if isinstance(part, _TIMER_RECORDS)):
            found.setdefault(name.lower(), name)
    return tuple(found.values())


def numbered_timers(
    program: Program, numbers: Sequence[int], kept: re.Pattern[str]
) -> tuple[dict[str, int], int]:
    """A number for each timer by lower-case name, and one that no timer has, 0 if there is none.

    A timer whose name says its number keeps it; of the others the first number is given last.
    Timers beyond the numbers have none. kept: finds the number of a timer in kept text.
    """
    texts = [declaration.text for declaration in program.declarations]
    texts += [part.text for _, parts in statements_with_vendor_text(program) for part in parts]
    taken = {int(n) for text in texts for n in kept.findall(text)}
    wanted = [name.lower() for name in timers(program)]
    said = ((name, _NUMBERED_TIMER.fullmatch(name)) for name in wanted)
    given = {name: int(match[1]) for name, match in said if match and int(match[1]) in numbers}
    taken.update(given.values())
    free = [n for n in (*numbers[1:], numbers[0]) if n not in taken]
    left = [name for name in wanted if name not in given]
    given.update(zip(left, free, strict=False))
    taken.update(given.values())
    return given, next((n for n in numbers if n not in taken), 0)


def timer_in_seconds(
    operator: str, left: e.Expression, right: e.Expression, parts: int
) -> e.Binary | e.Elapsed:
    """An operation; a timer that counts parts of seconds becomes seconds beside a number.

    parts: of a second. What counts them is `Elapsed` multiplied by their number.
    """
    unit = e.Number(parts)
    match left, right:
        case e.Binary("*", e.Elapsed() as timer, factor), e.Number(value) if factor == unit:
            if operator == "/" and value == parts:
                return timer
            if operator in e.RELATIONS:
                right, left = e.number_of(value / parts), timer
        case e.Number(value), e.Binary("*", e.Elapsed() as timer, factor) if factor == unit:
            if operator in e.RELATIONS:
                left, right = e.number_of(value / parts), timer
    return e.Binary(operator, left, right)  # type: ignore[arg-type]


_NUMBERED_TIMER: Final = re.compile(r"timer_(0|[1-9][0-9]{0,3})")
_TIMER_RECORDS: Final = (p.StartTimer, e.Elapsed)
