"""Programs whose motions take time: when things happen, and where the arm is then."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path as FilePath

import numpy as np
import pytest

from assistant import languages, robots
from assistant.compiler import load
from assistant.program.geometry import Pose
from assistant.program.motion import FINE, Blend, Kind, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow
from assistant.robots.timing import Drive, simulate
from assistant.virtual.events import How, Moved, Noted, Run, Said, Switched
from assistant.virtual.kernel import Ending, Kernel, Task
from assistant.virtual.kernel.timed_arm import Timed, track_of
from assistant.virtual.melfa import start_slot
from assistant.virtual.rapid.interpreter import start_task

ARM = robots.get("irb1200-7-0.7")
MELFA = robots.get("rv-4frl")
SAMPLES = FilePath(__file__).parents[2] / "samples"
HARD = 10_000.0
"""mm/s² of the tool; the axes bound nothing."""


def drive(arm: robots.Robot = ARM, acceleration: float = HARD) -> Drive:
    return Drive(arm.speeds * 1e3, arm.speeds * 1e6, math.inf, acceleration)


HEAD = """MODULE Cell
PERS tooldata tGrip:=[TRUE,[[0,0,0],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
CONST robtarget pA:=[[400,-100,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget pB:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget pC:=[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget pFar:=[[400,200,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR triggdata tr;
VAR clock ck;
"""
LOOSE = "ConfL\\Off; ConfJ\\Off;\nMoveAbsJ jStart, v1000, fine, tGrip;\n"


def joints_at(position: tuple[float, ...], arm: robots.Robot = ARM) -> tuple[float, ...]:
    found = arm.joints_of([position], [[0.0, 0.0, 1.0, 0.0]], [[-128, 0, 0, 0, 0, 0]])[0]
    return tuple(found.tolist())


A = joints_at((400.0, -100.0, 300.0))


def rapid(
    main: str, *, more: str = "", motion: Timed | None = None, alone: bool = True
) -> tuple[Kernel, Run]:
    """A program that begins with the arm at pA. alone: whether nothing else needs the time."""
    text = f"{HEAD}PROC main()\nConfL\\Off; ConfJ\\Off;\n{main}\nENDPROC\n{more}\nENDMODULE\n"
    tree = languages.get("rapid").parse(text)
    assert tree.findings == ()
    kernel = Kernel(motion=motion or Timed(ARM, drive(), A))
    start_task(kernel, (tree,), robot=ARM)
    if not alone:
        kernel.at(1e6, lambda: None)
    return kernel, kernel.run()


def times(run: Run, kind: type = Switched) -> list[float]:
    return [round(row.time, 4) for row in run.log if isinstance(row.what, kind)]


# ------------------------------------------------------------------------- by hand, in RAPID


def test_a_line_takes_its_way_by_its_speed_and_the_time_to_come_to_it() -> None:
    """300 mm at 100 mm/s with 1000 mm/s²: 3 s and 0.1 s."""
    motion = Timed(ARM, drive(acceleration=1000.0), A)
    kernel, run = rapid("MoveL pFar, v100, fine, tGrip;\nSet do1;", motion=motion)
    assert run.ended == "end"
    assert kernel.now == pytest.approx(3.1, abs=1e-6)
    assert times(run) == [3.1]


@pytest.mark.parametrize("alone", [True, False])
@pytest.mark.parametrize(
    ("zone", "second", "third"),
    [("fine", 1.01, 2.02), ("z10", 0.905, None)],
    ids=["fine", "fly-by"],
)
def test_what_stands_behind_a_motion_runs_as_its_corner_begins(
    zone: str, second: float, third: float | None, alone: bool
) -> None:
    """100 mm at 100 mm/s with 10000 mm/s², 10 mm of it in the corner: (90 - 0.5) / 100 + 0.01."""
    main = f"MoveL pB, v100, {zone}, tGrip;\nSet do1;\nMoveL pC, v100, fine, tGrip;\nSet do2;"
    kernel, run = rapid(main, alone=alone)
    moved, switched = times(run, Moved), times(run)
    assert moved == [0.0, second]
    assert switched[0] == second
    if third is not None:
        assert switched[1] == third
    assert switched[1] == round(kernel.clock, 4)
    # A corner saves way: the parabola is shorter than the two sides of 10 mm by 3.77 mm.
    if zone == "z10":
        assert switched[1] == pytest.approx(2.0 + 0.01 - 0.0377, abs=2e-3)


def test_a_program_runs_ahead_by_as_much_as_it_is_told_to() -> None:
    motion = Timed(ARM, drive(), A, ahead=0.2)
    main = "MoveL pB, v100, z10, tGrip;\nSet do1;\nMoveL pC, v100, fine, tGrip;"
    assert times(rapid(main, motion=motion, alone=False)[1]) == [0.705]


@pytest.mark.parametrize("alone", [True, False])
def test_a_motion_that_comes_too_late_for_its_corner(alone: bool) -> None:
    """The arm stops in the point at 1.01 s; the next motion is commanded at 2.905 s."""
    main = "MoveL pB, v100, z10, tGrip;\nWaitTime 2;\nMoveL pC, v100, fine, tGrip;"
    kernel, run = rapid(main, alone=alone)
    notes = [row for row in run.log if isinstance(row.what, Noted)]
    assert [round(row.time, 4) for row in notes] == [2.905]
    assert "50024" in str(notes[0].what)
    assert kernel.now == pytest.approx(2.905 + 1.01, abs=1e-6)


@pytest.mark.parametrize("alone", [True, False])
@pytest.mark.parametrize(
    ("trigger", "at"),
    [
        ("TriggIO tr, 20\\DOp:=do1, 1;", 0.805),  # 80 mm: (80 - 0.5) / 100 + 0.01
        ("TriggIO tr, 30\\Start\\DOp:=do1, 1;", 0.305),
        ("TriggIO tr, 0.25\\Time\\DOp:=do1, 1;", 0.76),
        ("TriggEquip tr, 20, 0.1\\DOp:=do1, 1;", 0.705),
    ],
)
def test_outputs_on_the_way_are_set_at_their_place(trigger: str, at: float, alone: bool) -> None:
    main = f"{trigger}\nTriggL pB, v100, tr, fine, tGrip;\nSet do2;"
    _, run = rapid(main, alone=alone)
    assert times(run) == [at, 1.01]
    assert [row.what.signal for row in run.log if isinstance(row.what, Switched)] == ["do1", "do2"]


def test_an_output_in_a_corner_is_set_after_the_program_went_on() -> None:
    """At the end of the way, which the next motion cuts; the statement behind comes before it."""
    main = (
        "TriggIO tr, 0\\DOp:=do1, 1;\nTriggL pB, v100, tr, z10, tGrip;\nSet do2;\n"
        "MoveL pC, v100, fine, tGrip;"
    )
    _, run = rapid(main)
    order = [row.what.signal for row in run.log if isinstance(row.what, Switched)]
    assert order == ["do2", "do1"]
    first, second = times(run)
    assert first == 0.905
    assert first < second < 1.01


def test_positions_are_read_where_the_arm_is() -> None:
    main = (
        'MoveL pB, v100, z10, tGrip;\nTPWrite ""\\Pos:=CPos();\nWaitTime 0.02;\n'
        'TPWrite ""\\Pos:=CPos();\nWaitTime 5;\nTPWrite ""\\Pos:=CPos();'
    )
    _, run = rapid(main)
    said = [row.what.text for row in run.log if isinstance(row.what, Said)]
    y = [float(text.strip("[]").split(",")[1]) for text in said]
    assert y == pytest.approx([-10.0, -8.0, 0.0], abs=1e-3)


def test_a_clock_runs_while_the_arm_moves() -> None:
    main = 'ClkStart ck;\nMoveL pB, v100, fine, tGrip;\nClkStop ck;\nTPWrite ""\\Num:=ClkRead(ck);'
    _, run = rapid(main)
    assert [float(row.what.text) for row in run.log if isinstance(row.what, Said)] == [1.01]


def test_the_time_that_a_motion_states_holds() -> None:
    """2 s for 100 mm: 50 mm/s, and what it takes to come to that."""
    kernel, _ = rapid("MoveL pB, v100\\T:=2, fine, tGrip;")
    assert kernel.now == pytest.approx(2.005, abs=1e-6)


@pytest.mark.parametrize(
    ("main", "message"),
    [
        ("MoveL Offs(pA,2000,0,0), v100, fine, tGrip;", "12: 50050"),
        (
            "MoveAbsJ [[200,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v100, fine, tGrip;",
            "50027: joint J1",
        ),
        (
            "ConfJ\\On;\nMoveJ [pB.trans,pB.rot,[0,0,0,4],pB.extax], v100, fine, tGrip;",
            "50080",
        ),
    ],
)
@pytest.mark.parametrize("alone", [True, False])
def test_motions_that_cannot_be_made_end_the_run(main: str, message: str, alone: bool) -> None:
    _, run = rapid(f"MoveL pB, v100, fine, tGrip;\n{main}\nSet do1;", alone=alone)
    assert run.ended == "error"
    assert message in run.message
    assert times(run) == []
    assert times(run, Moved) == [0.0, 1.01]


@pytest.mark.parametrize("strict", [True, False])
def test_axes_that_turn_further_than_the_target_says(strict: bool) -> None:
    """Axis 1 is at -14 degrees at pA, in quadrant -1; the target says 0."""
    motion = Timed(ARM, drive(), A, strict=strict)
    main = "MoveL pB, v100, fine, tGrip;\nConfL\\On;\nMoveL pA, v100, fine, tGrip;\nSet do1;"
    _, run = rapid(main, motion=motion)
    assert run.ended == ("error" if strict else "end")
    assert ("50080" in run.message) == strict
    assert times(run) == ([] if strict else [2.02])


def test_a_line_on_which_the_arm_changes_its_branch_is_told_of() -> None:
    """From a wrist that bends down to one that is turned over."""
    flipped = "[pB.trans,pB.rot,[0,0,0,1],pB.extax]"
    _, run = rapid(
        f"MoveL pFar, v100, fine, tGrip;\nConfL\\On;\nMoveL {flipped}, v100, fine, tGrip;"
    )
    assert run.ended == "end"
    assert [note for note in run.notes if "13: the arm cannot stay in one branch" in note]


def test_a_run_whose_arm_is_held_for_ever_is_stopped() -> None:
    motion = Timed(ARM, drive(), A)
    kernel = Kernel(motion=motion)

    def body(task: Task) -> Ending:
        motion.go(task, line((400.0, 200.0, 300.0), 10.0))
        return Ending()

    kernel.task("one", body)
    kernel.at(2.95, lambda: motion.hold(kernel))
    assert (kernel.run().ended, kernel.now) == ("stopped", 2.95)


def test_a_run_that_takes_too_long_ends_where_its_time_is_over() -> None:
    main = "\n".join(f"MoveL p{x}, v100, fine, tGrip;\nSet do{x};" for x in "BCBC")
    text = f"{HEAD}PROC main()\nConfL\\Off;\n{main}\nENDPROC\nENDMODULE\n"
    kernel = Kernel(motion=Timed(ARM, drive(), A), most_time=2.5)
    start_task(kernel, (languages.get("rapid").parse(text),), robot=ARM)
    run = kernel.run()
    assert run.ended == "time"
    assert times(run) == [1.01, 2.02]


# ------------------------------------------------------------------------------ beside others


def test_tasks_run_while_the_arm_moves_and_do_not_change_its_time() -> None:
    main = "MoveL pB, v100, z10, tGrip;\nSet do1;\nMoveL pC, v100, fine, tGrip;\nSet do2;"
    text = f"{HEAD}PROC main()\nConfL\\Off;\n{main}\nENDPROC\nENDMODULE\n"
    other = (
        "MODULE m\nPROC main()\nFOR i FROM 1 TO 15 DO\nWaitTime 0.1;\n"
        "PulseDO\\PLength:=0.05, do3;\nENDFOR\nENDPROC\nENDMODULE\n"
    )
    kernel = Kernel(motion=Timed(ARM, drive(), A))
    for name, source in (("T_ROB1", text), ("T_BACK", other)):
        start_task(kernel, (languages.get("rapid").parse(source),), name=name, robot=ARM)
    run = kernel.run()
    assert run.ended == "end"
    mine = [round(row.time, 4) for row in run.log if row.task == "T_ROB1"]
    alone = [round(row.time, 4) for row in rapid(main)[1].log]
    assert mine == alone
    stamps = [row.time for row in run.log]
    assert stamps == sorted(stamps)
    assert len([row for row in run.log if row.task == "T_BACK" and row.time < 0.9]) > 5


# ----------------------------------------------------------------------------------- the arm


def line(to: tuple[float, float, float], blend: float = 0.0) -> Moved:
    flange, how = Pose(to, (0.0, 0.0, 1.0, 0.0)), How(mass=0.0)
    return Moved("linear", flange, Pose(), speed=100.0, blend=blend, how=how)


def test_an_arm_that_is_held_goes_on_from_where_it_stands() -> None:
    """Held after 1 s, at 95 mm, for 5 s; what is left, 205 mm, takes 2.05 and 0.1 s."""
    motion = Timed(ARM, drive(acceleration=1000.0), A)
    kernel = Kernel(motion=motion)

    def body(task: Task) -> Ending:
        motion.go(task, line((400.0, 200.0, 300.0)))
        task.switch("there", 1.0)
        return Ending()

    kernel.task("one", body)
    places: list[float] = []
    kernel.at(1.0, lambda: motion.hold(kernel))
    kernel.at(3.0, lambda: places.append(motion.where()[0].position[1]))
    kernel.at(6.0, lambda: motion.resume(kernel))
    run = kernel.run()
    assert run.ended == "end"
    assert places == pytest.approx([-5.0], abs=1e-2)
    assert times(run) == [8.15]
    track = track_of(motion, run.log, kernel.now)
    assert track.position[150, 1] == pytest.approx(-5.0, abs=1e-2)


def test_a_motion_that_is_cut_ends_where_the_arm_is() -> None:
    motion = Timed(ARM, drive(acceleration=1000.0), A)
    kernel = Kernel(motion=motion)

    def body(task: Task) -> Ending:
        motion.go(task, line((400.0, 200.0, 300.0)))
        task.switch("on", 1.0)
        motion.go(task, line((400.0, -100.0, 300.0)))
        task.switch("back", 1.0)
        return Ending()

    task = kernel.task("one", body)
    kernel.at(1.0, lambda: motion.cut(task) and None)
    run = kernel.run()
    assert times(run) == [1.0, 2.05]


TRAP_CELL = """VAR intnum stop;
PROC main()
ConfL\\Off; ConfJ\\Off;
CONNECT stop WITH Attend;
ISignalDI di1, 1, stop;
MoveL pFar, v100, fine, tGrip;
Set do1;
MoveL pA, v100, fine, tGrip;
Set do2;
ENDPROC
TRAP Attend
{trap}
ENDTRAP
ENDMODULE
"""


@pytest.mark.parametrize(
    ("trap", "wanted"),
    [
        # After 1 s the arm is at 95 mm of 300 mm at 100 mm/s, which take 0.1 s to come to.
        ("StopMove;\nWaitTime 5;\nStartMove;", [8.15, 11.25]),
        ("StopMove;\nClearPath;\nStartMove;", [1.0, 2.05]),
        # 95 mm back and forth: 1.05 s each.
        (
            "StopMove;\nStorePath;\npHere:=CRobT(\\Tool:=tGrip\\WObj:=wobj0);\n"
            "MoveL pA, v100, fine, tGrip;\nMoveL pHere, v100, fine, tGrip;\nRestoPath;\nStartMove;",
            [1.0 + 2.1 + 2.15, 8.35],
        ),
    ],
    ids=["stop", "clear", "store"],
)
def test_a_trap_stops_the_arm_on_its_way(trap: str, wanted: list[float]) -> None:
    text = HEAD + "VAR robtarget pHere;\n" + TRAP_CELL.replace("{trap}", trap)
    tree = languages.get("rapid").parse(text)
    assert tree.findings == ()
    kernel = Kernel(motion=Timed(ARM, drive(acceleration=1000.0), A))
    start_task(kernel, (tree,), robot=ARM)
    kernel.at(1.0, lambda: kernel.board.inputs.set("di1", 1.0))
    run = kernel.run()
    assert (run.ended, run.message) == ("end", "")
    assert times(run) == wanted


# ---------------------------------------------------------------------- the same as `simulate`


@pytest.mark.parametrize("alone", [True, False])
@pytest.mark.parametrize("sample", ["rapid/gluing.mod", "rapid/drilling.mod", "melfa/LOADER.prg"])
def test_a_program_takes_as_long_as_simulate_says(sample: str, alone: bool) -> None:
    file = SAMPLES / sample
    program = load(str(file)).program
    kernel: Kernel
    if file.suffix == ".mod":
        kernel = Kernel(motion=Timed(ARM))
        start_task(kernel, (languages.get("rapid").parse(file.read_text()),), robot=ARM)
    else:
        kernel = Kernel(motion=Timed(MELFA))
        start_slot(kernel, (languages.get("melfa-basic-5").parse(file.read_text()),), robot=MELFA)
    if not alone:
        kernel.at(1e6, lambda: None)
    assert kernel.run().ended == "end"
    done = simulate(robots.solve_program(program, ARM if file.suffix == ".mod" else MELFA))
    assert done.duration.least == done.duration.most
    assert kernel.now == pytest.approx(done.seconds, abs=0.001)


@pytest.mark.parametrize("count", [120, 2000])
def test_a_path_takes_as_long_as_simulate_says(count: int) -> None:
    """Of 120 points also where each is planned by itself as the arm comes to it."""
    turn = np.linspace(0.0, 6.0 * np.pi, count)
    points = np.column_stack([400 + 60 * np.cos(turn), 60 * np.sin(turn), 300 + turn])
    path = Path.of(
        "way",
        points,
        [[0.0, 0.0, 1.0, 0.0]] * count,
        kinds=np.array([Kind.JOINT] + [Kind.LINEAR] * (count - 1)),
        speeds=[Speed(100.0)],
        blends=[FINE, Blend(1.0)],
        blend=np.array([0] + [1] * (count - 2) + [0]),
    )
    program = Program("p", (Procedure("main", (Follow(path),)),))
    wanted = simulate(robots.solve_program(program, ARM)).seconds
    for alone in (True, False)[: 2 if count < 1000 else 1]:
        motion = Timed(ARM)
        kernel = Kernel(motion=motion)

        def body(task: Task, motion: Timed = motion) -> Ending:
            for row, (x, y, z) in enumerate(points.tolist()):
                blend = 0.0 if row in (0, count - 1) else 1.0
                moved = line((x, y, z), blend)
                if row == 0:
                    moved = replace(moved, kind="joint")
                motion.go(task, moved)
            return Ending()

        kernel.task("one", body)
        if not alone:
            kernel.at(1e6, lambda: None)
        run = kernel.run()
        assert kernel.now == pytest.approx(wanted, rel=1e-3 if not alone else 1e-6)
        assert all(one.time <= other.time for one, other in pairwise(run.log))


def test_the_track_of_a_run() -> None:
    motion = Timed(ARM, drive(acceleration=1000.0), A)
    main = "MoveL pFar, v100, fine, tGrip;\nSet do1;\nWaitTime 1;"
    kernel, run = rapid(main, motion=motion)
    track = track_of(motion, run.log, kernel.now)
    assert track.t[-1] == pytest.approx(4.1)
    middle = 155
    assert track.t[middle] == pytest.approx(1.55)
    assert track.position[middle] == pytest.approx([400.0, 50.0, 300.0], abs=1e-3)
    assert track.speed[middle] == pytest.approx(100.0)
    assert track.speed[-1] == 0.0
    p, _ = ARM.fk(track.joints)
    assert np.abs(p - track.position).max() < 0.05
    assert track.names == ("do1",)
    assert track.signals[[300, 311], 0].tolist() == [0.0, 1.0]
    assert set(track.columns()) >= {"t", "position", "joints", "signals", "signal_names"}
