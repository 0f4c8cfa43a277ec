"""Array types of columns, readers of arrays from users, and functions of short rows.

numpy goes along a row of few numbers several times slower than down as many columns.
"""

from __future__ import annotations

import sys
from collections.abc import Sized
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
_OUT_OF_BOUNDS: Final = error("TB448", "{what} is {value:g}", "give a number {bounds}")
_UNEVEN: Final = error(
    "TB443",
    "{count} {what} but {others} {other}",
    "give as many of the one as of the other",
)


def reals(values: ArrayLike) -> Floats:
    """Return a new float64 array of the given numbers; raises ValueError unless all are real.

    Complex numbers are refused, as numpy would drop a part of each, and so are truth values.
    """
    return np.array(_reals(values), order="C")


def rows_of(values: ArrayLike, width: int, what: str) -> Floats:
    """Rows (n, width) of an array (…, width), of a single row too; raises Refused for others.

    what: names the rows in the finding. Nothing is copied that need not be.
    """
    array = _reals_of(values, what)
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
    found = rows_of(values, width, what)
    if not ((found == np.rint(found)) & (np.abs(found) < _WHOLE)).all():
        raise Refused(_NO_REALS(what=what, reason="they are no whole numbers"))
    return np.asarray(found, dtype=np.int64)


def number_of(value: object, what: str) -> float:
    """Return a real number, NaN included; raises Refused for texts, booleans and the like."""
    if isinstance(value, float | int | np.floating | np.integer) and not isinstance(value, bool):
        try:
            found = float(value)
        except OverflowError:  # a whole number of hundreds of digits
            found = np.inf
        if not np.isinf(found):
            return found
    raise Refused(_NO_REALS(what=what, reason=f"`{value!r:.40}` is no finite number"))


def row_of(values: ArrayLike, what: str) -> Floats:
    """A row (k,) of real numbers, NaN included, also of a single one; raises Refused for others."""
    found = np.atleast_1d(_reals_of(values, what))
    if found.ndim != 1 or not found.size:
        raise Refused(_NO_REALS(what=what, reason=f"the shape is {found.shape}, not (k,)"))
    return found


def finite_row(values: ArrayLike, what: str) -> Floats:
    """Same as `row_of`, for numbers that are all finite."""
    found = row_of(values, what)
    if not np.isfinite(found).all():
        raise Refused(_NO_REALS(what=what, reason="it holds a number that is not finite"))
    return found


def finite_columns(values: ArrayLike, what: str, width: int | None = None) -> Floats:
    """Return rows (n, k) of finite numbers, also for a column (n,); raise Refused for others.

    width: k that is required, None for any.
    """
    found = _reals_of(values, what)
    if found.ndim == 1 and width in (None, 1):
        found = found[:, None]
    if found.ndim != 2 or not found.size or width not in (None, found.shape[1]):
        raise Refused(_SHAPE(what=what, shape=found.shape, width=width or "k"))
    return finite_rows(found, found.shape[1], what)


def number_within(
    value: object,
    what: str,
    *,
    above: float = -np.inf,
    least: float = -np.inf,
    most: float = np.inf,
) -> float:
    """Return a finite number within bounds; raise Refused for another one.

    above: bound that the number exceeds. least, most: bounds that it may reach.
    """
    found = number_of(value, what)
    if not (found > above and least <= found <= most):
        bounds = f"above {above:g}" if above > -np.inf else f"from {least:g}"
        if most < np.inf:
            bounds += f" to {most:g}"
        raise Refused(_OUT_OF_BOUNDS(what=what, value=found, bounds=bounds))
    return found


def require_same_length(one: Sized, other: Sized, what: str, others: str) -> None:
    """Raises Refused for columns of different lengths."""
    if len(one) != len(other):
        finding = _UNEVEN(what=what, other=others, count=len(one), others=len(other))
        raise Refused(finding)


_OTHER_KINDS: Final = {
    "c": "complex numbers",
    "b": "truth values",
    "U": "text",
    "S": "text",
    "M": "times",
    "m": "times",
}
"""Contents of arrays, by the kind of numpy, that are not real numbers although numpy converts them.
"""
_WHOLE: Final = 2.0**53
"""From here on float64 does not hold every whole number."""


def _reals(values: ArrayLike) -> Floats:
    """Return values as float64, not copied if possible; raise ValueError unless all are real."""
    # Values can be masked only where the module for it is loaded, which takes a while.
    masking = sys.modules.get("numpy.ma")
    try:
        if masking is not None and masking.is_masked(values):
            raise ValueError("it holds masked values")
        given = np.asarray(values)
        if given.dtype.kind in _OTHER_KINDS:
            raise ValueError(f"it holds {_OTHER_KINDS[given.dtype.kind]}")
        return np.asarray(given, dtype=np.float64)
    except IndexError:  # an object with a length of 0 that is indexed, such as an empty SE3
        raise ValueError("it is empty") from None
    except (TypeError, OverflowError) as error:
        raise ValueError(str(error)) from None


def _reals_of(values: ArrayLike, what: str) -> Floats:
    """Same as `_reals`; raises Refused."""
    try:
        return _reals(values)
    except ValueError as reason:
        raise Refused(_NO_REALS(what=what, reason=str(reason))) from None


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
