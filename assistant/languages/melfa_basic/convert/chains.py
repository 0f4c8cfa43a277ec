"""A `Select` that was written as a row of `IF … THEN *S1C1` made a `Select` again."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.jumping import goes_to
from assistant.languages.melfa_basic.tree.targets import labels_named, lone_labels

_FIRST: Final = re.compile(r"(S[0-9]+)C1")


def chained(items: Sequence[s.Item], ends: dict[int, str]) -> list[s.Item]:
    """The lines with such rows as blocks. ends: gets the last label of each, by its line."""
    lines = list(items)
    at = 0
    while at < len(lines):
        made = _at(lines, at, ends)
        if made is not None:
            lines = made
        at += 1
    return lines


def _at(lines: list[s.Item], at: int, ends: dict[int, str]) -> list[s.Item] | None:
    """All lines with the row that begins here as a block, None if none begins here."""
    aimed = _aimed(lines[at])
    found = _FIRST.fullmatch(aimed[1]) if aimed is not None else None
    if found is None:
        return None
    name = found[1]
    labels = lone_labels(lines)
    last = labels.get(name + "Z", -1)
    row = _row(lines, at, name)
    if row is None:
        return None
    cases, subject, after, default = row
    heads = [s.Line(statement=case, comment=comment) for case, comment in cases]
    if default is not None:
        heads.append(s.Line(statement=s.Command("Default"), comment=default.comment))
    names = [f"{name}C{number}" for number in range(1, len(heads) + 1)]
    starts = [labels.get(one, -1) for one in names]
    edges = [*starts, last]
    if sorted(edges) != edges or edges[0] < after:
        return None
    bodies: list[list[s.Item]] = []
    for low, high in pairwise(edges):
        if not goes_to(lines[high - 1], name + "Z") or high - 1 <= low:
            return None
        bodies.append(lines[low + 1 : high - 1])
    first = lines[at]
    head = s.Line(statement=s.Select(subject))
    before, behind = lines[:at], lines[last + 1 :]
    match before[-1] if before else None:
        case s.Line(label=None, statement=s.Assign(target=held, value=value)) as line if (
            held == s.Variable("M" + name) == subject
        ):
            head = replace(line, statement=s.Select(value))
            before.pop()
    if head.span is None:
        head = replace(head, span=first.span)
    block: list[s.Item] = [head, *lines[after : starts[0]]]
    for case, body in zip(heads, bodies, strict=True):
        block += [case, *body]
    closing = s.Line(statement=s.Command("End Select"))
    outside = labels_named([*before, *behind])
    if not {name + "Z", *names}.isdisjoint(outside) or set(names).intersection(labels_named(block)):
        return None
    ends[id(closing)] = name + "Z"
    return [*before, *block, closing, *behind]


def _aimed(item: s.Item) -> tuple[s.Expression | None, str] | None:
    """Where a line goes, in upper case, and on what condition; None if it does anything else."""
    match item:
        case s.Line(label=None, statement=s.If(condition, s.Target(place=str() as place), None)):
            return condition, place.upper()
        case s.Line(label=None, statement=s.Jump("GoTo", s.Target(place=str() as place))):
            return None, place.upper()
    return None


Row = tuple[list[tuple[s.Case, str | None]], s.Expression, int, s.Line | None]


def _row(lines: Sequence[s.Item], at: int, name: str) -> Row | None:
    """The cases, what is selected by, the place behind the row, the jump to the default."""
    cases: list[tuple[s.Case, str | None]] = []
    subject: s.Expression | None = None
    for behind, line in enumerate(lines[at:], at + 1):
        aimed = _aimed(line)
        if aimed is None or not isinstance(line, s.Line):
            return None
        condition, label = aimed
        following = f"{name}C{len(cases) + 1}"
        if condition is None:
            if subject is None or label not in (following, name + "Z"):
                return None
            return cases, subject, behind, line if label == following else None
        tested = _test(condition)
        if tested is None or (subject is not None and tested[0] != subject):
            return None
        subject, item = tested
        if cases and label == f"{name}C{len(cases)}" and line.comment is None:
            old, said = cases[-1]
            cases[-1] = s.Case((*old.items, item)), said
        elif label == following:
            cases.append((s.Case((item,)), line.comment))
        else:
            return None
    return None


def _test(condition: s.Expression) -> tuple[s.Expression, s.CaseRange | s.CaseIs] | None:
    match condition:
        case s.Binary("AND", s.Binary(">=", left, low), s.Binary("<=", right, high)) if (
            left == right
        ):
            return left, s.CaseRange(low, high)
        case s.Binary("=", left, value):
            return left, s.CaseRange(value)
        case s.Binary("<>" | "><" | "<" | "<=" | "=<" | ">" | ">=" | "=>" as operator, left, value):
            return left, s.CaseIs(operator, value)
    return None
