"""Jumps that stand for a block made blocks again: `If` … `EndIf`, wide `Wait`, `Select`, `Break`.

Only the very forms that `jumps` writes are taken, and only if nothing else goes to their labels;
every other jump stays as it is.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

from assistant.languages.line_blocks import Blocks
from assistant.languages.melfa_basic.tables.dialects import Dialect
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import blocks_of
from assistant.languages.melfa_basic.tree.jumping import jumping_ifs, jumps_to, read_waiting_loop
from assistant.languages.melfa_basic.tree.targets import labels_named, labels_of, lone_labels

_FIRST_CASE_LABEL: Final = re.compile(r"(S[0-9]+)C1")
_BREAK_LABEL: Final = re.compile(r"B[0-9]+Z")


def with_blocks(items: Sequence[s.Item], dialect: Dialect) -> list[s.Item]:
    """The lines with such jumps as the blocks of a dialect that has them."""
    lines = list(items)
    if dialect.wide_wait:
        lines = _with_waits(lines)
    chains: dict[int, str] = {}
    if dialect.nested_select:
        lines = with_selects(lines, chains)
    refused: set[str] = set()
    while dialect.blocks:
        made, ends = _with_ifs(lines, refused)
        blocks = blocks_of(made)
        if blocks.sound:
            if dialect.breaks:
                made = _with_breaks(made, blocks, ends | chains)
            missing = (set(labels_named(made)) - labels_of(made).keys()) & labels_of(lines).keys()
            left = {
                name
                for name in ends.values()
                if name in missing or _is_partly_missing(name, missing)
            }
        else:
            known = {*ends.values(), *refused}
            left = {name for name in ends.values() if _crosses(lines, known - {name})}
            if not left:
                return lines
        if not left:
            return made
        refused |= left
    return lines


def _crosses(lines: Sequence[s.Item], refused: set[str]) -> bool:
    """Whether an `If` crosses other blocks, the only one that is not refused."""
    made, _ = _with_ifs(lines, refused)
    return not blocks_of(made).sound


def _is_partly_missing(end: str, missing: set[str]) -> bool:
    return any(re.fullmatch(end[:-1] + r"[TN][0-9]+", name) for name in missing)


# ---------------------------------------------------------------------------------- Wait


def _with_waits(items: list[s.Item]) -> list[s.Item]:
    counts = Counter(labels_named(items))
    made: list[s.Item] = []
    at = 0
    while at < len(items):
        found = read_waiting_loop(items[at : at + 3])
        if found is None or counts[found[0]] != 1 or counts[found[0] + "Z"] != 1:
            made.append(items[at])
            at += 1
            continue
        test = items[at + 1]
        if isinstance(test, s.Line):
            made.append(replace(test, statement=s.Command("Wait", (found[1],))))
        at += 3
    return made


# ------------------------------------------------------------------------------------ If


def _with_ifs(items: Sequence[s.Item], refused: set[str]) -> tuple[list[s.Item], dict[int, str]]:
    """The lines with `If` blocks, and by the identity of an `EndIf` the label that was there."""
    lines: list[s.Item | None] = list(items)
    ends: dict[int, str] = {}
    for name, places in jumping_ifs(items).values():
        if name + "Z" not in refused:
            ends[id(_put_block_words(lines, items, places))] = name + "Z"
    return [line for line in lines if line is not None], ends


def _put_block_words(
    lines: list[s.Item | None], items: Sequence[s.Item], places: Sequence[int]
) -> s.Line:
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


# -------------------------------------------------------------------------------- Select


def with_selects(items: Sequence[s.Item], ends: dict[int, str]) -> list[s.Item]:
    """The lines with such rows as blocks. ends: gets the last label of each, by its line."""
    lines = list(items)
    at = 0
    while at < len(lines):
        made = _select_at(lines, at, ends)
        if made is not None:
            lines = made
        at += 1
    return lines


def _select_at(lines: list[s.Item], at: int, ends: dict[int, str]) -> list[s.Item] | None:
    """All lines with the row that begins here as a block, None if none begins here."""
    aimed = _aim_of(lines[at])
    found = _FIRST_CASE_LABEL.fullmatch(aimed[1]) if aimed is not None else None
    if found is None:
        return None
    name = found[1]
    labels = lone_labels(lines)
    last = labels.get(name + "Z", -1)
    row = _case_row(lines, at, name)
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
        if not jumps_to(lines[high - 1], name + "Z") or high - 1 <= low:
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


def _aim_of(item: s.Item) -> tuple[s.Expression | None, str] | None:
    """Where a line goes, in upper case, and on what condition; None if it does anything else."""
    match item:
        case s.Line(label=None, statement=s.If(condition, s.Target(place=str() as place), None)):
            return condition, place.upper()
        case s.Line(label=None, statement=s.Jump("GoTo", s.Target(place=str() as place))):
            return None, place.upper()
    return None


CaseRow = tuple[list[tuple[s.Case, str | None]], s.Expression, int, s.Line | None]


def _case_row(lines: Sequence[s.Item], at: int, name: str) -> CaseRow | None:
    """The cases, what is selected by, the place behind the row, the jump to the default."""
    cases: list[tuple[s.Case, str | None]] = []
    subject: s.Expression | None = None
    for behind, line in enumerate(lines[at:], at + 1):
        aimed = _aim_of(line)
        if aimed is None or not isinstance(line, s.Line):
            return None
        condition, label = aimed
        following = f"{name}C{len(cases) + 1}"
        if condition is None:
            if subject is None or label not in (following, name + "Z"):
                return None
            return cases, subject, behind, line if label == following else None
        tested = _case_of(condition)
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


def _case_of(condition: s.Expression) -> tuple[s.Expression, s.CaseRange | s.CaseIs] | None:
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


# --------------------------------------------------------------------------------- Break


def _with_breaks(items: Sequence[s.Item], blocks: Blocks, ends: Mapping[int, str]) -> list[s.Item]:
    """Jumps behind the innermost block made `Break`, without labels that nothing goes to then.

    ends: labels that were at the end of a block, by the identity of the line that ends it.
    """
    leaving: dict[int, str] = {}
    below: dict[int, str] = {}
    labels = {at: name for name, at in lone_labels(items).items() if _BREAK_LABEL.fullmatch(name)}
    for block in blocks.all:
        if block.last is None or blocks.closing[block.last][-1] is not block:
            continue  # the `Next` of an outer loop as well
        label = ends.get(id(items[block.last]))
        if label is None and block.last + 1 in labels:
            label = below[block.last + 1] = labels[block.last + 1]
        if label is not None:
            leaving[block.first] = label
    made: list[s.Item] = []
    for at, item in enumerate(items):
        inner = blocks.around[at]
        label = leaving.get(inner.first) if inner is not None and at not in inner.parts else None
        made.append(item if label is None else _break_line(item, label))
    wanted = set(labels_named(made))
    return [item for at, item in enumerate(made) if below.get(at, "") in {"", *wanted}]


def _break_line(node: s.Item, label: str) -> s.Item:
    if not isinstance(node, s.Line):
        return node
    if jumps_to(node, label):
        return replace(node, statement=s.Command("Break"))
    if isinstance(node.statement, s.If) and node.statement.then is not None:
        branches = [
            s.Command("Break") if b == s.Jump("GoTo", s.Target(label)) else b
            for b in (node.statement.then, node.statement.otherwise)
        ]
        return replace(node, statement=s.If(node.statement.condition, *branches))
    return node
