"""Procedures in the code lines of a file: blocks, subroutines, functions and interrupt handlers.

A region is what `GoSub` calls, or a function. A file may begin with a jump over its subroutines:
`in_order` puts the main part first. Lines that nothing runs into from above may be anywhere, with
all that follows up to the next line that control never runs past. In programs that were written
here, lines that only call what answers an interrupt (trampolines) are taken out.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import field, replace
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.languages.line_blocks import Blocks, Exits
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.control_flow import (
    blocks_of,
    exits_of,
    graph_of,
    jumping_ifs,
    labels_named,
    labels_of,
    statement_of,
)
from assistant.languages.melfa_basic.tree.walk import literal, statements_in
from assistant.languages.settings_flow import Interrupt

Code = Sequence[s.Entry]


class Structure:
    """The blocks of some code.

    places: first line of each block → the places of all its keywords, the last one included; not
    of a block that is not whole, or whose inner words have labels. depth: by line, in how many of
    these it stands, its first and last line included.
    """

    def __init__(self, code: Code) -> None:
        self.blocks: Blocks = blocks_of(code)
        jumping, named = jumping_ifs(code).items(), Counter(labels_named(code))
        self.places = {
            at: places
            for at, (name, places) in jumping
            if getattr(code[at], "comment", None) is None
            and _has_no_other_jumps(name, places, named)
        } | {
            block.first: block.words
            for block in self.blocks.all
            # A label at an inner word lets jumps enter the block there, which no block can express.
            if block.last is not None and all(code[at].label is None for at in block.words[1:])
        }
        change = [0] * (len(code) + 1)
        for places in self.places.values():
            change[places[0]] += 1
            change[places[-1] + 1] -= 1
        self.depth = list(itertools.accumulate(change[:-1]))


def _has_no_other_jumps(name: str, places: Sequence[int], named: Mapping[str, int]) -> bool:
    """True if no other jumps lead into an `If` of jumps. named: number of uses of each label, by
    label.
    """
    branches = len(places) // 3
    numbers = range(1, branches + 1)
    inner = (f"{name}{letter}{number}" for letter in "TN" for number in numbers)
    return all(named[label] == 1 for label in inner) and named[name + "Z"] == branches


def _is_lone_command(item: s.Entry, keyword: str) -> bool:
    """True if a line is that word alone."""
    return item.label is None and item.statement == s.Command(keyword)


def _is_blank(item: s.Entry) -> bool:
    return isinstance(item, s.Line) and not (item.statement or item.label or item.comment)


@dataclass(frozen=True, slots=True)
class Region:
    """Lines low to high (not included) of one procedure's body.

    label: what `GoSub` calls it by, upper case; None for the first procedure and functions.
    function: its head. before: lines that run ahead of the body, those above the first function.
    notes, behind: lines of comment above a function or a subroutine with its label, and below the
    last one. answers: the word by which interrupts lead there, empty if none do. unused: no
    statement of the file calls it.
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
    answering = {} if own else _interrupt_handlers(code)
    unused = set() if own else _unused_subroutines(code, depth)
    starts = _procedure_starts(code, depth, named, own, answering, unused)
    edges: list[tuple[int, str | None]] = [(0, None), *starts]
    # The comments of programs that were written here are in the procedures that they are of.
    heads = [0, *(at if own else _comments_above(code, at) for at, _ in starts), len(code)]
    made = []
    for i, (start, label) in enumerate(edges):
        stop = heads[i + 1]
        # A loop back to the procedure's label needs it in the body; else the name of the procedure
        # replaces the label.
        in_body = label is None or label in set(_jump_targets(code, range(start, stop)))
        low = start if in_body else start + 1
        answers = answering.get(label or "", "")
        last = _END if label is None else _RETURN if answers != "GoSub" else RETURN_TO_PROGRAM
        high, behind = _without_last(code, low, stop, last), (0, 0)
        if not own and stop == len(code):
            high, behind = _without_comments_below(code, low, stop, high, last)
        region = Region(low, high, label, notes=(heads[i], low), behind=behind)
        made.append(replace(region, answers=answers, unused=label in unused))
    return made


def _without_last(code: Code, low: int, high: int, last: s.Command) -> int:
    """The end of lines without those that are blank and without the statement that ends them."""
    stop = high
    while stop > low and _is_blank(code[stop - 1]):
        stop -= 1
    ends = stop > low and code[stop - 1].label is None and code[stop - 1].statement == last
    return stop - 1 if ends else stop


