"""The kinds of valid programs, each with what draws one."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from random import Random
from typing import Final

from tests.fuzz.valid import melfa, pseudo, rapid

GENERATORS: Final[dict[str, Callable[[Random], tuple[str, set[str]]]]] = {
    "pseudo": pseudo.program,
    "rapid": rapid.program,
    **{f"melfa-basic-{level}": partial(melfa.program, level) for level in (4, 5, 6)},
}
