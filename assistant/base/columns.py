"""Numbers in columns to and from text, vectorised: no Python object per row in either direction.

    rows_text([b"p", Integer(i), b":=[", Decimal(x, 3, strip=True), b"];"], n)

writes n rows one after the other. Digits are written in groups of four from a table, into a byte
matrix with a mask of the bytes that count; the masked bytes in row order are the text.

If a reader has the offsets of numbers and words already, `Slots` fetches each as one or two machine
words and sums its digits in parallel, all rows at once. `columns_html` shows columns in a notebook:
their range, and the first and last rows.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import Final, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from assistant.base.data_classes import dataclass
from assistant.base.source_text import visible

_Bytes = NDArray[np.uint8]
_Mask = NDArray[np.bool_]

CHUNK: Final = 8192
"""Rows set at a time: the matrices of one chunk fit the processor's cache."""

_LARGEST_EXACT: Final = 2**53
"""Scaled values at or above this have no exact digits in a double."""


@dataclass(frozen=True, slots=True)
class Decimal:
    """values (n,) with a fixed number of decimal places, rounded half to even.

    plus: a sign on every number. strip: no trailing zeros, nor a bare point.
    missing: what stands for NaN; without it NaN raises ValueError, as infinity always does.
    """

    values: NDArray[np.float64]
    places: int
    plus: bool = False
    strip: bool = False
    missing: bytes | None = None


@dataclass(frozen=True, slots=True)
class Integer:
    """values (n,) as whole numbers."""

    values: NDArray[np.integer]


@dataclass(frozen=True, slots=True)
class Chosen:
    """The texts of a table by index (n,)."""

    index: NDArray[np.integer]
    table: Sequence[bytes]


Piece = bytes | Decimal | Integer | Chosen


def rows_text(pieces: Sequence[Piece], n: int) -> bytes:
    """The text of n rows, each made of the pieces in their order.

    Raises ValueError for infinity, NaN without a `missing`, or more digits than a double has.
    """
    return b"".join(_row_chunks(pieces, n))


def _row_chunks(pieces: Sequence[Piece], n: int) -> Iterator[bytes]:
    """The text of `rows_text` in parts of `CHUNK` rows."""
    merged = _merged(pieces)
    for start in range(0, n, CHUNK):
        rows = slice(start, min(start + CHUNK, n))
        fields = [_field(piece, rows) for piece in merged]
        edges = np.cumsum([0, *(field.width for field in fields)])
        text = np.empty((rows.stop - rows.start, edges[-1]), dtype=np.uint8)
        keep = np.ones(text.shape, dtype=bool)
        for field, left, right in zip(fields, edges, edges[1:], strict=False):
            field.write(text[:, left:right], keep[:, left:right])
        yield text[keep].tobytes()


def _merged(pieces: Sequence[Piece]) -> list[Piece]:
    merged: list[Piece] = []
    for piece in pieces:
        if isinstance(piece, bytes) and merged and isinstance(merged[-1], bytes):
            merged[-1] += piece
        elif piece != b"" or not isinstance(piece, bytes):
            merged.append(piece)
    return merged


class _Field(Protocol):
    """A piece of some rows: how wide it is at most, and how it is written."""

    @property
    def width(self) -> int: ...

    def write(self, text: _Bytes, keep: _Mask) -> None:
        """Fills the columns of all rows, and clears `keep` for the bytes that do not count."""


def _field(piece: Piece, rows: slice) -> _Field:
    match piece:
        case bytes():
            return _Constant(piece)
        case Chosen():
            return _Choice(np.asarray(piece.index[rows]), piece.table)
        case Integer():
            values = np.asarray(piece.values[rows], dtype=np.int64)
            return _Digits(np.abs(values), values < 0)
        case Decimal():
            return _decimal(piece, np.asarray(piece.values[rows], dtype=np.float64))


@dataclass(frozen=True, slots=True)
class _Constant:
    content: bytes

    @property
    def width(self) -> int:
        return len(self.content)

    def write(self, text: _Bytes, keep: _Mask) -> None:  # noqa: ARG002  all of it counts
        text[:] = np.frombuffer(self.content, dtype=np.uint8)


