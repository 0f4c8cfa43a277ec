"""Whether pictures in folders of several cameras are of the same moments, by their names."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import PurePath

import numpy as np

from assistant.base.arrays import Rows
from assistant.base.diagnostics import Diagnostic
from assistant.vision.cameras import rules


def pairing_finding(
    one: str, names: Sequence[str], other: str, others: Sequence[str]
) -> Diagnostic | None:
    """What keeps pictures of two cameras from being paired in their order, None if nothing does.

    one, other: of the cameras. names, others: of their files, in their order. The last number in
    each name counts pictures if most of them follow each other by one: then a number that one
    camera has and the other lacks is a picture that is missing. Each may count from where it
    likes, and one of them may go on for longer.
    """
    counted = _picture_numbers(names), _picture_numbers(others)
    if counted[0] is None or counted[1] is None:
        count, more = len(names), len(others)
        if count == more:
            return None
        return rules.UNEVEN_PICTURES(one=one, count=count, other=other, others=more)
    both = min(len(names), len(others))
    apart = np.flatnonzero(counted[0][:both] != counted[1][:both])
    if not len(apart):
        return None
    at = int(apart[0])
    return rules.PICTURES_OUT_OF_STEP(one=one, other=other, first=names[at], second=others[at])


def _picture_numbers(names: Sequence[str]) -> Rows | None:
    """(n,) numbers of pictures from the first on, None if the names do not count."""
    found = [re.findall(r"\d{1,15}", PurePath(name).stem) for name in names]
    if not names or not all(found):
        return None
    numbers = np.array([int(one[-1]) for one in found])
    if len(numbers) > 1 and np.median(np.diff(numbers)) != 1.0:
        return None
    return np.asarray(numbers - numbers[0])
