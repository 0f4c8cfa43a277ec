"""What every language does, within the budget of its stage; no language has to think of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from typing import TYPE_CHECKING, Any, Final

from assistant.base.budgets import (
    ADAPTING,
    BUILDING,
    CHECKING,
    LAYING_OUT,
    LIFTING,
    READING,
    Stage,
    within,
)
from assistant.base.source_text import SourceText

if TYPE_CHECKING:
    from assistant.program.program import Program

SizeMeasure = Callable[[Any], tuple[str | None, int]]
"""The place and the size of an input: of a text, a tree, some trees, or a program."""


def text_size(text: SourceText | str) -> tuple[str | None, int]:
    return (None, len(text)) if isinstance(text, str) else (text.path, len(text.text))


def trees_size(trees: Any) -> tuple[str | None, int]:
    """Of the texts that they were read from; a tree that was built has none."""
    listed = trees if isinstance(trees, Sequence) else (trees,)
    texts = [tree.source for tree in listed if tree.source is not None]
    return texts[0].path if texts else None, sum(len(text.text) for text in texts)


def program_size(program: Program) -> tuple[str | None, int]:
    return None, program.size()


BUDGETED: Final[dict[str, tuple[Stage, SizeMeasure]]] = {
    "parse": (READING, text_size),
    "check": (CHECKING, trees_size),
    "lift_trees": (LIFTING, trees_size),
    "format": (LAYING_OUT, trees_size),
    "renumber": (LAYING_OUT, trees_size),
    "convert": (ADAPTING, program_size),
    "exported": (ADAPTING, program_size),
    "adapt": (ADAPTING, program_size),
    "build": (BUILDING, program_size),
}
"""Methods of a language → the stage that they are, and how their first argument is measured."""


def budgeted(methods: dict[str, Any]) -> dict[str, Callable[..., Any]]:
    """Those of the methods that are stages, within their budgets."""
    return {
        name: _with_budget(methods[name], stage, measure)
        for name, (stage, measure) in BUDGETED.items()
        if name in methods and not getattr(methods[name], "__isabstractmethod__", False)
    }


def _with_budget(
    method: Callable[..., Any], stage: Stage, measure: SizeMeasure
) -> Callable[..., Any]:
    @wraps(method)
    def run(self: Any, first: Any, *rest: Any, **named: Any) -> Any:
        place, size = measure(first)
        with within(stage, place, size):
            return method(self, first, *rest, **named)

    return run
