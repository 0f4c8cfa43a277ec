"""Numbers and words at known offsets of a text, eight bytes at a time.

Where a reader knows already at which offsets things stand, each is fetched as one or two
machine words and its digits are summed in parallel, all rows at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

Offsets = NDArray[np.intp]
Words = NDArray[np.uint64]

WORD: Final = 8
MOST_DIGITS: Final = 15
"""A whole number of so many digits is an exact double, and so is the power of ten below it."""
_DIGITS: Final = np.uint64(0x3030303030303030)
_OVER_NINE: Final = np.uint64(0x7676767676767676)
_HIGH: Final = np.uint64(0x8080808080808080)
_PAIRS: Final = np.uint64(0x000000FF000000FF)
_FIRST: Final = np.uint64(100 + (1_000_000 << 32))
_SECOND: Final = np.uint64(1 + (10_000 << 32))
_POWERS: Final = 10 ** np.arange(19, dtype=np.int64)
_ALL: Final = np.uint64(0xFFFFFFFFFFFFFFFF)


class Slots:
    """A text in which offsets count from `WORD` bytes of margin, so that words may overhang."""

    def __init__(self, data: bytes) -> None:
        margin = b" " * WORD
        padded = margin + data + margin
        self.bytes = np.frombuffer(padded, dtype=np.uint8)
        self._words: Words = np.ndarray((len(padded) - WORD + 1,), "<u8", padded, strides=(1,))

    def words(self, starts: Offsets, lengths: Offsets) -> Words:
        """The first eight bytes from each start, zero behind `lengths`."""
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
        """Whether the text stands at each start."""
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
            at = np.maximum(ends - 2 * WORD, 0)
            high, also = _eight(self._words[at], np.maximum(count - WORD, 0))
            value, good = value + high * _POWERS[WORD], good & also & (count <= 2 * WORD)
        return value, good

    def decimals(
        self, starts: Offsets, ends: Offsets, points: Offsets, known: Sequence[tuple[bytes, float]]
    ) -> NDArray[np.float64]:
        """The doubles nearest to what is written in each slot, as `float` would give them.

        points: of each slot its decimal point, or its end. known: spellings of one number
        that many slots hold. Raises ValueError for a slot that holds no number.
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
            places = np.minimum(places, MOST_DIGITS)
            values = (whole * _POWERS[places] + fraction) / _POWERS[places].astype(np.float64)
        else:
            values = whole.astype(np.float64)
        np.negative(values, out=values, where=negative)
        good &= (digits >= 1) & (digits <= MOST_DIGITS)
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
            different, index = np.unique(written, return_inverse=True)
            values[left] = np.array([float(text) for text in different])[index]
        return values


def _eight(words: Words, count: Offsets) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """The number that the last `count` bytes of each word spell, where they are all digits."""
    over = np.maximum(WORD - count, 0).astype(np.uint64) << np.uint64(3)
    value = ((words ^ _DIGITS) >> over) << over
    good = ((value + _OVER_NINE) | value) & _HIGH == 0
    value = value * np.uint64(10) + (value >> np.uint64(8))
    pairs = (value & _PAIRS) * _FIRST + ((value >> np.uint64(16)) & _PAIRS) * _SECOND
    return (pairs >> np.uint64(32)).view(np.int64), good
