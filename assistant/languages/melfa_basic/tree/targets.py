"""Where statements lead, the labels and steps that they name, and the ways through lines."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final, TypeVar

from assistant.languages import line_blocks
from assistant.languages.line_blocks import ON, Blocks, Exits, Graph
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import statement_of
from assistant.languages.step_numbers import Change, cut_at, first_step
from assistant.program.rewriting import rewrite

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
    """Where a statement leads; a target is a jump to it."""
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
