"""Where blocks begin and end in the code lines of a file."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Mapping, Sequence

from assistant.languages.line_blocks import Blocks
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import blocks_of
from assistant.languages.melfa_basic.tree.jumping import jumping_ifs
from assistant.languages.melfa_basic.tree.targets import labels_named

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
            if block.last is not None and all(code[at].label is None for at in block.words[1:])
        }
        change = [0] * (len(code) + 1)
        for places in self.places.values():
            change[places[0]] += 1
            change[places[-1] + 1] -= 1
        self.depth = list(itertools.accumulate(change[:-1]))


def _has_no_other_jumps(name: str, places: Sequence[int], named: Mapping[str, int]) -> bool:
    """Whether no other jumps lead into an `If` of jumps. named: how often labels are, by label."""
    branches = len(places) // 3
    numbers = range(1, branches + 1)
    inner = (f"{name}{letter}{number}" for letter in "TN" for number in numbers)
    return all(named[label] == 1 for label in inner) and named[name + "Z"] == branches


def is_lone_command(item: s.Entry, keyword: str) -> bool:
    """Whether a line is that word alone."""
    return item.label is None and item.statement == s.Command(keyword)


def is_blank(item: s.Entry) -> bool:
    return isinstance(item, s.Line) and not (item.statement or item.label or item.comment)
