"""Where blocks and procedures begin and end in the code lines of a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import closed, divided, opened
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.melfa_basic.tree.jumping import THEN, branches

Entry = s.Line | MoveRows
Code = Sequence[Entry]


def is_command(item: Entry, keyword: str) -> bool:
    """Whether a line is that word alone."""
    return isinstance(item, s.Line) and item.label is None and item.statement == s.Command(keyword)


def is_blank(item: Entry) -> bool:
    return isinstance(item, s.Line) and not (item.statement or item.label or item.comment)


def structure(code: Code) -> dict[int, list[int]]:
    """First line of each block → the places of all its keywords, the last one included.

    A block that is not closed, or not in order, is not in it.
    """
    found: dict[int, list[int]] = {}
    stack: list[tuple[str, list[int]]] = []
    for at, item in enumerate(code):
        if not isinstance(item, s.Line):
            continue
        statement = item.statement
        kind = opened(statement)
        if kind:
            stack.append((kind, [at]))
            continue
        middle = divided(statement)
        if middle and stack and stack[-1][0] == middle and item.label is None:
            stack[-1][1].append(at)
        for kind in closed(statement):
            _close(stack, kind, at, found, item.label is None)
    return found | _jumping(code)


def _close(
    stack: list[tuple[str, list[int]]], kind: str, at: int, found: dict[int, list[int]], plain: bool
) -> None:
    if stack and stack[-1][0] == kind:
        _, places = stack.pop()
        if plain:
            found[places[0]] = [*places, at]
    else:
        stack.clear()


def _jumping(code: Code) -> dict[int, list[int]]:
    """The same for an `If` that is written with jumps: see `branches`."""
    labels: dict[str, int] = {}
    for at, item in enumerate(code):
        if isinstance(item, s.Line) and item.label is not None:
            if item.statement is not None or item.comment is not None:
                continue
            labels.setdefault(item.label.upper(), at)
    found: dict[int, list[int]] = {}
    for at, item in enumerate(code):
        match item:
            case s.Line(
                label=None, comment=None, statement=s.If(then=s.Target(place=str() as name))
            ):
                first = THEN.fullmatch(name)
                places = branches(code, labels, at, first.group(1)) if first else None
                if places:
                    found[at] = places
    return found


def labels_in(code: Code, low: int, high: int) -> set[str]:
    """Labels of a range, in upper case."""
    return {
        item.label.upper()
        for item in code[low:high]
        if isinstance(item, s.Line) and item.label is not None
    }


def depths(code: Code, blocks: Mapping[int, list[int]]) -> list[int]:
    """In how many blocks each line stands, its first and last line included."""
    change = [0] * (len(code) + 1)
    for first, places in blocks.items():
        change[first] += 1
        change[places[-1] + 1] -= 1
    depth, at = [], 0
    for step in change[:-1]:
        at += step
        depth.append(at)
    return depth


def innermost_ends(count: int, blocks: Mapping[int, list[int]]) -> dict[int, int]:
    """By line, the last line of the innermost block that it stands in."""
    ends: dict[int, int] = {}
    around: list[int] = []
    for at in range(count):
        while around and around[-1] <= at:
            around.pop()
        if around:
            ends[at] = around[-1]
        if at in blocks:
            around.append(blocks[at][-1])
    return ends
