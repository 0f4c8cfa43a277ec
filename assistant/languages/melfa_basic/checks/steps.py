"""Rules of lines: their numbers, their length, and where jumps go."""

from __future__ import annotations

import re
from typing import Final

from assistant.base.diagnostics import Span
from assistant.languages.checks.names import repeated
from assistant.languages.checks.registry import Found
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks.damage import steps_of
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.tables.dialects import LAST_STEP
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.melfa_basic.tree.targets import exits_of
from assistant.languages.step_numbers import places_of_steps

_NUMBER: Final = re.compile(r"[ \t]*([0-9]+)")


def step_order(look: Look) -> Found:
    """Step numbers ascend, fit, and stand at every line if at one."""
    numbered = any(isinstance(i, MoveRows) or i.number is not None for i in look.code)
    before = 0
    for item in look.code:
        if isinstance(item, MoveRows):
            before = int(item.steps[-1])  # in a table they ascend
        elif item.number is None:
            if numbered:
                what = "the line has no step number, but others have"
                yield look.finding(rules.NO_STEP_NUMBER, item, what=what)
        else:
            where = _step_number(look, item)
            if not 1 <= item.number <= LAST_STEP:
                yield look.finding(rules.STEP_RANGE, where, number=item.number, most=LAST_STEP)
            if item.number <= before:
                yield look.finding(rules.NOT_ASCENDING, where, number=item.number, before=before)
            before = item.number
    first = next((line for line in look.lines if line.statement or line.label), None)
    if first is not None and not numbered and look.dialect.steps_needed:
        what = f"{look.dialect.title} needs a step number at every line, and no line has one"
        yield look.finding(rules.NO_STEP_NUMBER, first, what=what)


def _step_number(look: Look, line: s.Line) -> Span | None:
    if line.span is None or look.source is None:
        return None
    found = _NUMBER.match(look.source.text, line.span.start)
    return Span(*found.span(1)) if found else line.span


def step_lengths(look: Look) -> Found:
    """Steps that are longer than a controller takes, in bytes of the file's own encoding."""
    source = look.source
    encoding = source.encoding if source is not None else "utf-8"
    most = look.dialect.line
    for line in look.lines:
        text = look.text_of(line)
        if len(text) * 4 <= most:
            continue
        length = len(text.encode(encoding, "replace"))
        if length > most:
            yield look.finding(rules.LONG_LINE, line, length=length, most=most)


# --------------------------------------------------------------------------------------- labels


def jump_labels(look: Look) -> Found:
    """A label stands once, and what is jumped to is there; functions have their own."""
    for scope in look.scopes:
        lines = look.lines_of(scope)
        for line in repeated(lines, _label_of):
            yield look.at(rules.TWO_LABELS, line, f"*{line.label}", name=line.label)
        labels = set(map(_label_of, lines))
        for line in lines:
            yield from _missing_targets(look, line, labels, inside=scope.function is not None)


def _label_of(line: s.Line) -> str | None:
    return line.label.upper() if line.label is not None else None


def _missing_targets(look: Look, line: s.Line, labels: set[str | None], *, inside: bool) -> Found:
    for target in exits_of(line.statement).targets:
        if isinstance(target.place, int):
            if target.place not in look.once(_step_numbers):
                word = str(target.place)
                yield look.at(rules.NO_STEP, line, word, name=target.place)
            elif not look.dialect.line_targets:
                word, title = str(target.place), look.dialect.title
                yield look.at(rules.LINE_TARGET, line, word, name=target.place, title=title)
        elif target.place.upper() not in labels:
            other = target.place.upper() in look.once(_all_labels)
            where = ""
            if other:
                where = " in this Function" if inside else " outside of the Functions"
            yield look.at(rules.NO_LABEL, line, target, name=target.place, where=where)


def _step_numbers(look: Look) -> set[int]:
    return steps_of(look.damage).union(places_of_steps(look.code))


def _all_labels(look: Look) -> set[str | None]:
    return set(map(_label_of, look.lines))
