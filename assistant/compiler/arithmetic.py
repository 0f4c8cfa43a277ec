"""Results that the controllers of two languages may compute differently.

Halves that are rounded, remainders below 0, and sums of small steps.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.diagnostics import Diagnostic, error, warning
from assistant.compiler.loader import with_project_settings
from assistant.languages.language_types import ARITHMETIC
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.integer_inference import NumberFacts
from assistant.program.program import Procedure, Program
from assistant.program.statement_index import statements_with

if TYPE_CHECKING:
    from assistant.languages import Language


_ARITHMETIC_ASSUMED: Final = warning(
    "CO105",
    "{what}: {way} is assumed of both controllers, but no manual confirms it",
    "try it on both, and state `{key}` in the tables [{one}] and [{other}] of assistant.toml",
)
_ARITHMETIC_DIFFERENT: Final = error(
    "CO106",
    "{what}: `{key}` is {first} in [{one}] and {second} in [{other}]",
    "keep the value from being {avoided}, or correct what assistant.toml states",
)
_INEXACT_STEPS: Final = warning(
    "CO117",
    "`{name}` counts in steps of {step}, which add up with rounding errors: {bound} is met by one "
    "controller and may be missed by the other",
    "count in whole numbers and multiply by {step}, or compare with a value between two steps",
)
_NEAR_STEP_PART: Final = 1e-3
"""Parts of a step by which a bound may be off a multiple of it and still be met."""
_OPERATION_WORDS: Final = {
    "halves": ("a number that may end in .5 is rounded", "a half"),
    "remainder": ("a division of whole numbers that may be negative", "negative"),
}
_RESULT_WORDS: Final = {
    "away": "away from zero",
    "even": "to the even number",
    "up": "up",
    "dividend": "with a remainder of the dividend's sign",
    "divisor": "with a remainder of the divisor's sign",
}


def arithmetic_findings(
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
    one, other = (
        with_project_settings(source, folder).stated,
        with_project_settings(target, folder).stated,
    )
    for key, span in _operations_used(program):
        what, avoided = _OPERATION_WORDS[key]
        usual = ARITHMETIC[key].words[0]
        first, second = one.get(key, usual), other.get(key, usual)
        tables: dict[str, Any] = {"key": key, "one": source.table, "other": target.table}
        if first != second:
            yield _ARITHMETIC_DIFFERENT(
                **tables, what=what, first=first, second=second, avoided=avoided, span=span
            )
        elif key not in one or key not in other:
            yield _ARITHMETIC_ASSUMED(**tables, what=what, way=_RESULT_WORDS[first], span=span)
    yield from _inexact_steps(program)


def _inexact_steps(program: Program) -> Iterator[Diagnostic]:
    """Findings on loops and comparisons that end where a sum of inexact steps meets a bound."""
    steps: dict[str, float] = {}
    bounds: list[tuple[str, float | None, Any]] = []
    constants = {
        name.lower(): variable.initial
        for name, variable in program.variables.items()
        if variable.storage == "constant"
    }

    def number(value: e.Expression | None) -> float | None:
        match value:
            case e.Name(name):
                return number(constants.get(name.lower()))
            case e.Binary("*", angle, e.Number(e.DEGREE)):
                degrees = number(angle)
                return None if degrees is None else degrees * e.DEGREE
        return float(value.value) if isinstance(value, e.Number) else None

    def bound(counted: e.Expression, value: e.Expression, span: Any) -> None:
        """Note a comparison of a name, or of its degrees, with a value."""
        match counted:
            case e.Name(name):
                bounds.append((name, number(value), span))
            case e.Binary("/", e.Name(name), e.Number(e.DEGREE)):
                bounds.append((name, number(e.Binary("*", value, e.Number(e.DEGREE))), span))

    def finding(name: str, step: float, end: float | None, span: Any) -> Diagnostic:
        met = "the last value" if end is None else f"{end:g}"
        return _INEXACT_STEPS(name=name, step=f"{abs(step):g}", bound=met, span=span)

    for statement, parts in statements_with(program, p.For, p.Assign, e.Binary):
        match statement:
            case p.For(variable, first, last, step=each):
                step, end = number(each), number(last)
                if (
                    step is not None
                    and _is_inexact(step)
                    and _meets_bound(number(first), end, step)
                ):
                    yield finding(variable, step, end, statement.span)
            case p.Assign(e.Name(name), e.Binary("+" | "-", e.Name(other), each)):
                step = number(each)
                if name.lower() == other.lower() and step is not None and _is_inexact(step):
                    steps[name.lower()] = step
        for part in parts:
            match part:
                case e.Binary(relation, one, other_side) if relation in e.RELATIONS:
                    bound(one, other_side, statement.span)
                    bound(other_side, one, statement.span)
    for name, end, span in bounds:
        added = steps.get(name.lower())
        if added is not None and end is not None and _meets_bound(0.0, end, added):
            yield finding(name, added, end, span)


def _is_inexact(step: float) -> bool:
    """True if a controller's single-precision number is not exactly this step."""
    return float(np.float32(step)) != step


def _meets_bound(first: float | None, last: float | None, step: float) -> bool:
    """True unless a count from first in steps clearly passes last between two steps."""
    if first is None or last is None:
        return True
    rounds = (last - first) / step
    return abs(rounds - round(rounds)) < _NEAR_STEP_PART


def _operations_used(program: Program) -> Iterator[tuple[str, Any]]:
    """Yield the operations of each statement that depend on the controller, with its span."""
    numbers: NumberFacts | None = None
    for procedure in program.procedures:
        for statement, parts in statements_with(procedure, e.Binary, e.Apply):
            asked = [part for part in parts if _depends_on_controller(part)]
            if not asked:
                continue
            numbers = numbers or NumberFacts(program)
            for key in dict.fromkeys(_arithmetic_key(part, procedure, numbers) for part in asked):
                if key is not None:
                    yield key, statement.span


def _depends_on_controller(part: Any) -> bool:
    return getattr(part, "operator", None) in ("div", "mod") or (
        isinstance(part, e.Apply) and part.function == "round"
    )


def _arithmetic_key(part: Any, procedure: Procedure, numbers: NumberFacts) -> str | None:
    """Return the part of ARITHMETIC that a division or rounding depends on, None if its operands
    rule it out.
    """
    match part:
        case e.Apply("round", (value,)):
            return None if numbers.of(value, procedure).whole else "halves"
        case e.Binary(_, left, right):
            known = numbers.of(left, procedure).positive, numbers.of(right, procedure).positive
            return None if all(known) else "remainder"
    return None
