"""Where the arm is for every motion statement of a program."""

from __future__ import annotations

import numpy as np

from assistant import robots
from assistant.program.pseudo import parse

ARM = robots.get("irb1200-7-0.7")
TEXT = """program p

target a [450, 0, 400] [0, 0, 1, 0]
target b [450, 100, 400] [0, 0, 1, 0]
target c [450, 0, 300] [0, 0, 1, 0]
joints ready [0, 0, 0, 0, 30, 0]

procedure main
  move absolute ready speed 100 mm/s joint 10 % blend fine
  move joint a speed 100 mm/s joint 10 % blend fine
  if 1 < 2
    move circular via c to b speed 100 mm/s blend 5 mm
  end
  wait 1 s
  move linear a speed 100 mm/s blend fine
end
"""


def test_a_leg_a_statement_in_order_of_text() -> None:
    journey = robots.journey(parse(TEXT), ARM)
    assert journey.findings == ()
    legs = journey.legs["main"]
    assert [leg.rows for leg in legs] == [slice(0), slice(0, 1), slice(0, 2), slice(0, 1)]
    assert np.array_equal(legs[0].joints, [[0, 0, 0, 0, 30, 0]])
    assert np.array_equal(legs[1].before, [0, 0, 0, 0, 30, 0])
    assert np.array_equal(legs[2].before, legs[1].joints[0])
    assert legs[3].before is None, "the branch may not have been taken"
    assert len(journey.stretches) == 3
    arc = legs[2].stretch
    assert arc is not None
    assert np.allclose(ARM.fk(legs[2].joints)[0], [[450, 0, 300], [450, 100, 400]])
    assert [arc.run.pace.blends[row].radius for row in arc.run.pace.blend] == [5.0, 5.0]
    assert np.isnan(arc.run.external).all()


def test_what_only_running_tells_has_no_joints() -> None:
    text = TEXT.replace("move circular via c to b", "move circular via c to offset(b, n, 0, 0)")
    text = text.replace("procedure main\n", "procedure main\n  variable n number\n", 1)
    journey = robots.journey(parse(text), ARM)
    assert [leg.stretch is None for leg in journey.legs["main"]] == [True, False, True, False]
    assert len(journey.legs["main"][2].joints) == 0
