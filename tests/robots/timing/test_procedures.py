"""Times of procedures: calls, loops, waits, branches, and what is not known."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages, robots
from assistant.base.diagnostics import Refused
from assistant.program.program import Declaration
from assistant.program.pseudo import parse
from assistant.program.statements import Opaque
from assistant.program.vendor_statements import with_effects
from assistant.robots.timing import Drive, Simulation, simulate
from tests.examples import drawn

ARM = robots.get("irb1200-7-0.7")
LOOSE = Drive(ARM.speeds * 1e3, ARM.speeds * 1e6, math.inf, math.inf)
"""Axes that bind nothing: a move takes its length over its speed, to some hundredths."""
HEAD = """program p

signal di digital input

target a [400, -100, 400] [0, 0, 1, 0]
target b [400, 100, 400] [0, 0, 1, 0]
target far [2000, 0, 0] [0, 0, 1, 0]

variable n number = 0
variable total number

procedure main
"""
THERE = "  move joint a speed maximum rotation 100000 deg/s blend fine\n"
FORTH = "  move linear b speed 100 mm/s blend fine\n"
BACK = "  move linear a speed 50 mm/s blend fine\n"


def done(body: str, rest: str = "") -> Simulation:
    program = parse(HEAD + body + "end\n" + rest)
    return simulate(robots.solve_program(program, ARM), drive=LOOSE)


def seconds(body: str, rest: str = "") -> float:
    simulation = done(body, rest)
    assert simulation.duration.least == pytest.approx(simulation.duration.most)
    return simulation.seconds


def near(value: float) -> object:
    return pytest.approx(value, abs=0.05)


def test_moves_and_waits_add_up() -> None:
    assert seconds(THERE + FORTH + "  wait 1.5 s\n" + BACK) == near(2 + 1.5 + 4)


def test_a_loop_counts_its_rounds() -> None:
    loop = f"  for i from 1 to 7\n{FORTH}{BACK}    wait 0.25 s\n  end\n"
    assert seconds(THERE + loop) == near(7 * 6.25)
    by_two = loop.replace("from 1 to 7", "from 7 to 1 step -2")
    assert seconds(THERE + by_two) == near(4 * 6.25)
    assert seconds(THERE + loop.replace("1 to 7", "7 to 1")) == near(0)
    assert seconds(THERE + loop.replace("1 to 7", "1 to 4000")) == pytest.approx(
        4000 * 6.25, rel=1e-4
    )


def test_a_loop_starts_again_from_where_it_ended() -> None:
    assert seconds(THERE + f"  for i from 1 to 5\n{FORTH}  end\n") == near(2)


def test_calls_and_what_they_are_given() -> None:
    rest = (
        "\nprocedure go(height number, p position)\n"
        "  move linear offset(p, 0, 0, height) speed 100 mm/s blend fine\n"
        "  move linear p speed 100 mm/s blend fine\nend\n"
    )
    body = THERE + "  for i from 1 to 3\n    call go(i * 10, a)\n  end\n"
    simulation = done(body, rest)
    assert simulation.unknown == ()
    assert simulation.seconds == near(2 * (0.1 + 0.2 + 0.3))
    assert simulation.procedures["go"].least == near(0.2)
    assert simulation.procedures["go"].most == near(0.6)
    assert [simulation.moves.number.tolist(), simulation.moves.length.round(3).tolist()][0] == [
        1,
        1,
        2,
    ]


def test_arrays_components_and_functions_that_compute() -> None:
    rest = (
        "\nprocedure higher(p position, k number) returns number\n  variable most number = 30\n"
        "  if k * 10 > most\n    return most\n  end\n  return k * 10\nend\n"
    )
    body = THERE + (
        "  for i from 1 to 4\n"
        "    q = offset(places[2], 0, 0, higher(a, steps[i]))\n"
        "    move linear q speed 100 mm/s blend fine\n"
        "    move linear offset(a, q.x - 400, 0, 0) speed 100 mm/s blend fine\n  end\n"
    )
    arrays = (
        "constant places position[2] = [target [400, 0, 400] [0, 0, 1, 0], "
        "target [400, -100, 400] [0, 0, 1, 0]]\nconstant steps number[4] = [1, 2, 3, 9]\n"
        "variable q position\n\nprocedure main\n"
    )
    text = HEAD.replace("procedure main\n", arrays) + body + "end\n" + rest
    simulation = simulate(robots.solve_program(parse(text), ARM), drive=LOOSE)
    assert simulation.unknown == ()
    assert simulation.seconds == near(2 * (0.1 + 0.2 + 0.3 + 0.3))


def test_a_taught_place_counts_unless_the_program_sets_it() -> None:
    taught = "persistent p position = target [400, 100, 400] [0, 0, 1, 0]\n\nprocedure main\n"
    text = HEAD.replace("procedure main\n", taught) + THERE
    text += "  move linear p speed 100 mm/s blend fine\n"
    simulation = simulate(robots.solve_program(parse(text + "end\n"), ARM), drive=LOOSE)
    assert (simulation.seconds, simulation.unknown) == (near(2), ())
    text += "  p = offset(p, total, 0, 0)\nend\n"
    simulation = simulate(robots.solve_program(parse(text), ARM), drive=LOOSE)
    assert [one.what[:6] for one in simulation.unknown] == ["move 2"]


def test_external_axes_are_told_of() -> None:
    held = "target [400, {}, 400] [0, 0, 1, 0] external [{}]"
    moves = "".join(
        f"  move linear {held.format(y, e)} speed 100 mm/s blend fine\n"
        for y, e in ((0, 10), (50, 10), (100, 20))
    )
    simulation = done(THERE + moves)
    assert [one.what for one in simulation.unknown] == ["move 4: its external axes are not timed"]


def test_a_move_to_joints_with_a_tool_that_is_not_declared() -> None:
    text = HEAD.replace("variable n", "joints up [0, 0, 0, 0, 30, 0]\n\nvariable n") + THERE
    text += "  move absolute up speed 100 mm/s blend fine tool elsewhere\nend\n"
    simulation = simulate(robots.solve_program(parse(text), ARM))
    what = "move 2: its tool or frame is not known; the flange is taken"
    assert [one.what for one in simulation.unknown] == [what]
    assert simulation.moves.seconds[-1] > 1


def test_a_loop_with_a_condition_that_the_text_tells() -> None:
    body = THERE + f"  while n < 4\n    n = n + 1\n{FORTH}{BACK}  end\n"
    assert seconds(body) == near(4 * 6)


def test_branches_give_the_shortest_and_the_longest() -> None:
    branch = f"  if di = 1\n    wait 3 s\n  else\n{FORTH}  end\n"
    simulation = done(THERE + branch + BACK)
    # Back from b, or from a, where the arm is already.
    assert simulation.duration.least == near(2 + 0)
    assert simulation.duration.most == near(3 + 4)
    known = f"  n = 3\n  if n > 2\n{FORTH}  else\n    wait 9 s\n  end\n"
    assert seconds(THERE + known) == near(2)


def test_a_switch_may_take_none_of_its_cases() -> None:
    body = f"{THERE}  n = di\n  switch n\n  case 1, 2\n    wait 4 s\n  end\n"
    simulation = done(body)
    assert (simulation.duration.least, simulation.duration.most) == (near(0), near(4))


def test_a_return_on_one_way_ends_the_procedure() -> None:
    early = "  if di = 1\n    wait 2 s\n    return\n  end\n"
    rest = f"\nprocedure try\n  wait 1 s\n{early}  wait 8 s\nend\n"
    simulation = done(THERE + "  call try\n  wait 1 s\n", rest)
    assert simulation.duration.least == near(1 + 2 + 1)
    assert simulation.duration.most == near(1 + 8 + 1)


@pytest.mark.parametrize(
    ("body", "what", "expected"),
    [
        ("  wait for di = 1\n", "the wait for di = 1", 0),
        ("  wait until di = 1\n", "the wait until di = 1", 0),
        ("  wait total s\n", "a wait of total, which only running the program tells", 0),
        ("  stop\n", "a stop, until somebody starts the program again", 0),
        (
            "  while di = 1\n    wait 2 s\n  end\n",
            "how often the loop while di = 1 goes round; once is counted",
            2,
        ),
        (
            "  for i from 1 to total\n    wait 2 s\n  end\n",
            "how often the loop over i goes round; once is counted",
            2,
        ),
        ("  while true\n    wait 2 s\n  end\n", "the loop runs for ever; one round is counted", 2),
        (
            "  move linear offset(a, total, 0, 0) speed 10 mm/s blend fine\n",
            "move 2 to `offset(a, total, 0, 0)`: only running the program tells where that is",
            0,
        ),
    ],
)
def test_what_only_running_tells_is_listed(body: str, what: str, expected: float) -> None:
    simulation = done(THERE + body)
    assert [str(one) for one in simulation.unknown] == [f"main: {what}"]
    assert simulation.seconds == near(expected)


def test_what_follows_a_place_that_is_not_known_is_not_timed() -> None:
    lost = "  move linear offset(a, total, 0, 0) speed 10 mm/s blend fine\n"
    simulation = done(THERE + lost + FORTH + BACK)
    assert simulation.seconds == near(4)
    assert [one.what[:6] for one in simulation.unknown] == ["move 2", "move 3"]
    assert simulation.moves.number.tolist() == [1, 4]


MOTION = "is a motion whose time is not known"
PERHAPS = "may move the arm, in a time that is not known"
NEITHER = "is taken as neither time nor motion"


@pytest.mark.parametrize(
    ("language", "text", "what"),
    [
        ("rapid", "MoveL c,v100\\T:=7,fine,tool0;", MOTION),
        ("rapid", "ArcL c,v100,seam1,weld1,fine,tool0;", MOTION),
        ("rapid", "TriggIO gun,0.2\\DOp:=do1,1;", NEITHER),
        ("rapid", "SetAO ao1,3;", NEITHER),
        ("rapid", "elsewhere\\fast;", PERHAPS),
        ("rapid", "stands\\fast;", NEITHER),
        ("rapid", "goes\\fast;", PERHAPS),
        ("rapid", "runs\\fast;", PERHAPS),
        ("rapid", "logs\\fast;", NEITHER),
        ("melfa-basic-5", "Mvs P3 Wth M_Out(8)=1", MOTION),
        ("melfa-basic-5", "If M1=0 Then Mov P3", MOTION),
        ("melfa-basic-5", "MvTune 2", NEITHER),
        ("melfa-basic-5", "GoSub *Away", PERHAPS),
        ("another", "PTP P3", PERHAPS),
    ],
)
def test_a_motion_that_is_kept_as_its_text_leads_nobody_knows_where(
    language: str, text: str, what: str
) -> None:
    rest = "\nprocedure stands\n  wait 1 s\nend\n\nprocedure goes\n  call stands\n" + BACK + "end\n"
    program = parse(HEAD + THERE + FORTH + BACK + FORTH + "end\n" + rest)
    main, *others = program.procedures
    main = replace(main, body=(*main.body[:2], Opaque(language, text), *main.body[3:]))
    program = replace(
        program,
        procedures=(main, *others),
        declarations=(
            Declaration("rapid", "PROC runs(\\switch fast)\n  logs;\n  goes;\nENDPROC"),
            Declaration("rapid", "PROC logs(\\switch fast)\n  IF TRUE logs;\n  stands;\nENDPROC"),
        ),
    )
    program = with_effects(program, languages.effect)
    simulation = simulate(robots.solve_program(program, ARM), drive=LOOSE)
    told = [str(one) for one in simulation.unknown if one.procedure == "main"]
    assert told[0] == f"main: `{text}` {what}"
    assert len(told) == (1 if what == NEITHER else 2)  # the move behind a motion as well
    assert simulation.seconds == near(2)


def test_routines_in_kept_text_that_call_each_other_may_both_move() -> None:
    program = parse(HEAD + THERE + FORTH + "end\n\nprocedure runs\n" + BACK + "end\n")
    main, *others = program.procedures
    calls = tuple(Opaque("rapid", f"{name}\\fast;") for name in ("ping", "pong"))
    program = replace(
        program,
        procedures=(replace(main, body=(*main.body, *calls)), *others),
        declarations=(
            Declaration("rapid", "PROC ping(\\switch fast)\n  pong;\n  runs;\nENDPROC"),
            Declaration("rapid", "PROC pong(\\switch fast)\n  ping;\nENDPROC"),
        ),
    )
    program = with_effects(program, languages.effect)
    simulation = simulate(robots.solve_program(program, ARM), drive=LOOSE)
    told = [one.what for one in simulation.unknown if one.procedure == "main"]
    assert told == [f"`{name}\\fast;` {PERHAPS}" for name in ("ping", "pong")]


def test_procedures_that_nobody_calls_and_that_call_themselves() -> None:
    rest = f"\nprocedure alone\n{THERE}{FORTH}end\n\nprocedure again\n  call again\nend\n"
    simulation = done(THERE + "  call again\n", rest)
    assert simulation.procedures["alone"].most == near(2)
    assert "again: `again` calls itself; that is not followed" in map(str, simulation.unknown)


@pytest.mark.slow
def test_calls_that_double_and_double_again_end() -> None:
    body = "".join(f"\nprocedure p{i}\n  call p{i + 1}\n  call p{i + 1}\nend\n" for i in range(40))
    simulation = done(THERE + "  call p0\n", f"{body}\nprocedure p40\n  wait 1 s\nend\n")
    assert any("too many calls" in one.what for one in simulation.unknown)
    assert simulation.procedures["p39"].most == near(2)


PLAIN = st.sampled_from(
    [
        THERE,
        FORTH,
        BACK.replace("fine", "10 mm"),
        "  move linear offset(a, 0, 0, n) speed 200 mm/s blend 5 mm\n",
        "  move linear offset(a, total, 0, 0) speed 200 mm/s blend fine\n",
        "  wait 0.25 s\n",
        "  wait for di = 1\n",
        "  n = n + 1\n",
        "  n = di\n",
        "  override 50 %\n",
        "  acceleration 50 % deceleration 80 %\n",
        "  call inner(n)\n",
        "  return\n",
        "  stop\n",
    ]
)
OPENINGS = st.sampled_from(
    [
        *("if di = 1", "if n < 3", "for i from 1 to 3", "for n from 1 to di"),
        *("while n < 4", "while di = 1", "while true"),
    ]
)
BODIES = st.recursive(
    st.lists(PLAIN, max_size=4).map("".join),
    lambda inner: st.lists(
        st.builds(lambda opening, body: f"  {opening}\n{body}  end\n", OPENINGS, inner), max_size=3
    ).map("".join),
    max_leaves=8,
)


@settings(max_examples=drawn(60), deadline=None)
@given(BODIES, BODIES)
def test_times_fit_together_whatever_the_program_does(body: str, inner: str) -> None:
    inner = inner.replace("call inner(n)", "wait 1 s")
    simulation = done(THERE + body, f"\nprocedure inner(k number)\n{inner}end\n")
    assert 0.0 <= simulation.duration.least <= simulation.duration.most + 1e-9
    for one in simulation.procedures.values():
        assert 0.0 <= one.least <= one.most + 1e-9
    spent = 0.0 if simulation.history is None else simulation.history.seconds
    assert spent == pytest.approx(simulation.seconds)
    assert simulation.samples.t[-1] == pytest.approx(simulation.seconds, abs=simulation.period)
    assert (simulation.moves.seconds >= 0.0).all()


def test_what_cannot_be_reached_has_no_time() -> None:
    with pytest.raises(Refused) as refused:
        done(THERE + "  move joint far speed 100 mm/s blend fine\n")
    assert refused.value.findings[0].code == "RB102"
