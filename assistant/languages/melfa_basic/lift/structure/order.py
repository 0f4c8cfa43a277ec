"""The lines of a file in the order of its procedures: the main part first, subroutines behind it.

A file may begin with a jump over its subroutines. Lines that nothing runs into from above may
stand anywhere, with all that follows up to the next line that control never runs past.
"""

from __future__ import annotations

import itertools

from assistant.languages.melfa_basic.lift.structure.blocks import Structure
from assistant.languages.melfa_basic.lift.structure.regions import (
    called,
    goes_on_above,
    handlers,
    jumps,
)
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import statement_of
from assistant.languages.melfa_basic.tree.targets import labels_of


def in_order(code: list[s.Entry]) -> list[s.Entry]:
    """The lines as they are, unless a part of the main program stands behind a subroutine.

    Then: what the first line leads to by jumps, what nothing calls, and each subroutine whole.
    """
    if any(isinstance(statement_of(item), s.Function) for item in code):
        return code
    edges = _edges(code)
    spans = list(itertools.starmap(range, itertools.pairwise(edges)))
    whole = _joined(code, spans)
    main = whole[0]
    if [k for k, part in enumerate(whole) if part == main] == list(range(whole.count(main))):
        return code
    wanted = called(code) | set(handlers(code))
    calls = [not wanted.isdisjoint(labels_of(code, span)) for span in spans]
    subroutines = {part for part, is_called in zip(whole, calls, strict=True) if is_called}

    def place(k: int) -> tuple[int, int, bool, int]:
        part = whole[k]
        rank = 0 if part == main else 2 if part in subroutines else 1
        return rank, part, part != main and not calls[k], k

    ordered = sorted(range(len(spans)), key=place)
    return [code[at] for k in ordered for at in spans[k]]


def _edges(code: list[s.Entry]) -> list[int]:
    """Where runs of lines begin that nothing runs into from above, and the end."""
    depth = Structure(code).depth
    inner = (at for at in range(1, len(code)) if not depth[at] and _begins(code, at))
    return [0, *inner, len(code)]


def _begins(code: list[s.Entry], at: int) -> bool:
    """Comments stay with the lines below them."""
    return statement_of(code[at - 1]) is not None and not goes_on_above(code, at)


def _joined(code: list[s.Entry], spans: list[range]) -> list[int]:
    """By run, the first of those that jumps join with it."""
    home = {name: k for k, span in enumerate(spans) for name in labels_of(code, span)}
    joined, answering = list(range(len(spans))), handlers(code)

    def first(k: int) -> int:
        while joined[k] != k:
            joined[k] = joined[joined[k]]
            k = joined[k]
        return k

    for k, span in enumerate(spans):
        for name in jumps(code, span, answering):
            if name in home:
                one, two = sorted((first(k), first(home[name])))
                joined[two] = one
    return [first(k) for k in joined]
