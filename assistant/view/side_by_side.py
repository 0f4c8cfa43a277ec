"""Two texts side by side, line by line: a program and its translation, or two programs.

Rows are in the order of the source; a line that was written for no line of it is put before its
successor. Declarations are paired by old and new names.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from itertools import accumulate, pairwise
from typing import Final

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.base.source_text import SourceText, lines_of, visible
from assistant.compiler.comparison import Comparison, paired_statements
from assistant.compiler.loader import language_of
from assistant.compiler.source_map import Place, Places
from assistant.compiler.translation import LEVELS, Translation
from assistant.report.translation import renamed_items
from assistant.view.motion import Record, column_text, text_records

_NO_LEVEL: Final = len(LEVELS)
"""Level of a line that is not a statement."""
_MOST_REASONS: Final = 2_000

PairedLines = tuple[int, int, int]
"""A line of the source, one that it became, and a level; 0 where there is no line."""


@dataclass(frozen=True, slots=True)
class SideBySide:
    """Lines of a source, paired with the written lines.

    texts: of the source. rows: each line of them once or more often, and each line that was written
    at least once, in order of the source. Lines are counted through all texts from 1; a line is
    paired with one that it became. reasons: why a line is not translated unchanged. heading: of
    both columns.
    """

    texts: Sequence[SourceText]
    rows: Sequence[PairedLines]
    reasons: Mapping[int, str] = field(default_factory=dict)
    heading: str = "What each line became"

    def record(self) -> Record:
        texts, left = text_records(self.texts)
        rows = np.array(self.rows, dtype=np.int64).reshape(-1, 3)
        reasons = dict(list(self.reasons.items())[:_MOST_REASONS])
        return {
            "heading": self.heading,
            "texts": texts,
            "left": left,
            "rows": column_text(rows),
            "reasons": reasons,
        }


def translation_side_by_side(translation: Translation) -> SideBySide:
    """Return the lines of a translation, next to the written lines, if any."""
    compiled, lifted = translation.compiled, translation.proof.lifted
    source = _CountedTexts(compiled.places.texts)
    written = _CountedTexts(
        Places(lifted).texts if translation.files and lifted is not None else ()
    )
    levels: dict[int, int] = {}
    reasons: dict[int, str] = {}
    links = list[tuple[list[int], list[int]]]()
    spans: dict[tuple[int, ...], list[int]] = {}
    for row in translation.rows:
        first = source.line(row.place)
        if first == 0:
            continue
        count = len(lines_of(row.place.text.rstrip())) if row.count > 1 else 1
        for line in range(first, first + max(1, count)):
            levels[line] = max(levels.get(line, 0), LEVELS.index(row.level))
        why = [
            visible(f"{f.code} {f.message}" + (f"; {f.cure}" if f.cure else ""))
            for f in row.reasons
        ]
        if why:
            reasons[first] = "\n".join(why)
        went = tuple(written.lines(row.went))
        if went:
            spans.setdefault(went, []).extend(range(first, first + max(1, count)))
    links += [(sources, list(went)) for went, sources in spans.items()]
    links += _declaration_pairs(translation, source, written)
    origin = compiled.source.origin
    marks = ["#" if origin is None else language_of(origin.language).comment_mark]
    marks.append(language_of(compiled.language).comment_mark)
    links += _comment_pairs(source, written, marks, links)
    return SideBySide(source.texts, _paired_rows(source, written, links, levels), reasons)


def comparison_side_by_side(done: Comparison) -> SideBySide:
    """The lines of two compared programs, with their statements in pairs."""
    one, other = done.programs
    own = _CountedTexts(Places(one.program, one.text).texts)
    others = _CountedTexts(Places(other.program, other.text).texts)
    links, levels, reasons = list[tuple[list[int], list[int]]](), dict[int, int](), dict[int, str]()
    for row in done.rows or paired_statements(done):
        first = 0 if row.first is None else own.line(row.first)
        second = 0 if row.second is None else others.line(row.second)
        if first:
            level = LEVELS.index("supported" if row.alike else "partial" if second else "not")
            levels[first] = max(levels.get(first, 0), level)
        if first and second:
            links.append(([first], [second]))
    for difference in done.differences:
        place = difference.places[0]
        if place is not None and (line := own.line(place)):
            levels[line] = LEVELS.index("not")
            reasons[line] = visible(f"{difference.what}; with {difference.inputs}")
    rows = _paired_rows(own, others, links, levels)
    return SideBySide(own.texts, rows, reasons, "Statements of both programs")


class _CountedTexts:
    """Texts whose lines are counted through all of them, from 1."""

    def __init__(self, texts: Sequence[SourceText]) -> None:
        self.texts = texts
        counts = [text.line_count for text in texts]
        self._firsts = [0, *accumulate(counts)]
        self.count = self._firsts[-1]
        # What stands behind the end of the last line is none that people see; 0 is no line either.
        self.ends = {0} | {
            before + text.line_count
            for text, before in zip(texts, self._firsts, strict=False)
            if not text.line_text(text.line_count)
        }
        self._of = {
            text.path: first
            for text, first in reversed(list(zip(texts, self._firsts, strict=False)))
        }

    def line(self, place: Place) -> int:
        """Return the line where a position begins; 0 in another text."""
        before = self._of.get(place.path)
        return 0 if before is None else before + place.line

    def lines(self, places: Iterable[Place]) -> Iterator[int]:
        """All lines of places, each once."""
        seen = set[int]()
        for place in places:
            first = self.line(place)
            for line in range(first, first + max(1, len(lines_of(place.text.rstrip())))):
                if first and line not in seen:
                    seen.add(line)
                    yield line


def _declaration_pairs(
    translation: Translation, source: _CountedTexts, written: _CountedTexts
) -> Iterator[tuple[list[int], list[int]]]:
    """The lines that declare something in both, by its old and its new name."""
    lifted = translation.proof.lifted
    if lifted is None or not written.count:
        return
    made = _declaring_lines(Places(lifted))
    own = _declaring_lines(translation.compiled.places)
    for old, new, place in renamed_items(translation):
        if old.owner or not new:
            continue
        lines = own(old.name) or ([] if place is None else [source.line(place)])
        found = made(new)
        if len(lines) == len(found) == 1 and lines[0] and found[0]:
            yield lines, found


def _comment_pairs(
    source: _CountedTexts,
    written: _CountedTexts,
    marks: Sequence[str],
    links: Iterable[tuple[Sequence[int], Sequence[int]]],
) -> Iterator[tuple[list[int], list[int]]]:
    """Lines of both that hold the same comment and nothing else, in their order, if neither is
    paired already.
    """
    linked = list(links)
    taken = {line for mine, _ in linked for line in mine}
    made = {line for _, its in linked for line in its}
    known: dict[str, list[int]] = {}
    for line, comment in _comments(written, marks):
        if line not in made:
            known.setdefault(comment, []).append(line)
    for line, comment in _comments(source, marks):
        if line not in taken and (there := known.get(comment)):
            yield [line], [there.pop(0)]


def _comments(texts: _CountedTexts, marks: Sequence[str]) -> Iterator[tuple[int, str]]:
    """The lines that are a comment, without its mark and the step number before it."""
    number = 0
    for text in texts.texts:
        for line in range(1, text.line_count + 1):
            number += 1
            said = text.line_text(line).lstrip("0123456789 \t")
            mark = next((one for one in marks if said.startswith(one)), "")
            if mark and (comment := said[len(mark) :].strip()):
                yield number, comment


def _declaring_lines(places: Places) -> Callable[[str], list[int]]:
    """Return a function that gives the lines that declare a name outside procedures.

    Many like declarations may be one part without a name: from these it gives the first line that
    assigns a value to the name.
    """
    known: dict[str, list[int]] = {}
    for part in places.parts():
        if part.owner:
            continue
        first, last = places.lines(part.span)
        if part.name:
            known.setdefault(part.name.lower(), []).append(first)
        elif last > first > 0 and (place := places.of(part.span)) is not None:
            for number, line in enumerate(lines_of(place.text)):
                for word in _ASSIGNED.findall(line)[:1]:
                    known.setdefault(word.lower(), []).append(first + number)
    return lambda name: known.get(name.lower(), [])


_ASSIGNED: Final = re.compile(r"(\w+)\s*:?=")


def _paired_rows(
    source: _CountedTexts,
    written: _CountedTexts,
    links: Iterable[tuple[Sequence[int], Sequence[int]]],
    levels: Mapping[int, int],
) -> list[PairedLines]:
    """Return the paired rows in order of the source; a written line without a source comes before
    the next line that has one, or at the end.

    If a group has equal numbers of source and written lines, they are paired one by one; else the
    written lines are next to and below the first source line.
    """
    became: dict[int, list[int]] = {}
    for mine, its in links:
        pairs = (
            zip(mine, its, strict=True) if len(mine) == len(its) else ((mine[0], t) for t in its)
        )
        for line, there in pairs:
            if there not in became.setdefault(line, []):
                became[line].append(there)
    sources_of: dict[int, int] = {}
    for line, lines in sorted(became.items()):
        for one in lines:
            sources_of.setdefault(one, line)
    before, after, first, last = _unpaired_lines(sources_of, written.count)
    rows = [(0, one, _NO_LEVEL) for one in first]
    for line in range(1, source.count + 1):
        level = levels.get(line, _NO_LEVEL)
        goals = became.get(line, [])
        if not goals:
            rows.append((line, 0, level))
        for number, goal in enumerate(goals):
            once = sources_of[goal] == line
            rows += [(0, extra, _NO_LEVEL) for extra in before.get(goal, ()) if once]
            rows.append((0 if number else line, goal, level))
            rows += [(0, extra, _NO_LEVEL) for extra in after.get(goal, ()) if once]
    rows += [(0, goal, _NO_LEVEL) for goal in last]
    return [one for one in rows if one[0] not in source.ends or one[1] not in written.ends]


def _unpaired_lines(
    sources_of: Mapping[int, int], written: int
) -> tuple[dict[int, list[int]], dict[int, list[int]], list[int], list[int]]:
    """Group written lines without a source by where they belong.

    Return them by the line that they precede, by the line that they follow, those at the beginning,
    and all of them if no line has a source. They precede the next line that has one, or follow the
    last one if the source goes back there.
    """
    before: dict[int, list[int]] = {}
    after: dict[int, list[int]] = {}
    known = sorted(sources_of)
    if not known:
        return before, after, [], list(range(1, written + 1))
    for last, one in pairwise(known):
        between = list(range(last + 1, one))
        if between and sources_of[one] >= sources_of[last]:
            before[one] = between
        elif between:
            after[last] = between
    if known[-1] < written:
        after[known[-1]] = list(range(known[-1] + 1, written + 1))
    return before, after, list(range(1, known[0])), []
