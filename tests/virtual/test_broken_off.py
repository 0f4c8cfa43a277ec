"""Moves that end as soon as something holds: in pseudo-programs, and as each language says them."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import assistant
from assistant import languages, robots
from assistant.program import pseudo
from assistant.program.program import Program
from assistant.virtual.events import Run, Switched
from assistant.virtual.kernel import Kernel
from assistant.virtual.kernel.timed_arm import Timed
from assistant.virtual.melfa import start_slot
from assistant.virtual.pseudo import start_program
from assistant.virtual.rapid.controller import Controller
from assistant.virtual.rapid.interpreter import start_task

ARMS = {"pseudo": "irb1200-7-0.7", "rapid": "irb1200-7-0.7", "melfa-basic-6": "rv-7frl"}
PROGRAM = """program p for {arm}
signal part digital input 9
signal door digital input 10
signal here digital output 1
signal way digital output 2
signal gone digital output 3
target a [400, -150, 400] [0, 0, 1, 0]
target b [400, 150, 400] [0, 0, 1, 0]
variable p1 position
procedure main
  move linear a speed 100 mm/s blend fine
  {move} until {until}
  set way = broken_off()
  p1 = here(tool0, base)
  if p1.y < 100
    set here = 1
  end
  move linear a speed 100 mm/s blend fine
  set gone = 1
end
"""
STRAIGHT = "move linear b speed 100 mm/s blend fine"
ARC = "move circular via target [430, 0, 400] [0, 0, 1, 0] to b speed 100 mm/s blend fine"
TURNED = "move absolute joints [30, 0, 0, 0, 30, 0] speed 100 mm/s blend fine"


def ran(language: str, move: str, until: str, at: float | None) -> Run:
    """The part comes at some time; the arm begins to move when it stands at the first target."""
    arm = robots.get(ARMS[language])
    program = pseudo.parse(PROGRAM.format(arm=ARMS[language], move=move, until=until))
    start = arm.joints_of([[400, -150, 400]], [[0, 0, 1, 0]], [[-128, 0, 0, 0, 0, 0]])[0]
    kernel = Kernel(motion=Timed(arm, joints=start), most_time=60.0)
    if at is not None:
        kernel.at(at, lambda: kernel.board.inputs.set(INPUTS[language][0], 1.0))
    RUNS[language](kernel, program, arm)
    run = kernel.run()
    assert (run.ended, run.message) == ("end", "")
    return run


def _rapid(kernel: Kernel, program: Program, arm: robots.Robot) -> None:
    tree = languages.get("rapid").parse(_written("rapid", program, arm))
    controller = Controller()
    controller.known |= {"part", "door"}
    start_task(kernel, (tree,), robot=arm, controller=controller)


def _melfa(kernel: Kernel, program: Program, arm: robots.Robot) -> None:
    tree = languages.get("melfa-basic-6").parse(_written("melfa-basic-6", program, arm))
    start_slot(kernel, (tree,), robot=arm)


def _written(language: str, program: Program, arm: robots.Robot) -> str:
    done = assistant.compile(program, language=language, robot=arm.name)
    assert done.files, done.findings
    (text,) = done.files.values()
    return text.decode()


INPUTS = {"pseudo": ("part",), "rapid": ("part",), "melfa-basic-6": ("9",)}
RUNS: dict[str, Callable[..., object]] = {
    "pseudo": lambda kernel, program, arm: start_program(kernel, program, robot=arm),
    "rapid": _rapid,
    "melfa-basic-6": _melfa,
}


def told(run: Run) -> list[tuple[str, float, float]]:
    """Outputs, with the times that they are set at."""
    return [
        (str(row.what.signal), row.what.value, round(row.time, 1))
        for row in run.log
        if isinstance(row.what, Switched)
    ]


@pytest.mark.parametrize("language", ARMS)
@pytest.mark.parametrize("move", [STRAIGHT, ARC, TURNED], ids=["line", "arc", "joints"])
def test_a_move_ends_where_the_arm_is(language: str, move: str) -> None:
    """One second of way, and the same back."""
    found = told(ran(language, move, "part = 1", 1.0))
    assert [value for _, value, _ in found] == [1.0, 1.0, 1.0]
    assert found[0][2] == found[1][2] == 1.0
    if move == STRAIGHT:
        assert found[2][2] == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("language", ARMS)
def test_a_move_that_nothing_ends_is_made_whole(language: str) -> None:
    found = told(ran(language, STRAIGHT, "part = 1", None))
    assert [value for _, value, _ in found] == [0.0, 1.0]
    assert found[0][2] == pytest.approx(3.0, abs=0.1)


@pytest.mark.parametrize("language", ARMS)
def test_a_move_is_not_begun_where_its_end_holds(language: str) -> None:
    found = told(ran(language, STRAIGHT, "part = 0", None))
    assert [value for _, value, _ in found] == [1.0, 1.0, 1.0]
    assert found[2][2] < 0.2


@pytest.mark.parametrize("language", ARMS)
def test_several_conditions_end_a_move(language: str) -> None:
    found = told(ran(language, STRAIGHT, "part = 1 and door = 0", 1.0))
    assert [value for _, value, _ in found] == [1.0, 1.0, 1.0]
    assert found[0][2] in (1.0, 1.1)


SEARCH = r"""MODULE Cell
CONST robtarget a:=[[400,-150,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget b:=[[400,150,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR robtarget found;
PROC main()
ConfL\Off;
MoveL a,v100,fine,tool0;
SearchL{search},found,b,v100,tool0;
SetAO aoPlace,found.trans.y;
ERROR
IF ERRNO=ERR_WHLSEARCH SetAO aoPlace,1000;
IF ERRNO=ERR_SIGSUPSEARCH SetAO aoPlace,2000;
RETURN;
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize(
    ("search", "place", "time"),
    [
        # 100 mm behind the start at 1 s, 200 mm at 2 s; the whole way of 300 mm takes 3 s.
        (r"\Stop,part", -50, 1.0),
        (r"\PStop,part\PosFlank", -50, 1.0),
        (r"\SStop,part\NegFlank", 50, 2.0),
        (r"\SStop,part\Flanks", -50, 1.0),
        (r"\SStop,part\HighLevel", -50, 1.0),
        (r"\SStop,part\LowLevel", -150, 0.0),
        (" part", -50, 3.0),
        (r"\Sup,part", -50, 3.0),
        (r"\Sup,part\Flanks", 1000, 3.0),
        (r"\Stop,door", 2000, 0.0),
        (r"\Stop,door\PosFlank", 1000, 3.0),
        (r"\Stop,door\HighLevel", -150, 0.0),
    ],
)
def test_what_a_search_finds(search: str, place: float, time: float) -> None:
    """The part is there from 1 s to 2 s, the door is open."""
    arm = robots.get(ARMS["rapid"])
    tree = languages.get("rapid").parse(SEARCH.replace("{search}", search))
    assert tree.findings == ()
    start = arm.joints_of([[400, -150, 400]], [[0, 0, 1, 0]], [[-128, 0, 0, 0, 0, 0]])[0]
    kernel = Kernel(motion=Timed(arm, joints=start))
    kernel.board.inputs.set("door", 1.0)
    kernel.at(1.0, lambda: kernel.board.inputs.set("part", 1.0))
    kernel.at(2.0, lambda: kernel.board.inputs.set("part", 0.0))
    start_task(kernel, (tree,), robot=arm)
    ((signal, found, when),) = told(kernel.run())
    assert signal == "aoplace"
    assert when == pytest.approx(time, abs=0.1)
    assert found == pytest.approx(place, abs=2.0)
