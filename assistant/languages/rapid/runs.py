"""Long runs of alike lines as columns: declared robtargets and plain moves, read and written.

A million targets are a million lines of two forms. They are matched as a whole and turned
into numpy columns; the grammar sees one token each. What does not fit exactly is left in the
text for the grammar, so that both ways always agree.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.languages.rapid.tables import LONGEST_NAME, RESERVED, UNUSED
from assistant.program.columns import Chosen, Decimal, Integer, Piece, inside, numbers, rows_text

FEWEST: Final = 8
"""Rows that make a run; fewer are cheap as ordinary nodes."""

MOST: Final = 8192
"""Rows read at a time, so that their text and numbers fit the processor's cache."""

POSITION_PLACES: Final = 4
QUATERNION_PLACES: Final = 9
JOINT_PLACES: Final = 6
"""Of joints and external axes, degrees or mm."""
MOST_DECIMALS: Final = 1e6
"""mm; smaller values have nine exact decimals in a double."""
PARTS: Final = ((0, 3), (3, 7), (7, 11), (11, 17))
"""Columns of position, quaternion, confdata and external axes."""
MOVES: Final = ("MoveJ", "MoveL", "MoveC")
JOINT, LINEAR, CIRCULAR = range(3)


@dataclass(frozen=True, slots=True, eq=False)
class Names:
    """n names, each a stem and a number behind it.

    stem: (n,) int32 rows of stems. number: (n,) int64, -1 for a name that is its stem.
    """

    stems: tuple[bytes, ...]
    stem: NDArray[np.int32]
    number: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.stem)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Names):
            return NotImplemented
        if len(self) != len(other) or not np.array_equal(self.number, other.number):
            return False
        same = np.array([[a == b for b in other.stems] for a in self.stems], dtype=bool)
        return len(self) == 0 or bool(same[self.stem, other.stem].all())

    def __hash__(self) -> int:
        return hash((len(self), self.number[:1].tobytes()))

    def pieces(self) -> list[Piece]:
        digits = Chosen(self.stem, self.stems)
        if (self.number >= 0).all():
            return [digits, Integer(self.number)]
        missing = np.where(self.number < 0, np.nan, self.number)
        return [digits, Decimal(missing, 0, missing=b"")]

    def name(self, row: int) -> str:
        """One name; for the few, never for all."""
        number = int(self.number[row])
        stem = self.stems[int(self.stem[row])].decode("ascii")
        return f"{stem}{number}" if number >= 0 else stem

    def rows(self, rows: slice | NDArray[np.intp]) -> Names:
        return Names(self.stems, self.stem[rows], self.number[rows])

    @staticmethod
    def numbered(stem: str, count: int, first: int = 1) -> Names:
        """`stem` followed by first, first + 1 …"""
        return Names(
            (stem.encode("ascii"),),
            np.zeros(count, dtype=np.int32),
            np.arange(first, first + count, dtype=np.int64),
        )


@dataclass(frozen=True, slots=True, eq=False)
class TargetRun:
    """n declared robtargets.

    values: (n, 17) position mm, quaternion, confdata, external axes with 9E9 for unused ones.
    """

    names: Names
    values: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.values)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TargetRun):
            return NotImplemented
        return self.names == other.names and np.array_equal(self.values, other.values)

    def __hash__(self) -> int:
        return hash(self.names)


@dataclass(frozen=True, slots=True)
class MotionNames:
    """What a plain move names behind its target; frame empty without WObj."""

    speed: str
    zone: str
    tool: str
    frame: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class MoveRun:
    """n plain moves.

    kinds: (n,) uint8, rows of MOVES. names: the n targets. vias: of the circular moves only.
    motion: (n,) int32 rows of motions.
    """

    kinds: NDArray[np.uint8]
    names: Names
    vias: Names
    motion: NDArray[np.int32]
    motions: tuple[MotionNames, ...]

    def __len__(self) -> int:
        return len(self.kinds)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, MoveRun):
            return NotImplemented
        if len(self) != len(other) or not np.array_equal(self.kinds, other.kinds):
            return False
        same = np.array([[a == b for b in other.motions] for a in self.motions], dtype=bool)
        return (
            self.names == other.names
            and self.vias == other.vias
            and (len(self) == 0 or bool(same[self.motion, other.motion].all()))
        )

    def __hash__(self) -> int:
        return hash(self.names)


