"""The templates of generated source, and how numbers and words are written into it."""

from __future__ import annotations

import keyword
import math
import re
import sys
from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING, Final

from assistant.resources import resource

if TYPE_CHECKING:
    from jinja2 import Environment

LONGEST_NAME: Final = 40
"""Characters of a name that a file of the user's gives to what is generated."""
LONGEST_WORDS: Final = 120
"""Characters of what such a file says that stand in a comment."""


@cache
def template_environment() -> Environment:
    """Templates of our own, which are named by their places below `templates/`."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    def text(name: str) -> str:
        return resource("templates", name).read_text(encoding="utf-8")

    return Environment(  # noqa: S701 - C, Python and XML: each value is written by a function here
        loader=FunctionLoader(text),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def number_literal(value: float) -> str:
    """A finite float as C, Python and XML read it, to the last digit."""
    if not math.isfinite(value):
        raise ValueError(f"{value} is no number of a source")
    return repr(float(value) + 0.0)


def number_literals(values: Iterable[float]) -> tuple[str, ...]:
    """Each of them by `number`."""
    return tuple(number_literal(value) for value in values)


def safe_text(text: str) -> str:
    """Text of the user's for a comment or a string: nothing in it can end one or begin another."""
    plain = "".join(c if c.isascii() and (c.isalnum() or c in " -_.,()/+") else " " for c in text)
    return re.sub(r"/+", "/", " ".join(plain.split()))[:LONGEST_WORDS].strip() or "an arm"


def source_identifier(text: str) -> str:
    """Text of the user's as the name of a module and the beginning of names: `rv_2aj`."""
    plain = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")[:LONGEST_NAME].strip("_")
    if not plain or not plain[0].isalpha():
        plain = f"arm_{plain}".strip("_")
    if keyword.iskeyword(plain) or plain in sys.stdlib_module_names or plain in _RESERVED_NAMES:
        plain += "_arm"
    return plain


_RESERVED_NAMES: Final = frozenset(
    {"con", "prn", "aux", "nul", "std"}
    | {f"{port}{number}" for port in ("com", "lpt") for number in range(1, 10)}
)
"""Names of devices, which no file of Windows may have."""