def _without_comments_below(
    code: Code, low: int, stop: int, high: int, last: s.Command
) -> tuple[int, tuple[int, int]]:
    """The end of the last procedure, and the comments of the file below the word that ends it.

    high: the end if there are none.
    """
    below = max(low, _comments_above(code, stop))
    end = _without_last(code, low, below, last)
    return (end, (below, stop)) if end < below < stop else (high, (0, 0))


RETURN_TO_PROGRAM: Final = s.Command("Return", (s.Number(0),))
"""Goes on with what an interrupt came in."""
_RETURN: Final = s.Command("Return")
_END: Final = s.Command("End")


def _interrupt_handlers(code: Code) -> dict[str, str]:
    """Return the handlers that only interrupts lead to, by label, with the word of the interrupt.

    A called handler returns to the interrupted line by `Return 0` alone; one that is jumped to ends
    the program.
    """
    calls, found = called_labels(code), dict[str, str]()
    for item in code:
        if isinstance(node := statement_of(item), s.DefAct) and node.stop.upper() in _STOP_WORDS:
            label = target_name(node.target)
            found[label] = node.keyword if found.get(label, node.keyword) == node.keyword else ""
    labels = labels_of(code)
    return {
        label: word
        for label, word in found.items()
        # An empty word: handlers that are both called and jumped to have no one meaning.
        if word
        and label in labels
        and label not in calls
        and _ends_as_handler(code, labels[label], word)
    }


_FATAL_ERRORS: Final = range(9000, 9200)
"""Errors of the program's own that end it (COSIROP: ERROR)."""
_STOP_WORDS: Final = ("", "S", "F")
"""Ways in which an interrupt stops the arm at once (COSIROP: DEF ACT; F of the force sensor)."""


def _ends_as_handler(code: Code, at: int, word: str) -> bool:
    """True if the lines from a label on end as an interrupt handler must."""
    last = RETURN_TO_PROGRAM if word == "GoSub" else _END
    for item in code[at:]:
        node = statement_of(item)
        match node:
            case s.Command("Return" | "End"):
                return node == last
            case s.Command("Error", (s.Number(number),)) if (
                _FATAL_ERRORS.start <= number < _FATAL_ERRORS.stop
            ):
                return word == "GoTo"
    return False


def _function_regions(code: Code) -> list[Region] | None:
    """Return functions and the lines above them; None if the code has none, or not in order."""
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
        # Statements between functions belong to none of them.
        between = code[above:start]
        if above and not all(_is_note(item) for item in between):
            return None
        notes.append((above, start))
        above = end + 1
    if not all(_is_note(item) or _is_lone_command(item, "End") for item in code[above:]):
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


def _is_note(item: object) -> bool:
    return isinstance(item, s.Line) and item.statement is None and item.label is None


