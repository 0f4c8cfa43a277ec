"""Texts parsed by lark itself, with the grammar of their language: a second reader for the proof.

It shares the grammar file with the reader of the language, but not the driver of the tables, the
words or the columns. The files of a program of up to WHOLE lines are parsed completely. Of a longer
one rows of long runs of like lines are left out by default, so that what remains of each file is
still a complete text.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.arrays import Rows
from assistant.base.budgets import READING, within, without_gc
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, Span
from assistant.base.source_text import with_line_feeds
from assistant.languages.language_types import Sampling

if TYPE_CHECKING:
    from lark import Lark

    from assistant.languages.language import Language

WHOLE: Final = 20_000
"""Lines of a program, all of its files together, that is parsed completely in any case."""
SAMPLED: Final = 2_000
"""Rows at the ends of all runs of a longer one that are parsed at most, as many between them."""
WINDOW: Final = 100
"""Most rows of a sample of a run."""
ENDS_EARLY: Final = "the text ends where more is expected"


@dataclass(frozen=True, slots=True)
class Parsed:
    """Result of parsing some texts with lark.

    lines: number that lark parsed, of a total. refused: why and where the grammar refuses a text.
    """

    lines: int = 0
    total: int = 0
    refused: tuple[Diagnostic, ...] = ()

    def record(self) -> dict[str, int]:
        """The numbers as plain data."""
        return {"lines": self.lines, "of": self.total}

    def __str__(self) -> str:
        of = "" if self.lines == self.total else f" of {self.total:,}"
        return f"{self.lines:,}{of} line{'s' * (self.total != 1)} parsed"


@without_gc()
def parse(
    language: Language[Any],
    trees: Iterable[Any],
    refusal: Rule,
    sampling: Sampling,
    spacing: Spacing | None = None,
) -> Parsed | None:
    """Parse the texts that trees were read from; None if the language has no grammar for lark.

    refusal: rule for a text that the grammar refuses, which names the language and a reason.
    spacing: of samples over a longer program that the texts are a part of.
    """
    parser = language.by_lark()
    if parser is None:
        return None
    given = list(trees)
    lines = total = sum(tree.source.ended_line_count for tree in given)
    in_samples = sampling == "samples" and (spacing is not None or total > WHOLE)
    sources = [(tree.source, list(language.runs(tree)) if in_samples else []) for tree in given]
    refused: list[Diagnostic] = []
    # Samples are spread over the runs of all files together, so the bound holds for the program.
    spacing = spacing or Spacing.of([len(run) for _, runs in sources for run in runs])
    for source, runs in sources:
        left_out = between_samples(runs, spacing)
        lines -= sum(rows for _, _, rows in left_out)
        with within(READING, source.path, len(source.text)):
            wrong = _refused(parser, with_line_feeds(source.text), left_out)
        if wrong is not None:
            at, reason = wrong
            # An empty file has no character to point to.
            end = min(at + 1, len(source.text))
            span = Span(min(at, end), end)
            refused.append(source.finding(refusal, span, language=language.title, reason=reason))
    return Parsed(lines, total, tuple(refused))


@dataclass(frozen=True, slots=True)
class Spacing:
    """window: rows of a sample. stride: rows from the start of one sample to the next."""

    window: int
    stride: int

    @staticmethod
    def of(runs: Sequence[int]) -> Spacing:
        """Up to SAMPLED rows at the ends of runs of so many rows each, and as many between them."""
        window = max(1, min(WINDOW, SAMPLED // (2 * max(len(runs), 1))))
        # The stride is at least two windows, or the samples would join.
        return Spacing(window, max(2 * window, -(-sum(runs) * window // SAMPLED)))


def between_samples(runs: Sequence[Rows], spacing: Spacing) -> list[tuple[int, int, int]]:
    """Return the pieces to leave out of a text: start, end and number of rows of each.

    runs: offsets (n, 2) at which each row of a run starts and ends, for each run. The first and
    last rows of each run stay, and windows between them.
    """
    window, stride = spacing.window, spacing.stride
    pieces: list[tuple[int, int, int]] = []
    for run in runs:
        last = len(run) - window
        # The last sample ends with the last row, wherever the stride leads.
        starts = np.append(np.arange(0, max(last - window, 0), stride), last)
        for first, following in zip(starts[:-1] + window, starts[1:], strict=True):
            if first < following:
                pieces.append((int(run[first, 0]), int(run[following, 0]), int(following - first)))
    return pieces


def _refused(
    parser: Lark, text: str, left_out: Sequence[tuple[int, int, int]]
) -> tuple[int, str] | None:
    """Return the offset at which lark refuses a text, and the reason; None for a sound text."""
    from lark import UnexpectedInput, UnexpectedToken

    short, shifts = _without(text, left_out)
    try:
        parser.parse(short, start="start")
    except UnexpectedInput as error:
        ended = isinstance(error, UnexpectedToken) and error.token.type == "$END"
        at = error.pos_in_stream
        if ended or at is None:
            at, reason = len(short), ENDS_EARLY
        else:
            found = error.token if isinstance(error, UnexpectedToken) else short[at]
            reason = f"`{found}` is not expected there"
        # The offset counts on by all pieces that were left out before it.
        return at + sum(shift for begin, shift in shifts if begin <= at), reason
    return None


def _without(
    text: str, left_out: Sequence[tuple[int, int, int]]
) -> tuple[str, list[tuple[int, int]]]:
    """Return a text without some pieces; for each, the offset of the gap and its length."""
    if not left_out:
        return text, []
    pieces: list[str] = []
    shifts: list[tuple[int, int]] = []
    at = length = 0
    for begin, end, _ in left_out:
        pieces.append(text[at:begin])
        length += begin - at
        shifts.append((length, end - begin))
        at = end
    return "".join([*pieces, text[at:]]), shifts
