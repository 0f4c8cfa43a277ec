"""The procedures that the code of a file holds: what `GoSub` calls, and functions."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import Final

from assistant.languages.line_blocks import Exits
from assistant.languages.melfa_basic.lift.structure.blocks import Code, is_blank, is_lone_command
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import blocks_of, statement_of
from assistant.languages.melfa_basic.tree.targets import exits_of, graph_of, labels_of
from assistant.languages.melfa_basic.tree.walk import statements_in


@dataclass(frozen=True, slots=True)
class Region:
    """Lines low to high (not included) of one procedure's body.

    label: what `GoSub` calls it by, upper case; None for the first procedure and functions.
    function: its head. before: lines that run ahead of the body, those above the first function.
    notes, behind: lines of comment above a function, and below the last one. answers: the word
    by which interrupts lead there, empty if none do. unused: no statement of the file calls it.
    """

    low: int
    high: int
    label: str | None = None
    function: s.Function | None = None
    before: tuple[int, int] = (0, 0)
    notes: tuple[int, int] = (0, 0)
    behind: tuple[int, int] = (0, 0)
    answers: str = ""
    unused: bool = False

    @property
    def is_first(self) -> bool:
        return self.label is None and (self.function is None or self.before is not NOWHERE)

    def holds(self, at: int) -> bool:
        return self.low <= at < self.high or self.before[0] <= at < self.before[1]

    def places(self) -> list[int]:
        return [*range(*self.before), *range(self.low, self.high)]


NOWHERE = (-1, -1)
"""`before` of a function that is not the main one."""


def procedure_regions(
    code: Code, depth: Sequence[int], named: Mapping[str, str], own: bool
) -> list[Region]:
    """The procedures of a file, the one that runs first before the others."""
    found = _function_regions(code)
    if found is not None:
        return found
    answering = {} if own else interrupt_handlers(code)
    unused = set() if own else unused_subroutines(code, depth)
    starts = _procedure_starts(code, depth, named, own, answering, unused)
    edges: list[tuple[int, str | None]] = [(0, None), *starts]
    made = []
    for i, (start, label) in enumerate(edges):
        stop = edges[i + 1][0] if i + 1 < len(edges) else len(code)
        if label is None or label in set(jump_targets(code, range(start, stop))):
            made.append(_without_end(code, start, stop, label))
        else:
            made.append(
                replace(_without_end(code, start + 1, stop, label), notes=(start, start + 1))
            )
    return [
        replace(one, answers=answering.get(one.label or "", ""), unused=one.label in unused)
        for one in made
    ]


def _without_end(code: Code, low: int, high: int, label: str | None) -> Region:
    """Without the `End` or `Return` that it ends with."""
    stop = high
    while stop > low and is_blank(code[stop - 1]):
        stop -= 1
    if stop > low and is_lone_command(code[stop - 1], "End" if label is None else "Return"):
        stop -= 1
    return Region(low, stop, label)


RETURN_TO_PROGRAM: Final = s.Command("Return", (s.Number(0),))
"""Goes on with what an interrupt came in."""
_END: Final = s.Command("End")


def interrupt_handlers(code: Code) -> dict[str, str]:
    """What interrupts lead to, by label, with their word: lines that only they lead to.

    What they call goes back to where it came by `Return 0` alone; what they go to ends the program.
    """
    calls, found = called_labels(code), dict[str, str]()
    for item in code:
        if isinstance(node := statement_of(item), s.DefAct) and node.stop.upper() in STOP_WORDS:
            label = target_name(node.target)
            found[label] = node.keyword if found.get(label, node.keyword) == node.keyword else ""
    labels = labels_of(code)
    return {
        label: word
        for label, word in found.items()
        if word
        and label in labels
        and label not in calls
        and _ends_as_handler(code, labels[label], word)
    }


FATAL_ERRORS: Final = range(9000, 9200)
"""Errors of the program's own that end it (COSIROP: ERROR)."""
STOP_WORDS: Final = ("", "S", "F")
"""Ways in which an interrupt stops the arm at once (COSIROP: DEF ACT; F of the force sensor)."""


