"""Where the arm is for every motion statement of a program."""

from __future__ import annotations

import numpy as np

from assistant import robots
from assistant.program.expressions import TargetValue
from assistant.program.geometry import Pose, Target
from assistant.program.motion import FINE, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.pseudo import parse
from assistant.program.statements import Follow, Motion, Move

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
    solution = robots.solve_program(parse(TEXT), ARM)
    assert solution.findings == ()
    legs = solution.legs["main"]
    assert [leg.rows for leg in legs] == [slice(0), slice(0, 1), slice(0, 2), slice(0, 1)]
    assert np.array_equal(legs[0].joints, [[0, 0, 0, 0, 30, 0]])
    assert np.array_equal(legs[1].before, [0, 0, 0, 0, 30, 0])
    assert np.array_equal(legs[2].before, legs[1].joints[0])
    assert legs[3].before is None, "the branch may not have been taken"
    assert len(solution.solved_runs) == 3
    arc = legs[2].solved_run
    assert arc is not None
    assert np.allclose(ARM.fk(legs[2].joints)[0], [[450, 0, 300], [450, 100, 400]])
    assert [arc.run.pace.blends[row].radius for row in arc.run.pace.blend] == [5.0, 5.0]
    assert np.isnan(arc.run.external).all()


def test_what_only_running_tells_has_no_joints() -> None:
    text = TEXT.replace("move circular via c to b", "move circular via c to offset(b, n, 0, 0)")
    text = text.replace("procedure main\n", "procedure main\n  variable n number\n", 1)
    solution = robots.solve_program(parse(text), ARM)
    assert [leg.solved_run is None for leg in solution.legs["main"]] == [True, False, True, False]
    assert len(solution.legs["main"][2].joints) == 0


def test_an_empty_path_has_its_place_among_the_legs() -> None:
    q = np.tile((0.0, 0.0, 1.0, 0.0), (2, 1))
    there = Path.of("there", np.array([[450.0, 0, 400], [450, 50, 400]]), q, speeds=[Speed(100.0)])
    nothing = Path.of("nothing", np.empty((0, 3)), np.empty((0, 4)), speeds=[Speed(100.0)])
    target = TargetValue(Target(Pose((450.0, 0.0, 350.0), (0.0, 0.0, 1.0, 0.0))))
    move = Move("joint", target, Motion(Speed(100.0), FINE))
    body = (Follow(nothing), move, Follow(nothing), Follow(there), Follow(nothing))
    for statements in (body, body[:1], body[2:]):
        program = Program("p", (Procedure("main", statements),))
        solution = robots.solve_program(program, ARM)
        assert solution.findings == ()
        assert [leg.statement for leg in solution.legs["main"]] == list(statements)
        assert [len(leg.joints) for leg in solution.legs["main"]] == [
            len(s.path) if isinstance(s, Follow) else 1 for s in statements
        ]


def test_only_the_first_findings_state_the_nearest_pose() -> None:
    places = (900, 910, 900, 920, 930, 940)
    moves = [
        f"  move joint at_{x} speed 100 mm/s joint 10 % blend fine\n  call wait_here()\n"
        for x in places
    ]
    targets = [f"target at_{x} [{x}, 0, 400] [0, 0, 1, 0]\n" for x in sorted(set(places))]
    waiting = "end\n\nprocedure wait_here\n  wait 1 s\nend\n"
    text = "".join(["program p\n\n", *targets, "\nprocedure main\n", *moves, waiting])
    findings = robots.solve_program(parse(text), ARM).findings
    assert [finding.code for finding in findings] == ["RB102"] * 5
    stated = ["the nearest pose that it can take is" in finding.cure for finding in findings]
    assert stated == [True, True, True, False, False]
    assert findings[0].place is not None and "2 times" in findings[0].place
    assert all("one that reaches" in finding.cure for finding in findings)


def test_the_old_name_still_solves():
    assert robots.journey is robots.solve_program
