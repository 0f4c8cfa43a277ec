"""Tasks that wait for what is outside of a run: real time passes meanwhile."""

from __future__ import annotations

import socket
import threading
import time

from assistant.virtual.kernel import Ending, Kernel, Task


def test_what_comes_from_outside_ends_a_wait() -> None:
    kernel = Kernel()
    server = socket.create_server(("127.0.0.1", 0))
    server.setblocking(False)
    come: list[bool] = []

    def has_come() -> bool:
        try:
            server.accept()[0].close()
        except BlockingIOError:
            return False
        return True

    def waits(task: Task) -> Ending:
        come.append(task.wait(has_come, 30.0, "a caller", outside=True))
        return Ending()

    def calls() -> None:
        socket.create_connection(server.getsockname()).close()

    kernel.task("server", waits)
    with server:
        caller = threading.Timer(0.02, calls)
        caller.start()
        run = kernel.run()
        caller.join()
    assert come == [True] and run.ended == "end"


def test_simulated_time_is_not_ahead_of_real_time_while_a_task_waits_outside() -> None:
    """Another task's long delay does not end the wait at once."""
    kernel = Kernel(statement_time=0.001)
    seen: list[tuple[float, float]] = []
    began = time.monotonic()

    def waits(task: Task) -> Ending:
        task.wait(lambda: False, 0.04, "nobody", outside=True)
        return Ending()

    def goes_on(task: Task) -> Ending:
        while task.kernel.now < 0.03:
            task.step()
            seen.append((task.kernel.now, time.monotonic() - began))
        task.delay(3600.0)
        return Ending()

    kernel.task("outside", waits)
    kernel.task("beside", goes_on)
    run = kernel.run()
    assert len(seen) == 30
    assert all(now - 0.0011 <= real for now, real in seen)
    assert run.ended == "end" and kernel.now >= 3600.0


def test_a_wait_for_the_outside_ends_with_its_time() -> None:
    kernel = Kernel(most_time=0.02)
    kernel.task("alone", lambda task: Ending(message=str(task.wait(bool, None, outside=True))))
    assert kernel.run().ended == "time"


def test_statements_that_take_time_keep_the_pace_of_a_run() -> None:
    kernel = Kernel(statement_time=0.001, pace=1.0)
    seen: list[tuple[float, float]] = []
    began = time.monotonic()

    def runs(task: Task) -> Ending:
        for _ in range(30):
            task.step()
            seen.append((kernel.clock - 0.001, time.monotonic() - began))
        return Ending()

    kernel.task("alone", runs)
    assert kernel.run().ended == "end"
    assert len(seen) == 30
    assert all(simulated <= real for simulated, real in seen)
