"""The lines of a file in the order of its procedures: the main part first, subroutines behind it.

A file may begin with a jump over its subroutines. Lines that nothing runs into from above may
stand anywhere, with all that follows up to the next line that control never runs past.
"""

from __future__ import annotations

import itertools

from assistant.languages.melfa_basic.lift.structure.blocks import (
    Entry,
    depths,
    labels_in,
    structure,
)
from assistant.languages.melfa_basic.lift.structure.regions import called, goes_on_above, jumps
from assistant.languages.melfa_basic.tree import syntax as s


def in_order(code: list[Entry]) -> list[Entry]:
    """The lines as they are, unless a part of the main program stands behind a subroutine.

    Then: what the first line leads to by jumps, what nothing calls, and each subroutine whole.
    """
    if any(isinstance(i, s.Line) and isinstance(i.statement, s.Function) for i in code):
        return code
    edges = _edges(code)
    spans = list(itertools.pairwise(edges))
    whole = _joined(code, spans)
    main = whole[0]
    if [k for k, part in enumerate(whole) if part == main] == list(range(whole.count(main))):
        return code
    wanted = called(code)
    calls = [bool(labels_in(code, *span) & wanted) for span in spans]
    subroutines = {part for part, is_called in zip(whole, calls, strict=True) if is_called}

    def place(k: int) -> tuple[int, int, bool, int]:
        part = whole[k]
        rank = 0 if part == main else 2 if part in subroutines else 1
        return rank, part, part != main and not calls[k], k

    ordered = sorted(range(len(spans)), key=place)
    return [item for k in ordered for item in code[slice(*spans[k])]]


def _edges(code: list[Entry]) -> list[int]:
    """Where runs of lines begin that nothing runs into from above, and the end."""
    depth = depths(code, structure(code))
    inner = (at for at in range(1, len(code)) if not depth[at] and _begins(code, at))
    return [0, *inner, len(code)]


def _begins(code: list[Entry], at: int) -> bool:
    """Comments stay with the lines below them."""
    above = code[at - 1]
    return isinstance(above, s.Line) and above.statement is not None and not goes_on_above(code, at)


def _joined(code: list[Entry], spans: list[tuple[int, int]]) -> list[int]:
    """By run, the first of those that jumps join with it."""
    home = {name: k for k, span in enumerate(spans) for name in labels_in(code, *span)}
    whole = list(range(len(spans)))
    for k, span in enumerate(spans):
        for name in jumps(code, *span):
            if name in home:
                one, two = sorted((whole[k], whole[home[name]]))
                whole = [one if part == two else part for part in whole]
    return whole
