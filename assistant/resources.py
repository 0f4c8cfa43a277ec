"""Grammars, templates and samples: inside the package when installed, beside it in a checkout."""

from __future__ import annotations

import sys
from importlib.resources import files
from importlib.resources.abc import Traversable
from importlib.util import cache_from_source
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lark import Lark


def resource(folder: str, name: str) -> Traversable:
    """A file of `grammars`, `templates` or `samples`; raises FileNotFoundError if there is none."""
    inside = files("assistant").joinpath(folder, name)
    beside = Path(__file__).resolve().parent.parent / folder / name
    for found in (inside, beside):
        if found.is_file():
            return found
    raise FileNotFoundError(f"{folder}/{name} is missing from the installation")


def read_grammar(name: str) -> str:
    """The text of a lark grammar."""
    return resource("grammars", name).read_text(encoding="utf-8")


def load_grammar(name: str, **options: Any) -> Lark:
    """The LALR parser of a grammar, its tables kept as Python keeps the bytecode of a module.

    Working the tables out takes most of the time in which a small program is checked. They go
    where bytecode goes, since who can write there can change the program as well; lark holds
    them against the grammar, the options, its own version and Python's. options: as of
    `lark.Lark`; `edit_terminals` is not among what is compared.
    """
    from lark import Lark

    return Lark(read_grammar(name), parser="lalr", cache=_kept_tables(name), **options)


def _kept_tables(name: str) -> str | bool:
    """The file for the tables of a grammar, False where none can be kept."""
    source = resource("grammars", name)
    if not isinstance(source, Path) or sys.dont_write_bytecode:
        return False
    try:
        kept = Path(cache_from_source(str(source))).with_suffix(".lalr")
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.open("ab").close()  # lark only logs that it cannot write
    except (NotImplementedError, OSError):
        return False
    return str(kept)
