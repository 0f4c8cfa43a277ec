"""Break points, steps and pauses: where a run is held.

A break point moves to the next line with a statement; it can have a condition, a hit count, and a
text to log instead of holding.
"""

from __future__ import annotations

import operator
import os
import re
from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field
from functools import cache
from typing import Final, Literal

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.base.source_text import SourceText
from assistant.languages.melfa_basic.tree import syntax as melfa
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.rapid.tree import syntax as rapid
from assistant.languages.rapid.tree.walk import lists
from assistant.program.program import walk
from assistant.virtual.debugging.expressions import Evaluate, Wrong, read_expression
from assistant.virtual.debugging.messages import Object, number, text
from assistant.virtual.kernel import Task
from assistant.virtual.tasks import Programs

Stride = Literal["in", "over", "out"]
Reason = Literal["breakpoint", "step", "pause", "entry"]


# Cached: each statement that runs asks, and realpath goes to the file system.
@cache
def _same_file(path: str) -> str:
    """Return one spelling of a file's path for all its spellings."""
    return os.path.normcase(os.path.realpath(path))


@dataclass(slots=True)
class Step:
    """A step of a task. depth: how many calls run where it begins."""

    task: Task
    stride: Stride
    depth: int

    def is_done(self, task: Task) -> bool:
        if task is not self.task:
            return False
        if self.stride == "in":
            return True
        # A step over also ends in the caller, if this call returns.
        depth = len(task.levels())
        return depth < self.depth if self.stride == "out" else depth <= self.depth


@dataclass(slots=True)
class Holding:
    """points: lines with a break point by the file's name. step: the one that is being made."""

    points: dict[str, frozenset[int]] = field(default_factory=dict)
    step: Step | None = None
    pause: Reason | None = None

    def set_points(self, path: str, lines: Iterable[int]) -> None:
        """The break points of a file, instead of those that it had."""
        self.points[_same_file(path)] = frozenset(lines)

    def reason(self, task: Task) -> Reason | None:
        """Why a task is held before its next statement, None if it is not."""
        if self.pause is not None:
            return self.pause
        if self.step is not None and self.step.is_done(task):
            return "step"
        if any(self.points.values()):
            place = task.where()
            if place is not None and place[1] in self.points.get(_same_file(place[0]), ()):
                return "breakpoint"
        return None

    def go(self, step: Step | None = None) -> None:
        """The run goes on, to the end of a step or to whatever holds it."""
        self.step, self.pause = step, None


Lines = Mapping[str, Sequence[int]]
"""Lines at which a statement begins, rising, by the name of the file (`_same_file`)."""

_HIT_COUNT: Final = re.compile(r"\s*(>=|<=|==|=|>|<|%)?\s*(\d{1,9})\s*")
_HIT_TESTS: Final[Mapping[str, Callable[[int, int], bool]]] = {
    ">=": operator.ge,
    "<=": operator.le,
    "==": operator.eq,
    "=": operator.eq,
    ">": operator.gt,
    "<": operator.lt,
    "%": lambda count, every: count % every == 0,
}
_NO_STATEMENT: Final = (
    rapid.CommentLine | rapid.Data | rapid.TargetRunNode | rapid.LabelMark | rapid.Placeholder
)


def statement_lines(programs: Programs) -> Lines:
    """The lines at which programs can be held: a run comes to a statement there."""
    found: dict[str, set[int]] = {}

    def add(source: SourceText | None, span: Span | None, count: int = 1) -> None:
        if source is not None and span is not None:
            first = source.line_column(span.start)[0]
            lines = found.setdefault(_same_file(source.path or ""), set())
            lines.update(range(first, first + count))

    if programs.program is not None and programs.text is not None:
        for procedure in programs.program.procedures:
            for statement in walk(procedure.body):
                add(programs.text, statement.span)
    for tree in (tree for part in programs.parts for tree in part.trees):
        match tree:
            case rapid.File():
                for module in tree.modules:
                    for item in module.items:
                        for body in lists(item) if isinstance(item, rapid.Routine) else ():
                            for node in body:
                                # A run of moves is one node with a statement in each line.
                                if isinstance(node, rapid.MoveRunNode):
                                    add(tree.source, node.span, len(node.run))
                                elif not isinstance(node, _NO_STATEMENT):
                                    add(tree.source, node.span)
            case melfa.File():
                for line in tree.items:
                    if isinstance(line, melfa.Line):
                        if line.statement is not None:
                            add(tree.source, line.span)
                    elif isinstance(line, MoveRows):
                        add(tree.source, line.span, len(line))
    return {path: sorted(lines) for path, lines in found.items()}


