"""Pseudo-programs that run: what they do, and that what is written of them does the same."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import compile, robots
from assistant.compiler.simulated_run import programs
from assistant.languages import get
from assistant.program import pseudo
from assistant.virtual.events import Moved, Run, Said, Stopped, Switched, Waited
from assistant.virtual.kernel import Board, Kernel, Signals
from assistant.virtual.melfa import run as run_melfa
from assistant.virtual.proving.comparison import difference
from assistant.virtual.pseudo import start_program
from assistant.virtual.rapid import run as run_rapid

SAMPLES = Path(__file__).parents[2] / "samples"
HEAD = """program cell for irb1200-7-0.7

tool tip tip [0, 0, 100]
frame table object [300, 0, 0] [1, 0, 0, 0]
signal ready digital input 3
signal glue digital output 8
target a [400, -100, 400] [0, 0, 1, 0]
"""


def ran(
    body: str, more: str = "", inputs: dict[str, float] | None = None, steps: int = 5000
) -> Run:
    """The run of a program whose `main` is some lines."""
    program = pseudo.parse(f"{HEAD}{more}\nprocedure main\n{body}\nend\n")
    kernel = Kernel(Board(Signals(inputs or {})), most_steps=5000)
    start_program(kernel, program, robot=robots.get("irb1200-7-0.7"))
    return kernel.run()


def said(run: Run) -> list[str]:
    assert run.ended == "end", run.message
    return [event.text for event in run.events if isinstance(event, Said)]


def values(*expressions: str, more: str = "") -> list[str]:
    return said(ran("\n".join(f"message {one}" for one in expressions), more))


def test_numbers_texts_and_truths() -> None:
    assert values("2 + 3 * 4", "7 / 2", "-7 div 2", "-7 mod 4", "2 ^ 3", "round(-2.5)") == (
        ["14", "3.5", "-3", "-3", "8", "-3"]
    )
    assert values('"a" + text(1.5)', "length(fixed(2, 3))", 'part("robot", 2, 3)') == (
        ["a1.5", "5", "obo"]
    )
    assert values("1 < 2 and not 2 <> 2", "1 > 2 xor true", "sin(30) = 1", "max(1, 3, 2)") == (
        ["true", "true", "false", "3"]
    )
    assert values("bitor(4, 1)", "atan2(1, -1)", "sqrt(16)", "floor(-1.5)") == (
        ["5", "135", "4", "-2"]
    )


def test_positions_and_their_components() -> None:
    assert values("a.x", "offset(a, 1, 2, 3).z", "distance(a, offset(a, 3, 4, 0))") == (
        ["400", "403", "5"]
    )
    assert values("relative(a, 0, 0, 10).z") == ["390"]


def test_loops_branches_and_jumps() -> None:
    assert said(
        ran("for i from 1 to 3\nmessage i\nend\nfor i from 3 towards 2\nmessage i\nend")
    ) == (["1", "2", "3", "3", "2"])
    body = "n = 2\nif n = 1\nmessage 1\nelseif n = 2\nmessage 2\nelse\nmessage 3\nend"
    assert said(ran(body, "variable n number")) == ["2"]
    body = "label again\nn = n + 1\nif n < 3\ngoto again\nend\nmessage n"
    assert said(ran(body, "variable n number")) == ["3"]
    body = "while n < 2\nn = n + 1\nend\nmessage n"
    assert said(ran(body, "variable n number")) == ["2"]
    assert ran("while true\nend").ended == "steps"


def test_calls_by_value_and_by_reference() -> None:
    more = (
        "variable n number = 5\nvariable rows number[3]\n"
        "procedure twice(k inout number)\nk = k * 2\nend\n"
        "procedure sum(x number, y number) returns number\nreturn x + y\nend\n"
    )
    body = "rows[2] = 4\ncall twice(rows[2])\ncall twice(n)\nmessage n\nmessage sum(rows[2], 1)"
    assert said(ran(body, more)) == ["10", "9"]


def test_signals_waits_and_timers() -> None:
    run = ran("set glue = 1\nwait 0.5 s\nrestart timer t\nwait 2 s\nmessage elapsed(t)")
    assert run.events == (Switched("glue", 1.0), Waited(0.5), Waited(2.0), Said("2"))
    assert run.seconds == 2.5
    assert ran("wait for ready = 1").ended == "stopped"
    assert ran("wait for ready = 1", inputs={"ready": 1.0}).ended == "end"
    assert ran("stop\nset glue = 1").events == (Stopped(), Switched("glue", 1.0))
    assert ran("exit\nset glue = 1").events == (Stopped(end=True),)


def test_motions_with_tools_and_frames() -> None:
    run = ran("move linear a speed 100 mm/s blend 5 mm tool tip frame table")
    (moved,) = run.events
    assert isinstance(moved, Moved)
    assert (moved.kind, moved.speed, moved.blend) == ("linear", 100.0, 5.0)
    assert moved.flange is not None
    assert moved.flange.position == pytest.approx((700, -100, 500))


@pytest.mark.parametrize(
    ("body", "more", "ended", "says"),
    [
        ("message 1 / 0", "", "error", "division by zero"),
        ("n = 1", "constant n number = 2", "error", "constant"),
        ("message rows[4]", "variable rows number[3]", "error", "no element"),
        ("message nothing", "", "error", "no variable"),
        ("message elapsed(t)", "", "error", "never started"),
        ('message 1 + "a"', "", "error", "a text"),
        ("set ready = 1", "", "error", "the input"),
        ("call other", "", "error", "no procedure"),
        ("message here(tip, table).x", "", "unknown", "where the arm is"),
        ("opaque rapid | TPErase;", "", "unknown", "TPErase"),
    ],
)
def test_what_goes_wrong_is_said(body: str, more: str, ended: str, says: str) -> None:
    run = ran(body, more)
    assert run.ended == ended, run
    assert says in run.message


@pytest.mark.parametrize(
    "name",
    [pytest.param("plate.dxf", marks=pytest.mark.slow), "positioning.csv", "taught.toml"],
)
@pytest.mark.parametrize(
    ("language", "robot"), [("rapid", "irb1200-7-0.7"), ("melfa-basic-5", "rv-4frl")]
)
def test_what_is_written_of_a_source_does_the_same(name: str, language: str, robot: str) -> None:
    arm = robots.get(robot)
    program = programs([str(SAMPLES / name)], robot=arm).program
    assert program is not None
    kernel = Kernel()
    start_program(kernel, program, robot=arm)
    first = kernel.run()
    compiled = compile(str(SAMPLES / name), language=language, robot=robot)
    spoken = get(language)
    trees = [spoken.parse(spoken.decode(data)) for data in compiled.files.values()]
    bits = {
        signal.lower(): (declared.number,)
        for signal, declared in program.signals.items()
        if declared.number is not None
    }
    if language == "rapid":
        assert difference(first, run_rapid(trees, robot=arm)) is None
    else:
        assert difference(first, run_melfa(trees, robot=arm), bits) is None
    assert first.ended == "end" and len(first.events) > 5
