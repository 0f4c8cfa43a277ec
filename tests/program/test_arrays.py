"""Functions of short rows against what numpy says of them."""

from __future__ import annotations

import numpy as np
import pytest

from assistant.base.arrays import Floats, all_of, any_of, max_abs, norms


@pytest.fixture(params=[(0, 3), (1, 4), (200, 6)], ids=str)
def rows(request: pytest.FixtureRequest) -> Floats:
    found = np.random.default_rng(3).normal(size=request.param)
    found[5::7, 1] = np.nan
    found[6::7, 2] = -np.inf
    return found


def test_norms(rows: Floats) -> None:
    np.testing.assert_allclose(norms(rows), np.linalg.norm(rows, axis=-1), rtol=1e-15)
    deep = np.stack([rows, 2.0 * rows])
    np.testing.assert_allclose(norms(deep), np.linalg.norm(deep, axis=-1), rtol=1e-15)


def test_the_largest_size(rows: Floats) -> None:
    assert np.array_equal(max_abs(rows), np.abs(rows).max(axis=1), equal_nan=True)


def test_truths(rows: Floats) -> None:
    good = rows > -0.5
    assert np.array_equal(all_of(good), good.all(axis=1))
    assert np.array_equal(any_of(good), good.any(axis=1))
