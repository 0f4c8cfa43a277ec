"""A toy robot language: the smallest that passes the laws. Copy it to begin a real one.

Text goes to the tree in `reading.py` and back in `text.py`, the tree to a pseudo-program in
`lift.py`; `adapt.py` makes of any pseudo-program one that can be said, and `lower.py` its tree.
`tables.py` has the limits, words, statements and findings, `checks.py` the rules of its own.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from assistant.base.diagnostics import Diagnostic, has_errors
from assistant.base.source_text import SourceText
from assistant.languages import Adapted, Language, Precision
from assistant.languages.legalisation import adapted
from assistant.program.program import Program
from assistant.robots import Robot

from . import adapt, checks, lift, lower, reading, text
from .tree import File


def language(name: str) -> Toy:
    return Toy()


class Toy(Language[File]):
    name = "toy"
    title = "Toy"
    suffixes = (".toy",)
    encodings = ("utf-8", "latin-1")
    precision = Precision(position=5.1e-7, angle=2e-4)
    comment_mark = "#"
    joint_words = re.compile(r"\b(turn|joints)\b")
    family = "TY"
    fixed = ("TY1", "TY3")

    def parse(self, source: SourceText | str) -> File:
        return reading.parse(source)

    def render(self, tree: File) -> str:
        return text.render(tree)

    def format(self, tree: File) -> str:
        return text.render(tree) if has_errors(tree.findings) else text.laid_out(tree)

    def lift_trees(self, trees: Sequence[File], robot: Robot | None) -> Program:
        return lift.lift(trees)

    def adapt(
        self, program: Program, robot: Robot | None = None, *, most_targets: int | None = None
    ) -> Adapted:
        return adapted(self, program, adapt.CAN, adapt.PASSES)

    def build(self, program: Program, robot: Robot | None = None, unit: str | None = None) -> File:
        return lower.build(program)

    def check(self, trees: Sequence[File]) -> tuple[Diagnostic, ...]:
        return tuple(finding for tree in trees for finding in checks.check(tree))
