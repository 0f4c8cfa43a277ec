"""Names that are spelled like another one, for cures that suggest them."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Final

_LEAST_SIMILARITY: Final = 0.7
"""Least similarity of two names, as `difflib` counts it: one letter in three may differ."""
_SHORTEST_PREFIX: Final = 3
"""Fewest letters and digits by which names with that beginning are suggested."""
_MOST_SUGGESTIONS: Final = 6
"""Most names that are suggested."""


def near_name(word: str, names: Iterable[str]) -> str | None:
    """Return the name that is spelled most like a word, without case; None if none is near."""
    return next(iter(spelled_like(word, names, 1)), None)


def spelled_like(
    word: str, names: Iterable[str], most: int, least: float = _LEAST_SIMILARITY
) -> list[str]:
    """Return the names that are spelled like a word, without case; the best first.

    most: number of names. least: their similarity, see `difflib.SequenceMatcher.ratio`.
    """
    plain: Final = {name.casefold(): name for name in names}
    return [plain[one] for one in get_close_matches(word.casefold(), plain, n=most, cutoff=least)]


def near_names(given: str, known: Iterable[str]) -> tuple[str, ...]:
    """Return the names that begin with the given one, else those that are spelled like it.

    Case, blanks and punctuation do not count: `IRB 4600` begins three arms.
    """
    plain: dict[str, list[str]] = {}
    for name in known:
        plain.setdefault(_letters_and_digits(name), []).append(name)
    wanted = _letters_and_digits(given)
    begun = [one for one in plain if len(wanted) >= _SHORTEST_PREFIX and one.startswith(wanted)]
    close = begun or spelled_like(wanted, plain, _MOST_SUGGESTIONS)
    return tuple(name for one in close for name in plain[one])[:_MOST_SUGGESTIONS]


def did_you_mean(given: str, known: Iterable[str], otherwise: str) -> str:
    """A cure: `did you mean ...?` where names are near, else what to do otherwise."""
    near = near_names(given, known)
    if not near:
        return otherwise
    *others, last = near
    return f"did you mean {', '.join(others)} or {last}?" if others else f"did you mean {last}?"


def _letters_and_digits(name: str) -> str:
    return "".join(c for c in name.casefold() if c.isalnum())
