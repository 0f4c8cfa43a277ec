"""Control flow of lines: blocks, jump targets and labels, and blocks that are written as jumps.

Dialects without `If` blocks or a `Wait` for any condition write them with jumps:

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

import operator
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, TypeVar

from assistant.languages import line_blocks
from assistant.languages.line_blocks import NO_WORD, ON, Blocks, BlockWord, Exits, Graph
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.step_numbers import Change, cut_at, first_step
from assistant.program.rewriting import rewrite

CLOSING: Final = {"Next": "For", "WEnd": "While", "EndIf": "If", "End Select": "Select"}
"""Word → the kind of block that it closes."""
_BLOCK_COMMANDS: Final[Mapping[str, BlockWord]] = {
    **{word: BlockWord(closes=(kind,)) for word, kind in CLOSING.items()},
    "While": BlockWord("While", "loop"),
    "Else": BlockWord(parts="If", certain=True),
    "Default": BlockWord(parts="Select", certain=True),
    "FEnd": BlockWord(bounds="ends"),
}
_BLOCK_STATEMENTS: Final[Mapping[type, BlockWord]] = {
    s.For: BlockWord("For", "loop"),
    s.Select: BlockWord("Select", "choice"),
    s.ElseIf: BlockWord(parts="If"),
    s.Case: BlockWord(parts="Select"),
    s.Function: BlockWord(bounds="begins"),
}


def block_word(statement: s.Statement | None) -> BlockWord:
    """Return the role of a statement in blocks; `Next M1,M2` closes two loops."""
    match statement:
        case s.Command("While", (condition, *_)) if _always_holds(condition):
            return BlockWord("While", "loop", certain=True)
        case s.Command(keyword=keyword):
            return _BLOCK_COMMANDS.get(keyword, NO_WORD)
        case s.If(then=None):
            return BlockWord("If")
        case s.Next(variables=variables):
            return BlockWord(closes=("For",) * max(1, len(variables)))
    return _BLOCK_STATEMENTS.get(type(statement), NO_WORD)


_COMPARISONS: Final[Mapping[str, Callable[[float, float], bool]]] = {
    "=": operator.eq, "<>": operator.ne, "<": operator.lt, ">": operator.gt,
    "<=": operator.le, ">=": operator.ge,
}  # fmt: skip


def _always_holds(condition: s.Expression | None) -> bool:
    """True for `1` and for comparisons of numbers that hold, such as `1=1`."""
    match condition:
        case s.Number(value=value):
            return bool(value)
        case s.Binary(sign, s.Number(value=one), s.Number(value=two)) if sign in _COMPARISONS:
            return _COMPARISONS[sign](one, two)
    return False


def is_block_word(statement: s.Statement | None) -> bool:
    """True if a statement opens, divides or closes a block."""
    return block_word(statement).is_of_block


def statement_of(item: object) -> s.Statement | None:
    """The statement of a line, None for what has none."""
    return item.statement if isinstance(item, s.Line) else None


def blocks_of(code: Sequence[object], places: Iterable[int] | None = None) -> Blocks:
    """The blocks of the lines at some places, of all if none are given."""
    chosen = range(len(code)) if places is None else places
    return line_blocks.blocks_of((at, block_word(statement_of(code[at]))) for at in chosen)


T = TypeVar("T", s.Item, s.Entry)
I = TypeVar("I", bound=s.Item)  # noqa: E741


_EXITS_OF_WORDS: Final[Mapping[str, Exits[s.Target]]] = {
    "Break": Exits(on=False, breaks=True),
    "Return": Exits(on=False, returns=True),
    "Exit Function": Exits(on=False, returns=True),
    "FEnd": Exits(on=False, returns=True),
    "End": Exits(on=False),
}
"""`Break` leads behind the innermost block, an `If` too: stated for `If` and `Select` [CR1D 4-208],
for loops as programs use it. An `If` on one line is no block.
"""


def exits_of(statement: s.Statement | s.Target | None) -> Exits[s.Target]:
    """Return the exits of a statement; a target is a jump to it."""
    match statement:
        case (s.Target() as target) | s.Jump("GoTo", target):
            return Exits(jumps=(target,), on=False)
        case s.Jump(_, target):
            return Exits(calls=(target,))
        case s.OnJump(_, keyword, targets):
            named = tuple(target for target in targets if target is not None)
            return Exits(jumps=named) if keyword == "GoTo" else Exits(calls=named)
        case s.OnCom(_, target):
            return Exits(handlers=((target, True),))
        case s.DefAct(_, _, keyword, target):
            return Exits(handlers=((target, keyword == "GoSub"),))
        case s.If(_, then, otherwise) if then is not None:
            return exits_of(then) | exits_of(otherwise)
        case s.Command(keyword=keyword, arguments=given):
            named = tuple(one for one in given if isinstance(one, s.Target))
            handlers = Exits(handlers=tuple((target, True) for target in named))
            return handlers if named else _EXITS_OF_WORDS.get(keyword, ON)
    return ON


def graph_of(
    code: Sequence[object],
    places: Sequence[int],
    blocks: Blocks,
    steps: Mapping[int, int] | None = None,
) -> Graph:
    """The ways through the lines at some places, which follow each other in that order.

    steps: place by step number, for jumps to them.
    """
    labels, known = labels_of(code, places), steps or {}

    def find(target: s.Target) -> int | None:
        place = target.place
        return known.get(place) if isinstance(place, int) else labels.get(place.upper())

    return line_blocks.graph_of(places, blocks, lambda at: exits_of(statement_of(code[at])), find)


def targets_in(items: Iterable[object]) -> Iterator[s.Target]:
    """Every jump target of some lines."""
    for item in items:
        # The shared value for no exits is by far the most frequent.
        if (exits := exits_of(statement_of(item))) is not ON:
            yield from exits.targets


def labels_named(items: Iterable[object]) -> Iterator[str]:
    """The labels that the jumps of some lines name, in upper case."""
    for target in targets_in(items):
        if isinstance(target.place, str):
            yield target.place.upper()


def steps_named(items: Iterable[object]) -> set[int]:
    """The step numbers that the jumps of some lines name."""
    return {target.place for target in targets_in(items) if isinstance(target.place, int)}


def labels_written(items: Iterable[object]) -> Iterator[str]:
    """The labels of some lines as they are written."""
    for item in items:
        if isinstance(item, s.Line) and item.label is not None:
            yield item.label


def labels_of(code: Sequence[object], places: Iterable[int] | None = None) -> dict[str, int]:
    """The labels of the lines at some places, in upper case, with the first place of each."""
    found: dict[str, int] = {}
    for at in range(len(code)) if places is None else places:
        item = code[at]
        if isinstance(item, s.Line) and item.label is not None:
            found.setdefault(item.label.upper(), at)
    return found


def lone_labels(code: Sequence[object]) -> dict[str, int]:
    """The same of lines that are a label and nothing else."""
    alone = (
        at
        for at, item in enumerate(code)
        if isinstance(item, s.Line) and item.statement is None and item.comment is None
    )
    return labels_of(code, alone)


def retargeted(item: I, change: Change) -> I:
    """The line with its jumps changed."""

    def changed(node: Any) -> Any:
        place = change(node.place) if isinstance(node, s.Target) else None
        return node if place is None or place == node.place else s.Target(place)

    return rewrite(item, changed) if exits_of(statement_of(item)).targets else item


def with_labelled_jumps(items: Sequence[T]) -> tuple[list[T | s.Line], dict[str, int]]:
    """The lines with jumps to labels only, and which labels were made for which steps.

    A number that no line has stays in its jump. A table of moves is cut where a jump leads to.
    """
    wanted = steps_named(items)
    if not wanted:
        return list(items), {}
    taken = set(labels_of(items))
    made: dict[str, int] = {}
    names: dict[str | int, str] = {}
    lines: list[T | s.Line] = []
    for item in cut_at(items, wanted):
        number = first_step(item)
        if number in wanted and number not in names:
            if isinstance(item, s.Line) and item.label is not None:
                names[number] = item.label
            else:
                label = names[number] = _free_label(f"L{number}", taken)
                made[label] = number
                lines.append(s.Line(label=label, span=getattr(item, "span", None)))
        lines.append(item)
    return [retargeted(item, lambda place: names.get(place, place)) for item in lines], made


def _free_label(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "X"
    taken.add(name)
    return name


_FIRST_BRANCH_LABEL: Final = re.compile(r"(I[0-9]+)T1")
"""The label of the first branch, in upper case; the group is what all its labels begin with."""
WAIT_LABEL: Final = re.compile(r"W[0-9]+", re.IGNORECASE)
"""The label at the top of a loop that waits."""


def jumping_ifs(lines: Sequence[object]) -> dict[int, tuple[str, list[int]]]:
    """First line of each → what its labels begin with, and its `_branch_lines`."""
    labels = lone_labels(lines)
    found: dict[int, tuple[str, list[int]]] = {}
    for at, line in enumerate(lines):
        match line:
            case s.Line(label=None, statement=s.If(then=s.Target(place=str() as name))):
                first = _FIRST_BRANCH_LABEL.fullmatch(name.upper())
                places = _branch_lines(lines, labels, at, first[1]) if first else None
                if first and places:
                    found[at] = first[1], places
    return found


def _branch_lines(
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
        # A line that is not where the compiler puts it is a user's own.
        if not _is_branch_test(lines[at], then, other) or labels.get(then) != at + 1:
            return None
        if not at + 2 <= after - 1 < end or not jumps_to(lines[after - 1], name + "Z"):
            return None
        places += [at, after - 1, after]
        branch += 1
        # Another `If` right below the label is the next branch.
        if labels.get(f"{name}T{branch}") != after + 2:
            return [*places, end]
        at = after + 1


def _is_branch_test(line: object, then: str, other: str) -> bool:
    """True if a line is an `If` that jumps to either label."""
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
    """True for `variable = constant`, which every version can wait for."""
    match condition:
        case s.Binary("=", s.Variable(), s.Number()):
            return True
    return False


def waiting_loop(label: str, condition: s.Expression, line: s.Line) -> list[s.Line]:
    """Return a loop that only waits for a condition. line: the one that contains the test."""
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
    """True if a line only jumps to a label, in upper case; it may have a comment."""
    match line:
        case s.Line(label=None, statement=s.Jump("GoTo", s.Target(place=str() as place))):
            return place.upper() == label
    return False
