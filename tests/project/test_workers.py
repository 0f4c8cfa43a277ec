"""Processes that answer at once, and one that dies."""

import os
import subprocess
import sys
import threading
import time

import pytest

from assistant.project import build_jobs
from assistant.project.build_jobs import at_once

slow = pytest.mark.slow  # each process is a new Python


@slow
def test_each_argument_gets_its_answer_in_another_process():
    answers = at_once(os.path.basename, ["a/1", "a/2", "a/3"], 2, str)
    assert answers == ["1", "2", "3"]
    ids = at_once(_process, [1, 2], 1, str)
    assert ids[0] == ids[1] != os.getpid()


@slow
def test_no_process_is_given_a_password(monkeypatch):
    for name in ("ROBOT_ASSISTANT_PASSWORD", "ROBOT_ASSISTANT_CELL1_PASSWORD"):
        monkeypatch.setenv(name, "secret")
    asked = ["ROBOT_ASSISTANT_PASSWORD", "ROBOT_ASSISTANT_CELL1_PASSWORD", "PATH"]
    assert at_once(os.getenv, asked, 1, str) == [None, None, os.environ["PATH"]]


@slow
def test_only_what_a_dead_process_was_at_is_lost():
    assert at_once(_or_die, [1, 0, 3], 1, lambda argument: -1) == [1, -1, 3]


def test_a_process_that_does_not_end_loses_no_answer(monkeypatch):
    monkeypatch.setattr(build_jobs, "ENDED", 0.2)
    assert at_once(_lingering, [1, 2, 3], 2, lambda argument: -1) == [1, 2, 3]


@slow
def test_a_process_that_cannot_be_started_loses_only_what_it_was_to_answer(monkeypatch):
    tries = iter((OSError("no memory"), None, None))
    begin = build_jobs._Worker._begin

    def sometimes(worker):
        if wrong := next(tries):
            raise wrong
        return begin(worker)

    monkeypatch.setattr(build_jobs._Worker, "_begin", sometimes)
    assert at_once(_or_die, [1, 2, 3], 1, lambda argument: -1) == [-1, 2, 3]


@slow
def test_a_script_without_a_guard_builds(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "from assistant.project.build_jobs import at_once\n"
        "import os\nprint(at_once(os.path.basename, ['a/1', 'a/2'], 2, str))\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.stderr) == ("['1', '2']\n", "")


def _process(_: int) -> int:
    return os.getpid()


def _lingering(argument: int) -> int:
    """Answers, but the process goes on for a minute after its last question."""
    threading.Thread(target=time.sleep, args=(60.0,)).start()
    return argument


def _or_die(argument: int) -> int:
    if not argument:
        os._exit(9)
    return argument
