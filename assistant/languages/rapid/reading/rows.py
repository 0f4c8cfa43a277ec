r"""Long runs of alike lines read into columns: declared robtargets and plain moves.

    CONST robtarget p1:=[[600,0,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    MoveL p1,v100,z10,tool0\WObj:=table;
    MoveL [[600,0,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z10,tool0;

A regular expression bounds a run and its words; blanks are taken out, which leaves every row
with its marks in the same order, and names and numbers are fetched from between the marks for
all rows at once. What does not fit exactly is left in the text for the grammar, so that both
ways always agree.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.languages.rapid.tables.words import LONGEST_NAME, RESERVED, UNUSED
from assistant.languages.rapid.tree.runs import (
    CIRCULAR,
    FEWEST,
    JOINT,
    LINEAR,
    PARTS,
    MotionNames,
    MoveRun,
    Names,
    Store,
    TargetRun,
)
from assistant.program.arrays import Floats
from assistant.program.digits_at_offsets import WORD, Offsets, Slots

MOST: Final = 8192
"""Rows read at a time, so that their text and numbers fit the processor's cache."""

_B = r"[ \t]"
_NAME = r"[A-Za-z][A-Za-z0-9_]*+"
_SLOT = rf"{_B}*+[-+0-9.eE]++{_B}*+"
_EOL = rf";{_B}*+(?:\r?\n|\Z)"


def _slots(count: int) -> str:
    return r"\[" + ",".join([_SLOT] * count) + r"\]"


_WIDE = r"\[\[[-+0-9.eE,\[\]]++"
"""A value without blanks; that its brackets and commas stand right is seen in the columns."""
_SPACED = r"\[" + ",".join(_slots(stop - start) for start, stop in PARTS) + r"\]"
_DECLARED = rf"{_B}++{_NAME}{_B}*+:={_B}*+(?:{_WIDE}{_EOL}|{_SPACED}{_EOL})"
_HEAD = rf"(?P<head>(?:LOCAL{_B}++)?+CONST{_B}++robtarget)"
_BEHIND = rf"{_B}*+,{_B}*+".join([_NAME] * 3)
_FRAME = rf"(?:{_B}*+,?+{_B}*+\\WObj{_B}*+:={_B}*+{_NAME})?+{_B}*+{_EOL}"
_TAIL = rf"{_B}*+,{_B}*+{_BEHIND}{_FRAME}"
_MOVE = rf"{_B}*+Move(?:[JL]{_B}++{_NAME}|C{_B}++{_NAME}{_B}*+,{_B}*+{_NAME}){_TAIL}"
_INLINE = rf"{_B}*+Move[JL]{_B}*+(?:{_WIDE}(?<=\],){_BEHIND}{_FRAME}|{_SPACED}{_TAIL})"
_REST = f"{{{FEWEST - 1},{MOST - 1}}}+"
_ALL = f"{{{FEWEST},{MOST}}}+"

_RUNS: Final = re.compile(
    rf"^(?:{_B}*+{_HEAD}{_DECLARED}(?:{_B}*+(?P=head){_DECLARED}){_REST}"
    rf"|(?P<moves>(?:{_MOVE}){_ALL})|(?P<inline>(?:{_INLINE}){_ALL}))",
    re.MULTILINE,
)
_BLANKS: Final = b" \t\r\n"


@dataclass(frozen=True, slots=True)
class Found:
    """A run in a text: its offsets and what it says. scope: of declarations."""

    start: int
    end: int
    run: TargetRun | MoveRun
    scope: str = ""


def find_runs(text: str) -> Iterator[Found]:
    """The runs of a text, in order; rows that are not exactly plain are left out."""
    store = Store(text.count(";"))
    for match in _RUNS.finditer(text):
        start, end = match.span()
        head = match["head"]
        scope = "LOCAL" if head and head.startswith("LOCAL") else ""
        reader: Reader
        if head is not None:
            reader = _Declarations(len(re.sub(r"\s", "", head)), store)
        elif match["moves"] is not None:
            reader = _moves
        else:
            reader = _Inline(store)
        yield from _read(text, start, end, reader, scope, store)


Reader = Callable[[bytes], TargetRun | MoveRun]


