"""Functions that a program calls and that stand in no file, as the cell has them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

from assistant.base.source_text import SourceText
from assistant.languages.melfa_basic.reading.parser import parse
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.undeclared_names import ROUTINES, SuppliedValue, Wanted

_RESULT_TYPES: Final = {"num": ("M", "0"), "string": ("C", '""'), "": ("V", "")}
"""By the type of what a function gives: its letter, and what it gives until it is written."""
FUNCTION_END: Final = s.Command("FEnd")
_TYPE_LETTERS: Final = {"num": "M", "string": "C", "position": "P", "joints": "J"}


def with_supplied_functions(
    tree: s.File,
    wanted: Sequence[tuple[Wanted, SuppliedValue | None]],
    trees: Sequence[s.File],
    dialect: str,
) -> s.File:
    """The tree with functions below its code: those of the cell's files, stops, or empty ones."""
    made: list[s.Item] = []
    for one, value in wanted:
        found = () if value in ROUTINES else _function_of_files(one.name, trees)
        made += found or parse(SourceText(_function_text(one, value)), dialect).items
    code = [at for at, item in enumerate(tree.items) if isinstance(item, s.Entry)]
    ends = [at for at in code if getattr(tree.items[at], "statement", None) == FUNCTION_END]
    below = (ends or code or [-1])[-1] + 1
    bare = (replace(item, number=None, span=None) for item in made if isinstance(item, s.Line))
    return replace(tree, items=(*tree.items[:below], *bare, *tree.items[below:]))


def _function_text(wanted: Wanted, value: SuppliedValue | None) -> str:
    letter, nothing = _RESULT_TYPES.get(wanted.type, ("M", "0"))
    given = ",".join(
        f"ByVal {_TYPE_LETTERS.get(one.type, 'M')}G{number}"
        for number, one in enumerate(wanted.arguments, 1)
    )
    lines = [f"Function {letter} {wanted.name}({given})"]
    lines += [] if value == "empty" else ["Hlt"]
    lines += [f"{wanted.name}={nothing}"] if nothing else []
    return "\n".join((*lines, "FEnd")) + "\n"


def _function_of_files(name: str, trees: Sequence[s.File]) -> tuple[s.Item, ...]:
    """The lines of a function that a file has."""
    for tree in trees:
        lines = tuple(_function_lines(name.upper(), tree))
        if lines:
            return lines
    return ()


def _function_lines(key: str, tree: s.File) -> Iterator[s.Line]:
    inside = False
    for item in tree.code:
        if not isinstance(item, s.Line):
            continue
        if isinstance(item.statement, s.Function):
            inside = item.statement.name.upper() == key
        if inside:
            yield item
        if item.statement == FUNCTION_END:
            inside = False
