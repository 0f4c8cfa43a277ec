"""The language's own rules over the files of a program."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from assistant.languages.melfa_basic import printer, rules
from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.columnar import MVR, MoveRows, PositionRows
from assistant.languages.melfa_basic.dialects import DIALECTS, LAST_STEP, Dialect
from assistant.languages.melfa_basic.lift.gathering import split_name
from assistant.languages.melfa_basic.lift.positions import Positions
from assistant.program.diagnostics import Diagnostic, Rule, Span

MOST_ROWS: Final = 20
"""Findings about rows of one table; more say nothing new."""


def check(trees: Sequence[s.File]) -> tuple[Diagnostic, ...]:
    """Findings over the trees of one program, in the order of their lines."""
    found: list[Diagnostic] = []
    for tree in trees:
        found += sorted(_File(tree).findings(), key=lambda f: f.line or 0)
    return tuple(found)


class _File:
    """One file with what its checks share."""

    def __init__(self, tree: s.File) -> None:
        self.tree = tree
        self.dialect: Dialect = DIALECTS[tree.dialect]
        self.code = [i for i in tree.items if isinstance(i, s.Line | MoveRows)]
        self.functions = any(
            isinstance(i, s.Line) and isinstance(i.statement, s.Function) for i in self.code
        )

    def find(self, rule: Rule, span: Span | None, **words: Any) -> Diagnostic:
        if self.tree.source is not None and span is not None:
            return self.tree.source.finding(rule, span, **words)
        return rule(path=self.tree.source.path if self.tree.source else None, **words)

    def findings(self) -> Iterator[Diagnostic]:
        yield from self.labels()
        yield from self.positions()
        yield from self.blocks()
        yield from self.steps()
        yield from self.names()
        yield from self.words()

    # --------------------------------------------------------------------------- jumps

    def labels(self) -> Iterator[Diagnostic]:
        """A label stands once, and what is jumped to is there; functions have their own."""
        lines = [i for i in self.code if isinstance(i, s.Line)]
        steps = {i.number for i in lines}
        for rows in self.code:
            if isinstance(rows, MoveRows):
                steps.update(rows.steps.tolist() if len(rows) < 100_000 else ())
        for part in self.scopes(lines):
            seen: set[str] = set()
            for line in part:
                if line.label is None:
                    continue
                if line.label.upper() in seen:
                    yield self.find(rules.TWO_LABELS, line.span, name=line.label)
                seen.add(line.label.upper())
            for line in part:
                for target in _of_type(line.statement, s.Target):
                    if isinstance(target.place, int):
                        if target.place not in steps:
                            yield self.find(rules.NO_STEP, line.span, name=target.place)
                    elif target.place.upper() not in seen:
                        yield self.find(rules.NO_LABEL, line.span, name=target.place)

    def scopes(self, lines: list[s.Line]) -> Iterator[list[s.Line]]:
        part: list[s.Line] = []
        for line in lines:
            if isinstance(line.statement, s.Function) and part:
                yield part
                part = []
            part.append(line)
        yield part

    # ----------------------------------------------------------------------- positions

    def positions(self) -> Iterator[Diagnostic]:
        """Every position that a program without called parts uses has a value."""
        known = Positions(self.tree)
        yield from self.twice()
        outside = any(
            isinstance(node, s.Include | s.FPrm | s.Function)
            for line in self.code
            if isinstance(line, s.Line)
            for node in (line.statement,)
        )
        if outside or not self.code:
            return
        assigned = set(self.assigned())
        reported: set[str] = set()
        for item in self.code:
            if isinstance(item, MoveRows):
                yield from self.undefined_rows(item, known, assigned)
                continue
            for variable in _of_type(item.statement, s.Variable):
                key = variable.key
                if key in assigned or key in reported or not self.needs_value(variable):
                    continue
                if known.constant(key) is None:
                    reported.add(key)
                    kind = "joint variable" if key[0] == "J" else "position"
                    yield self.find(rules.NO_POSITION, item.span, kind=kind, name=variable.name)

    def needs_value(self, variable: s.Variable) -> bool:
        """A plain position or joint variable by its first letter, and no function."""
        if variable.arguments is not None or variable.suffix or variable.key[1:2] == "_":
            return False
        return bool(re.fullmatch(r"[PJ][0-9]+", variable.key)) or (
            variable.key[0] in "PJ" and variable.key in self.moved_to
        )

    @cached_property
    def moved_to(self) -> set[str]:
        """Variables that moves, tools and bases name."""
        return {
            variable.key
            for item in self.code
            if isinstance(item, s.Line)
            and (
                isinstance(item.statement, s.Motion)
                or (isinstance(item.statement, s.Command) and item.statement.keyword in PLACES)
            )
            for variable in _of_type(item.statement, s.Variable)
        }

    def assigned(self) -> Iterator[str]:
        for item in self.code:
            statement = item.statement if isinstance(item, s.Line) else None
            for node in _of_type(statement, s.Assign):
                yield node.target.key
            match statement:
                case (
                    s.Input(variables=variables)
                    | s.FPrm(variables=variables)
                    | s.Dim(variables=variables)
                ):
                    yield from (v.key for v in variables)

    def undefined_rows(
        self, rows: MoveRows, known: Positions, assigned: set[str]
    ) -> Iterator[Diagnostic]:
        arc = rows.kinds == MVR
        numbers = np.unique(np.concatenate([rows.end, rows.via[arc], rows.start[arc]]))
        _, _, found = known.find(rows.stem, numbers)
        missing = [n for n in numbers[~found].tolist() if f"{rows.stem}{n}".upper() not in assigned]
        for number in missing[:MOST_ROWS]:
            name = f"{rows.stem}{number}"
            yield self.find(rules.NO_POSITION, rows.span, kind="position", name=name)

    def twice(self) -> Iterator[Diagnostic]:
        """Names with two variable lines."""
        counts: Counter[str] = Counter()
        stems: dict[str, list[Any]] = {}
        for item in self.tree.items:
            if isinstance(item, PositionRows):
                stems.setdefault(item.stem.upper(), []).append(item.numbers)
            elif isinstance(item, s.Data):
                split = split_name(item.variable)
                if split:
                    stems.setdefault(split[0].upper(), []).append(np.array([split[1]]))
                else:
                    counts[printer.expression(item.variable).upper()] += 1
        for stem, found in stems.items():
            numbers, times = np.unique(np.concatenate(found), return_counts=True)
            counts.update({f"{stem}{n}": 2 for n in numbers[times > 1][:MOST_ROWS].tolist()})
        for name, count in counts.items():
            if count > 1:
                span = next((i.span for i in self.tree.items if _named(i, name)), None)
                yield self.find(rules.TWO_POSITIONS, span, name=name)

    # -------------------------------------------------------------------------- blocks

    def blocks(self) -> Iterator[Diagnostic]:
        """For and Next, While and WEnd, If and EndIf, Select and End Select by pairs."""
        stack: list[tuple[str, Span | None]] = []
        for line in self.code:
            if not isinstance(line, s.Line) or line.statement is None:
                continue
            word = _opens(line.statement)
            if word:
                stack.append((word, line.span))
                continue
            for closing in _closes(line.statement):
                opening = _PAIRS[closing][0]
                if stack and stack[-1][0] == opening:
                    stack.pop()
                else:
                    number = _PAIRS[closing][1]
                    yield self.find(
                        rules.UNBALANCED, line.span, word=closing, other=opening, number=number
                    )
        closings = {opening: (closing, number) for closing, (opening, number) in _PAIRS.items()}
        for word, span in stack:
            closing, number = closings[word]
            yield self.find(rules.UNBALANCED, span, word=word, other=closing, number=number)

    # --------------------------------------------------------------------------- steps

    def steps(self) -> Iterator[Diagnostic]:
        """Step numbers ascend and fit; so does every line."""
        numbered = any(isinstance(i, MoveRows) or i.number is not None for i in self.code)
        before = 0
        source = self.tree.source
        for item in self.code:
            if isinstance(item, MoveRows):
                numbers = np.concatenate([[before], item.steps])
                wrong = np.flatnonzero(numbers[1:] <= numbers[:-1])[:MOST_ROWS]
                for at in wrong.tolist():
                    yield self.find(
                        rules.NOT_ASCENDING, item.span, number=numbers[at + 1], before=numbers[at]
                    )
                highest = int(item.steps.max())
                if highest > LAST_STEP:
                    yield self.find(rules.STEP_RANGE, item.span, number=highest, most=LAST_STEP)
                before = int(item.steps[-1])
                continue
            if item.span is not None and source is not None:
                text = source.text[item.span.start : item.span.end].rstrip("\r\n")
            else:
                text = printer.line(item, self.dialect.upper)
            length = len(text.encode("utf-8"))
            if length > self.dialect.line:
                yield self.find(rules.LONG_LINE, item.span, length=length, most=self.dialect.line)
            if item.number is None:
                if numbered and (item.statement or item.label):
                    yield self.find(rules.NO_STEP_NUMBER, item.span)
                continue
            if not 1 <= item.number <= LAST_STEP:
                yield self.find(rules.STEP_RANGE, item.span, number=item.number, most=LAST_STEP)
            if item.number <= before:
                yield self.find(rules.NOT_ASCENDING, item.span, number=item.number, before=before)
            before = item.number

    # --------------------------------------------------------------------------- names

    def names(self) -> Iterator[Diagnostic]:
        """Names are within the limits of the version."""
        seen: set[str] = set()
        for item in self.tree.items:
            if isinstance(item, PositionRows | MoveRows):
                numbers = item.numbers if isinstance(item, PositionRows) else item.end
                longest = f"{item.stem}{int(numbers.max())}"
                yield from self.too_long(longest, self.dialect.longest, item.span, seen)
            elif isinstance(item, s.Line):
                if item.label:
                    yield from self.too_long(item.label, self.dialect.longest, item.span, seen)
                for variable in _of_type(item.statement, s.Variable):
                    yield from self.too_long(variable.name, self.dialect.longest, item.span, seen)
            elif isinstance(item, s.Data):
                name = item.variable.name
                yield from self.too_long(name, self.dialect.longest, item.span, seen)

    def too_long(
        self, name: str, most: int, span: Span | None, seen: set[str]
    ) -> Iterator[Diagnostic]:
        system = name[1:2] == "_"  # status variables have names of their own length
        if len(name) > most and not system and name.upper() not in seen:
            seen.add(name.upper())
            yield self.find(rules.LONG_NAME, span, name=name, most=most)

    def words(self) -> Iterator[Diagnostic]:
        """Statements that the version does not have."""
        for line in self.code:
            statement = line.statement if isinstance(line, s.Line) else None
            missing = None
            match statement:
                case s.If(then=None) | s.ElseIf() if not self.dialect.blocks:
                    missing = "If … EndIf"
                case s.Command(keyword=("EndIf" | "Else") as word) if not self.dialect.blocks:
                    missing = word
                case s.Command(keyword="Break") if not self.dialect.breaks:
                    missing = "Break"
                case s.Function() | s.Include() | s.Static() if not self.dialect.functions:
                    missing = type(statement).__name__
            if missing:
                yield self.find(
                    rules.NOT_IN_DIALECT, line.span, word=missing, title=self.dialect.title
                )


PLACES: Final = ("Tool", "Base")

_PAIRS: Final = {
    "Next": ("For", 3230),
    "WEnd": ("While", 3250),
    "EndIf": ("If", 3252),
    "End Select": ("Select", 3254),
}
"""Closing word → opening word and the controller's error number."""


def _opens(statement: s.Statement) -> str | None:
    from assistant.languages.melfa_basic.lift.blocks import opened

    return opened(statement)


def _closes(statement: s.Statement) -> tuple[str, ...]:
    if isinstance(statement, s.Next):
        return ("Next",) * max(1, len(statement.variables))
    if isinstance(statement, s.Command) and statement.keyword in _PAIRS:
        return (statement.keyword,)
    return ()


def _named(item: s.Item, name: str) -> bool:
    if isinstance(item, s.Data):
        return printer.expression(item.variable).upper() == name
    found = split_name(s.Variable(name))
    return (
        isinstance(item, PositionRows)
        and found is not None
        and item.stem.upper() == found[0].upper()
        and bool((item.numbers == found[1]).any())
    )


def _of_type(node: Any, kind: Any) -> Iterator[Any]:
    """Every node of a type inside a statement."""
    left = [node]
    while left:
        inner = left.pop()
        if isinstance(inner, kind):
            yield inner
        if isinstance(inner, tuple):
            left += inner
        elif is_dataclass(inner):
            left += [getattr(inner, f.name) for f in fields(inner)]