# Writing


def targets_text(run: TargetRun, scope: str, indent: str, newline: str) -> str:
    """The declarations of a run; every value comes back as the very same double."""
    head = f"{indent}{scope + ' ' if scope else ''}CONST robtarget "
    pieces: list[Piece] = [head.encode("ascii"), *run.names.pieces(), b":=[["]
    for part, (start, stop) in enumerate(PARTS):
        pieces.append(b"],[" if part else b"")
        for column in range(start, stop):
            pieces.append(b"," if column > start else b"")
            pieces += _number(run.values[:, column])
    pieces.append(b"]];" + newline.encode("ascii"))
    return rows_text(pieces, len(run)).decode("ascii")


def _number(values: NDArray[np.float64]) -> list[Piece]:
    """A column in the fewest decimals that give it back; odd values as Python writes them."""
    if len(values) > 1 and (values == values[0]).all():
        return [rows_text(_number(values[:1]), 1)]
    for places in (0, POSITION_PLACES, QUATERNION_PLACES):
        if (np.abs(values) < MOST_DECIMALS).all() and (np.round(values, places) == values).all():
            return [Decimal(values, places, strip=True)]
    odd = (np.abs(values) >= MOST_DECIMALS) | (np.round(values, QUATERNION_PLACES) != values)
    different, index = np.unique(values[odd], return_inverse=True)
    texts = [b"9E9" if v == UNUSED else repr(float(v)).encode("ascii") for v in different]
    chosen = np.zeros(len(values), dtype=np.int64)
    chosen[odd] = index + 1
    pieces: list[Piece] = [Chosen(chosen, (b"", *texts))]
    if not odd.all():
        plain = np.where(odd, np.nan, values)
        pieces.append(Decimal(plain, QUATERNION_PLACES, strip=True, missing=b""))
    return pieces


def moves_text(run: MoveRun, indent: str, newline: str) -> str:
    circular = run.kinds == CIRCULAR
    row = np.cumsum(circular) - 1
    via = Names(
        (*run.vias.stems, b""),
        np.where(circular, _at(run.vias.stem, row), len(run.vias.stems)).astype(np.int32),
        np.where(circular, _at(run.vias.number, row), -1),
    )
    between = Chosen(circular.astype(np.int64), (b"", b","))
    kinds = tuple(f"{indent}{kind} ".encode("ascii") for kind in MOVES)
    tails = tuple(
        f",{m.speed},{m.zone},{m.tool}{chr(92) + 'WObj:=' + m.frame if m.frame else ''};{newline}"
        for m in run.motions
    )
    pieces: list[Piece] = [Chosen(run.kinds, kinds)]
    if circular.any():
        pieces += [*via.pieces(), between]
    pieces += [*run.names.pieces(), Chosen(run.motion, tuple(t.encode("ascii") for t in tails))]
    return rows_text(pieces, len(run)).decode("ascii")


def _at(values: NDArray[np.int64] | NDArray[np.int32], rows: NDArray[np.intp]) -> NDArray[np.int64]:
    if not len(values):
        return np.zeros(len(rows), dtype=np.int64)
    return np.asarray(values[np.maximum(rows, 0)], dtype=np.int64)


# Reading

_NAME = r"[A-Za-z][A-Za-z0-9_]*+"
_SLOT = r" *+[-+0-9.eE]++ *+"
_EOL = r";[ \t]*+(?:\r?\n|\Z)"


def _slots(count: int) -> str:
    return r"\[" + ",".join([_SLOT] * count) + r"\]"


_HEAD = r"[ \t]*+(?P<local>(?:LOCAL +)?+)CONST +robtarget +"
_VALUE = rf"\[{_slots(3)},{_slots(4)},{_slots(4)},{_slots(6)}\]"
_TARGET_ROW = rf"[ \t]*+(?P=local)CONST +robtarget +{_NAME} *+:= *+{_VALUE}{_EOL}"
_TAIL = rf" *+, *+{_NAME} *+, *+{_NAME} *+, *+{_NAME}(?: *+\\WObj *+:= *+{_NAME})?+ *+"
_MOVE_ROW = rf"[ \t]*+Move(?:[JL] ++{_NAME}|C ++{_NAME} *+, *+{_NAME}){_TAIL}{_EOL}"

_NO_EXTERNAL: Final = b"[9E9,9E9,9E9,9E9,9E9,9E9]"

