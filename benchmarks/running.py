"""Cases: counting loops of both interpreters beside the same loop in CPython; motions in time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from assistant import languages, robots
from assistant.virtual.kernel import Kernel
from assistant.virtual.kernel.timed_arm import Timed
from assistant.virtual.melfa import start_slot
from assistant.virtual.rapid.interpreter import start_task
from benchmarks.reading import Reading

ROUNDS: Final = 50_000
MOVES: Final = 10_000
RAPID_ARM, MELFA_ARM = "irb1200-7-0.7", "rv-4frl"
RAPID_LOOP: Final = """MODULE m
VAR num n:=0;
PROC main()
    WHILE n<{rounds} DO
        n:=n+1;
    ENDWHILE
ENDPROC
ENDMODULE
"""
MELFA_LOOP: Final = "1 M1=0\n2 While M1<{rounds}\n3 M1=M1+1\n4 WEnd\n5 End\n"
PYTHON_LOOP: Final = "n = 0\nwhile n < {rounds}:\n    n = n + 1\n"


def rapid(text: str, timed: bool) -> Kernel:
    arm = robots.get(RAPID_ARM)
    kernel = _kernel(arm, timed)
    start_task(kernel, (languages.get("rapid").parse(text),), robot=arm)
    return kernel


def melfa(text: str, timed: bool) -> Kernel:
    arm = robots.get(MELFA_ARM)
    kernel = _kernel(arm, timed)
    start_slot(kernel, (languages.get("melfa-basic-5").parse(text),), robot=arm)
    return kernel


def _kernel(arm: robots.Robot, timed: bool) -> Kernel:
    kernel = Kernel(most_steps=10_000_000)
    if timed:
        kernel.motion = Timed(arm)
    return kernel


def counting(start: Callable[[str, bool], Kernel], text: str) -> Callable[[int], Kernel]:
    return lambda statements: start(text.format(rounds=statements // 2), False)


def run(kernel: Kernel) -> float:
    """How many statements it ran."""
    _finish(kernel)
    return float(kernel.steps)


def moved(kernel: Kernel) -> float:
    """How many seconds it simulated."""
    _finish(kernel)
    return kernel.now


def _finish(kernel: Kernel) -> None:
    done = kernel.run()
    if done.ended != "end":
        raise SystemExit(f"the run ended as `{done.ended}` {done.message}")


def python_loop(statements: int) -> str:
    return PYTHON_LOOP.format(rounds=statements // 2)


def python_run(text: str) -> None:
    exec(text, {})


def places(n: int) -> np.ndarray:
    """(n, 3) mm, a coil in front of the arm."""
    turn = np.linspace(0.0, 20.0 * np.pi, n)
    return np.column_stack([400 + 60 * np.cos(turn), 60 * np.sin(turn), 380 + turn])


def rapid_moves(n: int, beside: bool = False) -> Kernel:
    rest = "[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v200"
    lines = [f"MoveL [[{x:.3f},{y:.3f},{z:.3f}],{rest},z1,tool0;" for x, y, z in places(n)]
    lines[0] = lines[0].replace("MoveL", "MoveJ").replace("z1", "fine")
    lines[-1] = lines[-1].replace("z1", "fine")
    text = "MODULE m\nPROC main()\n" + "\n".join(lines) + "\nENDPROC\nENDMODULE\n"
    kernel = rapid(text, True)
    if beside:
        kernel.at(1e6, lambda: None)
    return kernel


def melfa_moves(n: int) -> Kernel:
    lines = ["Spd 200", "Mov P1", "Cnt 1,1,1"]
    lines += [f"Mvs P{i}" for i in range(2, n + 1)]
    points = [
        f"P{i}=({x:+.2f},{y:+.2f},{z:+.2f},+180.00,+0.00,+180.00)(7,0)"
        for i, (x, y, z) in enumerate(places(n), 1)
    ]
    numbered = [f"{number} {line}" for number, line in enumerate([*lines, "End"], 1)]
    return melfa("\n".join([*numbered, *points]) + "\n", True)


RUNNING: Final[dict[str, Reading]] = {
    "counting loop, CPython": Reading((python_loop, python_run), (2 * ROUNDS,), "statements"),
    "counting loop, RAPID": Reading(
        (counting(rapid, RAPID_LOOP), run), (2 * ROUNDS,), "statements"
    ),
    "counting loop, MELFA-BASIC": Reading(
        (counting(melfa, MELFA_LOOP), run), (2 * ROUNDS,), "statements"
    ),
    "moves of RAPID": Reading((rapid_moves, moved), (MOVES,), "simulated seconds"),
    "moves of MELFA-BASIC": Reading((melfa_moves, moved), (MOVES,), "simulated seconds"),
    "moves of RAPID, each as the arm comes to it": Reading(
        (lambda n: rapid_moves(n, beside=True), moved), (MOVES // 10,), "simulated seconds"
    ),
}
