"""Processes that answer at once, and one that dies."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from assistant.base import worker_processes
from assistant.base.worker_processes import Processes, Worker, WorkerDied

slow = pytest.mark.slow  # each process is a new Python


@slow
def test_each_argument_gets_its_answer_in_another_process():
    answers = Processes(2).answers(os.path.basename, ["a/1", "a/2", "a/3"], _lost)
    assert answers == ["1", "2", "3"]
    ids = Processes(1).answers(_process, [1, 2], _lost)
    assert ids[0] == ids[1] != os.getpid()


@slow
def test_no_process_is_given_a_password(monkeypatch):
    for name in ("ROBOT_ASSISTANT_PASSWORD", "ROBOT_ASSISTANT_CELL1_PASSWORD"):
        monkeypatch.setenv(name, "secret")
    asked = ["ROBOT_ASSISTANT_PASSWORD", "ROBOT_ASSISTANT_CELL1_PASSWORD", "PATH"]
    assert Processes(1).answers(os.getenv, asked, _lost) == [None, None, os.environ["PATH"]]


@slow
def test_only_what_a_dead_process_was_at_is_lost():
    answers = Processes(1).answers(_or_die, [1, 0, 3], lambda argument, died: str(died))
    assert answers == [1, "exit status 9", 3]


@slow
def test_an_error_of_the_system_is_raised_where_the_answers_are_wanted(tmp_path):
    with pytest.raises(FileNotFoundError, match="gone"):
        Processes(2).answers(os.listdir, [str(tmp_path), str(tmp_path / "gone")], _lost)


@slow
def test_an_argument_at_which_a_process_dies_once_is_tried_again(tmp_path):
    marks = [tmp_path / name for name in "abc"]
    assert Processes(2).answers(_die_first, marks, lambda argument, died: str(died)) == [
        "a",
        "b",
        "c",
    ]


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_it_is_said_how_a_process_died():
    worker = Worker()
    try:
        with pytest.raises(WorkerDied, match=r"^signal SIGKILL$"):
            worker.answer(_killed, 0)
        with pytest.raises(WorkerDied, match=r"^exit status 9$"):
            worker.answer(_or_die, 0)
    finally:
        worker.close()


def test_a_process_that_does_not_end_loses_no_answer_and_is_not_waited_for():
    begun = time.monotonic()
    assert Processes(2).answers(_lingering, [1, 2, 3], lambda argument, died: -1) == [1, 2, 3]
    assert time.monotonic() - begun < 40.0


@slow
@pytest.mark.parametrize(
    ("failures", "arguments", "answers"), [(1, [1, 2, 3], [1, 2, 3]), (2, [1], ["no memory"])]
)
def test_what_a_process_that_cannot_be_started_was_to_answer_is_asked_again(
    monkeypatch, failures, arguments, answers
):
    tries = iter([OSError("no memory")] * failures + [None] * 2)
    start = subprocess.Popen

    def sometimes(*words, **how):
        if wrong := next(tries):
            raise wrong
        return start(*words, **how)

    monkeypatch.setattr(worker_processes.subprocess, "Popen", sometimes)
    assert Processes(1).answers(_or_die, arguments, lambda argument, died: str(died)) == answers


def test_a_worker_that_is_closed_while_its_process_starts_leaves_none(monkeypatch):
    worker, begun, start = Worker(), [], subprocess.Popen

    def closing(*words, **how):
        worker.close()
        begun.append(start(*words, **how))
        return begun[0]

    monkeypatch.setattr(worker_processes.subprocess, "Popen", closing)
    for _ in range(2):
        with pytest.raises(WorkerDied):
            worker.answer(_process, 1)
    assert begun[0].returncode is not None
    assert len(begun) == 1


def test_what_a_function_prints_is_no_answer(capfd):
    assert Processes(1).answers(_loud, [1], _lost) == [1]
    assert capfd.readouterr() == ("", "loud\n")


@slow
@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_no_process_outlives_the_one_that_asked(tmp_path, number):
    script = tmp_path / "script.py"
    script.write_text(
        "from assistant.base.worker_processes import Processes\n"
        "from tests.program.system.test_worker_processes import _noted\n"
        f"Processes(2).answers(_noted, [{str(tmp_path)!r}] * 4, print)\n"
    )
    with subprocess.Popen([sys.executable, script], stderr=subprocess.DEVNULL) as asking:
        _until(lambda: len(list(tmp_path.glob("*.pid"))) == 2)
        asking.send_signal(number)
        assert asking.wait(30) == -number
    ids = [int(file.stem) for file in tmp_path.glob("*.pid")]
    assert len(ids) == 2  # no other argument was begun
    if number == signal.SIGKILL:
        (tmp_path / "go").touch()  # the end of a request is where a worker sees that none asks
    _until(lambda: not any(map(_runs, ids)))


@slow
def test_a_script_without_a_guard_builds(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "from assistant.base.worker_processes import Processes\n"
        "import os\nprint(Processes(2).answers(os.path.basename, ['a/1', 'a/2'], print))\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.stderr) == ("['1', '2']\n", "")


def _die_first(mark: Path) -> str:
    """Ends the process at the first call with a file that is not there yet."""
    if not mark.exists():
        mark.touch()
        os._exit(9)
    return mark.name


def _lost(argument: object, died: WorkerDied) -> object:
    raise AssertionError((argument, str(died)))


def _killed(_: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


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


def _loud(argument: int) -> int:
    os.write(1, b"loud\n")
    return argument


def _noted(folder: str) -> None:
    """Leaves the number of its process, and waits for a file."""
    path = Path(folder)
    (path / f"{os.getpid()}.pid").touch()
    _until((path / "go").exists)


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    stat = Path(f"/proc/{process}/stat")
    return not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] != "Z"


def _until(done: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 60.0
    while not done():
        assert time.monotonic() < deadline
        time.sleep(0.02)