def _ends_as_handler(code: Code, at: int, word: str) -> bool:
    """Whether the lines from a label on end as what an interrupt leads to has to."""
    last = RETURN_TO_PROGRAM if word == "GoSub" else _END
    for item in code[at:]:
        node = statement_of(item)
        match node:
            case s.Command("Return" | "End"):
                return node == last
            case s.Command("Error", (s.Number(number),)) if (
                FATAL_ERRORS.start <= number < FATAL_ERRORS.stop
            ):
                return word == "GoTo"
    return False


def _function_regions(code: Code) -> list[Region] | None:
    """Functions and the lines above them; None if there are none, or not in order."""
    spans: list[tuple[int, int, s.Function]] = []
    head: tuple[int, s.Function] | None = None
    for at, item in enumerate(code):
        statement = statement_of(item)
        if isinstance(statement, s.Function):
            if head is not None:
                return None
            head = at, statement
        elif statement == s.Command("FEnd"):
            if head is None:
                return None
            spans.append((head[0], at, head[1]))
            head = None
    if not spans or head is not None:
        return None
    notes, above = [], 0
    for start, end, _ in spans:
        between = code[above:start]
        if above and not all(is_note(item) for item in between):
            return None
        notes.append((above, start))
        above = end + 1
    if not all(is_note(item) or is_lone_command(item, "End") for item in code[above:]):
        return None
    prefix = _comments_above(code, spans[0][0])
    notes[0] = prefix, spans[0][0]
    main = next((k for k, (_, _, f) in enumerate(spans) if f.name.upper() == "MAIN"), None)
    made = [
        Region(start + 1, end, None, f, (0, prefix) if k == main else NOWHERE, notes[k])
        for k, (start, end, f) in enumerate(spans)
    ]
    made[-1] = replace(made[-1], behind=(above, len(code)))
    if main is None:
        return [Region(0, prefix), *made]
    return [made[main], *made[:main], *made[main + 1 :]]


def is_note(item: object) -> bool:
    return isinstance(item, s.Line) and item.statement is None and item.label is None


def _comments_above(code: Code, first: int) -> int:
    """Where the comments begin that stand right above the first function."""
    while first and is_note(code[first - 1]):
        first -= 1
    return first


# ------------------------------------------------------------------------------ subroutines


def _procedure_starts(
    code: Code,
    depth: Sequence[int],
    named: Mapping[str, str],
    own: bool,
    answering: Mapping[str, str],
    unused: Set[str],
) -> list[tuple[int, str]]:
    """Place and label (upper case) of each procedure after the first.

    Own files name them in the heading. In others a procedure is what `GoSub` calls, if nothing
    runs into it from above, and no jump leads in or out. unused: see `unused_subroutines`.
    """
    wanted = set(named) if own else called_labels(code) | set(answering) | unused
    starts: list[tuple[int, str]] = []
    for at, item in enumerate(code):
        if item.label is None or depth[at]:
            continue
        label = item.label.upper()
        if label not in wanted or item.statement is not None:
            continue
        if own or not goes_on_above(code, at):
            starts.append((at, label))
            wanted.discard(label)
    return starts if own else _closed(code, starts)


_CALLED_FROM_ELSEWHERE: Final = "*L_"
"""Prefix of labels of a base program that other programs may call (manual CR1D, 4.3.5)."""


