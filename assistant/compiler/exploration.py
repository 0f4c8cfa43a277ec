"""Maps of explored space that grow: by random moves, by recordings, by programs.

Only motion without contact frees space. A program is run to its end, up to a time, or up to the
first contact with a hidden scene; it is refused if it could have run otherwise than simulated.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.compiler.retarget import has_free_turns
from assistant.program.expressions import Number
from assistant.program.statement_index import records_in_procedures
from assistant.program.statements import (
    For,
    Goto,
    If,
    Interrupt,
    Move,
    MoveCircular,
    MoveJoints,
    Opaque,
    Switch,
    Travel,
    While,
)
from assistant.program.vendor_statements import effect_of

if TYPE_CHECKING:
    from assistant.base.arrays import Floats
    from assistant.cell.exploration.explorer import Explorer
    from assistant.cell.exploration.occupancy import Occupancy
    from assistant.cell.scene import Scene
    from assistant.program.program import Program
    from assistant.robots.timing import Simulation
    from assistant.robots.timing.segments import History


@dataclass(frozen=True, slots=True)
class ExplorationRequest:
    """Request for an exploration. cell: file of the cell; robot: its name there, None for the only
    one.

    chart: file of the chart, continued if it exists. size: mm of a cell, None for that of the chart
    or the usual one. thinner: mm that the bodies of the robot are rounder than it, at most.
    """

    cell: FilePath
    chart: FilePath
    robot: str | None = None
    size: float | None = None
    thinner: float = 0.0


@dataclass(frozen=True, slots=True)
class ExplorationResult:
    """Result of an exploration. runs: rows of (runs so far, cells new in them, litres free).

    contacts: number of contacts, and how many of these gave no place.
    """

    occupancy: Occupancy
    runs: tuple[tuple[int, int, float], ...]
    contacts: int
    placeless: int
    findings: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class ExplorationStart:
    """Explorer with its present knowledge; findings of the cell file and of unusable bodies."""

    asked: ExplorationRequest
    explorer: Explorer
    findings: tuple[Diagnostic, ...]


def start_exploration(asked: ExplorationRequest) -> ExplorationStart:
    """Start an exploration.

    Raises Unreadable or Refused for invalid files, a robot that the cell lacks, a chart of another
    robot or of other cells.
    """
    from assistant.cell.cell_file import read_scene
    from assistant.cell.exploration.explorer import CELL_SIZE, Explorer
    from assistant.cell.exploration.occupancy import load_map
    from assistant.cell.findings import OTHER_GRID, WRONG_CELL_SIZE

    scene, findings = read_scene(asked.cell, explored=False)
    known = load_map(asked.chart) if asked.chart.exists() else None
    usual = CELL_SIZE if known is None else known.size
    size = usual if asked.size is None else asked.size
    if known is not None and size != known.size:
        one, other = f"cells of {known.size:g} mm", f"{size:g} mm asked for"
        raise Refused(OTHER_GRID(path=str(asked.chart), one=one, other=other), exit_status=2)
    if not (np.isfinite(asked.thinner) and asked.thinner >= 0.0):
        raise Refused(WRONG_CELL_SIZE(size=f"{asked.thinner:g}"), exit_status=2)
    explorer = Explorer(scene, asked.robot, size, known, asked.thinner)
    return ExplorationStart(asked, explorer, (*findings, *explorer.findings))


def _hidden_scene(begun: ExplorationStart, hidden: FilePath | None) -> Scene:
    """Return the scene that provides contacts: of another cell file, else what is known of the
    cell.

    Raises Refused if the robot there is another one, or has another base.
    """
    from assistant.cell.cell_file import read_scene
    from assistant.cell.exploration.filled_cells import robot_named
    from assistant.cell.findings import OTHER_HIDDEN_ROBOT, STANDS_ELSEWHERE

    explorer = begun.explorer
    if hidden is None:
        return explorer.scene
    scene, _ = read_scene(hidden, explored=False)
    own = explorer.placed
    there = robot_named(scene, own.name)
    files: dict[str, Any] = {"hidden": hidden, "cell": begun.asked.cell}
    if there.robot.name != own.robot.name:
        models: dict[str, Any] = {"other": there.robot.title, "robot": own.robot.title}
        raise Refused(OTHER_HIDDEN_ROBOT(name=own.name, **models, **files), exit_status=2)
    stand = [(placed.name, placed.robot.name) for placed in scene.robots]
    known = [(placed.name, placed.robot.name) for placed in explorer.scene.robots]
    if there.base != own.base or stand != known:
        raise Refused(STANDS_ELSEWHERE(name=own.name, **files), exit_status=2)
    return scene


def contact_test(cell: FilePath, robot: str) -> Callable[[Floats], bool]:
    """Return a function of joints (a,): True if the robot touches something in a cell, or itself.

    robot: its name in the catalogue; other robots of the cell are at home. Raises Refused if the
    cell has no such robot.
    """
    from assistant.cell.cell_file import read_scene
    from assistant.cell.collision.model import Model
    from assistant.cell.findings import NO_EXPLORING_ROBOT

    scene, _ = read_scene(cell, explored=False)
    names = [placed.robot.name for placed in scene.robots]
    if robot not in names:
        raise Refused(
            NO_EXPLORING_ROBOT(name=robot, names=", ".join(names) or "none"), exit_status=2
        )
    model, number = Model(scene), names.index(robot)
    columns = model.carriers.columns[number]
    home = np.concatenate([placed.robot.home for placed in scene.robots])

    def touches(joints: Floats) -> bool:
        row = home.copy()
        row[columns] = joints
        return bool(model.nearest(row[None])[0][0] <= 0.0)

    return touches


def explore_by_random_moves(
    begun: ExplorationStart, hidden: FilePath | None, moves: int, seed: int | None
) -> ExplorationResult:
    """Explore by random moves, each up to the first contact in the hidden scene.

    seed: None for a different one with each run recorded in the chart.
    """
    from assistant.cell.exploration.explorer import in_scene, wander

    explorer = begun.explorer
    scene = _hidden_scene(begun, hidden)
    indicated = in_scene(scene, next(p for p in scene.robots if p.name == explorer.placed.name))
    draw = np.random.default_rng(explorer.occupancy.runs if seed is None else seed)
    joints, done, contacts, placeless = None, 0, 0, 0
    rows = []
    for wanted in _reporting_steps(moves):
        part = int(draw.integers(1 << 31))
        found = wander(explorer, indicated, wanted - done, seed=part, start=joints)
        done, joints = wanted, found.joints
        contacts, placeless = contacts + found.contacts, placeless + found.placeless
        rows.append((done, found.new, explorer.occupancy.litres))
    return ExplorationResult(explorer.occupancy, tuple(rows), contacts, placeless, begun.findings)


def _reporting_steps(moves: int) -> Iterator[int]:
    """Yield the numbers of moves after which progress is reported: an eighth, a quarter, the half,
    all.
    """
    yield from sorted({max(moves * part // 8, 1) for part in (1, 2, 4, 8)})


def explore_by_recordings(
    begun: ExplorationStart, recordings: Sequence[FilePath], contact: str | None
) -> ExplorationResult:
    """Explore by recordings of joints; contact: the input among them that is not 0 in contact."""
    from assistant.cell.exploration.recordings import read_recording

    explorer, found = begun.explorer, list(begun.findings)
    contacts, rows = 0, []
    for path in recordings:
        recording = read_recording(path, explorer.placed.robot, contact)
        found += recording.findings
        new = _freed_cells(explorer, recording.runs)
        contacts += recording.contacts
        rows.append((len(recording.runs), new, explorer.occupancy.litres))
    return ExplorationResult(explorer.occupancy, tuple(rows), contacts, contacts, tuple(found))


def learn_from_runs(
    begun: ExplorationStart, runs: Sequence[Floats], contacts: int
) -> ExplorationResult:
    """Learn from runs of joints (n, a) without contact, recorded while the arm moved."""
    explorer = begun.explorer
    new = _freed_cells(explorer, runs)
    rows = ((len(runs), new, explorer.occupancy.litres),)
    return ExplorationResult(explorer.occupancy, rows, contacts, contacts, begun.findings)


def _freed_cells(explorer: Explorer, runs: Sequence[Floats]) -> int:
    """Free the cells of runs of joints (n, a) of the explorer's robot; returns the new ones."""
    new = 0
    for run in runs:
        joints = np.tile(explorer.home, (len(run), 1))
        joints[:, explorer.filler.columns] = run
        new += explorer.gone(joints)
    return new


