"""When outputs are set that moves set on their way."""

from __future__ import annotations

import pytest

from assistant import robots
from assistant.program.pseudo import parse
from assistant.report.timing import lines, record
from assistant.robots.timing import Simulation, simulate

PROGRAM = """program p
signal gun digital output 1
target a [400, -100, 400] [0, 0, 1, 0]
target m [450, 0, 400] [0, 0, 1, 0]
target b [400, 100, 400] [0, 0, 1, 0]
procedure main
move joint a speed 100 mm/s blend fine
{move}
end
"""
STRAIGHT = "move linear b speed 100 mm/s blend fine"


def timed(move: str) -> Simulation:
    program = parse(PROGRAM.format(move=move))
    return simulate(robots.solve_program(program, robots.get("irb1200-7-0.7")))


@pytest.mark.parametrize(
    ("place", "part", "more"),
    [
        ("0 mm from start", 0.0, 0.0),
        ("100 mm before end", 0.5, 0.0),
        ("100 mm from start", 0.5, 0.0),
        ("50 %", 0.5, 0.0),
        ("0 mm before end", 1.0, 0.0),
        ("0.3 s before end", 1.0, -0.3),
        ("100 mm before end ahead 0.2 s", 0.5, -0.2),
        ("100 mm before end ahead -0.2 s", 0.5, 0.2),
        ("0 mm from start ahead 0.2 s", 0.0, 0.0),
    ],
)
@pytest.mark.parametrize("move", [STRAIGHT, "move circular via m to b speed 100 mm/s blend fine"])
def test_an_output_has_its_time(move: str, place: str, part: float, more: float) -> None:
    done = timed(f"{move} set gun = 1 at {place}")
    (one,) = done.outputs
    whole = float(done.moves.seconds[1:].sum())
    if "circular" in move and "100 mm" in place:  # not half of the arc
        assert 0.0 < one.seconds < whole
        return
    assert one.seconds == pytest.approx(part * whole + more, abs=0.01)


def test_what_is_set_takes_no_time() -> None:
    with_output = timed(f"{STRAIGHT} set gun = 1 at 50 mm before end set gun = 0 at 90 %")
    assert with_output.seconds == timed(STRAIGHT).seconds
    assert [one.value for one in with_output.outputs] == ["1", "0"]
    shown = "\n".join(lines(with_output))
    assert "main move 2" in shown and "gun = 1" in shown
    assert [one["signal"] for one in record(with_output)["outputs"]] == ["gun", "gun"]


def test_a_program_without_outputs_tells_of_none() -> None:
    assert timed(STRAIGHT).outputs == ()
    assert "outputs" not in "\n".join(lines(timed(STRAIGHT)))
