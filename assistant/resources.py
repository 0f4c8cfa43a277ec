"""Grammars, templates and samples: inside the package when installed, beside it in a checkout."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path


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
