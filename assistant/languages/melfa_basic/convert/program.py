"""A whole program that was read in another dialect, converted."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING

from assistant.languages.language import Conversion
from assistant.languages.melfa_basic.convert.comparing import compared
from assistant.languages.melfa_basic.convert.conversion import convert
from assistant.languages.melfa_basic.lift.files.program import lift
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.diagnostics import has_errors
from assistant.program.program import Program

if TYPE_CHECKING:
    from assistant.robots import Robot


def conversion(
    program: Program, dialect: str, names: Sequence[str], robot: Robot | None
) -> Conversion[s.File] | None:
    """The files in the dialect, None if the program is not as it was read in another one.

    Programs with a `Function`, for a dialect without, are none either: they go through the
    pseudo-program. names: of the files of trees without a path, in their order. robot: that the
    program is to run on.
    """
    origin = program.origin
    if origin is None or origin.language not in DIALECTS or origin.language == dialect:
        return None
    trees = origin.trees
    if any(has_errors(tree.findings) for tree in trees):
        return None
    if not DIALECTS[dialect].functions and any(map(_has_functions, trees)):
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
    left = iter(names)
    files: dict[str, s.File] = {}
    for tree in converted.trees:
        path = tree.source.path if tree.source else None
        name = PurePath(path).stem + ".prg" if path else next(left, None)
        if name is None:
            return None
        files[name] = tree
    return Conversion(files, lambda back: compared(trees, back, read), converted.findings)


def _has_functions(tree: s.File) -> bool:
    return any(isinstance(i, s.Line) and isinstance(i.statement, s.Function) for i in tree.items)
