"""The lines of a file in the order of its procedures: the main part first, then subroutines.

A file may begin with a jump over its subroutines. Lines that nothing runs into from above may
stand anywhere, with all that follows up to the next line that control never runs past.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from assistant.languages.melfa_basic.lift.structure.blocks import Structure
from assistant.languages.melfa_basic.lift.structure.regions import (
    called_labels,
    goes_on_above,
    interrupt_handlers,
    is_note,
    jump_targets,
    procedure_regions,
    unused_subroutines,
)
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import statement_of
from assistant.languages.melfa_basic.tree.targets import exits_of, graph_of, labels_of

MOST_COPIES: Final = 4
"""Times the lines of the file that its procedures may have with the lines that they share."""


def in_order(code: list[s.Entry]) -> list[s.Entry]:
    """The lines as they are, unless a part of the main program stands behind a subroutine.

    Then: what the first line leads to by jumps, what nothing calls, and each subroutine whole.
    """
    if any(isinstance(statement_of(item), s.Function) for item in code):
        return code
    edges = _run_edges(code)
    spans = list(itertools.starmap(range, itertools.pairwise(edges)))
    whole = _joined_runs(code, spans)
    main = whole[0]
    if [k for k, part in enumerate(whole) if part == main] == list(range(whole.count(main))):
        return code
    wanted = called_labels(code) | set(interrupt_handlers(code))
    calls = [not wanted.isdisjoint(labels_of(code, span)) for span in spans]
    subroutines = {part for part, is_called in zip(whole, calls, strict=True) if is_called}

    def place(k: int) -> tuple[int, int, bool, int]:
        part = whole[k]
        rank = 0 if part == main else 2 if part in subroutines else 1
        return rank, part, part != main and not calls[k], k

    ordered = sorted(range(len(spans)), key=place)
    return [code[at] for k in ordered for at in spans[k]]


def _run_edges(code: list[s.Entry]) -> list[int]:
    """Where runs of lines begin that nothing runs into from above, and the end."""
    depth = Structure(code).depth
    inner = (at for at in range(1, len(code)) if not depth[at] and _run_begin(code, at))
    return [0, *inner, len(code)]


def _run_begin(code: list[s.Entry], at: int) -> bool:
    """Comments stay with the lines below them."""
    return statement_of(code[at - 1]) is not None and not goes_on_above(code, at)


def _joined_runs(code: list[s.Entry], spans: list[range]) -> list[int]:
    """By run, the first of those that jumps join with it."""
    home = {name: k for k, span in enumerate(spans) for name in labels_of(code, span)}
    joined, answering = list(range(len(spans))), interrupt_handlers(code)

    def first(k: int) -> int:
        while joined[k] != k:
            joined[k] = joined[joined[k]]
            k = joined[k]
        return k

    for k, span in enumerate(spans):
        for name in jump_targets(code, span, answering):
            if name in home:
                one, two = sorted((first(k), first(home[name])))
                joined[two] = one
    return [first(k) for k in joined]


def separated(code: list[s.Entry]) -> list[s.Entry]:
    """The lines with every subroutine in one piece, if some are in several or share lines.

    A subroutine is what control comes to from its label, without what that calls. Lines that
    several of them share are given to each, with labels of their own.
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
        answering = {name for name, word in interrupt_handlers(code).items() if word == "GoSub"}
        unused = unused_subroutines(code, structure.depth)
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
        dead = [at for at in range(len(self.code)) if at not in live and not is_note(self.code[at])]
        parts[0] = self._closed([0, *dead])
        if sum(map(len, parts)) > MOST_COPIES * len(self.code):
            return self.code
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
                for at in range(block.first, block.last + 1)
            }
            if inside <= found:
                return found
            found = self.graph.reached(found | inside)

    def _notes(self, owner: dict[int, int]) -> list[int]:
        """Comments that nothing comes to: they go with the lines below them, or else above."""
        found: list[int] = []
        for at in reversed(range(len(self.code))):
            if at not in owner and is_note(self.code[at]):
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
        above = first and self._runs_into(part[first - 1], part[first])
        if start is not None and above:  # lines of its own run into its first one
            label = self.code[start].label
            assert label is not None
            names[label.upper()] = self._free(label)
            made += [
                s.Line(label=label),
                s.Line(statement=s.Jump("GoTo", s.Target(names[label.upper()]))),
            ]
            first = 0
        elif first:
            behind = next(
                (k for k in range(first, len(part) - 1) if not self._runs_on(part[k])),
                len(part) - 1,
            )
            part = [*part[first : behind + 1], *part[:first], *part[behind + 1 :]]
        for k, at in enumerate(part):
            made.append(self._renamed(self.code[at], names))
            after = part[k + 1] if k + 1 < len(part) else None
            if after != at + 1 and self._at_end(at):
                made.append(s.Line(statement=s.Command("End"), span=self.code[at].span))
        return made

    def _runs_on(self, at: int) -> bool:
        """True if control runs from a line, or from the loop that it ends, to the next line."""
        return goes_on_above(self.code, at + 1) or self.blocks.around.get(at) is not None

    def _runs_into(self, above: int, at: int) -> bool:
        between = range(above + 1, at)
        return self._runs_on(above) and all(is_note(self.code[k]) for k in between)

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
