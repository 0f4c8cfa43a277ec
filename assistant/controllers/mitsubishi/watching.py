"""Looking at a CR controller again and again; needs no operation right and changes nothing."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator, Sequence
from typing import Final

from assistant.controllers.mitsubishi import signals as numbered
from assistant.controllers.mitsubishi import values
from assistant.controllers.mitsubishi.position import position
from assistant.controllers.mitsubishi.session import Session
from assistant.controllers.mitsubishi.state import controller_state
from assistant.controllers.states import Sample

SIGNAL_NAME: Final = re.compile(r"(?:(in|out|m_in|m_out)[: (]?)?(\d{1,5})\)?", re.IGNORECASE)
ALL_SLOTS: Final = 20
"""Looks after which all slots are asked; else those that had a program."""


def watch(session: Session, interval: float, signals: Sequence[str]) -> Iterator[Sample]:
    """A sample each `interval` seconds, later ones where the controller answers slower.

    signals: `in:5`, `out:900`, or a number alone for an input.
    """
    wanted = {name: _parse_signal(name) for name in signals}
    began = time.monotonic()
    count = 0
    slots: Sequence[int] | None = None
    while True:
        seconds = time.monotonic() - began
        told = controller_state(session, slots if count % ALL_SLOTS else None)
        slots = [int(task.name) for task in told.tasks]
        yield Sample(seconds, told, position(session), _signal_values(session, wanted))
        count += 1
        late = time.monotonic() - began - seconds
        time.sleep(max(0.0, interval - late))


def _parse_signal(name: str) -> tuple[bool, str]:
    """Whether it is an output, and its number."""
    found = SIGNAL_NAME.fullmatch(name)
    if found is None:
        raise values.bad_value(name, "a signal", "it names none", "`in:5`, `out:900` or `5`")
    numbered.number_of(found[2])
    return (found[1] or "in").lower().endswith("out"), found[2]


def _signal_values(session: Session, wanted: dict[str, tuple[bool, str]]) -> dict[str, float]:
    found: dict[str, float] = {}
    for is_output, read in ((False, numbered.inputs), (True, numbered.outputs)):
        names = {name: number for name, (out, number) in wanted.items() if out is is_output}
        if names:
            told = read(session, list(names.values()))
            found |= {name: told[number] for name, number in names.items()}
    return {name: found[name] for name in wanted}
