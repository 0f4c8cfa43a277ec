"""Jumps that stand for a block made blocks again: `If` … `EndIf`, wide `Wait`, `Break`.

Only the very forms that `jumps` writes are taken, and only if nothing else goes to their labels;
every other jump stays as it is.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

from assistant.languages.melfa_basic.convert.chains import chained
from assistant.languages.melfa_basic.convert.nesting import Block, Node, flat, nested
from assistant.languages.melfa_basic.convert.steps import targets
from assistant.languages.melfa_basic.tables.dialects import Dialect
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.jumping import THEN, branches, goes_to

_WAIT: Final = re.compile(r"W[0-9]+")
_LEFT: Final = re.compile(r"B[0-9]+Z")


def to_blocks(items: Sequence[s.Item], dialect: Dialect) -> list[s.Item]:
    """The lines with such jumps as the blocks of a dialect that has them."""
    lines = list(items)
    if dialect.wide_wait:
        lines = _waits(lines)
    chains: dict[int, str] = {}
    if dialect.nested_select:
        lines = chained(lines, chains)
    refused: set[str] = set()
    while dialect.blocks:
        made, ends = _ifs(lines, refused)
        structure = nested(made)
        if structure is None:
            return _without_ifs(lines, refused) if ends else lines
        if dialect.breaks:
            behind: dict[int, str] = {}
            _breaks(structure, ends | chains, behind)
            made = flat(structure)
            wanted = {t.place.upper() for t in targets(made) if isinstance(t.place, str)}
            made = [i for i in made if behind.get(id(i), "") in {"", *wanted}]
        missing = _missing(made, lines)
        left = {name for name in ends.values() if name in missing or _partly(name, missing)}
        if not left:
            return made
        refused |= left
    return lines


def _without_ifs(lines: list[s.Item], refused: set[str]) -> list[s.Item]:
    """As far as it goes with the first `If` that crosses another block left as it is."""
    made: list[s.Item] = lines
    for name in sorted(set(_names(lines)) - refused):
        tried, ends = _ifs(lines, {n for n in _names(lines) if n != name})
        if ends and nested(tried) is None:
            refused.add(name)
    made, _ = _ifs(lines, refused)
    return made if nested(made) is not None else lines


def _names(lines: Sequence[s.Item]) -> Iterator[str]:
    for item in lines:
        if isinstance(item, s.Line) and item.label is not None:
            if found := THEN.fullmatch(item.label.upper()):
                yield found.group(1) + "Z"


def _missing(made: Sequence[s.Item], before: Sequence[s.Item]) -> set[str]:
    """Labels that jumps still go to and that are there no more, in upper case."""
    there = {i.label.upper() for i in made if isinstance(i, s.Line) and i.label}
    were = {i.label.upper() for i in before if isinstance(i, s.Line) and i.label}
    wanted = {t.place.upper() for t in targets(made) if isinstance(t.place, str)}
    return (wanted - there) & were


def _partly(end: str, missing: set[str]) -> bool:
    return any(re.fullmatch(end[:-1] + r"[TN][0-9]+", name) for name in missing)


# ---------------------------------------------------------------------------------- Wait


def _waits(items: list[s.Item]) -> list[s.Item]:
    counts = Counter(t.place.upper() for t in targets(items) if isinstance(t.place, str))
    made: list[s.Item] = []
    at = 0
    while at < len(items):
        condition = _wait(items[at : at + 3], counts)
        if condition is None:
            made.append(items[at])
            at += 1
            continue
        test = items[at + 1]
        if isinstance(test, s.Line):
            made.append(replace(test, statement=s.Command("Wait", (condition,))))
        at += 3
    return made


def _wait(lines: Sequence[s.Item], counts: Counter[str]) -> s.Expression | None:
    """The condition of `*W1`, `IF … THEN *W1Z ELSE *W1`, `*W1Z`."""
    match lines:
        case [
            s.Line(label=str() as first, statement=None, comment=None),
            s.Line(
                label=None,
                statement=s.If(
                    condition=condition,
                    then=s.Target(place=str() as out),
                    otherwise=s.Target(place=str() as again),
                ),
            ),
            s.Line(label=str() as last, statement=None, comment=None),
        ]:
            name = first.upper()
            if (
                _WAIT.fullmatch(name)
                and again.upper() == name
                and out.upper() == last.upper() == name + "Z"
                and counts[name] == counts[name + "Z"] == 1
            ):
                return condition
    return None


# ------------------------------------------------------------------------------------ If


def _ifs(items: Sequence[s.Item], refused: set[str]) -> tuple[list[s.Item], dict[int, str]]:
    """The lines with `If` blocks, and by the identity of an `EndIf` the label that was there."""
    labels = {
        i.label.upper(): at
        for at, i in enumerate(items)
        if isinstance(i, s.Line) and i.label and i.statement is None and i.comment is None
    }
    lines: list[s.Item | None] = list(items)
    ends: dict[int, str] = {}
    for at, item in enumerate(items):
        match item:
            case s.Line(label=None, statement=s.If(then=s.Target(place=str() as name))):
                found = THEN.fullmatch(name.upper())
                if found is None or found.group(1) + "Z" in refused:
                    continue
                places = branches(items, labels, at, found.group(1))
                if places:
                    end = _replaced(lines, items, places)
                    ends[id(end)] = found.group(1) + "Z"
    return [line for line in lines if line is not None], ends


def _replaced(lines: list[s.Item | None], items: Sequence[s.Item], places: Sequence[int]) -> s.Line:
    """Puts the words of a block where the jumps stand; gives the line that ends it."""
    *branches, end = places
    for first in range(0, len(branches), 3):
        at, jump, after = branches[first : first + 3]
        test, goto = items[at], items[jump]
        if not isinstance(test, s.Line) or not isinstance(test.statement, s.If):
            continue
        condition = test.statement.condition
        opening: s.Statement = s.ElseIf(condition) if first else s.If(condition, None)
        lines[at] = replace(test, statement=opening)
        lines[at + 1] = lines[after] = None
        comment = goto.comment if isinstance(goto, s.Line) else None
        is_last = first + 3 == len(branches)
        if is_last and (after + 1 < end or comment is not None):
            lines[jump] = s.Line(statement=s.Command("Else"), comment=comment)
        else:
            lines[jump] = s.Line(comment=comment) if comment is not None else None
    closing = s.Line(statement=s.Command("EndIf"))
    lines[end] = closing
    return closing


# --------------------------------------------------------------------------------- Break


def _breaks(nodes: Sequence[Node], ends: dict[int, str], behind: dict[int, str]) -> None:
    """Jumps behind the innermost block made `Break`, in place.

    behind: gets the labels below such blocks, by the identity of their lines.
    """
    for at, node in enumerate(nodes):
        if not isinstance(node, Block):
            continue
        label = ends.get(id(node.end))
        below = nodes[at + 1] if at + 1 < len(nodes) else None
        match below:
            case s.Line(label=str() as name, statement=None, comment=None):
                if label is None and node.kind != "Function" and _LEFT.fullmatch(name.upper()):
                    label = behind[id(below)] = name.upper()
        for part in node.parts:
            if label is not None:
                part.body[:] = [_broken(inner, label) for inner in part.body]
            _breaks(part.body, ends, behind)


def _broken(node: Node, label: str) -> Node:
    if not isinstance(node, s.Line):
        return node
    if goes_to(node, label):
        return replace(node, statement=s.Command("Break"))
    if isinstance(node.statement, s.If) and node.statement.then is not None:
        branches = [
            s.Command("Break") if b == s.Jump("GoTo", s.Target(label)) else b
            for b in (node.statement.then, node.statement.otherwise)
        ]
        return replace(node, statement=s.If(node.statement.condition, *branches))
    return node
