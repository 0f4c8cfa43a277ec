"""What statements do: each has an answer, and who times a program makes something of each."""

from __future__ import annotations

from functools import cache
from typing import get_args

from assistant import robots
from assistant.program import statements as p
from assistant.program.program import walk
from assistant.program.pseudo import parse
from assistant.robots.timing import simulate
from tests.tables import every_row

LINES: dict[type, str] = {
    p.Move: "move linear target [350, 0, 400] [0, 0, 1, 0] speed 100 mm/s blend fine",
    p.MoveCircular: "move circular via target [390, 60, 400] [0, 0, 1, 0] to "
    "target [400, 0, 400] [0, 0, 1, 0] speed 100 mm/s blend fine",
    p.MoveJoints: "move absolute there speed 100 mm/s blend fine",
    p.Travel: "travel to start speed 100 mm/s blend fine",
    p.Follow: "follow seam\n linear [400, 0, 400] [0, 0, 1, 0] speed 100 mm/s blend fine\n"
    " linear [380, 0, 400]\nend",
    p.Wait: "wait 2 s",
    p.WaitSignal: "wait for ready = true",
    p.WaitUntil: "wait until n > 3",
    p.StartTimer: "restart timer watch",
    p.SetSignal: "set go = true",
    p.Gripper: "open hand 1",
    p.SetAcceleration: "acceleration 50 % deceleration 50 %",
    p.SetOverride: "override 50 %",
    p.Call: "call pause",
    p.Assign: "n = 4",
    p.If: "if n < 3\n wait 2 s\nend",
    p.While: "while n < 3\n n = n + 1\n wait 2 s\nend",
    p.For: "for i from 1 to 3\n wait 2 s\nend",
    p.Switch: "switch n\ncase 1\n wait 2 s\nend",
    p.Stop: "stop",
    p.Return: "return",
    p.Comment: "# a comment",
    p.Label: "label here",
    p.Goto: "goto end_of_all",
    p.Message: 'message "a text"',
    p.Attach: 'attach log to file "LOG.TXT" for append',
    p.Detach: "detach log",
    p.Send: 'send log line "a text", n',
    p.Interrupt: "interrupt door when ready calls pause",
    p.SwitchInterrupt: "interrupt door on",
    p.SwitchInterrupts: "interrupts off",
    p.Opaque: "opaque rapid | SearchL di1,p,q,v10,tool0;",
}
"""A line of each statement, which goes on from the target `start`."""
PROGRAM = """program p
signal go digital output 1
signal ready digital input 1
target start [400, 0, 400] [0, 0, 1, 0]
joints there [10, 10, 10, 0, 30, 0]
variable n number = 0
procedure main
move joint start speed 100 mm/s blend fine
{line}
label end_of_all
move linear target [400, 0, 300] [0, 0, 1, 0] speed 100 mm/s blend fine
end
procedure pause
wait 2 s
end
"""
AT_ONCE = ("sets", "marks", "says")
"""Traits that take no time."""


@cache
def told(line: str) -> tuple[float, int]:
    """Seconds of a program with a line, and how many things nothing tells the time of."""
    program = parse(PROGRAM.format(line=line))
    done = simulate(robots.solve_program(program, robots.get("irb1200-7-0.7")))
    return done.duration.most, len(done.unknown)


def test_every_statement_has_a_trait_and_a_line() -> None:
    assert set(p.TRAITS) == set(get_args(p.Statement)) == set(LINES)
    for kind, line in LINES.items():
        (procedure, _) = parse(PROGRAM.format(line=line)).procedures
        assert any(type(statement) is kind for statement in walk(procedure.body)), kind


@every_row("kind", list(LINES))
def test_a_statement_takes_time_is_noted_or_is_done_at_once(kind: type) -> None:
    """A statement that is new to whoever times a program must not pass for nothing."""
    changed = told(LINES[kind]) != told("# nothing")
    pace = kind in (p.SetAcceleration, p.SetOverride)  # which set how long moves take
    assert changed == (pace or p.TRAITS[kind] not in AT_ONCE)
