"""Array types of columns, readers of arrays from users, and functions of short rows.

numpy goes along a row of few numbers several times slower than down as many columns.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from assistant.base.diagnostics import Refused, error

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Ints = NDArray[np.int64]
Rows = NDArray[np.intp]
"""Places in other columns."""
Truths = NDArray[np.bool_]

_SHAPE: Final = error(
    "TB441",
    "{what}: the shape is {shape}, not (n, {width})",
    "give a row of {width} numbers for each; transpose columns",
)
_NO_REALS: Final = error("TB442", "{what}: {reason}", "give real numbers")
_UNEVEN: Final = error(
    "TB443",
    "{count} {what} but {others} {other}",
    "give as many of the one as of the other",
)


def reals(values: ArrayLike) -> Floats:
    """Return a new float64 array of the given numbers; raises ValueError unless all are real.

    Complex numbers are refused, as numpy would drop a part of each, and so are truth values.
    """
    try:
        given = np.asarray(values)
        _check_real(given)
        return np.array(given, dtype=np.float64, order="C")
    except (TypeError, OverflowError) as error:
        raise ValueError(str(error)) from None


def rows_of(values: ArrayLike, width: int, what: str) -> Floats:
    """Rows (n, width) of an array (…, width), of a single row too; raises Refused for others.

    what: names the rows in the finding. Nothing is copied that need not be.
    """
    try:
        given = np.asarray(values)
        _check_real(given)
        array = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as reason:
        raise Refused(_NO_REALS(what=what, reason=str(reason))) from None
    if array.shape[-1:] == (width,):
        return array if array.ndim == 2 else array.reshape(-1, width)
    if array.shape == (0,):
        return array.reshape(0, width)
    raise Refused(_SHAPE(what=what, shape=array.shape, width=width))


def finite_rows(values: ArrayLike, width: int, what: str) -> Floats:
    """Same as `rows_of`, for numbers that are all finite."""
    found = rows_of(values, width, what)
    wrong = np.flatnonzero(~np.isfinite(found).all(axis=1))
    if len(wrong):
        reason = f"row {wrong[0] + 1} of (n, {width}) holds a number that is not finite"
        raise Refused(_NO_REALS(what=what, reason=reason))
    return found


def whole_rows(values: ArrayLike, width: int, what: str) -> Ints:
    """Same as `rows_of`, for whole numbers."""
    given = np.asarray(values)
    found = rows_of(given, width, what)
    if given.dtype.kind not in "iu" and not (found == np.rint(found)).all():
        raise Refused(_NO_REALS(what=what, reason="they are no whole numbers"))
    return np.asarray(found, dtype=np.int64)


def number_of(value: object, what: str) -> float:
    """Return a real number, NaN included; raises Refused for texts, booleans and the like."""
    if isinstance(value, float | int | np.floating | np.integer) and not isinstance(value, bool):
        found = float(value)
        if not np.isinf(found):
            return found
    raise Refused(_NO_REALS(what=what, reason=f"`{value!r:.40}` is no finite number"))


def require_same_length(one: Floats, other: Floats, what: str, others: str) -> None:
    """Raises Refused for columns of different lengths."""
    if len(one) != len(other):
        finding = _UNEVEN(what=what, other=others, count=len(one), others=len(other))
        raise Refused(finding)


def _check_real(given: NDArray[np.generic]) -> None:
    if given.dtype.kind == "c":
        raise ValueError("it holds complex numbers")
    if given.dtype.kind == "b":
        raise ValueError("it holds truth values")


def evenly_spaced(count: int, most: int) -> Rows:
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