def _comments_above(code: Code, first: int) -> int:
    """Return the place where the comments right above the first function begin."""
    while first and _is_note(code[first - 1]):
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
    runs into it from above, and no jump leads in or out. unused: see `_unused_subroutines`.
    """
    wanted = set(named) if own else called_labels(code) | set(answering) | unused
    starts: list[tuple[int, str]] = []
    for at, item in enumerate(code):
        if item.label is None or depth[at]:
            continue
        label = item.label.upper()
        if label not in wanted or item.statement is not None:
            continue
        if own or not _goes_on_above(code, at):
            starts.append((at, label))
            wanted.discard(label)
    return starts if own else _closed(code, starts)


_CALLED_FROM_ELSEWHERE: Final = "*L_"
"""Prefix of labels of a base program that other programs may call (manual CR1D, 4.3.5)."""


def _unused_subroutines(code: Code, depth: Sequence[int]) -> set[str]:
    """Labels of subroutines that no line calls or jumps to, in upper case.

    Old subroutines remain in files: nothing runs into their lines, and these end with `Return`.
    """
    graph = graph_of(code, range(len(code)), blocks_of(code))
    # Interrupts may run a handler that no line calls.
    live = graph.reached([0, *graph.handlers], through_calls=True) if code else set()
    found = set[str]()
    above = set[str]()  # what lines above jump to
    for at, item in enumerate(code):
        if at:
            above.update(_jump_targets(code, (at - 1,)))
        label = "" if item.label is None else item.label.upper()
        if not label or depth[at] or at in live or label.startswith(_CALLED_FROM_ELSEWHERE):
            continue
        # A jump from above makes the lines a part of the main program, dead or not.
        if _goes_on_above(code, at) or label in above:
            continue
        if any(_returns(statement_of(code[to])) for to in graph.reached([at])):
            found.add(label)
    return found


def _returns(statement: s.Statement | None) -> bool:
    return any(one == s.Command("Return") for one in statements_in(statement))


def _closed(code: Code, starts: list[tuple[int, str]]) -> list[tuple[int, str]]:
    """Those that no jump leads into or out of; an interrupt costs its own statements alone."""
    # Each start that is dropped joins its lines to the procedure above, whose jumps then change:
    # repeat until all are closed.
    while starts:
        edges = [0, *(at for at, _ in starts), len(code)]
        spans = list(itertools.starmap(range, itertools.pairwise(edges)))
        inside = [labels_of(code, span) for span in spans]
        bad: set[int] = set()
        for k, span in enumerate(spans):
            for name in (target_name(to) for at in span for to in _exits(code, at).jumps):
                other = next((j for j, labels in enumerate(inside) if name in labels), k)
                if other != k:
                    # The main program is number 0, and always stays.
                    bad |= {j for j in (other, k) if j}
        if not bad:
            return starts
        starts = [start for k, start in enumerate(starts, 1) if k not in bad]
    return starts


def _exits(code: Code, at: int) -> Exits[s.Target]:
    return exits_of(statement_of(code[at]))


def called_labels(code: Code) -> set[str]:
    """Return the labels that `GoSub` statements name."""
    return {target_name(to) for item in code for to in exits_of(statement_of(item)).calls}


def _jump_targets(
    code: Code, places: Iterable[int], besides: Collection[str] = ()
) -> Iterator[str]:
    """Yield the jump targets of some lines, and those of interrupts that they define.

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
    """Return the unique name of a jump's target: the label in upper case, or `#` and the step."""
    place = target.place
    return place.upper() if isinstance(place, str) else f"#{place}"


def next_word(code: Code, at: int) -> int:
    """The next line that is more than a comment, or the end."""
    return next((k for k in range(at + 1, len(code)) if not _is_note(code[k])), len(code))


def _goes_on_above(code: Code, at: int) -> bool:
    """True if control may reach the place from the line above it, or from the beginning."""
    above = next((k for k in range(at - 1, -1, -1) if not _is_note(code[k])), None)
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


_MOST_COPIES: Final = 4
"""Times the lines of the file that its procedures may have with the lines that they share."""


def in_order(code: list[s.Entry]) -> list[s.Entry]:
    """Return the lines unchanged, unless a part of the main program follows a subroutine.

    The order then is: the part that the first line leads to by jumps, the parts that nothing calls,
    and each complete subroutine.
    """
    if any(isinstance(statement_of(item), s.Function) for item in code):
        return code
    edges = _run_edges(code)
    spans = list(itertools.starmap(range, itertools.pairwise(edges)))
    whole = _joined_runs(code, spans)
    main = whole[0]
    if [k for k, part in enumerate(whole) if part == main] == list(range(whole.count(main))):
        return code
    wanted = called_labels(code) | set(_interrupt_handlers(code))
    calls = [not wanted.isdisjoint(labels_of(code, span)) for span in spans]
    subroutines = {part for part, is_called in zip(whole, calls, strict=True) if is_called}

    def place(k: int) -> tuple[int, int, bool, int]:
        part = whole[k]
        # Main program, then parts that nothing calls, then subroutines; a part begins with its
        # called run.
        rank = 0 if part == main else 2 if part in subroutines else 1
        return rank, part, part != main and not calls[k], k

    ordered = sorted(range(len(spans)), key=place)
    return [code[at] for k in ordered for at in spans[k]]


def _run_edges(code: list[s.Entry]) -> list[int]:
    """Return the beginnings of runs of lines that nothing runs into from above, and the end."""
    depth = Structure(code).depth
    inner = (at for at in range(1, len(code)) if not depth[at] and _run_begin(code, at))
    return [0, *inner, len(code)]


def _run_begin(code: list[s.Entry], at: int) -> bool:
    """Comments stay with the lines below them."""
    return statement_of(code[at - 1]) is not None and not _goes_on_above(code, at)


def _joined_runs(code: list[s.Entry], spans: list[range]) -> list[int]:
    """By run, the first of those that jumps join with it."""
    home = {name: k for k, span in enumerate(spans) for name in labels_of(code, span)}
    joined, answering = list(range(len(spans))), _interrupt_handlers(code)

    def first(k: int) -> int:
        while joined[k] != k:
            # Halves the path to the root, which keeps chains of runs short.
            joined[k] = joined[joined[k]]
            k = joined[k]
        return k

    for k, span in enumerate(spans):
        for name in _jump_targets(code, span, answering):
            if name in home:
                one, two = sorted((first(k), first(home[name])))
                joined[two] = one
    return [first(k) for k in joined]


