"""What two controllers may work out differently: halves that are rounded, remainders below 0."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant.compiler.project import configured
from assistant.languages.answers import (
    ARITHMETIC,
)
from assistant.program import expressions as e
from assistant.program.contents import saying
from assistant.program.diagnostics import Diagnostic, error, warning
from assistant.program.program import Procedure, Program
from assistant.program.wholes import Numbers

if TYPE_CHECKING:
    from assistant.languages import Language

UNCONFIRMED: Final = warning(
    "CO105",
    "{what}: {way} is assumed of both controllers, but no manual confirms it",
    "try it on both, and state `{key}` in the tables [{one}] and [{other}] of assistant.toml",
)
DIFFERENT: Final = error(
    "CO106",
    "{what}: `{key}` is {first} in [{one}] and {second} in [{other}]",
    "keep the value from being {avoided}, or correct what assistant.toml states",
)
WHAT: Final = {
    "halves": ("a number that may end in .5 is rounded", "a half"),
    "remainder": ("a division of whole numbers that may be negative", "negative"),
}
WAYS: Final = {
    "away": "away from zero",
    "even": "to the even number",
    "up": "up",
    "dividend": "with a remainder of the dividend's sign",
    "divisor": "with a remainder of the divisor's sign",
}


def differences(
    program: Program, source: Language[Any], target: Language[Any]
) -> Iterator[Diagnostic]:
    """Findings on what a lifted program works out, where the language of it and another differ.

    Raises Unreadable or Refused if the project's file is broken.
    """
    if source.family == target.family or program.origin is None:
        return
    texts = [tree.source for tree in program.origin.trees if tree.source is not None]
    path = next((text.path for text in texts if text.path), None)
    folder = FilePath(path or "").absolute().parent
    one, other = configured(source, folder).stated, configured(target, folder).stated
    for key, span in _met(program):
        what, avoided = WHAT[key]
        usual = ARITHMETIC[key].words[0]
        first, second = one.get(key, usual), other.get(key, usual)
        tables: dict[str, Any] = {"key": key, "one": source.table, "other": target.table}
        if first != second:
            yield DIFFERENT(
                **tables, what=what, first=first, second=second, avoided=avoided, span=span
            )
        elif key not in one or key not in other:
            yield UNCONFIRMED(**tables, what=what, way=WAYS[first], span=span)


def _met(program: Program) -> Iterator[tuple[str, Any]]:
    """What matters in each statement, with its span."""
    numbers: Numbers | None = None
    for procedure in program.procedures:
        for statement, parts in saying(procedure, e.Binary, e.Apply):
            asked = [part for part in parts if _asks(part)]
            if not asked:
                continue
            numbers = numbers or Numbers(program)
            for key in dict.fromkeys(_key(part, procedure, numbers) for part in asked):
                if key is not None:
                    yield key, statement.span


def _asks(part: Any) -> bool:
    return getattr(part, "operator", None) in ("div", "mod") or (
        isinstance(part, e.Apply) and part.function == "round"
    )


def _key(part: Any, procedure: Procedure, numbers: Numbers) -> str | None:
    """What of ARITHMETIC a division or rounding depends on, None if its operands rule it out."""
    match part:
        case e.Apply("round", (value,)):
            return None if numbers.of(value, procedure).whole else "halves"
        case e.Binary(_, left, right):
            known = numbers.of(left, procedure).positive, numbers.of(right, procedure).positive
            return None if all(known) else "remainder"
    return None