def _read(
    text: str, start: int, end: int, reader: Reader, scope: str, store: Store
) -> Iterator[Found]:
    """Reads a stretch of rows; where one is damaged the stretch is halved around it."""
    stretch = text[start:end]
    if stretch.count("\n") + (not stretch.endswith("\n")) < FEWEST:
        return
    before = store.taken
    try:
        run = reader(stretch.encode("ascii").translate(None, _BLANKS))
    except ValueError:
        store.taken = before
        middle = text.find("\n", start + (end - start) // 2, end - 1) + 1
        if middle > start:
            yield from _read(text, start, middle, reader, scope, store)
            yield from _read(text, middle, end, reader, scope, store)
        return
    yield Found(start, end, run, scope)


# Rows without blanks, one behind the other


@dataclass(frozen=True, slots=True)
class _Declarations:
    """head: length of what stands before each name."""

    head: int
    store: Store

    def __call__(self, data: bytes) -> TargetRun:
        text = Slots(data)
        marks = _Marks(text)
        values, opens = _targets(text, marks, ord(";"), self.store)
        return TargetRun(_names(text, marks.rows + self.head, opens - len(":=")), values)


def _moves(data: bytes) -> MoveRun:
    text = Slots(data)
    marks = _Marks(text)
    kinds = _kinds(text, marks.rows)
    circular = kinds == CIRCULAR
    first = marks.offsets[marks.first]
    last = marks.offsets[marks.first + circular]
    starts = np.where(circular, first + 1, marks.rows + len("MoveL"))
    vias = _names(text, marks.rows[circular] + len("MoveL"), first[circular])
    motion, motions = _motions(text, last + 1, marks.stops)
    return MoveRun(kinds, _names(text, starts, last), vias, motion, motions)


@dataclass(frozen=True, slots=True)
class _Inline:
    store: Store

    def __call__(self, data: bytes) -> MoveRun:
        text = Slots(data)
        marks = _Marks(text)
        values, _ = _targets(text, marks, ord(","), self.store)
        ends = marks.offsets[marks.first + values.shape[1] - 1]
        motion, motions = _motions(text, ends + 1, marks.stops)
        none = Names((), np.empty(0, dtype=np.int32), np.empty(0, dtype=np.int64))
        return MoveRun(_kinds(text, marks.rows), none, none, motion, motions, values)


_KINDS: Final = np.zeros(256, dtype=np.uint8)
_KINDS[ord("C")], _KINDS[ord("J")], _KINDS[ord("L")] = CIRCULAR, JOINT, LINEAR


def _kinds(text: Slots, rows: Offsets) -> NDArray[np.uint8]:
    return np.asarray(_KINDS[text.bytes[rows + len("Move")]])


class _Marks:
    """Commas and semicolons of rows, with the decimal point before each where there is one.

    signs, offsets, points: (marks,); a mark without a point has its own offset.
    first: (n,) the first mark of each row. rows, stops: (n,) where rows begin, and their `;`.
    """

    def __init__(self, text: Slots) -> None:
        letters = text.bytes
        at = np.flatnonzero((letters == ord(",")) | (letters == ord(";")) | (letters == ord(".")))
        signs = letters[at]
        mark = np.flatnonzero(signs != ord("."))
        before = mark - 1  # of the very first mark the last one, which is no point
        pointed = signs.take(before) == ord(".")
        if np.count_nonzero(pointed) + len(mark) != len(at):
            raise ValueError("a number has two points")
        self.signs, self.offsets = signs.take(mark), at.take(mark)
        self.points = np.where(pointed, at.take(before), self.offsets)
        ends = np.flatnonzero(self.signs == ord(";"))
        self.stops = self.offsets[ends]
        self.first = np.concatenate([[0], ends[:-1] + 1])
        self.rows = np.concatenate([[WORD], self.stops[:-1] + 1])

    def table(self, column: NDArray[Any], count: int) -> NDArray[Any]:
        """The first `count` marks of each row; ValueError if one has less."""
        n = len(self.rows)
        if len(column) == n * count:
            return column.reshape(n, count)
        if self.first[-1] + count > len(column):
            raise ValueError("a row is too short")
        return np.asarray(column[self.first[:, None] + np.arange(count)])


_SIZES: Final = tuple(stop - start for start, stop in PARTS)
_KNOWN: Final = tuple((text, UNUSED) for text in (b"9E9", b"9E+09", b"9E+9"))


def _targets(text: Slots, marks: _Marks, closing: int, store: Store) -> tuple[Floats, Offsets]:
    """The numbers (n, 17) of the aggregate of aggregates in each row, and where they begin.

    closing: the mark behind it. Raises ValueError unless all rows have that form.
    """
    n, count, parts = len(marks.rows), sum(_SIZES), len(_SIZES)
    letters = text.bytes
    found = np.flatnonzero(letters == ord("["))
    if len(found) != n * (parts + 1) or np.count_nonzero(letters == ord("]")) != len(found):
        raise ValueError("brackets are missing")
    opens = found.reshape(n, parts + 1)
    stops = marks.table(marks.offsets, count)
    signs = marks.table(marks.signs, count)
    points = marks.table(marks.points, count)
    last = np.cumsum(_SIZES) - 1
    inner, outer = stops[:, last[:-1]], stops[:, -1]
    if not (
        (opens[:, 0] > marks.rows).all()
        and (opens[:, 1] == opens[:, 0] + 1).all()
        and (opens[:, 2:] == inner + 1).all()
        and (letters[inner - 1] == ord("]")).all()
        and (letters[outer - 1] == ord("]")).all()
        and (letters[outer - 2] == ord("]")).all()
        and (signs[:, :-1] == ord(",")).all()
        and (signs[:, -1] == closing).all()
    ):
        raise ValueError("brackets or commas are out of place")
    values = store.take(n)
    for part, (left, right) in enumerate(PARTS):
        start, stop = opens[:, part + 1] + 1, stops[:, right - 1] - 1 - (right == count)
        rows = slice(1 if _alike(text, start, stop) else n)
        begins = np.column_stack([start[rows], stops[rows, left : right - 1] + 1])
        ends = np.column_stack([stops[rows, left : right - 1], stop[rows]])
        ended = np.minimum(points[rows, left:right], ends)
        values[:, left:right] = text.decimals(begins, ends, ended, _KNOWN)
    if not np.isfinite(values).all():
        raise ValueError("a number is too large")
    return values, opens[:, 0]


def _alike(text: Slots, starts: Offsets, ends: Offsets) -> bool:
    """Whether all rows say the same in the very same way; it is read once then."""
    first = text.bytes[starts[0] : ends[0]].tobytes()
    return bool((ends - starts == len(first)).all() and text.holds(first, starts).all())


# Words


def _names(text: Slots, starts: Offsets, ends: Offsets) -> Names:
    """Splits names into stems and numbers; ValueError if one cannot be a name."""
    if not len(starts):
        return Names((), np.empty(0, dtype=np.int32), np.empty(0, dtype=np.int64))
    lengths = ends - starts
    if int(lengths.max()) > LONGEST_NAME:
        raise ValueError("a name is too long")
    alike = _numbered(text, starts, ends)
    return alike if alike is not None else _different(text, starts, lengths)


def _numbered(text: Slots, starts: Offsets, ends: Offsets) -> Names | None:
    """Names of one stem, with a number each; None for others."""
    stem = text.bytes[starts[0] : ends[0]].tobytes().rstrip(b"0123456789")
    count = ends - starts - len(stem)
    if not (count.min() >= 1 and count.max() <= 15 and text.holds(stem, starts).all()):
        return None
    number, good = text.whole(ends, count)
    leading = (text.bytes[ends - count] == ord("0")) & (count > 1)
    if leading.any() or not good.all():
        return None
    return Names((stem,), np.zeros(len(starts), dtype=np.int32), number)


def _different(text: Slots, starts: Offsets, lengths: Offsets) -> Names:
    fields = text.fields(starts, lengths)
    n, width = len(fields), fields.dtype.itemsize
    letters = fields.view(np.uint8).reshape(n, width)
    filled = letters != 0
    digit = (letters >= ord("0")) & (letters <= ord("9"))
    tail = np.logical_and.accumulate((digit | ~filled)[:, ::-1], axis=1)[:, ::-1] & filled
    count = tail.sum(axis=1)
    # leading zeros, and more digits than an integer holds, stay with the stem
    lead = letters[np.arange(n), np.minimum(lengths - count, width - 1)]
    plain = (count > 0) & (count <= 15) & ((lead != ord("0")) | (count == 1))
    number, _ = text.whole(starts + lengths, np.where(plain, count, 0))
    stems = np.where(tail & plain[:, None], 0, letters).astype(np.uint8).view(f"S{width}")[:, 0]
    index, table = _distinct(stems)
    words = np.array([stem.decode("ascii").lower() in RESERVED for stem in table])
    if (words[index] & ~plain).any():
        raise ValueError("a name is a reserved word")
    return Names(tuple(table), index, np.where(plain, number, -1))


def _motions(
    text: Slots, starts: Offsets, ends: Offsets
) -> tuple[NDArray[np.int32], tuple[MotionNames, ...]]:
    """Which motion each row names behind its target, and the different ones."""
    if _alike(text, starts, ends):
        only = _motion(text.bytes[starts[0] : ends[0]].tobytes())
        return np.zeros(len(starts), dtype=np.int32), (only,)
    lengths = ends - starts
    if int(lengths.max()) > 4 * LONGEST_NAME + 24:
        raise ValueError("a name is too long")
    index, tails = _distinct(text.fields(starts, lengths))
    table: dict[MotionNames, int] = {}
    rows = [table.setdefault(_motion(tail), len(table)) for tail in tails]
    return np.array(rows, dtype=np.int32)[index], tuple(table)


def _motion(tail: bytes) -> MotionNames:
    speed, zone, tool, *frame = re.findall(r"[A-Za-z]\w*", tail.decode("ascii"))
    names = (speed, zone, tool, *frame[1:])
    if any(len(name) > LONGEST_NAME or name.lower() in RESERVED for name in names):
        raise ValueError("a word is no name")
    return MotionNames(speed, zone, tool, frame[1] if frame else "")


def _distinct(values: NDArray[np.bytes_]) -> tuple[NDArray[np.int32], list[bytes]]:
    """Index of each value in the list of different ones, in order of first appearance."""
    change = np.concatenate([[True], values[1:] != values[:-1]])
    firsts = values[change]
    table, first, inverse = np.unique(firsts, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(table), dtype=np.int32)
    rank[order] = np.arange(len(table), dtype=np.int32)
    index = rank[inverse][np.cumsum(change) - 1]
    return index, [bytes(v) for v in table[order]]
