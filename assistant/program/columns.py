r"""Numbers in columns to and from text, vectorised: no Python object a row either way.

    rows_text([b"p", Integer(i), b":=[", Decimal(x, 3, strip=True), b"];\r\n"], n)

writes n rows one after the other. Digits come in groups of four from a table, into a byte
matrix with a mask of the bytes that count; the masked bytes in row order are the text.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Mask = NDArray[np.bool_]

CHUNK: Final = 8192
"""Rows set at a time: the matrices of one chunk fit the processor's cache."""

LARGEST: Final = 2**53
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
    return b"".join(row_chunks(pieces, n))


def row_chunks(pieces: Sequence[Piece], n: int) -> Iterator[bytes]:
    """The text of `rows_text` in parts of `CHUNK` rows."""
    merged = _merged(pieces)
    for start in range(0, n, CHUNK):
        rows = slice(start, min(start + CHUNK, n))
        count = rows.stop - rows.start
        blocks = [_block(piece, rows, count) for piece in merged]
        matrix = np.concatenate([b for b, _ in blocks], axis=1)
        keep = np.concatenate([k for _, k in blocks], axis=1)
        yield matrix[keep].tobytes()


def _merged(pieces: Sequence[Piece]) -> list[Piece]:
    merged: list[Piece] = []
    for piece in pieces:
        if isinstance(piece, bytes) and merged and isinstance(merged[-1], bytes):
            merged[-1] += piece
        elif piece != b"" or not isinstance(piece, bytes):
            merged.append(piece)
    return merged


def _block(piece: Piece, rows: slice, n: int) -> tuple[Bytes, Mask]:
    match piece:
        case bytes():
            text = np.frombuffer(piece, dtype=np.uint8)
            return np.broadcast_to(text, (n, len(text))), np.ones((n, len(text)), dtype=bool)
        case Chosen():
            return _chosen(np.asarray(piece.index[rows]), piece.table)
        case Integer():
            values = np.asarray(piece.values[rows], dtype=np.int64)
            return _digits(np.abs(values), values < 0, places=0, plus=False, strip=False)
        case Decimal():
            return _decimal(piece, np.asarray(piece.values[rows], dtype=np.float64))


def _chosen(index: NDArray[np.integer], table: Sequence[bytes]) -> tuple[Bytes, Mask]:
    width = max((len(text) for text in table), default=0)
    texts = np.zeros((max(len(table), 1), width), dtype=np.uint8)
    lengths = np.array([len(text) for text in table] or [0])
    for row, text in enumerate(table):
        texts[row, : len(text)] = np.frombuffer(text, dtype=np.uint8)
    return texts[index], np.arange(width) < lengths[index][:, None]


def _decimal(piece: Decimal, values: NDArray[np.float64]) -> tuple[Bytes, Mask]:
    absent = np.isnan(values)
    if absent.any() and piece.missing is None:
        raise ValueError("not a number")
    scaled = np.rint(np.abs(np.where(absent, 0.0, values)) * 10.0**piece.places)
    if not (scaled < LARGEST).all():
        raise ValueError("a number has more digits than can be written")
    whole = scaled.astype(np.int64)
    negative = (values < 0) & (whole > 0)  # never "-0.00"
    matrix, keep = _digits(whole, negative, piece.places, plus=piece.plus, strip=piece.strip)
    if piece.missing is None or not absent.any():
        return matrix, keep
    other, kept = _chosen(absent.astype(np.int64), (b"", piece.missing))
    return np.concatenate([matrix, other], axis=1), np.concatenate(
        [keep & ~absent[:, None], kept], axis=1
    )


_FOUR: Final = np.frombuffer(b"".join(b"%04d" % i for i in range(10000)), np.uint8).reshape(-1, 4)
_ZERO, _POINT, _PLUS, _MINUS = b"0.+-"