_RUNS: Final = re.compile(
    rf"^(?:{_HEAD}{_NAME} *+:= *+{_VALUE}{_EOL}(?:{_TARGET_ROW}){{{FEWEST - 1},{MOST - 1}}}+"
    rf"|(?P<moves>(?:{_MOVE_ROW}){{{FEWEST},{MOST}}}+))",
    re.MULTILINE,
)


@dataclass(frozen=True, slots=True)
class Found:
    """A run in a text: its offsets and what it says. scope: of declarations."""

    start: int
    end: int
    run: TargetRun | MoveRun
    scope: str = ""


def find_runs(text: str) -> Iterator[Found]:
    """The runs of a text, in order; rows that are not exactly plain are left out."""
    for match in _RUNS.finditer(text):
        start, end = match.span()
        scope = (match["local"] or "").strip()
        yield from _read(text, start, end, moves=match["moves"] is not None, scope=scope)


def _read(text: str, start: int, end: int, *, moves: bool, scope: str) -> Iterator[Found]:
    """Reads a stretch of rows; where one is damaged the stretch is halved around it."""
    stretch = text[start:end]
    if stretch.count("\n") + (not stretch.endswith("\n")) < FEWEST:
        return
    try:
        data = stretch.encode("ascii")
        run = _moves(data) if moves else _targets(data)
    except ValueError:
        middle = text.find("\n", start + (end - start) // 2, end - 1) + 1
        if middle > start:
            yield from _read(text, start, middle, moves=moves, scope=scope)
            yield from _read(text, middle, end, moves=moves, scope=scope)
        return
    yield Found(start, end, run, scope)


def _targets(data: bytes) -> TargetRun:
    rows = data.count(b";")
    short = data.replace(_NO_EXTERNAL, b"[]")  # six numbers fewer to read
    stated = 17 if len(data) - len(short) != rows * (len(_NO_EXTERNAL) - 2) else 11
    read = numbers(inside(short if stated == 11 else data, b"[[", b"]]"))
    if len(read) != stated * rows or not np.isfinite(read).all():
        raise ValueError("a value is no number")
    values = np.full((rows, 17), UNUSED)
    values[:, :stated] = read.reshape(rows, stated)
    text = np.frombuffer(data, dtype=np.uint8)
    words = _find(text, b"robtarget") + len(b"robtarget")
    ends = _find(text, b":=")
    return TargetRun(_names(text, words, ends), values)


def _moves(data: bytes) -> MoveRun:
    text = np.frombuffer(data, dtype=np.uint8)
    stops = np.flatnonzero(text == ord(";"))
    begins = np.concatenate([[0], stops[:-1] + 1])
    first = begins + _skip(text, begins)
    kinds = np.searchsorted([ord("C"), ord("J"), ord("L")], text[first + 4])
    kind = np.array([CIRCULAR, JOINT, LINEAR], dtype=np.uint8)[kinds]
    circular = kind == CIRCULAR
    commas = np.flatnonzero(text == ord(","))
    at = np.searchsorted(commas, first)
    via_end = commas[at]
    target_end = commas[at + circular]
    starts = np.where(circular, via_end + 1, first + 5)
    vias = _names(text, first[circular] + 5, via_end[circular])
    names = _names(text, starts, target_end)
    motion, tails = _distinct(_field(text, target_end + 1, stops, 4 * LONGEST_NAME + 24))
    motions = tuple(_motion(tail) for tail in tails)
    return MoveRun(kind, names, vias, motion, motions)


def _motion(tail: bytes) -> MotionNames:
    words = re.findall(r"[A-Za-z]\w*", tail.decode("ascii"))
    speed, zone, tool, *frame = words
    return MotionNames(speed, zone, tool, frame[-1] if frame else "")


def _find(text: NDArray[np.uint8], mark: bytes) -> NDArray[np.intp]:
    """Offsets of a mark that cannot overlap itself."""
    room = len(text) - len(mark) + 1
    candidates = np.flatnonzero(text[:room] == mark[-1]) if len(mark) == 1 else None
    if candidates is None:
        candidates = np.flatnonzero((text[:room] == mark[0]) & (text[1 : room + 1] == mark[1]))
        for i in range(2, len(mark)):
            candidates = candidates[text[candidates + i] == mark[i]]
    return candidates


def _skip(text: NDArray[np.uint8], begins: NDArray[np.intp]) -> NDArray[np.intp]:
    """How many blanks and line ends stand at each offset."""
    skipped = np.zeros(len(begins), dtype=np.intp)
    last = len(text) - 1
    blank = np.zeros(256, dtype=bool)
    blank[list(b" \t\r\n")] = True
    while True:
        more = blank[text[np.minimum(begins + skipped, last)]]
        if not more.any():
            return skipped
        skipped = skipped + more


_PART: Final = 1 << 15


def _field(
    text: NDArray[np.uint8], starts: NDArray[np.intp], ends: NDArray[np.intp], most: int
) -> NDArray[np.bytes_]:
    """What stands between offsets, outer blanks removed, as fixed-width bytes.

    Raises ValueError for anything longer than `most`.
    """
    starts = starts + _skip(text, starts)
    lengths = ends - starts
    while (tail := (lengths > 0) & (text[starts + np.maximum(lengths, 1) - 1] == 32)).any():
        lengths = lengths - tail
    width = int(lengths.max(initial=1))
    if width > most:
        raise ValueError("a name is too long")
    out = np.zeros((len(starts), width), dtype=np.uint8)
    offsets = np.arange(width)
    for part in range(0, len(starts), _PART):
        rows = slice(part, part + _PART)
        where = np.minimum(starts[rows, None] + offsets, len(text) - 1)
        out[rows] = np.where(offsets < lengths[rows, None], text[where], 0)
    return out.view(f"S{width}")[:, 0]


def _distinct(values: NDArray[np.bytes_]) -> tuple[NDArray[np.int32], list[bytes]]:
    """Index of each value in the list of different ones, in order of first appearance."""
    if not len(values):
        return np.empty(0, dtype=np.int32), []
    change = np.concatenate([[True], values[1:] != values[:-1]])
    firsts = values[change]
    table, first, inverse = np.unique(firsts, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(table), dtype=np.int32)
    rank[order] = np.arange(len(table), dtype=np.int32)
    index = rank[inverse][np.cumsum(change) - 1]
    return index, [bytes(v) for v in table[order]]


def _names(text: NDArray[np.uint8], starts: NDArray[np.intp], ends: NDArray[np.intp]) -> Names:
    """Splits names into stems and numbers; ValueError if one cannot be a name."""
    fields = _field(text, starts, ends, LONGEST_NAME)
    n = len(fields)
    if not n:
        return Names((), np.empty(0, dtype=np.int32), np.empty(0, dtype=np.int64))
    width = fields.dtype.itemsize
    letters = fields.view(np.uint8).reshape(n, width)
    filled = letters != 0
    digit = (letters >= ord("0")) & (letters <= ord("9"))
    tail = np.logical_and.accumulate((digit | ~filled)[:, ::-1], axis=1)[:, ::-1] & filled
    count = tail.sum(axis=1)
    # leading zeros, and more digits than an integer holds, stay with the stem
    lead = letters[np.arange(n), np.minimum(filled.sum(axis=1) - count, width - 1)]
    plain = (count > 0) & (count <= 15) & ((lead != ord("0")) | (count == 1))
    tail &= plain[:, None]
    number = np.zeros(n, dtype=np.int64)
    for column in range(width):
        number = np.where(
            tail[:, column], number * 10 + letters[:, column] - np.int64(ord("0")), number
        )
    stems = np.where(tail, 0, letters).astype(np.uint8).view(f"S{width}")[:, 0]
    index, table = _distinct(stems)
    if any(stem.decode("ascii").lower() in RESERVED for stem in table):
        whole = {s for s in table if s.decode("ascii").lower() in RESERVED}
        rows = np.isin(stems, list(whole)) & ~plain
        if rows.any():
            raise ValueError("a name is a reserved word")
    return Names(tuple(table), index, np.where(plain, number, -1))


def concatenate(runs: Sequence[TargetRun]) -> TargetRun:
    """Several runs as one."""
    stems: list[bytes] = []
    stem = []
    for run in runs:
        stem.append(run.names.stem + np.int32(len(stems)))
        stems.extend(run.names.stems)
    names = Names(
        tuple(stems),
        np.concatenate([np.empty(0, np.int32), *stem]),
        np.concatenate([np.empty(0, np.int64), *(run.names.number for run in runs)]),
    )
    return TargetRun(names, np.concatenate([np.empty((0, 17)), *(run.values for run in runs)]))
