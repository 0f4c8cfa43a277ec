"""Budgets of time and memory: what reaches them ends, also in threads, and nothing else does."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable

import pytest

from assistant.base.budgets import FACTOR_VARIABLE, STAGES, Stage, within
from assistant.base.diagnostics import Refused

SMALL = Stage("trying", "bytes", 0.1, 0.0, 60, 0)
ROOM = Stage("trying", "bytes", 1e6, 0.0, 60, 0)
LARGE = Stage("trying", "bytes", 1e6, 0.0, 1e6, 0)


def spin() -> None:
    while True:
        try:
            time.monotonic()
        except Exception:  # noqa: BLE001 - what tries again for ever ends as well
            continue


def grow() -> None:
    kept = []
    while True:
        kept.append(bytearray(10_000))


def at_once() -> None:
    bytearray(1 << 45)


def deep() -> None:
    deep()


def great() -> None:
    assert 10.0**400 > 0


def code_of(what: Callable[[], None], stage: Stage = SMALL) -> str:
    with pytest.raises(Refused) as refused, within(stage, "a.mod", 1234):
        what()
    (finding,) = refused.value.findings
    assert finding.path == "a.mod" and "trying" in finding.message and finding.cure
    return finding.code


@pytest.mark.parametrize(
    ("what", "stage", "code"),
    [
        (spin, SMALL, "LM001"),
        (grow, ROOM, "LM002"),
        (at_once, ROOM, "LM002"),
        (deep, LARGE, "LM003"),
        (great, LARGE, "LM004"),
    ],
)
def test_what_has_no_end_is_a_finding(what: Callable[[], None], stage: Stage, code: str) -> None:
    assert code_of(what, stage) == code


def test_the_budget_of_the_inner_or_the_outer_stage_is_reached() -> None:
    def inside() -> None:
        with within(SMALL, "inner.mod", 1):
            spin()

    with pytest.raises(Refused) as refused, within(LARGE, "outer.mod", 1):
        inside()
    assert refused.value.findings[0].path == "inner.mod"

    def outside() -> None:
        with within(LARGE, "inner.mod", 1):
            spin()

    with pytest.raises(Refused) as refused, within(SMALL, "outer.mod", 1):
        outside()
    assert refused.value.findings[0].path == "outer.mod"


def test_it_ends_in_the_thread_that_takes_too_much_and_in_no_other() -> None:
    codes: list[str] = []
    other = threading.Thread(target=lambda: codes.append(code_of(spin)))
    other.start()
    turns = 0
    with within(LARGE, "b.mod", 1):
        while other.is_alive():
            turns += 1
    assert codes == ["LM001"] and turns


@pytest.mark.skipif(not hasattr(time, "pthread_getcpuclockid"), reason="no clock of a thread")
def test_waiting_is_no_processor_time() -> None:
    """Another thread takes all of a like budget meanwhile."""
    codes: list[str] = []
    other = threading.Thread(target=lambda: codes.append(code_of(spin)))
    with within(SMALL, "a.mod", 1):
        other.start()
        other.join()
    assert codes == ["LM001"]


def test_the_factor_multiplies_time_and_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    for stage in STAGES:
        monkeypatch.delenv(FACTOR_VARIABLE, raising=False)
        before = stage.time_for(1000), stage.memory_for(1000)
        monkeypatch.setenv(FACTOR_VARIABLE, "3")
        assert (stage.time_for(1000), stage.memory_for(1000)) == pytest.approx(
            [3 * value for value in before]
        )


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="another limit, or none")
def test_afterwards_all_is_as_it_was() -> None:
    import resource

    before = resource.getrlimit(resource.RLIMIT_DATA)
    with within(SMALL, "a.mod", 1):
        assert resource.getrlimit(resource.RLIMIT_DATA) != before
    assert resource.getrlimit(resource.RLIMIT_DATA) == before


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no forks")
def test_a_fork_has_budgets_of_its_own() -> None:
    with within(LARGE, "a.mod", 1):
        child = os.fork()
        if child == 0:
            status = 1
            try:
                status = int(code_of(spin) != "LM001")
            finally:
                os._exit(status)
    assert os.waitpid(child, 0)[1] == 0


STRESS = """
import faulthandler, sys, threading, time
from contextlib import suppress
from assistant.base.diagnostics import Refused
from assistant.base import budgets
from assistant.base.budgets import Stage, within

faulthandler.dump_traceback_later(60, exit=True)  # what holds a lock for ever is told by name
sys.setswitchinterval(1e-5)
for name, value in {"_PERIOD": 0.0002, "_REPEAT_AFTER": 0.0003, "_MOST_TIMES": 1000}.items():
    assert hasattr(budgets, name)
    setattr(budgets, name, value)
outer, inner = Stage("outer", "-", 5e-4, 0, 512, 0), Stage("inner", "-", 2e-4, 0, 512, 0)
begin, refused = time.monotonic(), 0

least, enough = float(sys.argv[1]), int(sys.argv[2])

def going():  # at least so long, and on a busy computer until enough was refused
    gone = time.monotonic() - begin
    return gone < least or (refused <= enough and gone < 40.0)

def work():
    global refused
    while going():
        try:
            with within(outer, None, 0):
                until = time.monotonic() + 8e-4
                while time.monotonic() < until:
                    with suppress(Refused), within(inner, None, 0):
                        time.monotonic()
        except (Refused, budgets.Reached):
            refused += 1

def worker():
    while going():
        with suppress(budgets.Reached):
            work()

threads = [threading.Thread(target=worker) for _ in range(3)]
for one in threads:
    one.start()
for one in threads:
    one.join()
time.sleep(0.2)
print(refused > enough, len(budgets.watch.entered()))
"""


@pytest.mark.parametrize(
    ("seconds", "refused"), [("0.3", "15"), pytest.param("1.5", "100", marks=pytest.mark.slow)]
)
def test_what_is_told_while_entering_and_leaving_holds_nothing(seconds: str, refused: str) -> None:
    run = subprocess.run(
        [sys.executable, "-c", STRESS, seconds, refused],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (run.stdout.strip(), run.returncode) == ("True 0", 0), run.stderr


PROFILED = """
import sys
from tests.program.system.test_budgets import code_of, spin

assert code_of(spin) == "LM001"
calls = []
sys.setprofile(lambda *told: calls.append(told))
(lambda: None)()
sys.setprofile(None)
print(len(calls) > 0)
"""


def test_a_program_can_be_profiled_after_a_budget_was_reached() -> None:
    run = subprocess.run(
        [sys.executable, "-c", PROFILED], capture_output=True, text=True, timeout=60, check=False
    )
    assert (run.stdout.strip(), run.returncode) == ("True", 0), run.stderr