def separated(code: list[s.Entry]) -> list[s.Entry]:
    """Return the lines with every subroutine in one piece, if some are in several or share lines.

    A subroutine is the code that control reaches from its label, without the code that this calls.
    Each subroutine gets a copy of the lines that several share, with separate labels.
    """
    if any(isinstance(statement_of(item), s.Function) for item in code):
        return code
    wanted = called_labels(code)
    structure = Structure(code)
    found = procedure_regions(code, structure.depth, {}, False)
    if not wanted - {region.label for region in found}:
        return code
    return _Separating(code, structure, wanted).lines()


class _Separating:
    """wanted: labels of subroutines, in upper case."""

    def __init__(self, code: list[s.Entry], structure: Structure, wanted: set[str]) -> None:
        self.code, self.blocks = code, structure.blocks
        self.graph = graph_of(code, range(len(code)), structure.blocks)
        places = labels_of(code)
        answering = {name for name, word in _interrupt_handlers(code).items() if word == "GoSub"}
        unused = _unused_subroutines(code, structure.depth)
        begun = wanted | answering | unused
        starts = sorted({places[name] for name in begun if name in places} - {0})
        self.starts = [at for at in starts if not structure.depth[at]]
        self.whole = self.blocks.sound and len(self.starts) == len(starts)
        self.taken = set(places)

    def lines(self) -> list[s.Entry]:
        """The main program with what nothing comes to, then each subroutine."""
        if not self.whole or not self.code:
            return self.code
        parts = [self._closed([start]) for start in (0, *self.starts)]
        live = set().union(*parts)
        dead = [
            at for at in range(len(self.code)) if at not in live and not _is_note(self.code[at])
        ]
        parts[0] = self._closed([0, *dead])
        # Lines that many subroutines share multiply; the result would be larger than it is useful.
        if sum(map(len, parts)) > _MOST_COPIES * len(self.code):
            return self.code
        # The first part that reaches a line owns it; the others get copies with new labels.
        owner: dict[int, int] = {}
        for number, part in enumerate(parts):
            for at in part:
                owner.setdefault(at, number)
        for at in self._notes(owner):
            parts[owner[at]].add(at)
        made: list[s.Entry] = []
        for number, (part, start) in enumerate(zip(parts, (None, *self.starts), strict=True)):
            made += self._part(sorted(part), start, {at for at in part if owner.get(at) != number})
        return made

    def _closed(self, starts: Iterable[int]) -> set[int]:
        """Lines that control reaches from some places, with all lines of each block among them."""
        found = self.graph.reached(starts)
        while True:
            inside = {
                at
                for block in self.blocks.all
                if block.last is not None and not found.isdisjoint(block.words)
                # A block is complete in each copy: control may enter it without reaching all of its
                # lines.
                for at in range(block.first, block.last + 1)
            }
            if inside <= found:
                return found
            found = self.graph.reached(found | inside)

    def _notes(self, owner: dict[int, int]) -> list[int]:
        """Comments that nothing comes to: they go with the lines below them, or else above."""
        found: list[int] = []
        for at in reversed(range(len(self.code))):
            if at not in owner and _is_note(self.code[at]):
                beside = owner.get(at + 1, owner.get(at - 1))
                if beside is not None:
                    owner[at] = beside
                    found.append(at)
        return found

    def _part(self, part: list[int], start: int | None, copied: set[int]) -> list[s.Entry]:
        """The lines of a subroutine, or of the main program, in an order that begins with it."""
        names = self._names(part, start, copied)
        made: list[s.Entry] = []
        first = 0 if start is None else part.index(start)
        # Comments above the label are of the subroutine.
        while first and start is not None and self._is_note_of(part, first):
            first -= 1
        above = first and self._runs_into(part[first - 1], part[first])
        # A loop runs into the label from lines above it: the part keeps its order and begins with a
        # jump to the label.
        if start is not None and above:  # lines of its own run into its first one
            label = self.code[start].label
            assert label is not None
            names[label.upper()] = self._free(label)
            made += [
                s.Line(label=label),
                s.Line(statement=s.Jump("GoTo", s.Target(names[label.upper()]))),
            ]
            first = 0
        # The label comes first: lines above it move to where control does not run past.
        elif first:
            behind = next(
                (k for k in range(first, len(part) - 1) if not self._runs_on(part[k])),
                len(part) - 1,
            )
            part = [*part[first : behind + 1], *part[:first], *part[behind + 1 :]]
        for k, at in enumerate(part):
            made.append(self._renamed(self.code[at], names))
            after = part[k + 1] if k + 1 < len(part) else None
            # At the end of the file the controller ends the program; lines moved elsewhere need an
            # `End`.
            if after != at + 1 and self._at_end(at):
                made.append(s.Line(statement=s.Command("End"), span=self.code[at].span))
        return made

    def _is_note_of(self, part: list[int], first: int) -> bool:
        """True if a line of a part has a comment right above it that control does not run into."""
        above, at = part[first - 1], part[first]
        return above == at - 1 and _is_note(self.code[above]) and not self._runs_on(above)

    def _runs_on(self, at: int) -> bool:
        """True if control runs from a line, or from the loop that it ends, to the next line."""
        return _goes_on_above(self.code, at + 1) or self.blocks.around.get(at) is not None

    def _runs_into(self, above: int, at: int) -> bool:
        between = range(above + 1, at)
        return self._runs_on(above) and all(_is_note(self.code[k]) for k in between)

    def _at_end(self, at: int) -> bool:
        """True if control runs on from the last line of the file, which ends the program."""
        return at == len(self.code) - 1 and exits_of(statement_of(self.code[at])).on

    def _names(self, part: list[int], start: int | None, copied: set[int]) -> dict[str, str]:
        """New names for labels of copied lines, and of subroutines among lines of others."""
        names: dict[str, str] = {}
        entries = set(self.starts)
        for at in part:
            label = self.code[at].label
            if label is not None and at != start and (at in copied or at in entries):
                names[label.upper()] = self._free(label)
        return names

    def _free(self, label: str) -> str:
        number = 2
        while f"{label}_{number}".upper() in self.taken:
            number += 1
        self.taken.add(f"{label}_{number}".upper())
        return f"{label}_{number}"

    def _renamed(self, item: s.Entry, names: dict[str, str]) -> s.Entry:
        """A line with its own label, and what it jumps to, by their new names."""
        if not isinstance(item, s.Line):
            return item
        label = item.label and names.get(item.label.upper(), item.label)
        statement = item.statement and _with_new_labels(item.statement, names)
        return replace(item, label=label, statement=statement)


