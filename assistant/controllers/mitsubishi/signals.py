"""Inputs, outputs and hands of a CR controller; signals have numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.mitsubishi import values
from assistant.controllers.mitsubishi.answers import BARE_ANSWER
from assistant.controllers.mitsubishi.session import Session

SIGNAL_WORD: Final = re.compile(r"[0-9A-F]{4}", re.IGNORECASE)
WORD_BITS: Final = 16
LAST_SIGNAL: Final = 32767
HANDS: Final = range(1, 9)
HAND_OPEN, HAND_CLOSED = 1, 2


def inputs(session: Session, names: Sequence[str]) -> dict[str, float]:
    return _read_signals(session, "IN", names)


def outputs(session: Session, names: Sequence[str]) -> dict[str, float]:
    return _read_signals(session, "OUT", names)


def _read_signals(session: Session, command: str, names: Sequence[str]) -> dict[str, float]:
    """The signals by their names; one command reads 16 from the number that it states."""
    numbers = {name: number_of(name) for name in names}
    bits: dict[int, float] = {}
    for number in sorted(set(numbers.values())):
        if number not in bits:
            doing = f"reading {'inputs' if command == 'IN' else 'outputs'} from {number}"
            word = int(session.ask(f"{command}{number}", doing=doing, shape=SIGNAL_WORD).text, 16)
            bits |= {number + bit: float(word >> bit & 1) for bit in range(WORD_BITS)}
    return {name: bits[number] for name, number in numbers.items()}


def set_output(session: Session, name: str, value: float) -> None:
    """Switches one output, by the statement of the language; others stay as they are.

    OUT= of the link writes 16 outputs at once, and would undo what a program does to the
    other 15 in the meantime.
    """
    number = number_of(name)
    if value not in (0, 1):
        raise values.bad_value(f"{value:g}", "an output", "it is on or off", "0 or 1")
    doing = f"switching output {number}"
    with session.right(doing):
        session.ask(f"EXECM_OUT({number})={value:.0f}", doing=doing, shape=BARE_ANSWER)
    back = values.read_until_settled(
        lambda: outputs(session, [name])[name], lambda now: now == value
    )
    if back != value:
        raise Refused(
            rules.NOT_TAKEN(
                place=name, what=f"output {number}", sent=f"{value:g}", back=f"{back:g}"
            )
        )


def hand(session: Session, number: int, *, is_open: bool) -> None:
    """Opens or closes a hand; raises Refused if there is none of that number."""
    doing = f"{'opening' if is_open else 'closing'} hand {number}"
    there = _hand_states(session)
    if number not in HANDS or (there is not None and there.get(number) is None):
        raise values.bad_value(
            number, "a hand", "the controller has none of that number", "the number of a hand"
        )
    session.ask(f"HND{'ON' if is_open else 'OFF'}{number}", doing=doing, shape=BARE_ANSWER)
    told = _hand_states(session)
    if told is not None and told.get(number) != (HAND_OPEN if is_open else HAND_CLOSED):
        words = {HAND_OPEN: "open", HAND_CLOSED: "closed"}
        raise Refused(
            rules.NOT_TAKEN(
                place=str(session.address),
                what=f"hand {number}",
                sent="open" if is_open else "closed",
                back=words.get(told.get(number) or 0, "something else"),
            )
        )


def _hand_states(session: Session) -> dict[int, int | None] | None:
    """1 open or 2 closed by the number of a hand, None for no hand; None if it is not told."""
    answer = session.attempt("HNDSTS", doing="asking for the hands")
    fields = answer.text.strip("; ").split(";")
    if not answer.ok or len(fields) % 3 or not all(re.fullmatch(r"-?\d+", f) for f in fields):
        return None
    states = [int(field) for field in fields]
    return {
        n: None if states[at] < 0 else states[at + 1]
        for n, at in enumerate(range(0, len(states), 3), 1)
    }


def number_of(name: str) -> int:
    """The number of a signal; raises Refused."""
    if re.fullmatch(r"\d{1,5}", name, re.ASCII) and int(name) <= LAST_SIGNAL:
        return int(name)
    raise values.bad_value(
        name, "a signal", "signals of this controller have numbers", f"0 to {LAST_SIGNAL}"
    )
