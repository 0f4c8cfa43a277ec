"""Results that the controllers of two languages may compute differently.

Halves that are rounded, remainders below 0, sums of small steps, and angles where a little counts.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from math import isfinite
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.diagnostics import Diagnostic, Span, error, warning
from assistant.compiler.loader import with_project_settings
from assistant.languages.language_types import ARITHMETIC
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.converted_angles import EDGES, doubtful_angles
from assistant.program.analysis.integer_inference import NumberFacts
from assistant.program.analysis.possible_values import PossibleValues
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
_ANGLE_AT_EDGE: Final = warning(
    "CO127",
    "a value that is worked out with an angle {edge}: one controller has the angle in radian, the "
    "other in degrees, and after rounding they may go different ways at the edge",
    "{cure}",
)
_EDGE_CURES: Final = {
    "=": "ask whether the difference is below a tolerance, such as 0.001",
    "whole": "add a tolerance such as 0.001 before it is cut off, or round it to the nearest",
    "switch": "round it to the nearest first, or ask for ranges",
    "count": "let it end between two steps, such as half a step further",
}
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
    program: Program, exported: Program, source: Language[Any], target: Language[Any]
) -> Iterator[Diagnostic]:
    """Findings on what a lifted program works out, where the language of it and another differ.

    exported: the program without what its own language alone has. Raises Unreadable or Refused if
    the project's file is broken.
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
    # Exported, a program has the constants of its language as numbers.
    counted = {one.span: one for of in (exported, program) for one in _inexact_steps(of)}
    yield from counted.values()
    yield from _angles_at_edges(program, exported, counted)


def _angles_at_edges(
    program: Program, exported: Program, known: Container[Span | None]
) -> Iterator[Diagnostic]:
    """Findings on angles, in another unit in each language, where a little rounding counts.

    As lifted, a program has the conversions that its export may join to others; exported, it has
    the angles that its own functions give. known: spans that another finding is about.
    """
    found = dict.fromkeys(
        (statement.span, edge)
        for one in (program, exported)
        for statement, edge in doubtful_angles(one)
        if statement.span is not None and statement.span not in known
    )
    for span, edge in found:
        yield _ANGLE_AT_EDGE(edge=EDGES[edge], cure=_EDGE_CURES[edge], span=span)


def _inexact_steps(program: Program) -> Iterator[Diagnostic]:
    """Findings on loops and comparisons that end where a sum of inexact steps meets a bound."""
    possible: PossibleValues | None = None
    steps: dict[str, list[_Stated]] = {}
    starts: dict[str, list[_Stated]] = {}
    bounds: list[tuple[str, _Stated, p.Statement]] = []

    def numbers(stated: Iterable[_Stated]) -> set[float]:
        """Return the numbers that values may be, none for those that are not known."""
        nonlocal possible
        possible = possible or PossibleValues(program)
        return {one for value, owner in stated for one in possible.of(value, owner) or ()}

    for procedure in program.procedures:
        for statement, parts in statements_with(procedure, p.For, p.Assign, e.Binary):
            match statement:
                case p.For(variable, first, last, step=each) if each is not None:
                    for step in sorted(filter(_is_inexact, numbers([(each, procedure)]))):
                        begun, ends = numbers([(first, procedure)]), numbers([(last, procedure)])
                        met = [end for end in ends if _meets_bound(begun or {0.0}, end, step)]
                        if met or not begun or not ends:
                            yield _steps_finding(variable, step, min(met, default=None), statement)
                            break
                case p.Assign(target, value) if (name := _counted(target)) is not None:
                    added = _step_of(name, value)
                    known = starts if added is None else steps
                    stated = value if added is None else added
                    known.setdefault(name, []).append((stated, procedure))
            for part in parts:
                match part:
                    case e.Binary(relation, one, other) if relation in e.RELATIONS:
                        for asked, value in ((one, other), (other, one)):
                            counted, bound = _in_own_unit(asked, value)
                            if (name := _counted(counted)) is not None:
                                bounds.append((name, (bound, procedure), statement))
    begins = {
        name.lower(): variable.initial.value
        for name, variable in program.variables.items()
        if isinstance(variable.initial, e.Number)
    }
    inexact = {
        name: sorted(filter(_is_inexact, numbers(steps[name])))
        for name in dict.fromkeys(name for name, _, _ in bounds)
        if name in steps
    }
    for name, limit, statement in bounds:
        for step in inexact.get(name, ()):
            begun = numbers(starts.get(name, ())) | ({begins[name]} if name in begins else set())
            met = [end for end in numbers([limit]) if _meets_bound(begun or {0.0}, end, step)]
            if met:
                yield _steps_finding(name, step, min(met), statement)
                break


_Stated = tuple[e.Expression, Procedure]
"""A value with the procedure that states it."""


def _steps_finding(name: str, step: float, end: float | None, statement: p.Statement) -> Diagnostic:
    met = "the last value" if end is None else f"{end:g}"
    return _INEXACT_STEPS(name=name, step=f"{abs(step):g}", bound=met, span=statement.span)


def _counted(place: e.Expression) -> str | None:
    """Return what may be counted on, as it is known here: a variable, a component or an element."""
    match place:
        case e.Index(e.Name(name), indices):
            numbers = [one for one in indices if isinstance(one, e.Number)]
            if len(numbers) == len(indices):
                return f"{name.lower()}[{', '.join(f'{one.value:g}' for one in numbers)}]"
        case e.Name(name):
            return name.lower()
        case e.Member(e.Name(name), component):
            return f"{name}.{component}".lower()
    return None


def _step_of(name: str, value: e.Expression) -> e.Expression | None:
    """Return what is added to a variable to get its new value, None for any other value."""
    match value:
        case e.Binary("+", one, step) if _counted(one) == name:
            return step
        case e.Binary("+", step, one) if _counted(one) == name:
            return step
        case e.Binary("-", one, step) if _counted(one) == name:
            return e.Unary("-", step)
    return None


def _in_own_unit(asked: e.Expression, value: e.Expression) -> tuple[e.Expression, e.Expression]:
    """Return both sides of a comparison in the unit in which the first of them is kept."""
    degree = e.Number(e.DEGREE)
    match asked:
        case e.Binary("/", e.Name() | e.Member() as kept, unit) if unit == degree:
            return kept, e.Binary("*", value, degree)
        case e.Binary("*", e.Name() | e.Member() as kept, unit) if unit == degree:
            return kept, e.Binary("/", value, degree)
    return asked, value


def _is_inexact(step: float) -> bool:
    """True if a controller's single-precision number is not exactly this step."""
    return float(np.float32(step)) != step


def _meets_bound(starts: Iterable[float], end: float, step: float) -> bool:
    """True unless each count in steps clearly passes the end between two steps."""
    rounds = ((end - start) / step for start in starts)
    # A count that is no number never comes to its end.
    return any(abs(one - round(one)) < _NEAR_STEP_PART for one in rounds if isfinite(one))


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