@dataclass(frozen=True, slots=True)
class _Choice:
    index: NDArray[np.integer]
    table: Sequence[bytes]

    @property
    def width(self) -> int:
        return max((len(entry) for entry in self.table), default=0)

    def write(self, text: _Bytes, keep: _Mask) -> None:
        entries = np.zeros((max(len(self.table), 1), self.width), dtype=np.uint8)
        lengths = np.array([len(entry) for entry in self.table] or [0])
        for row, entry in enumerate(self.table):
            entries[row, : len(entry)] = np.frombuffer(entry, dtype=np.uint8)
        text[:] = entries[self.index]
        keep[:] = np.arange(self.width) < lengths[self.index][:, None]


def _decimal(piece: Decimal, values: NDArray[np.float64]) -> _Field:
    absent = np.isnan(values)
    if absent.any() and piece.missing is None:
        raise ValueError("not a number")
    scaled = np.rint(np.abs(np.where(absent, 0.0, values)) * 10.0**piece.places)
    if not (scaled < _LARGEST_EXACT).all():
        raise ValueError("a number has more digits than can be written")
    whole = scaled.astype(np.int64)
    negative = (values < 0) & (whole > 0)  # never "-0.00"
    digits = _Digits(whole, negative, piece.places, plus=piece.plus, strip=piece.strip)
    if piece.missing is None or not absent.any():
        return digits
    return _Gaps(digits, _Choice(absent.astype(np.int64), (b"", piece.missing)), absent)


@dataclass(frozen=True, slots=True)
class _Gaps:
    """Numbers, and what stands for those that are absent."""

    numbers: _Digits
    instead: _Choice
    absent: _Mask

    @property
    def width(self) -> int:
        return self.numbers.width + self.instead.width

    def write(self, text: _Bytes, keep: _Mask) -> None:
        edge = self.numbers.width
        self.numbers.write(text[:, :edge], keep[:, :edge])
        keep[self.absent, :edge] = False
        self.instead.write(text[:, edge:], keep[:, edge:])


