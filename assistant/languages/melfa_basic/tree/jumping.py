"""An `If`, and a `Wait` for any condition, written with jumps for dialects that lack them.

IF M1>0 THEN *I1T1 ELSE *I1N1
*I1T1
…
GOTO *I1Z
*I1N1
…
*I1Z

*W1
IF M1>0 THEN *W1Z ELSE *W1
*W1Z
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.targets import lone_labels

FIRST_BRANCH_LABEL: Final = re.compile(r"(I[0-9]+)T1")
"""The label of the first branch, in upper case; the group is what all its labels begin with."""
WAIT_LABEL: Final = re.compile(r"W[0-9]+", re.IGNORECASE)
"""The label at the top of a loop that waits."""


def jumping_ifs(lines: Sequence[object]) -> dict[int, tuple[str, list[int]]]:
    """By the place of its first line what the labels of each begin with, and its `branches`."""
    labels = lone_labels(lines)
    found: dict[int, tuple[str, list[int]]] = {}
    for at, line in enumerate(lines):
        match line:
            case s.Line(label=None, statement=s.If(then=s.Target(place=str() as name))):
                first = FIRST_BRANCH_LABEL.fullmatch(name.upper())
                places = branch_lines(lines, labels, at, first[1]) if first else None
                if first and places:
                    found[at] = first[1], places
    return found


def branch_lines(
    lines: Sequence[object], labels: Mapping[str, int], at: int, name: str
) -> list[int] | None:
    """Places: for each branch its `If`, the jump to the end, the label of the next; then the end.

    None where one of them is not as it should be. labels: places of lines that are a label and
    nothing else, by upper-case name. at: of the first `If`. name: group of THEN.
    """
    places: list[int] = []
    branch, end = 1, labels.get(name + "Z", -1)
    while True:
        then, other = f"{name}T{branch}", f"{name}N{branch}"
        after = labels.get(other, -1)
        if not _is_branch_test(lines[at], then, other) or labels.get(then) != at + 1:
            return None
        if not at + 2 <= after - 1 < end or not jumps_to(lines[after - 1], name + "Z"):
            return None
        places += [at, after - 1, after]
        branch += 1
        if labels.get(f"{name}T{branch}") != after + 2:
            return [*places, end]
        at = after + 1


def _is_branch_test(line: object, then: str, other: str) -> bool:
    """Whether a line is an `If` that jumps to either label."""
    match line:
        case s.Line(
            label=None,
            statement=s.If(
                then=s.Target(place=str() as yes), otherwise=s.Target(place=str() as no)
            ),
        ):
            return (yes.upper(), no.upper()) == (then, other)
    return False


def is_plain_wait(condition: s.Expression | None) -> bool:
    """Whether it is `variable = constant`, which every version waits for."""
    match condition:
        case s.Binary("=", s.Variable(), s.Number()):
            return True
    return False


def waiting_loop(label: str, condition: s.Expression, line: s.Line) -> list[s.Line]:
    """A loop that only waits for a condition. line: that the test stands in."""
    test = s.If(condition, s.Target(label + "Z"), s.Target(label))
    return [s.Line(label=label), replace(line, statement=test), s.Line(label=label + "Z")]


def read_waiting_loop(lines: Sequence[object]) -> tuple[str, s.Expression] | None:
    """Label and condition of `*W1`, `IF … THEN *W1Z ELSE *W1`, `*W1Z`, a loop that only waits."""
    match lines:
        case [
            s.Line(label=str(first), statement=None, comment=None),
            s.Line(
                label=None,
                statement=s.If(condition, s.Target(place=str(out)), s.Target(place=str(again))),
            ),
            s.Line(label=str(last), statement=None, comment=None),
        ] if WAIT_LABEL.fullmatch(first):
            name = first.upper()
            if again.upper() == name and out.upper() == last.upper() == name + "Z":
                return name, condition
    return None


def jumps_to(line: object, label: str) -> bool:
    """Whether a line is a jump to a label, in upper case, and nothing else but a comment."""
    match line:
        case s.Line(label=None, statement=s.Jump("GoTo", s.Target(place=str() as place))):
            return place.upper() == label
    return False