def _check_single_course(program: Program, simulation: Simulation) -> None:
    """Raises Refused, at the statement, for a program that may have gone otherwise than simulated.

    program: as it was read. Only a program that always goes one way tells where it has been.
    """
    from assistant.cell.findings import MANY_PATHS

    doubt = next(_course_doubts(program), None)
    beside = {id(one.plan) for one in simulation.passed} - set(_plan_ids(simulation.history))
    duration = simulation.duration
    if doubt is not None or beside or not math.isclose(duration.least, duration.most):
        raise Refused(MANY_PATHS(span=getattr(doubt, "span", None)))


def _course_doubts(program: Program) -> Iterator[object]:
    """Yield the records that make the course of a program, or its targets, vary between runs."""
    yield from records_in_procedures(program, If, Switch, While, Goto, Interrupt, Travel)
    for loop in records_in_procedures(program, For):
        step = () if loop.step is None else (loop.step,)
        if not all(isinstance(one, Number) for one in (loop.first, loop.last, *step)):
            yield loop
    for move in records_in_procedures(program, Move, MoveCircular, MoveJoints):
        if isinstance(move, Move | MoveCircular | MoveJoints) and move.until is not None:
            yield move
    for kept in records_in_procedures(program, Opaque):
        effect = effect_of(kept)
        if effect.jumps or effect.moves or effect.calls:
            yield kept
    if has_free_turns(program):
        yield program


def _plan_ids(history: History | None) -> Iterator[int]:
    for node in () if history is None else history.chain():
        if isinstance(node.done, tuple):
            yield from _plan_ids(node.done[0])
        else:
            yield id(node.done)


def explore_by_program(
    begun: ExplorationStart,
    program: Program,
    simulation: Simulation,
    until: float | None,
    hidden: FilePath | None,
) -> ExplorationResult:
    """Explore by a program that ran: to its end, up to a time, or as a hidden scene lets it.

    program: as it was read. Raises Refused if it is for another robot, or may have run differently.
    """
    from assistant.cell.findings import NO_EXPLORING_ROBOT

    _check_single_course(program, simulation)

    explorer = begun.explorer
    scene = None if hidden is None else _hidden_scene(begun, hidden)
    before = int(explorer.occupancy.touched.sum())
    try:
        new = explorer.ran(simulation, until, scene)
    except LookupError:
        names = ", ".join(placed.name for placed in explorer.scene.robots)
        raise Refused(
            NO_EXPLORING_ROBOT(name=simulation.robot.name, names=names), exit_status=2
        ) from None
    contacts = int(explorer.occupancy.touched.sum()) - before
    rows = ((1, new, explorer.occupancy.litres),)
    return ExplorationResult(explorer.occupancy, rows, contacts, 0, begun.findings)
