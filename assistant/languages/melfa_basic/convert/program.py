"""A whole program that was read in another dialect, converted."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import has_errors
from assistant.languages.language_types import Conversion
from assistant.languages.melfa_basic.convert import lines, names, original_names, words
from assistant.languages.melfa_basic.convert.conversion import convert
from assistant.languages.melfa_basic.convert.original_names import OriginalNames
from assistant.languages.melfa_basic.lift.files.program import file_stem, lift
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.targets import labels_of, with_labelled_jumps
from assistant.languages.melfa_basic.tree.walk import lines_with
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.comparison import Tolerance, compare
from assistant.program.program import Program
from assistant.program.rewriting import rewrite

if TYPE_CHECKING:
    from assistant.robots import Robot


def conversion(
    program: Program, dialect: str, file_names: Sequence[str], robot: Robot | None
) -> Conversion[s.File] | None:
    """The files in the dialect, None if the program is not as it was read in another one.

    Programs with a `Function`, for a dialect without, are none either: they go through the
    pseudo-program. file_names: of the files of trees without a path, in their order. robot: that
    the program is to run on.
    """
    origin = program.origin
    if origin is None or origin.language not in DIALECTS or origin.language == dialect:
        return None
    trees = origin.trees
    if any(has_errors(tree.findings) for tree in trees):
        return None
    functions = any(any(lines_with(tree.items, s.Function)) for tree in trees)
    if functions and not DIALECTS[dialect].functions:
        return None  # the pseudo-program has procedures, which every dialect says in its way
    if origin.robot is None:
        read, as_read = None, program == origin.lifted
    else:
        arms = dict.fromkeys([None, robot])
        read, as_read = next(((a, True) for a in arms if lift(trees, a) == program), (None, False))
    if not as_read:
        return None
    if robot is not None and read is None and program.robot not in (None, robot.name):
        return None  # another arm: its branches are chosen anew
    converted = convert(trees, dialect)
    left = iter(file_names)
    files: dict[str, s.File] = {}
    for tree in converted.trees:
        path = tree.source.path if tree.source else None
        name = PurePath(path).stem + ".prg" if path else next(left, None)
        if name is None:
            return None
        files[name] = tree
    return Conversion(files, lambda back: compared_programs(trees, back, read), converted.findings)


# Whether it says the same: both sides lifted, in one spelling


def compared_programs(
    before: Sequence[s.File], after: Sequence[s.File], robot: Robot | None
) -> tuple[Program, Program]:
    """The pseudo-programs of both, which must be the same.

    A form that a lift reads in one dialect only is compared in the first one: the program is
    converted back.
    """
    expected, actual = lifted_pair(before, after, robot)
    if compare(expected, actual, COMPARISON_TOLERANCE).same or not before:
        return expected, actual
    back = convert(after, before[0].dialect)
    if not back.trees:
        return expected, actual
    found = lifted_pair(before, back.trees, robot)
    return found if compare(*found, COMPARISON_TOLERANCE).same else (expected, actual)


COMPARISON_TOLERANCE: Final = Tolerance(1e-9, 1e-9, 0.0)
"""Of the comparison itself: numbers are not computed anew."""


def lifted_pair(
    before: Sequence[s.File], after: Sequence[s.File], robot: Robot | None
) -> tuple[Program, Program]:
    """The pseudo-programs of both, in the words that they share; one if these are the same."""
    lowest = min(DIALECTS[tree.dialect].level for tree in (*before, *after))
    one, two = ([_comparable_tree(tree, lowest) for tree in trees] for trees in (before, after))
    said = _lifted_without_dialect(one, robot)
    return said, said if _lifted_text(one) == _lifted_text(two) else _lifted_without_dialect(
        two, robot
    )


def _lifted_text(trees: Sequence[s.File]) -> list[tuple[str | None, tuple[s.Item, ...]]]:
    """What is lifted of trees, whatever dialect they are in."""
    return [(file_stem(tree), tree.items) for tree in trees]


def _lifted_without_dialect(trees: Sequence[s.File], robot: Robot | None) -> Program:
    program: Program = rewrite(lift(trees, robot, divide=False), _without_dialect)
    return program


def _comparable_tree(tree: s.File, lowest: int) -> s.File:
    items, memory = original_names.take_original_names(tree.items)
    items, made = with_labelled_jumps(lines.with_lone_labels(items))
    jumped = {label.upper() for label in made} | set(memory.steps)
    order = (label for label in labels_of(items) if label in jumped)
    numbers = {label: f"ATSTEP{n}" for n, label in enumerate(order)}
    if lowest == 4 and DIALECTS[tree.dialect].level > 4:
        lower = DIALECTS["melfa-basic-4"]
        items = words.Words(lower, OriginalNames(), _ignore_complaint).lines(
            lines.with_fitting_comments(items, lower)
        )
    elif lowest > 4:
        items = [rewrite(item, words.in_new_words) for item in items]
    table = names.Names(
        *({k: v.upper() for k, v in getattr(memory, kind).items()} for kind in names.NAME_TABLES)
    )
    table.labelled |= numbers
    items = original_names.with_heading_names(
        names.with_names(items, table, upper=True), table.named
    )
    return replace(tree, items=tuple(items), parsed=())


def _ignore_complaint(item: s.Item, what: str, cure: str) -> None:
    """What cannot be said was found before."""


def _without_dialect(part: Any) -> Any:
    if isinstance(part, p.Opaque | e.Verbatim):
        return replace(part, language="", text=_upper_outside_strings(part.text))
    return part


_STRING_LITERAL: Final = re.compile(r'("[^"]*")')


def _upper_outside_strings(text: str) -> str:
    """In upper case outside of strings."""
    return "".join(t if t.startswith('"') else t.upper() for t in _STRING_LITERAL.split(text))
