"""A kernel that lives on: commands of other threads, tasks that end, time that passes."""

from __future__ import annotations

import threading
import time

import pytest

from assistant import languages, robots
from assistant.virtual.kernel import Board, Ending, Kernel, Live
from assistant.virtual.kernel.timed_arm import Timed
from assistant.virtual.rapid.interpreter import start_task


@pytest.fixture
def ends():
    return []


def live(ends, **kernel):
    made = Live(
        lambda: Kernel(Board(), most_steps=10**12, **kernel),
        ended=lambda task, ending: ends.append((task.name, ending)),
    )
    made.start()
    return made


def start(controller, text, **how):
    tree = languages.get("rapid").parse(text)
    controller.do(lambda kernel: start_task(kernel, [tree], **how))


def wait_for(condition):
    until = time.monotonic() + 10.0
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.002)


def program(*lines):
    return "MODULE M\nPROC main()\n" + "\n".join(lines) + "\nENDPROC\nENDMODULE\n"


def test_it_lives_on_when_programs_end_well_or_badly(ends):
    controller = live(ends)
    start(controller, program("SetDO do_1, 1;"), name="GOOD")
    start(controller, program("VAR num n := 0;", "n := 1 / n;"), name="BAD")
    wait_for(lambda: len(ends) == 2)
    assert {name: ending.ended for name, ending in ends} == {"GOOD": "end", "BAD": "error"}
    assert controller.do(lambda kernel: kernel.board.outputs.read("do_1")) == 1.0
    start(controller, program("SetDO do_1, 0;"))
    wait_for(lambda: len(ends) == 3)
    assert controller.do(lambda kernel: kernel.board.outputs.read("do_1")) == 0.0
    controller.stop()


def test_a_waiting_program_sees_what_another_thread_sets(ends):
    controller = live(ends)
    start(controller, program("WaitDI di_1, 1;", "SetDO do_1, 1;"))
    assert controller.do(lambda kernel: kernel.board.outputs.read("do_1")) == 0.0
    controller.do(lambda kernel: kernel.board.inputs.set("di_1", 1.0))
    wait_for(lambda: ends)
    assert controller.do(lambda kernel: kernel.board.outputs.read("do_1")) == 1.0
    controller.stop()


def test_simulated_time_passes_as_real_time_does_also_under_many_commands(ends):
    controller = live(ends)
    began, clock = time.monotonic(), controller.do(lambda kernel: kernel.now)
    start(controller, program("WaitTime 0.2;"))
    asked = 0
    while not ends:
        controller.do(lambda kernel: None)
        asked += 1
    passed = controller.do(lambda kernel: kernel.now) - clock
    assert asked > 50
    assert 0.2 <= passed <= time.monotonic() - began + 0.01
    controller.stop()


def test_what_a_command_raises_is_the_callers(ends):
    controller = live(ends)
    with pytest.raises(KeyError):
        controller.do(lambda kernel: {}["nothing"])
    assert controller.do(lambda kernel: 3) == 3
    controller.stop()
    with pytest.raises(RuntimeError, match="off"):
        controller.do(lambda kernel: 3)


def test_a_motion_that_cannot_be_made_ends_its_program_alone(ends):
    robot = robots.get("irb1200-7-0.7")
    controller = live(ends, motion=Timed(robot))
    far = "[[9000,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    near = "[[10,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    start(controller, program(f"MoveL {far}, v100, fine, tool0;"), name="FAR", robot=robot)
    wait_for(lambda: ends)
    assert ends[0][0] == "FAR"
    assert ends[0][1].ended == "error"
    start(controller, program(f"MoveAbsJ {near}, v5000, fine, tool0;"), name="NEAR", robot=robot)
    wait_for(lambda: len(ends) == 2)
    assert ends[1] == ("NEAR", Ending())
    joints = controller.do(lambda kernel: kernel.motion.where())[1]
    assert joints[0] == pytest.approx(10.0)
    controller.stop()


def test_commands_of_many_threads_come_each_once(ends):
    controller, seen = live(ends), []
    threads = [
        threading.Thread(target=lambda n=n: controller.do(lambda kernel: seen.append(n)))
        for n in range(20)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(seen) == list(range(20))
    controller.stop()


def test_what_nobody_foresaw_in_a_program_leaves_the_others_alive(ends):
    controller = live(ends)

    def body(task):
        task.step()
        raise ZeroDivisionError("nobody thought of it")

    controller.do(lambda kernel: kernel.task("ODD", body))
    wait_for(lambda: ends)
    assert ends[0][1].ended == "unknown" and "nobody thought of it" in ends[0][1].message
    start(controller, program("SetDO do_1, 1;"))
    wait_for(lambda: len(ends) == 2)
    assert ends[1][1] == Ending()
    controller.stop()
