"""Ways through three cells, beside OMPL as it comes: `python -m benchmarks --only planning`.

OMPL as it comes: RRTConnect to the one branch of the arm that is nearest, moves looked at in steps
of 1 % of the space (its own default), then its own simplification. Its ways are then looked at
between the steps as well. Both have the same model of the cell and the same margins.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.cell.planning.path_search import planner_library
from assistant.cell.planning.planner import plan
from assistant.cell.planning.program_moves import check_route
from assistant.cell.planning.space import Space, goal_joints
from assistant.cell.scene import Scene
from benchmarks.cells import ARM, CELLS, TIP, Problem, problems

COUNTS: Final = {"shelf": 34, "window": 33, "two robots": 33}
SECONDS: Final = 30.0
"""Of a search, at most."""


@dataclass(frozen=True, slots=True)
class Way:
    """seconds: all of it took. length: seconds of its axes. clear: between its rows, too. lines:
    the share of its moves that are straight lines of the tip.
    """

    seconds: float
    length: float
    clear: bool
    lines: float = 0.0


def ours(scene: Scene, problem: Problem, *, linear: bool = False) -> Way | None:
    begun = time.perf_counter()
    try:
        way = plan(
            scene,
            problem.start,
            problem.goal,
            robot="arm",
            tool=TIP,
            others=problem.others,
            linear=linear,
            seconds=SECONDS,
        )
    except Refused:
        return None
    done = time.perf_counter() - begun
    space = Space(scene, scene.robots[0], others=problem.others, tool=TIP)
    clear = check_route(space, way.route).good  # as a controller goes it, corners and all
    return Way(done, way.length, clear, float(way.linear.mean()))


def lines(scene: Scene, problem: Problem) -> Way | None:
    return ours(scene, problem, linear=True)


def plain(scene: Scene, problem: Problem) -> Way | None:
    """OMPL as it comes."""
    begun = time.perf_counter()
    space = Space(scene, scene.robots[0], others=problem.others, tool=TIP)
    goals = goal_joints(ARM, problem.goal, problem.start, TIP)
    base, geometric, util = planner_library()
    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(1)
    room = base.RealVectorStateSpace(len(ARM.axes))
    bounds = base.RealVectorBounds(len(ARM.axes))
    for axis, (low, high) in enumerate(ARM.limits.tolist()):
        bounds.setLow(axis, low)
        bounds.setHigh(axis, high)
    room.setBounds(bounds)
    setup = geometric.SimpleSetup(room)

    def free(state: Any) -> bool:
        return bool(space.free(_row(state)[None])[0])

    setup.setStateValidityChecker(free)
    info = setup.getSpaceInformation()
    setup.setStartAndGoalStates(_state(info, problem.start), _state(info, goals[0]))
    setup.setPlanner(geometric.RRTConnect(info))
    setup.solve(SECONDS)
    if not setup.haveExactSolutionPath():
        return None
    setup.simplifySolution()
    rows = np.array([_row(state) for state in setup.getSolutionPath().getStates()])
    done = time.perf_counter() - begun
    length = float(np.linalg.norm(np.diff(rows, axis=0) / ARM.speeds, axis=1).sum())
    return Way(done, length, not space.hits(rows))


def _row(state: Any) -> Floats:
    return np.array([state[axis] for axis in range(len(ARM.axes))])


def _state(info: Any, row: Floats) -> Any:
    state = info.allocState()
    for axis, value in enumerate(row.tolist()):
        state[axis] = value
    return state


WAYS: Final = (("ours", ours), ("ours, on lines", lines), ("OMPL as it comes", plain))


def report(share: float = 1.0) -> None:
    """share: of the 100 problems."""
    print("\nPlanning: a known free way, of which only start and goal are told")
    for cell, count in COUNTS.items():
        scene = CELLS[cell]()
        some = list(problems(cell, scene, max(1, round(share * count)), seed=1))
        for name, way_of in WAYS:
            print(f"  {cell:12}{name:18}{_said([way_of(scene, one) for one in some])}", flush=True)


def _said(ways: Sequence[Way | None]) -> str:
    found = [way for way in ways if way is not None and way.seconds < SECONDS]
    if not found:
        return f"0 of {len(ways)} found in {SECONDS:g} s"
    seconds = np.array([way.seconds for way in found])
    share = np.mean([way.lines for way in found])
    on_lines = f", {share:.0%} of the moves lines" if share else ""
    return (
        f"{len(found)} of {len(ways)} found, {sum(way.clear for way in found)} clear, median "
        f"{np.median(seconds):.2f} s, longest {seconds.max():.2f} s; median length "
        f"{np.median([way.length for way in found]):.2f} s of the axes{on_lines}"
    )


if __name__ == "__main__":
    report()
