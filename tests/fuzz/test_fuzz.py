"""The short form of `make fuzz`: what once failed, and the same changes of it at each run."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from random import Random

import pytest

from tests.fuzz.minimising import failure, minimised
from tests.fuzz.mutating import changed, stock
from tests.fuzz.state import state_of
from tests.fuzz.table import TARGETS
from tests.fuzz.target import ROOT, Broken, Target, promise

every_target = pytest.mark.parametrize("target", TARGETS.values(), ids=list(TARGETS))


@pytest.fixture(autouse=True)
def raising(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROBOT_ASSISTANT_TRACEBACK", "1")


@pytest.mark.parametrize(
    ("target", "case"),
    [(target, case) for target in TARGETS.values() for case in target.cases()],
    ids=lambda one: one.name,
)
def test_what_once_failed(target: Target, case: Path) -> None:
    target.run(case.read_bytes())


@pytest.mark.one_in(4)
@every_target
def test_changes_of_what_is_sound(target: Target) -> None:
    seeds = list(target.seeds())
    assert seeds
    parts, chance = stock(target, seeds), Random(1)
    for _ in range(target.tried):
        target.run(changed(chance.choice(seeds), parts, chance))


@pytest.mark.slow
def test_the_command_counts_on_and_tells_what_failed(tmp_path: Path) -> None:
    for _ in range(2):
        command = [sys.executable, "-m", "tests.fuzz", "kept", "--inputs=20", "--engine=changes"]
        done = subprocess.run(
            [*command, f"--place={tmp_path}"], cwd=ROOT, capture_output=True, text=True, check=True
        )
    assert "40 inputs so far, 0 failures" in done.stdout
    assert state_of(TARGETS["kept"], tmp_path).counts().inputs == 40


def fails_on_b(data: bytes) -> None:
    promise(b"b" not in data, "there is a b")


def test_a_failure_is_written_and_made_small(tmp_path: Path) -> None:
    target = Target("b", fails_on_b, lambda: [b"a"])
    state = state_of(target, tmp_path)
    data = b"a line\nthe other b line\nand one\n"
    assert failure(target, data) == "there is a b"
    with pytest.raises(Broken) as raised:
        target.run(data)
    path = state.fail(target, data, raised.value)
    assert path is not None
    assert path.read_bytes() == data
    assert f"--again {path}" in path.with_suffix(".txt").read_text()
    assert state.fail(target, data, raised.value) is None
    assert minimised(target, data) == b"b"
