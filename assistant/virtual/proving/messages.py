"""Bytes that the other ends of sockets may say to programs that take bytes."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Sequence
from typing import Final

MESSAGE_WORDS: Final = 20
"""Numbers in a message; what most protocols of arms send has fewer."""
MOST_MESSAGES: Final = 60
SAID_WORD: Final = 60
"""Texts that come over a line in a run."""
_BYTES: Final = re.compile(r"\brawbytes\b", re.IGNORECASE)
_HIGHEST_FIRST: Final = re.compile(r"\\\s*Network\b", re.IGNORECASE)
_WHOLE: Final = re.compile(r"(?<![\w.#])[0-9]{1,4}(?![\w.])")


def likely_messages(text: str) -> tuple[str, ...]:
    """Messages for a program: how long one is, and words that are all one number of its text.

    A program goes on where it knows the kind of a message by its number; what it does not know may
    end it. Most numbers have four bytes, with the lowest first unless the text says otherwise.
    Characters stand for the bytes.
    """
    if _BYTES.search(text) is None:
        return ()
    numbers = dict.fromkeys(int(one) for one in _WHOLE.findall(text))
    orders = "><" if _HIGHEST_FIRST.search(text) else "<"
    return tuple(_built_message(list(numbers), orders))


def _built_message(numbers: list[int], orders: str) -> Iterator[str]:
    for number in sorted(numbers, reverse=True)[:MOST_MESSAGES]:
        for order in orders:
            words = struct.pack(f"{order}{MESSAGE_WORDS}I", *[number] * MESSAGE_WORDS)
            yield (struct.pack(f"{order}I", len(words)) + words).decode("latin-1")


def sent_words(run: int, known: Sequence[str], texts: Sequence[str]) -> tuple[str, ...]:
    """What the other ends of lines say in a run, by its number: a message of those that are known.

    Else numbers first, which any variable takes, and in the runs behind that also texts that the
    first program has, in turn.
    """
    if known:
        return (known[run % len(known)],)
    place = run % len(texts)
    first = [*texts[place:], *texts] if place else ["1", "2", "3"]
    return tuple(first[i % len(first)] for i in range(SAID_WORD))
