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

Measure = Callable[[Any], tuple[str | None, int]]
"""The place and the size of an input: of a text, a tree, some trees, or a program."""


def of_text(text: SourceText | str) -> tuple[str | None, int]:
    return (None, len(text)) if isinstance(text, str) else (text.path, len(text.text))


def of_trees(trees: Any) -> tuple[str | None, int]:
    """Of the texts that they were read from; a tree that was built has none."""
    listed = trees if isinstance(trees, Sequence) else (trees,)
    texts = [tree.source for tree in listed if tree.source is not None]
    return texts[0].path if texts else None, sum(len(text.text) for text in texts)


def of_program(program: Program) -> tuple[str | None, int]:
    return None, program.size()


BUDGETED: Final[dict[str, tuple[Stage, Measure]]] = {
    "parse": (READING, of_text),
    "check": (CHECKING, of_trees),
    "lift_trees": (LIFTING, of_trees),
    "format": (LAYING_OUT, of_trees),
    "renumber": (LAYING_OUT, of_trees),
    "convert": (ADAPTING, of_program),
    "exported": (ADAPTING, of_program),
    "adapt": (ADAPTING, of_program),
    "build": (BUILDING, of_program),
}
"""Methods of a language → the stage that they are, and how their first argument is measured."""


def budgeted(methods: dict[str, Any]) -> dict[str, Callable[..., Any]]:
    """Those of the methods that are stages, within their budgets."""
    return {
        name: _within(methods[name], stage, measure)
        for name, (stage, measure) in BUDGETED.items()
        if name in methods and not getattr(methods[name], "__isabstractmethod__", False)
    }


def _within(method: Callable[..., Any], stage: Stage, measure: Measure) -> Callable[..., Any]:
    @wraps(method)
    def run(self: Any, first: Any, *rest: Any, **named: Any) -> Any:
        place, size = measure(first)
        with within(stage, place, size):
            return method(self, first, *rest, **named)

    return run
