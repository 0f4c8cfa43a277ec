"""A `Select` that was written as a row of `IF … THEN *S1C1` made a `Select` again."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
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
    name = _name(lines[at])
    if name is None:
        return None
    labels = lone_labels(lines)
    last = labels.get(name + "Z", -1)
    row = _row(lines, at, name)
    if row is None:
        return None
    cases, subject, after, default = row
    count = len(cases) + (default is not None)
    starts = [labels.get(f"{name}C{number}", -1) for number in range(1, count + 1)]
    edges = [*starts, last]
    if sorted(edges) != edges or edges[0] < after:
        return None
    bodies: list[list[s.Item]] = []
    for low, high in zip(starts, edges[1:], strict=True):
        if not goes_to(lines[high - 1], name + "Z") or high - 1 <= low:
            return None
        bodies.append(lines[low + 1 : high - 1])
    first = lines[at]
    head = s.Line(statement=s.Select(subject))
    before = lines[:at]
    match before[-1] if before else None:
        case s.Line(label=None, statement=s.Assign(target=held, value=value)) as line if (
            held == s.Variable("M" + name) == subject
        ):
            head = replace(line, statement=s.Select(value))
            before.pop()
    block: list[s.Item] = [head, *lines[after : starts[0]]]
    for (case, comment), body in zip(cases, bodies, strict=False):
        block += [s.Line(statement=case, comment=comment), *body]
    if default is not None:
        block += [s.Line(statement=s.Command("Default"), comment=default.comment), *bodies[-1]]
    closing = s.Line(statement=s.Command("End Select"))
    made = [*before, *block, closing, *lines[last + 1 :]]
    gone = {name + "Z", *(f"{name}C{number}" for number in range(1, count + 1))}
    outside = labels_named([*before, *lines[last + 1 :]])
    if not gone.isdisjoint(outside) or (gone - {name + "Z"}).intersection(labels_named(block)):
        return None
    if isinstance(first, s.Line) and first.span is not None and head.span is None:
        made[len(before)] = replace(head, span=first.span)
    ends[id(closing)] = name + "Z"
    return made


def _name(item: s.Item) -> str | None:
    match item:
        case s.Line(
            label=None,
            statement=s.If(then=s.Target(place=str() as place), otherwise=None)
            | s.Jump("GoTo", s.Target(place=str() as place)),
        ):
            found = _FIRST.fullmatch(place.upper())
            return found.group(1) if found else None
    return None


Row = tuple[list[tuple[s.Case, str | None]], s.Expression, int, s.Line | None]


def _row(lines: Sequence[s.Item], at: int, name: str) -> Row | None:
    """The cases, what is selected by, the place behind the row, the jump to the default."""
    cases: list[tuple[s.Case, str | None]] = []
    subject: s.Expression | None = None
    while at < len(lines):
        match lines[at]:
            case s.Line(
                label=None,
                comment=comment,
                statement=s.If(
                    condition=condition, then=s.Target(place=str() as place), otherwise=None
                ),
            ):
                tested = _test(condition)
                if tested is None or (subject is not None and tested[0] != subject):
                    return None
                subject, item = tested
                if cases and place.upper() == f"{name}C{len(cases)}" and comment is None:
                    old, said = cases[-1]
                    cases[-1] = s.Case((*old.items, item)), said
                elif place.upper() == f"{name}C{len(cases) + 1}":
                    cases.append((s.Case((item,)), comment))
                else:
                    return None
            case (
                s.Line(label=None, statement=s.Jump("GoTo", s.Target(place=str() as place))) as line
            ) if subject is not None:
                if place.upper() == name + "Z":
                    return cases, subject, at + 1, None
                if place.upper() == f"{name}C{len(cases) + 1}":
                    return cases, subject, at + 1, line
                return None
            case _:
                return None
        at += 1
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
