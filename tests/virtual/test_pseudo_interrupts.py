"""Interrupts of pseudo-programs that run."""

from __future__ import annotations

from assistant import robots
from assistant.program import pseudo
from assistant.virtual.events import Run, Said
from assistant.virtual.kernel import Kernel
from assistant.virtual.kernel.timed_arm import Timed
from assistant.virtual.pseudo import start_program

HEAD = """program p for irb1200-7-0.7
signal door digital input 1
target a [400, 0, 400] [0, 0, 1, 0]
target b [400, 200, 400] [0, 0, 1, 0]
variable n number = 0

procedure answer
n = n + 1
message "answer ", n
{answer}
end

procedure main
interrupt opened when door = 1 calls answer
interrupt late when elapsed(clock) > 3 calls in_time
restart timer since
{main}
end

procedure in_time
interrupt late off
message "late"
end
"""


def ran(main: str, answer: str = "interrupt opened off") -> Run:
    """The door is open from 1 s to 2 s."""
    robot = robots.get("irb1200-7-0.7")
    program = pseudo.parse(HEAD.format(main=main, answer=answer))
    kernel = Kernel(most_steps=5000, motion=Timed(robot))
    for time, value in ((1.0, 1.0), (2.0, 0.0)):
        kernel.at(time, lambda value=value: kernel.board.inputs.set("door", value))
    start_program(kernel, program, robot=robot)
    return kernel.run()


def said(run: Run) -> list[str]:
    assert run.ended == "end", run.message
    return [event.text for event in run.events if isinstance(event, Said)]


def test_it_comes_in_a_wait_which_goes_on() -> None:
    run = ran("interrupt opened on\nwait 5 s\nmessage elapsed(since)")
    assert said(run) == ["answer 1", "5"]


def test_it_does_not_come_while_it_or_all_are_off() -> None:
    assert said(ran('wait 5 s\nmessage "none"')) == ["none"]
    lines = (
        'interrupt opened on\ninterrupts off\nwait 1.5 s\nmessage "shut"\ninterrupts on\nwait 1 s'
    )
    assert said(ran(lines)) == ["shut", "answer 1"]
    lost = "interrupt opened on\ninterrupts off\nwait 3 s\ninterrupts on\nwait 1 s"
    assert said(ran(lost)) == []


def test_it_comes_again_while_its_condition_holds() -> None:
    assert said(ran("interrupt opened on\nwait 3 s", "wait 0.4 s")) == (
        ["answer 1", "answer 2", "answer 3"]
    )


def test_it_ends_the_cycle_where_it_says_so() -> None:
    defined = "interrupt opened when door = 1 calls answer ends where n > 1\n"
    run = ran(f'{defined}interrupt opened on\nwait 3 s\nmessage "on"', "wait 0.4 s")
    assert said(run) == ["answer 1", "answer 2"]


def test_none_comes_while_one_is_answered() -> None:
    lines = "restart timer clock\ninterrupt opened on\ninterrupt late on\nwait 5 s"
    assert said(ran(lines, 'wait 4 s\nmessage "done"')) == ["answer 1", "done", "late"]


def test_the_arm_stands_meanwhile() -> None:
    moves = (
        "move joint a speed 1000 mm/s blend fine\ninterrupt opened on\nrestart timer way\n"
        "move linear b speed 50 mm/s blend fine\nmessage elapsed(way) > {seconds}"
    )
    assert said(ran(moves.format(seconds=7), "interrupt opened off\nwait 3 s"))[-1] == "true"
    assert said(ran(moves.format(seconds=7)))[-1] == "false"
