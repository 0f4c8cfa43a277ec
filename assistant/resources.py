"""Grammars, templates and samples: inside the package when installed, beside it in a checkout."""

from __future__ import annotations

import sys
from importlib.resources import files
from importlib.resources.abc import Traversable
from importlib.util import cache_from_source
from pathlib import Path


def resource(folder: str, name: str) -> Traversable:
    """Return a file of `grammars`, `templates` or `samples`; raises FileNotFoundError if it is
    missing.
    """
    inside = files("assistant").joinpath(folder, name)
    beside = Path(__file__).resolve().parent.parent / folder / name
    for found in (inside, beside):
        if found.is_file():
            return found
    raise FileNotFoundError(f"{folder}/{name} is missing from the installation")


def read_grammar(name: str) -> str:
    """The text of a lark grammar."""
    return resource("grammars", name).read_text(encoding="utf-8")


def kept_place(name: str, suffix: str) -> Path | None:
    """The file for what is worked out of a grammar, where the bytecode of a module would be.

    None where nothing can be kept.
    """
    source = resource("grammars", name)
    if not isinstance(source, Path) or sys.dont_write_bytecode:
        return None
    try:
        kept = Path(cache_from_source(str(source))).with_suffix(suffix)
        kept.parent.mkdir(parents=True, exist_ok=True)
    except (NotImplementedError, OSError):
        return None
    return kept