def unused_subroutines(code: Code, depth: Sequence[int]) -> set[str]:
    """Labels of subroutines that no line calls or jumps to, in upper case.

    Old subroutines remain in files: nothing runs into their lines, and these end with `Return`.
    """
    graph = graph_of(code, range(len(code)), blocks_of(code))
    live = graph.reached([0, *graph.handlers], through_calls=True) if code else set()
    found = set[str]()
    above = set[str]()  # what lines above jump to
    for at, item in enumerate(code):
        if at:
            above.update(jump_targets(code, (at - 1,)))
        label = "" if item.label is None else item.label.upper()
        if not label or depth[at] or at in live or label.startswith(_CALLED_FROM_ELSEWHERE):
            continue
        if goes_on_above(code, at) or label in above:
            continue
        if any(_returns(statement_of(code[to])) for to in graph.reached([at])):
            found.add(label)
    return found


def _returns(statement: s.Statement | None) -> bool:
    return any(one == s.Command("Return") for one in statements_in(statement))


def _closed(code: Code, starts: list[tuple[int, str]]) -> list[tuple[int, str]]:
    """Those that no jump leads into or out of; an interrupt costs its own statements alone."""
    while starts:
        edges = [0, *(at for at, _ in starts), len(code)]
        spans = list(itertools.starmap(range, itertools.pairwise(edges)))
        inside = [labels_of(code, span) for span in spans]
        bad: set[int] = set()
        for k, span in enumerate(spans):
            for name in (target_name(to) for at in span for to in _exits(code, at).jumps):
                other = next((j for j, labels in enumerate(inside) if name in labels), k)
                if other != k:
                    bad |= {j for j in (other, k) if j}
        if not bad:
            return starts
        starts = [start for k, start in enumerate(starts, 1) if k not in bad]
    return starts


def _exits(code: Code, at: int) -> Exits[s.Target]:
    return exits_of(statement_of(code[at]))


def called_labels(code: Code) -> set[str]:
    """What `GoSub` statements name."""
    return {target_name(to) for item in code for to in exits_of(statement_of(item)).calls}


def jump_targets(code: Code, places: Iterable[int], besides: Collection[str] = ()) -> Iterator[str]:
    """What statements of some lines go to, and interrupts because of them.

    besides: labels that interrupts may lead to.
    """
    for at in places:
        exits = exits_of(statement_of(code[at]))
        yield from map(target_name, exits.jumps)
        yield from (
            to for to in (target_name(one) for one, _ in exits.handlers) if to not in besides
        )


def odd_entries(code: Code, regions: Sequence[Region]) -> set[str]:
    """Labels that are reached by interrupts, or by calls of what is no procedure."""
    interrupts = (to for item in code for to, _ in exits_of(statement_of(item)).handlers)
    odd = called_labels(code) - {region.label for region in regions if region.label is not None}
    answering = {region.label for region in regions if region.answers}
    return odd | (set(map(target_name, interrupts)) - answering)


def target_name(target: s.Target) -> str:
    """How a jump's target is told from others: the label in upper case, or `#` and the step."""
    place = target.place
    return place.upper() if isinstance(place, str) else f"#{place}"


def next_word(code: Code, at: int) -> int:
    """The next line that is more than a comment, or the end."""
    return next((k for k in range(at + 1, len(code)) if not is_note(code[k])), len(code))


def goes_on_above(code: Code, at: int) -> bool:
    """Whether control may run into the place from the line above it, or from the beginning."""
    above = next((k for k in range(at - 1, -1, -1) if not is_note(code[k])), None)
    if above is None:
        return True
    return exits_of(statement_of(code[above])).on and not _loops_for_ever(code, above)


def _loops_for_ever(code: Code, at: int) -> bool:
    """True if a line is the end of a loop whose condition always holds and that nothing leaves."""
    if statement_of(code[at]) != s.Command("WEnd"):
        return False
    blocks = blocks_of(code)
    loop = blocks.words.get(at)
    if loop is None or loop.first not in loop.certain or len(blocks.closing.get(at, ())) != 1:
        return False
    inside = range(loop.first, at)
    return not any(
        blocks.around.get(k) is loop and exits_of(statement_of(code[k])).breaks for k in inside
    )