def _digits(
    whole: NDArray[np.int64], negative: Mask, places: int, *, plus: bool, strip: bool
) -> tuple[Bytes, Mask]:
    """Sign, integer part, point and fraction of whole / 10**places, with the bytes that count."""
    n = len(whole)
    most = int(whole.max(initial=0))
    digits = max(len(str(most)), places + 1)
    groups = -(-digits // 4)
    number = np.empty((n, 4 * groups), dtype=np.uint8)
    rest = whole
    for group in reversed(range(groups)):
        rest, low = np.divmod(rest, 10000) if group else (rest, rest)
        number[:, 4 * group : 4 * group + 4] = _FOUR[low]
    number = number[:, 4 * groups - digits :]
    before = digits - places
    shown = np.ones(number.shape, dtype=bool)
    if before > 1:  # leading zeros, except the one before the point
        np.logical_or.accumulate(
            number[:, : before - 1] != _ZERO, axis=1, out=shown[:, : before - 1]
        )
    if strip and places:
        tail = np.logical_or.accumulate(number[:, : before - 1 : -1] != _ZERO, axis=1)
        shown[:, before:] = tail[:, ::-1]
    sign = np.where(negative, _MINUS, _PLUS).astype(np.uint8)[:, None]
    signed = (negative | plus)[:, None]
    if not places:
        return np.concatenate([sign, number], axis=1), np.concatenate([signed, shown], axis=1)
    point = np.full((n, 1), _POINT, dtype=np.uint8)
    return (
        np.concatenate([sign, number[:, :before], point, number[:, before:]], axis=1),
        np.concatenate(
            [signed, shown[:, :before], shown[:, before : before + 1], shown[:, before:]], axis=1
        ),
    )


_SEPARATORS: Final = bytes.maketrans(b"[](),;\r\n\t", b"         ")
_NUMERIC: Final = b"0123456789+-.eE "
_BLANK: Final = ord(" ")
_POWERS: Final = 10 ** np.arange(19, dtype=np.int64)
_PART: Final = 1 << 18
"""Bytes read at a time, for the same reason as `CHUNK`."""


def numbers(data: bytes) -> NDArray[np.float64]:
    """All numbers of a text in which brackets, commas, semicolons and blanks separate.

    Each is the double nearest to what is written, as `float` would give it.
    Raises ValueError if anything else stands there or a number is malformed.
    """
    spaced = data.translate(_SEPARATORS) + b" "
    if spaced.translate(None, _NUMERIC):
        raise ValueError("the text holds more than numbers")
    for _ in range(2):  # RAPID's unused axis; twice, since neighbours share a blank
        spaced = spaced.replace(b" 9E9 ", b" 9000000000 ").replace(b" 9E+09 ", b" 9000000000 ")
    parts, start = [], 0
    while start < len(spaced):
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
    so_far = np.cumsum(digit, dtype=np.int32)
    through = so_far[ends - 1]
    first = np.concatenate([[0], through[:-1]])
    count = through - first
    points = np.flatnonzero(text == _POINT)
    signs = np.flatnonzero((text == _MINUS) | (text == _PLUS))
    of_point = np.searchsorted(starts, points, side="right") - 1
    odd = len(points) + len(signs) + int(through[-1]) != int(np.count_nonzero(filled))
    if (
        odd
        or count.min() < 1
        or count.max() > 15
        or (np.diff(of_point) == 0).any()
        or before[signs].any()
    ):
        return None
    place = np.repeat(through, count) - 1 - np.arange(through[-1])
    whole = np.add.reduceat((text[digit] - _ZERO) * _POWERS[place], first)
    decimals = np.zeros(len(starts), dtype=np.int64)
    decimals[of_point] = through[of_point] - so_far[points]
    values = whole / _POWERS[decimals].astype(np.float64)
    return np.where(text[starts] == _MINUS, -values, values)


def _any_numbers(spaced: bytes) -> NDArray[np.float64]:
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(spaced, dtype=np.float64, sep=" ")
        except DeprecationWarning:
            raise ValueError("a number is malformed") from None


def inside(data: bytes, opening: bytes, closing: bytes) -> bytes:
    """The text with everything blanked but what stands between the marks of each row.

    opening, closing: must alternate; the marks themselves are kept.
    Raises ValueError if they do not.
    """
    text = np.frombuffer(data, dtype=np.uint8)
    starts, ends = (_offsets(text, mark) for mark in (opening, closing))
    alternate = (
        len(starts) == len(ends) and (starts < ends).all() and (ends[:-1] < starts[1:]).all()
    )
    if not alternate:
        raise ValueError("opening and closing marks do not alternate")
    edge = np.zeros(len(text) + 1, dtype=np.int8)
    edge[starts] = 1
    edge[ends + len(closing)] = -1
    within = np.cumsum(edge[:-1], dtype=np.int8).view(bool)
    return np.where(within, text, ord(" ")).astype(np.uint8).tobytes()


def _offsets(text: Bytes, mark: bytes) -> NDArray[np.intp]:
    """Offsets of a mark, of overlapping ones the first."""
    room = len(text) - len(mark) + 1
    if room <= 0:
        return np.empty(0, dtype=np.intp)
    found = text[:room] == mark[0]
    for i in range(1, len(mark)):
        found = found & (text[i : room + i] == mark[i])
    offsets = np.flatnonzero(found)
    if len(offsets) < 2:
        return offsets
    apart = np.concatenate([[True], np.diff(offsets) >= len(mark)])
    return np.asarray(offsets[apart])
