"""Reads TOML within a budget; the standard library's reader sets itself no bound."""

from __future__ import annotations

import re
import tomllib
from typing import Any, Final

from assistant.program.diagnostics import Unreadable, error
from assistant.program.system.budgets import READING, within

MOST_PARTS: Final = 100
"""Parts of a dotted key. No file here needs more than 4; what `tomllib` takes for a key grows with
the square of them."""

LONG_KEY: Final = error(
    "LM007",
    "a key has more than {most} parts with dots between them",
    "write a key of fewer parts",
)

_PART: Final = r"""(?:[A-Za-z0-9_-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""
_LONG_KEY_PATTERN: Final = re.compile(
    rf"(?:^|[{{,])[ \t]*+\[{{0,2}}+[ \t]*+{_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{MOST_PARTS}}}",
    re.MULTILINE,
)
"""Such a key at the begin of a line, of a table's name or of an entry of an inline table."""


def parse_toml(text: str, path: str | None = None) -> dict[str, Any]:
    """What a TOML text says.

    Raises ValueError and RecursionError as `tomllib` does, Unreadable for a key of too many parts
    and Refused for what takes more than its budget.
    """
    if found := _LONG_KEY_PATTERN.search(text):
        line = text.count("\n", 0, found.end()) + 1
        raise Unreadable(LONG_KEY(path=path, line=line, most=MOST_PARTS))
    with within(READING, path, len(text)):
        try:
            return tomllib.loads(text)
        except RecursionError as raised:
            deep = raised
    raise deep  # outside, as a stage has a finding of its own for it