def _with_new_labels(node: s.Statement, names: dict[str, str]) -> s.Statement:
    """A statement with its jumps to the new names of labels; what it calls has kept its own."""

    def to(target: s.Target) -> s.Target:
        return s.Target(names.get(str(target.place).upper(), target.place))

    match node:
        case s.Jump("GoTo", target):
            return replace(node, target=to(target))
        case s.OnJump(keyword="GoTo", targets=targets):
            return replace(node, targets=tuple(one and to(one) for one in targets))
        case s.If(then=then, otherwise=otherwise):
            made = (
                to(x) if isinstance(x, s.Target) else x and _with_new_labels(x, names)
                for x in (then, otherwise)
            )
            yes, no = made
            return replace(node, then=yes, otherwise=no)
    return node


_ALL_INTERRUPTS: Final = 0
"""The number by which `Act` switches all."""

_InterruptKey = tuple[type, float | None]
"""The statement that defines an interrupt, and its number: None if that is worked out."""


@dataclass(slots=True)
class _InterruptLines:
    """By interrupt, the places of what it calls, and of lines that switch it on and off."""

    called: dict[_InterruptKey, set[int]] = field(default_factory=dict)
    on: dict[_InterruptKey, set[int]] = field(default_factory=dict)
    off: dict[_InterruptKey, set[int]] = field(default_factory=dict)


def calls_on_interrupt(statement: s.Statement) -> bool:
    """True for an interrupt that calls: `GoTo` abandons what the program was doing."""
    return isinstance(statement, s.OnCom) or (
        isinstance(statement, s.DefAct) and statement.keyword == "GoSub"
    )