def moved_to_statements(lines: Lines, path: str, asked: Iterable[int]) -> list[int]:
    """Lines of a file, each moved to the next one with a statement; those after the last are
    dropped.

    A file without known lines is not one of the programs yet, so its lines stay unchanged until it
    is loaded.
    """
    known = lines.get(_same_file(path))
    if known is None:
        return sorted(set(asked))
    rows = (bisect_left(known, line) for line in asked)
    return sorted({known[row] for row in rows if row < len(known)})


@dataclass(slots=True)
class Point:
    """A break point. line: where it holds, 0 for nowhere. said: why it does not.

    condition: None for always. hits: of how many times it holds. log: the text of a log point,
    whose expressions are in braces; it holds nothing. count: how often it was met.
    """

    line: int
    said: str = ""
    condition: Evaluate | None = None
    hits: Callable[[int], bool] | None = None
    log: Sequence[str | Evaluate] | None = None
    count: int = 0

    def record(self, asked: int) -> Object:
        """The answer to the editor that asked for it in a line."""
        answer: Object = {"verified": not self.said, "line": self.line or asked}
        return {**answer, "message": self.said} if self.said else answer


@dataclass(slots=True)
class Points:
    """The break points of a run. lines: of its programs."""

    lines: Lines = field(default_factory=dict)
    set: dict[str, Mapping[int, Sequence[Point]]] = field(default_factory=dict)

    def place(self, path: str, asked: Iterable[Object]) -> list[Object]:
        """The break points of a file instead of those that it had; the answers to each."""
        lines = self.lines.get(_same_file(path))
        made = [(number(one, "line"), _break_point(lines, one)) for one in asked]
        by_line: dict[int, list[Point]] = {}
        for _, point in made:
            if not point.said:
                by_line.setdefault(point.line, []).append(point)
        self.set[_same_file(path)] = by_line
        return [point.record(line) for line, point in made]

    def at(self, path: str, line: int) -> Sequence[Point]:
        return self.set.get(_same_file(path), {}).get(line, ())


def _break_point(lines: Sequence[int] | None, asked: Object) -> Point:
    """A break point, moved to the next line with a statement."""
    if lines is None:
        return Point(0, "the program that runs does not contain this file")
    row = bisect_left(lines, number(asked, "line"))
    if row == len(lines):
        return Point(0, "no statement begins in this line or after it")
    point = Point(lines[row])
    try:
        if condition := text(asked, "condition").strip():
            point.condition = read_expression(condition)
        if hits := text(asked, "hitCondition").strip():
            point.hits = _hit_test(hits)
        if log := text(asked, "logMessage"):
            point.log = _log_parts(log)
    except Wrong as wrong:
        point.said = str(wrong.args[0])
    return point


def _hit_test(given: str) -> Callable[[int], bool]:
    found = _HIT_COUNT.fullmatch(given)
    if found is None or (found[1] == "%" and int(found[2]) == 0):
        raise Wrong(f"`{given}` is no count of hits: write 5, >= 5 or % 5")
    compare, wanted = _HIT_TESTS[found[1] or "=="], int(found[2])
    return lambda count: compare(count, wanted)


def _log_parts(given: str) -> Sequence[str | Evaluate]:
    """Texts and expressions by turns."""
    parts: list[str | Evaluate] = []
    # Expressions may hold one level of braces, as indices of RAPID do.
    for place, part in enumerate(re.split(r"\{((?:[^{}]|\{[^{}]*\})*)\}", given)):
        parts.append(read_expression(part) if place % 2 else part)
    return parts
