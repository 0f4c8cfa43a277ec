"""Names that somebody may have meant, by how they are spelled."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Final

LEAST_SIMILARITY: Final = 0.7
"""How alike names have to be, as `difflib` counts: one letter in three may differ."""
SHORTEST_PREFIX: Final = 3
"""Letters and digits of a beginning by which names are told."""
MOST_SUGGESTIONS: Final = 6
"""Names that are told."""


def near_names(given: str, known: Iterable[str]) -> tuple[str, ...]:
    """Those that begin as the given one does, else those that are spelled like it; the best first.

    Case, blanks and punctuation do not count: `IRB 4600` begins three arms.
    """
    plain: dict[str, list[str]] = {}
    for name in known:
        plain.setdefault(_letters_and_digits(name), []).append(name)
    wanted = _letters_and_digits(given)
    begun = [one for one in plain if len(wanted) >= SHORTEST_PREFIX and one.startswith(wanted)]
    close = begun or get_close_matches(wanted, plain, n=MOST_SUGGESTIONS, cutoff=LEAST_SIMILARITY)
    return tuple(name for one in close for name in plain[one])[:MOST_SUGGESTIONS]


def did_you_mean(given: str, known: Iterable[str], otherwise: str) -> str:
    """A cure: `did you mean ...?` where names are near, else what to do otherwise."""
    near = near_names(given, known)
    if not near:
        return otherwise
    return (
        f"did you mean {', '.join(near[:-1])} or {near[-1]}?"
        if len(near) > 1
        else (f"did you mean {near[0]}?")
    )


def _letters_and_digits(name: str) -> str:
    return "".join(c for c in name.casefold() if c.isalnum())