def interrupts_of(
    code: Code, entries: Mapping[str, int], answers: Mapping[str, int]
) -> list[Interrupt]:
    """Those that call. entries: where the lines below each label begin, upper case. answers:
    procedures by the labels by which interrupts alone lead there.
    """
    found = _InterruptLines()
    places_of = {entries[label]: number for label, number in answers.items() if label in entries}
    for at, item in enumerate(code):
        whole = statement_of(item)
        for statement in statements_in(whole):
            _note_interrupt(statement, at, statement is whole, entries, answers, found)
    made = []
    for (kind, number), called in found.called.items():
        # A computed number may be that of any interrupt.
        on = {None, _ALL_INTERRUPTS, number} if number is not None else None
        places = [
            at
            for (switched, n), ats in found.on.items()
            if switched is kind and (on is None or n in on)
            for at in ats
        ]
        off = found.off.get((kind, _ALL_INTERRUPTS), set()) | found.off.get((kind, number), set())
        answer = places_of.get(next(iter(called))) if len(called) == 1 else None
        made.append(Interrupt(frozenset(called), frozenset(places), frozenset(off), answer))
    return made


def _note_interrupt(
    statement: s.Statement,
    at: int,
    certain: bool,
    entries: Mapping[str, int],
    answers: Mapping[str, int],
    found: _InterruptLines,
) -> None:
    """certain: it runs whenever its line does."""
    match statement:
        case s.DefAct(number, target=target) | s.OnCom(number, target):
            label = target_name(target)
            place = entries.get(label)
            if (calls_on_interrupt(statement) or label in answers) and place is not None:
                key = type(statement), _interrupt_number(number)
                found.called.setdefault(key, set()).add(place)
        # Off counts only where it certainly runs, on wherever it may: both keep the interrupt
        # possible.
        case s.Command("Act", (s.Binary("=", number, s.Number(0)),)) if literal(number) is not None:
            if certain:
                found.off.setdefault((s.DefAct, literal(number)), set()).add(at)
        case s.Command("Act", arguments):
            given = arguments[0] if arguments else None
            number = given.left if isinstance(given, s.Binary) else None
            found.on.setdefault((s.DefAct, literal(number)), set()).add(at)
        case s.Com(line, state):
            key = s.OnCom, _interrupt_number(line)
            if state == "On":
                found.on.setdefault(key, set()).add(at)
            elif certain and key[1] is not None:
                found.off.setdefault(key, set()).add(at)


def _interrupt_number(node: s.Expression | None) -> float | None:
    """That of an interrupt; a line that is not named is the first."""
    return 1 if node is None else literal(node)


Answer = tuple[s.Jump | s.Call, s.Expression | None]
"""The call that an interrupt leads to, and the condition on which the program then ends."""
Answers = Mapping[str, Answer]
"""By the label of its lines in upper case."""
_SHUT: Final = s.Command("Act", (s.Binary("=", s.Number(0), s.Number(0)),))
_OPEN: Final = s.Command("Act", (s.Binary("=", s.Number(0), s.Number(1)),))


def without_trampolines(code: list[s.Entry]) -> tuple[list[s.Entry], Answers]:
    """The lines of a program that was written here without those, and what they call."""
    wanted = {
        target_name(node.target)
        for item in code
        if isinstance(node := statement_of(item), s.DefAct)
    }
    if not wanted:
        return code, {}
    found: dict[str, Answer] = {}
    left: list[s.Entry] = []
    at = 0
    while at < len(code):
        label = code[at].label
        after, answer = (
            _trampoline(code, at + 1) if label and label.upper() in wanted else (0, None)
        )
        if label is None or answer is None:
            left.append(code[at])
            at += 1
            continue
        found[label.upper()] = answer
        at = after
        # The compiler put this `End` there so that control does not run into the trampolines.
        if at < len(code) and statement_of(code[at]) == s.Command("FEnd") and _ends_program(left):
            left.pop()
    return left, found


def _trampoline(code: list[s.Entry], at: int) -> tuple[int, Answer | None]:
    """Return the call in the lines below a label, and the place after them."""
    # A trampoline has five lines at most: shut, call, open, `If … End`, `Return 0`.
    lines = [statement_of(item) for item in code[at : at + 5]]
    shut = bool(lines) and lines[0] == _SHUT
    match lines[shut:]:
        case [s.Jump("GoSub") | s.Call() as call, *rest]:
            end = at + shut + 1
        case _:
            return 0, None
    if shut:
        if not rest or rest[0] != _OPEN:
            return 0, None
        rest, end = rest[1:], end + 1
    ends = None
    match rest:
        case [s.If(condition, s.Command("End"), None), *rest]:
            ends, end = condition, end + 1
    return (end + 1, (call, ends)) if rest and rest[0] == RETURN_TO_PROGRAM else (0, None)


def _ends_program(code: list[s.Entry]) -> bool:
    return bool(code) and code[-1].label is None and statement_of(code[-1]) == _END