_FOUR: Final = (np.arange(10000)[:, None] // (1000, 100, 10, 1) % 10 + ord("0")).astype(np.uint8)
"""The digits of all numbers of four, a row for each."""
_ZERO, _POINT, _PLUS, _MINUS = b"0.+-"


@dataclass(frozen=True, slots=True)
class _Digits:
    """whole / 10**places with its sign where `negative`."""

    whole: NDArray[np.int64]
    negative: _Mask
    places: int = 0
    plus: bool = False
    strip: bool = False

    @property
    def before(self) -> int:
        """Digits before the point, of the largest."""
        return max(len(str(int(self.whole.max(initial=0)))) - self.places, 1)

    @property
    def width(self) -> int:
        return 1 + self.before + (1 + self.places if self.places else 0)

    def write(self, text: _Bytes, keep: _Mask) -> None:
        before, places = self.before, self.places
        text[:, 0] = np.where(self.negative, _MINUS, _PLUS)
        keep[:, 0] = self.negative | self.plus
        whole, fraction = np.divmod(self.whole, 10**places) if places else (self.whole, None)
        self._number(whole, text[:, 1 : 1 + before])
        for column in range(before - 1):  # leading zeros, except the one before the point
            keep[:, 1 + column] = whole >= 10 ** (before - 1 - column)
        if fraction is None:
            return
        after = slice(2 + before, None)
        text[:, 1 + before] = _POINT
        self._number(fraction, text[:, after])
        if self.strip:
            # From the right: a zero counts only with another digit after it, the point only with
            # any.
            tail = np.logical_or.accumulate(text[:, : 1 + before : -1] != _ZERO, axis=1)
            keep[:, after] = tail[:, ::-1]
            keep[:, 1 + before] = tail[:, -1]

    def _number(self, values: NDArray[np.int64], text: _Bytes) -> None:
        """The last digits of each value, as many as there are columns."""
        right = text.shape[1]
        while right > 4:
            values, low = np.divmod(values, 10000)
            text[:, right - 4 : right] = _FOUR[low]
            right -= 4
        text[:, :right] = _FOUR[values % 10000, 4 - right :]


_SEPARATORS: Final = bytes.maketrans(b"[](),;\r\n\t", b"         ")
_NUMERIC: Final = b"0123456789+-.eE "
_BLANK: Final = ord(" ")
# 10^18 is the largest power of ten in 64 bits.
_POWERS: Final = 10 ** np.arange(19, dtype=np.int64)
_PART: Final = 1 << 18
"""Bytes read at a time, for the same reason as `CHUNK`."""


def read_numbers(data: bytes) -> NDArray[np.float64]:
    """Read all numbers of a text in which brackets, commas, semicolons and blanks separate them.

    Each is the double nearest to its text, as `float` would give it. Raises ValueError if the text
    has anything else or a number is malformed.
    """
    spaced = data.translate(_SEPARATORS) + b" "
    if spaced.translate(None, _NUMERIC):
        raise ValueError("the text holds more than numbers")
    for _ in range(2):  # RAPID's unused axis; twice, since neighbours share a blank
        spaced = spaced.replace(b" 9E9 ", b" 9000000000 ").replace(b" 9E+09 ", b" 9000000000 ")
    parts, start = [], 0
    while start < len(spaced):
        # A part ends at a blank, so that no number is cut.
        stop = spaced.find(b" ", min(start + _PART, len(spaced) - 1)) + 1
        part = spaced[start:stop]
        parts.append(_any_numbers(part) if (plain := _plain_numbers(part)) is None else plain)
        start = stop
    return np.concatenate(parts) if parts else np.empty(0)


def _plain_numbers(spaced: bytes) -> NDArray[np.float64] | None:
    """Numbers of at most 15 digits without exponent, None if there are others.

    The digits as a whole number and the power of ten are exact doubles, so their quotient
    is the correctly rounded value.
    """
    if b"E" in spaced or b"e" in spaced:
        return None
    text = np.frombuffer(spaced, dtype=np.uint8)
    filled = text != _BLANK
    digit = (text >= _ZERO) & (text <= _ZERO + 9)
    before = np.concatenate([[False], filled[:-1]])
    starts, ends = np.flatnonzero(filled & ~before), np.flatnonzero(before & ~filled)
    if not len(starts):
        return np.empty(0)
    # Digits are counted over the complete text: a number has those between its ends.
    so_far = np.cumsum(digit, dtype=np.int32)
    through = so_far[ends - 1]
    first = np.concatenate([[0], through[:-1]])
    count = through - first
    points = np.flatnonzero(text == _POINT)
    signs = np.flatnonzero((text == _MINUS) | (text == _PLUS))
    of_point = np.searchsorted(starts, points, side="right") - 1
    odd = len(points) + len(signs) + int(through[-1]) != int(np.count_nonzero(filled))
    # A second point or a sign inside a number is left to the slow reader, which refuses it.
    if (
        odd
        or count.min() < 1
        or count.max() > 15
        or (np.diff(of_point) == 0).any()
        or before[signs].any()
    ):
        return None
    # The power of ten of each digit: how many digits of its number follow.
    place = np.repeat(through, count) - 1 - np.arange(through[-1])
    whole = np.add.reduceat((text[digit] - _ZERO) * _POWERS[place], first)
    decimals = np.zeros(len(starts), dtype=np.int64)
    decimals[of_point] = through[of_point] - so_far[points]
    values = whole / _POWERS[decimals].astype(np.float64)
    return np.where(text[starts] == _MINUS, -values, values)


def _any_numbers(spaced: bytes) -> NDArray[np.float64]:
    # numpy only warns about text that it cannot read.
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(spaced, dtype=np.float64, sep=" ")
        except DeprecationWarning:
            raise ValueError("a number is malformed") from None


Offsets = NDArray[np.intp]
Words = NDArray[np.uint64]

WORD: Final = 8
_MOST_DIGITS: Final = 15
"""A whole number of so many digits is an exact double, and so is the power of ten below it."""
# Eight ASCII zeros: exclusive or with them turns digits into their values.
_DIGITS: Final = np.uint64(0x3030303030303030)
# A byte above 9 plus 0x76 sets the high bit of the byte.
_OVER_NINE: Final = np.uint64(0x7676767676767676)
_HIGH: Final = np.uint64(0x8080808080808080)
_PAIRS: Final = np.uint64(0x000000FF000000FF)
# Factors of the pairs of digits: the sum of the products is in the upper 32 bits.
_FIRST: Final = np.uint64(100 + (1_000_000 << 32))
_SECOND: Final = np.uint64(1 + (10_000 << 32))
_ALL: Final = np.uint64(0xFFFFFFFFFFFFFFFF)


class Slots:
    """A text in which offsets count from `WORD` bytes of margin, so that words may overhang."""

    def __init__(self, data: bytes) -> None:
        margin = b" " * WORD
        padded = margin + data + margin
        self.bytes = np.frombuffer(padded, dtype=np.uint8)
        # A word begins at every byte: they overlap, and nothing is copied.
        self._words: Words = np.ndarray((len(padded) - WORD + 1,), "<u8", padded, strides=(1,))

    def words(self, starts: Offsets, lengths: Offsets) -> Words:
        """The first eight bytes from each start, zero behind `lengths`."""
        # numpy shifts 64 bits and more to 0, so lengths of 0 and less give an empty word.
        over = np.maximum(WORD - lengths, 0).astype(np.uint64) << np.uint64(3)
        return np.asarray(self._words[starts] & (_ALL >> over))

    def fields(self, starts: Offsets, lengths: Offsets) -> NDArray[np.bytes_]:
        """The bytes (n,) from each start, as wide as the longest."""
        columns = max(-(-int(lengths.max(initial=1)) // WORD), 1)
        out = np.empty((len(starts), columns), dtype="<u8")
        for column in range(columns):
            at = np.minimum(starts + WORD * column, len(self._words) - 1)
            out[:, column] = self.words(at, lengths - WORD * column)
        return out.view(f"S{WORD * columns}")[:, 0]

    def holds(self, text: bytes, starts: Offsets) -> NDArray[np.bool_]:
        """True where the text begins at the given start, one truth per start."""
        found = np.ones(starts.shape, dtype=bool)
        for at in range(0, len(text), WORD):
            part = text[at : at + WORD]
            wanted = np.uint64(int.from_bytes(part, "little"))
            mask = np.uint64((1 << (8 * len(part))) - 1)
            place = np.minimum(starts + at, len(self._words) - 1)
            found &= (self._words[place] & mask) == wanted
            if not found.any():
                break
        return found

    def whole(self, ends: Offsets, count: Offsets) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Whole numbers of the `count` digits, 16 at most, before each end.

        The second array says where they are digits and not too many.
        """
        most = int(count.max(initial=0))
        if most == 1:
            digit = self.bytes[ends - 1] ^ np.uint8(ord("0"))
            digit[count == 0] = 0
            return digit.astype(np.int64), digit < 10
        value, good = _eight(self._words[ends - WORD], count)
        if most > WORD:
            # Two words back may be before the margin; no digit is taken from there.
            at = np.maximum(ends - 2 * WORD, 0)
            high, also = _eight(self._words[at], np.maximum(count - WORD, 0))
            value, good = value + high * _POWERS[WORD], good & also & (count <= 2 * WORD)
        return value, good

    def decimals(
        self, starts: Offsets, ends: Offsets, points: Offsets, known: Sequence[tuple[bytes, float]]
    ) -> NDArray[np.float64]:
        """Return the doubles nearest to the number in each slot, as `float` would give them.

        points: of each slot its decimal point, or its end. known: spellings of one number that many
        slots hold. Raises ValueError for a slot that holds no number.
        """
        head = self.bytes[starts]
        negative = head == ord("-")
        before = points - starts - (negative | (head == ord("+")))
        whole, good = self.whole(points, before)
        places = np.maximum(ends - points - 1, 0)
        digits = before + places
        if places.any():
            fraction, also = self.whole(ends, places)
            good &= also
            # Slots with more digits are read by `_odd`; the table has no power for all of them.
            places = np.minimum(places, _MOST_DIGITS)
            values = (whole * _POWERS[places] + fraction) / _POWERS[places].astype(np.float64)
        else:
            values = whole.astype(np.float64)
        np.negative(values, out=values, where=negative)
        good &= (digits >= 1) & (digits <= _MOST_DIGITS)
        if not good.all():
            odd = ~good
            values[odd] = self._odd(starts[odd], ends[odd], known)
        return np.asarray(values, dtype=np.float64)

    def _odd(
        self, starts: Offsets, ends: Offsets, known: Sequence[tuple[bytes, float]]
    ) -> NDArray[np.float64]:
        values = np.empty(len(starts))
        left = np.ones(len(starts), dtype=bool)
        for text, value in known:
            same = (ends - starts == len(text)) & self.holds(text, starts)
            values[same] = value
            left &= ~same
        if left.any():
            written = self.fields(starts[left], ends[left] - starts[left])
            # Such texts repeat: each different one is parsed once.
            different, index = np.unique(written, return_inverse=True)
            values[left] = np.array([float(text) for text in different])[index]
        return values


def _eight(words: Words, count: Offsets) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """The number that the last `count` bytes of each word spell, where they are all digits."""
    # Little-endian: the bytes before the digits are the low ones, and are shifted out.
    over = np.maximum(WORD - count, 0).astype(np.uint64) << np.uint64(3)
    value = ((words ^ _DIGITS) >> over) << over
    good = ((value + _OVER_NINE) | value) & _HIGH == 0
    value = value * np.uint64(10) + (value >> np.uint64(8))
    pairs = (value & _PAIRS) * _FIRST + ((value >> np.uint64(16)) & _PAIRS) * _SECOND
    return (pairs >> np.uint64(32)).view(np.int64), good


MOST_SHOWN_ROWS: Final = 8
"""Rows of a table that are shown, half of them from its end."""
MOST_SHOWN_COLUMNS: Final = 40


def columns_html(told: str, columns: Mapping[str, ArrayLike]) -> str:
    """Return an HTML table of columns (n,) or (n, k) by name; k columns are numbered from 1.

    told: text above the table. Names are shown literally, never interpreted as markup.
    """
    single = dict(_single_columns(columns))
    some = dict(list(single.items())[:MOST_SHOWN_COLUMNS])
    count = max((len(column) for column in some.values()), default=0)
    shown = _shown_rows(count)
    head = "".join(f"<th>{html_text(name)}</th>" for name in some)
    body = "".join(
        f"<tr><td>{'…' if row is None else row}</td>"
        + "".join(
            f"<td>{'' if row is None else _number_html(column, row)}</td>"
            for column in some.values()
        )
        + "</tr>"
        for row in shown
    )
    ranges = "".join(f"<td>{_range_html(column)}</td>" for column in some.values())
    more = len(single) - len(some)
    rest = f"<p>and {more} more columns</p>" if more > 0 else ""
    table = f"<table><thead><tr><th></th>{head}</tr></thead><tbody>{body}"
    last = f"<tr><td><small>from … to</small></td>{ranges}</tr>" if count else ""
    return f"<div><p>{html_text(told)}</p>{table}{last}</tbody></table>{rest}</div>"


def html_text(given: str) -> str:
    """A text as a page shows it, on one line, nothing in it that a page obeys."""
    from html import escape

    return escape(visible(given))


def _single_columns(columns: Mapping[str, ArrayLike]) -> list[tuple[str, NDArray[np.generic]]]:
    """Columns (n,), those of a wider one by number."""
    found: list[tuple[str, NDArray[np.generic]]] = []
    for name, given in columns.items():
        values = np.asarray(given)
        if values.ndim == 1:
            found.append((name, values))
        else:
            wide = values.reshape(len(values), -1)
            found += [(f"{name}.{i + 1}", column) for i, column in enumerate(wide.T)]
    return found


def _shown_rows(count: int) -> list[int | None]:
    if count <= MOST_SHOWN_ROWS:
        return list(range(count))
    half = MOST_SHOWN_ROWS // 2
    return [*range(half), None, *range(count - half, count)]


def _number_html(column: NDArray[np.generic], row: int) -> str:
    if row >= len(column):
        return ""
    value = column[row]
    return f"{value:.5g}" if np.issubdtype(column.dtype, np.floating) else html_text(str(value))


def _range_html(column: NDArray[np.generic]) -> str:
    if not np.issubdtype(column.dtype, np.number):
        return ""
    finite = column[np.isfinite(column)]
    return f"<small>{finite.min():.4g} … {finite.max():.4g}</small>" if len(finite) else ""
