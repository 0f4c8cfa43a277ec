"""A kernel whose time passes only as far as it is let."""

from __future__ import annotations

import threading

import pytest

from assistant import languages
from assistant.virtual.kernel import Board, Kernel
from assistant.virtual.kernel.kernel_thread import Stepped
from assistant.virtual.rapid.interpreter import start_task

BLINK = """\
MODULE M
PROC main()
SetDO do_1, 1;
WaitTime 0.25;
SetDO do_1, 0;
WaitDI di_1, 1;
SetDO do_2, 1;
ENDPROC
ENDMODULE
"""


@pytest.fixture
def ends():
    return []


@pytest.fixture
def live(ends):
    made = Stepped(
        lambda: Kernel(Board(), most_steps=10**12),
        ended=lambda task, ending: ends.append((made.kernel.now, ending.ended)),
    )
    made.start()
    yield made
    made.stop()


def start(live, text=BLINK):
    tree = languages.get("rapid").parse(text)
    live.do(lambda kernel: start_task(kernel, [tree]))


def outputs(live):
    return live.do(lambda kernel: [kernel.board.outputs.read(f"do_{i}") for i in (1, 2)])


def test_it_stands_until_it_is_let_and_no_longer_than_that(live, ends):
    start(live)  # what is asked for may come before the first turn of the task
    assert any(outputs(live) == [1.0, 0.0] for _ in range(100))
    assert live.do(lambda kernel: kernel.now) == 0.0
    live.advance(0.2)
    assert outputs(live) == [1.0, 0.0] and live.do(lambda kernel: kernel.now) == 0.2
    live.advance(0.25)
    assert outputs(live) == [0.0, 0.0]
    live.advance(0.1)  # is over
    assert live.now() == 0.25
    live.advance(1000.0)
    live.do(lambda kernel: kernel.board.inputs.set("di_1", 1.0))
    assert outputs(live) == [0.0, 1.0]
    live.advance(1000.5)
    assert ends == [(1000.0, "end")]


def test_what_is_asked_for_happens_at_the_moment_at_which_it_stands(live):
    moments = []
    for step in range(1, 200):
        live.advance(step / 64.0)
        moments.append(live.do(lambda kernel: kernel.now))
    assert moments == [step / 64.0 for step in range(1, 200)]


def test_others_may_ask_while_it_advances(live):
    """Each command is carried out, whatever the threads do; time never goes back."""
    seen: list[list[float]] = [[], []]
    over = threading.Event()

    def ask(mine):
        while not over.is_set():
            mine.append(live.do(lambda kernel: kernel.now))

    threads = [threading.Thread(target=ask, args=(mine,)) for mine in seen]
    for thread in threads:
        thread.start()
    for step in range(300):
        live.advance(step / 64.0)
    over.set()
    for thread in threads:
        thread.join()
    assert all(mine == sorted(mine) and mine for mine in seen)


def test_time_can_be_freed_and_taken_back(live):
    start(live)
    live.free()
    while outputs(live) != [0.0, 0.0]:
        pass
    assert live.do(lambda kernel: kernel.now) >= 0.25
    live.advance(8.0)
    assert [live.do(lambda kernel: kernel.now) for _ in range(3)] == [8.0] * 3


def test_a_loop_without_end_that_takes_no_time_is_told(live):
    start(live, "MODULE M\nPROC main()\nWHILE TRUE DO\nENDWHILE\nENDPROC\nENDMODULE\n")
    with pytest.raises(TimeoutError):
        live.advance(1.0, timeout=0.2)


def test_it_ends_wherever_it_stands():
    made = Stepped(lambda: Kernel(Board(), most_steps=10**12))
    made.start()
    start(made)
    made.stop()
    with pytest.raises(RuntimeError):
        made.do(lambda kernel: None)
    made.advance(1.0)  # nothing is left to wait for
