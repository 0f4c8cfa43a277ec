"""Types of columns of numbers, and functions of each of their short rows.

numpy goes along a row of few numbers several times slower than down as many columns.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Ints = NDArray[np.int64]
Rows = NDArray[np.intp]
"""Places in other columns."""
Truths = NDArray[np.bool_]


def reals(values: ArrayLike) -> Floats:
    """An array of numbers as someone gave them, of his own; raises ValueError if they are none.

    Complex numbers are none: numpy would leave out a part of each.
    """
    try:
        given = np.asarray(values)
        if np.iscomplexobj(given):
            raise ValueError("it holds complex numbers")
        return np.array(given, dtype=np.float64, order="C")
    except (TypeError, OverflowError) as error:
        raise ValueError(str(error)) from None


def evenly(count: int, most: int) -> Rows:
    """At most so many of `count` places, as far from each other as can be, both ends among them.

    most: at least 2, or only the first one is taken.
    """
    some = min(count, most)
    return np.arange(some, dtype=np.intp) * (count - 1) // max(some - 1, 1)


def norms(vectors: Floats) -> Floats:
    """Lengths (...) of vectors (..., c)."""
    squares = np.square(vectors)
    total = squares[..., 0].copy()
    for column in range(1, squares.shape[-1]):
        total += squares[..., column]
    return np.asarray(np.sqrt(total))


def max_abs(values: Floats) -> Floats:
    """(n,) the largest absolute value of each row (n, c); c is at least 1."""
    return np.asarray(np.abs(values.T, order="C").max(axis=0))


def all_of(truths: Truths) -> Truths:
    """(n,) whether all of a row (n, c) are true."""
    return np.asarray(np.ascontiguousarray(truths.T).all(axis=0))


def any_of(truths: Truths) -> Truths:
    """(n,) whether any of a row (n, c) is true."""
    return np.asarray(np.ascontiguousarray(truths.T).any(axis=0))
