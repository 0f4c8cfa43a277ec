"""Every case of the benchmarks still runs; how fast is theirs to say, not ours."""

from __future__ import annotations

import json

import pytest

from benchmarks.__main__ import EVERY
from tests.forks import Forks

POINTS = 200


@pytest.mark.one_in(4)
@pytest.mark.parametrize("case", sorted(EVERY))
def test_a_case_runs_and_says_how_long_it_took(case: str, forks: Forks) -> None:
    if "polars" in case:
        pytest.importorskip("polars", reason="polars comes with the extra `bench`")
    answer = forks.python("-m", "benchmarks", "--case", case, "--points", str(POINTS))
    assert answer.returncode == 0, answer.stderr[-2000:]
    measured = json.loads(answer.stdout)
    assert measured["seconds"] > 0.0
    assert measured["peak"] > 0.0
