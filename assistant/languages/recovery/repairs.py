"""The change that mends a damaged place: tried on the parser's stack, the best is the diagnosis."""

from __future__ import annotations

from typing import Final

from assistant.languages.recovery.broken import Broken, Repair
from assistant.languages.recovery.candidates import repair_candidates
from assistant.languages.recovery.left_out import placeholder

WORDS_AHEAD: Final = 6
"""Words of the next line that tell two changes apart."""


def best_repair(broken: Broken) -> Repair:
    """The change that reads on furthest; of several alike the one that people need most often."""
    goal = _goal_row(broken)
    likely: list[tuple[int, int, Repair]] = []
    ends = broken.word.first or broken.word.type in broken.syntax.blocks.ends.values()
    sure, ended, last, rest = likely.copy(), likely.copy(), likely.copy(), likely.copy()
    for order, (repair, row, weight) in enumerate(repair_candidates(broken)):
        put = [word.type for word in repair.put]
        reached = broken.reach(repair.keep, put, row) if repair.kept is None else goal + WORDS_AHEAD
        ranked = (min(reached, goal + WORDS_AHEAD), -order, repair)
        if reached > goal:
            (likely if weight < 2 else last).append(ranked)
        elif weight == 0 and reached > broken.error:
            sure.append(ranked)
        elif repair.what == "SEMICOLON" and row == broken.error <= reached and ends:
            ended.append(ranked)
        elif weight == 1 and reached == goal > broken.error:
            rest.append(ranked)
    for group in (likely, sure, ended, last, rest):
        if group:
            return max(group, key=lambda ranked: ranked[:2])[2]
    return placeholder(broken)


def _goal_row(broken: Broken) -> int:
    """Row that a mended statement reaches: the first word of the next line."""
    rows = range(broken.error + 1, len(broken.words))
    return next((row for row in rows if broken.words[row].first), len(broken.words) - 1)
