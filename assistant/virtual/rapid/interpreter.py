"""Run the tasks of RAPID programs, with all instructions and functions that are simulated.

`run` runs one task, `run_tasks` several tasks of one controller; `start_task` starts one in a
kernel. The tables have the names of built-in instructions and functions in lower case.
`_call_levels` lists the calls and data of a held program for a debugger.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import has_errors
from assistant.languages.rapid.tree import syntax as s
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.virtual.events import Run
from assistant.virtual.kernel import MOST_STEPS, Board, Ending, Kernel, Motion, Signals, Task
from assistant.virtual.kernel.kernel import Instant, Source
from assistant.virtual.kernel.script import Script, follow
from assistant.virtual.kernel.task import Level, Shown
from assistant.virtual.program_run import BUSY_TIME
from assistant.virtual.rapid import (
    dialogs,
    files,
    handlers,
    late_binding,
    motion,
    positions,
    run_state,
    scalar_functions,
    signals_and_waits,
    sockets,
    special_moves,
)
from assistant.virtual.rapid.call_arguments import Ability, as_function
from assistant.virtual.rapid.control_flow import Cycled, Fault, NotSimulated, Over
from assistant.virtual.rapid.controller import Controller, Kind, load_modules, used_signals
from assistant.virtual.rapid.expressions import settled
from assistant.virtual.rapid.handlers import run_trap
from assistant.virtual.rapid.machine import Abilities, Arm, Function, Machine, place_of
from assistant.virtual.rapid.machine import Signals as OwnSignals
from assistant.virtual.rapid.records import predefined
from assistant.virtual.rapid.scopes import Cell, Frame, Known, Meaning, Place, Types, Unit
from assistant.virtual.rapid.statements import call_routine
from assistant.virtual.rapid.values import (
    Array,
    Clock,
    Handle,
    Record,
    Shape,
    Trigger,
    Value,
    text_of,
)

_INSTRUCTIONS: Final[Mapping[str, Function]] = {
    **motion.MOTION_INSTRUCTIONS,
    **signals_and_waits.SIGNAL_INSTRUCTIONS,
    **run_state.RUN_INSTRUCTIONS,
    **special_moves.PROCESS_INSTRUCTIONS,
    **motion.DISPLACEMENT_INSTRUCTIONS,
    **handlers.ERROR_INSTRUCTIONS,
    **files.FILE_INSTRUCTIONS,
    **dialogs.DIALOG_INSTRUCTIONS,
    **handlers.INTERRUPT_INSTRUCTIONS,
    **sockets.RAW_INSTRUCTIONS,
    **sockets.SOCKET_INSTRUCTIONS,
    **special_moves.SEARCH_INSTRUCTIONS,
    **special_moves.STOP_INSTRUCTIONS,
    **signals_and_waits.TASK_INSTRUCTIONS,
    **signals_and_waits.WAIT_INSTRUCTIONS,
    **late_binding.NAME_INSTRUCTIONS,
    **late_binding.MODULE_INSTRUCTIONS,
}


_FUNCTIONS: Final[Mapping[str, Function]] = {
    **scalar_functions.NUMBER_FUNCTIONS,
    **scalar_functions.BIT_FUNCTIONS,
    **scalar_functions.STRING_FUNCTIONS,
    **positions.POSE_FUNCTIONS,
    **positions.ARM_FUNCTIONS,
    **positions.FRAME_FUNCTIONS,
    **run_state.RUN_FUNCTIONS,
    **run_state.DATE_FUNCTIONS,
    **dialogs.DIALOG_FUNCTIONS,
    **files.FILE_FUNCTIONS,
    **late_binding.MODULE_FUNCTIONS,
    **sockets.RAW_FUNCTIONS,
    **sockets.SOCKET_FUNCTIONS,
    **special_moves.STOP_FUNCTIONS,
    **signals_and_waits.TASK_FUNCTIONS,
}


def _call_levels(machine: Machine) -> list[Level]:
    """The routines that run, the innermost first."""
    at, found = machine.at, []
    for frame in reversed(machine.frames):
        if frame.routine is not None:
            found.append(Level(frame.routine.name, place_of(at), _data_groups(machine, frame)))
        # The caller is shown where it calls, not at its own first line.
        at = frame.called_at
    return found


def _data_groups(machine: Machine, frame: Frame) -> Mapping[str, Callable[[], Sequence[Shown]]]:
    return {
        "Routine": lambda: list(_shown_data(frame.names)),
        "Module": lambda: list(_shown_data(frame.unit.names)),
        "Task": lambda: list(_shown_data(machine.named)),
    }


# Parameters by reference are places in data of the caller.
def _shown_data(names: Mapping[str, Meaning]) -> Iterator[Shown]:
    for name, meaning in names.items():
        match meaning:
            case Cell(shape=shape, value=value):
                yield _shown_value(name, value, shape)
            case Place(holder=holder, shape=shape):
                # Data without a first value cannot be read; asking for it would end the run.
                known = holder.value is not None if isinstance(holder, Cell) else True
                yield _shown_value(name, meaning.get() if known else None, shape)


def _shown_value(name: str, value: Value | None, shape: Shape) -> Shown:
    kind = shape.type + "".join(f"{{{size}}}" for size in shape.sizes)
    match value:
        case None:
            return Shown(name, "", kind)
        case Record(parts=parts):
            inside = [_shown_value(key, part, Shape("")) for key, part in parts.items()]
        case Array(items):
            inside = [
                _shown_value(f"{{{i}}}", item, shape.element) for i, item in enumerate(items, 1)
            ]
        case Clock() | Trigger() | Handle():
            return Shown(name, f"<{kind}>", kind)
        case _:
            return Shown(name, text_of(value), kind)
    return Shown(name, _value_text(value), kind, lambda: inside)


def _value_text(value: Value) -> str:
    """Return the text of a value as ValToStr writes it; a placeholder for other values."""
    try:
        return text_of(value)
    except ValueError:
        return "<no value>"


_ABILITIES: Final = Abilities(_FUNCTIONS, _INSTRUCTIONS, call_routine)
Inputs = Source


def run(
    modules: s.File | Sequence[s.File],
    inputs: Inputs | None = None,
    robot: Robot | None = None,
    entry: str = "main",
    most_steps: int = MOST_STEPS,
    start: Pose | None = None,
    controller: Controller | None = None,
    abilities: Mapping[str, Ability] | None = None,
    most_cycles: int = 1,
) -> Run:
    """Runs one cycle of a program, from the call of its first routine to the end of that.

    modules: parsed, of one task. inputs: values of the inputs, by name in lower case; a table has
    those that are not 0. They stay unchanged: a wait for another value ends the run as `stopped`.
    robot: the arm; without it the end of a motion to joints is unknown. start: the flange in the
    base before the first motion, None if unknown. controller: data that tasks share, and
    differences between controllers; a new one by default. abilities: instructions and functions of
    an option or an add-in, by name; see the package. most_cycles: if more than one, as in
    continuous running, the run is over after them. Motions take no time, and outputs are 0 before
    they are set.
    """
    files = (modules,) if isinstance(modules, s.File) else tuple(modules)
    board = Board(Signals({} if inputs is None else inputs))
    kernel = Kernel(board, most_steps=most_steps)
    start_task(
        kernel,
        files,
        robot=robot,
        entry=entry,
        start=start,
        controller=controller,
        abilities=abilities,
        cycles=again_and_again(entry, most_cycles) if most_cycles > 1 else None,
    )
    return kernel.run()


def start_task(
    kernel: Kernel,
    files: Sequence[s.File],
    *,
    name: str = "T_ROB1",
    robot: Robot | None = None,
    entry: str = "main",
    start: Pose | None = None,
    joints: tuple[float, ...] | None = None,
    controller: Controller | None = None,
    kind: Kind = "normal",
    moves: bool | None = True,
    abilities: Mapping[str, Ability] | None = None,
    made: Callable[[Machine], None] | None = None,
    cycles: Cycles | None = None,
) -> Task:
    """A task of a controller that runs one cycle of a program; see `run`.

    joints: degrees where it starts, None where they are not known.
    kind: of others than `normal` ones the program runs again and again, until those have ended.
    moves: whether the task has a robot. All tasks are to be there before the kernel runs.
    made: is given the machine at once, whose data has not got its first values yet. cycles: is
    asked for the routine of each cycle, in the task, where it may wait; None ends the task.
    """
    shared = controller or Controller()
    # The task is made before its machine: `ending` below is only looked up when the task runs.
    task = kernel.task(name, lambda _: ending(), essential=kind == "normal")
    # All tasks share the names, so that one reads as an output what another one sets.
    outputs, known = used_signals(files)
    shared.outputs |= outputs
    shared.known |= known
    machine = Machine(
        task,
        _with_abilities(abilities or {}),
        Types(),
        OwnSignals(task, shared.outputs, shared.known),
        Arm(start or _standing_arm(kernel), joints),
        robot,
        predefined=predefined(robot),
        controller=shared,
        moves=moves,
    )
    machine.interrupts.run = partial(run_trap, machine)
    task.where, task.levels = machine.place, lambda: _call_levels(machine)
    shared.tasks.append(task)
    cells: list[Cell] = []

    def prepare() -> None:
        if any(has_errors(file.findings) for file in files):
            raise Fault("the text of a module has errors")
        loaded = load_modules(files, machine.types, shared.persistents)
        machine.named, machine.modules = dict(loaded.named), dict(loaded.units)
        cells.extend(loaded.cells)
        shared.programs.append((loaded, machine.types))

    # Errors of loading are held back until the task runs, so that each becomes the run's ending.
    wrong = _ending(machine, prepare)
    if made is not None:
        made(machine)
    # ExitCycle begins the next cycle where there is one; a normal single cycle ends with it.
    turns, once = cycles or _initial_pose(entry, kind), cycles is None and kind == "normal"

    def ending() -> Ending:
        try:
            ended = wrong or _ending(machine, lambda: _begin_cycle(machine, cells, turns, once))
        finally:
            # Also after an error: sockets and files stay open otherwise.
            for end in machine.at_end:
                end()
        # The last statement may have changed data that another task watches.
        machine.look()
        return ended or Ending()

    return task


Cycles = Callable[[Machine], str | None]


def again_and_again(entry: str, most: int) -> Cycles:
    """One cycle behind the other, until there have been so many."""
    one = _initial_pose(entry, "static")
    count = 0

    def cycles(machine: Machine) -> str | None:
        nonlocal count
        count += 1
        if count > most:
            raise Over("steps", f"more than {most} cycles")
        return one(machine)

    return cycles


def _initial_pose(entry: str, kind: Kind) -> Cycles:
    """One cycle of a normal task, cycles without end of another."""
    ran = False

    def cycles(machine: Machine) -> str | None:
        nonlocal ran
        if ran and kind == "normal":
            return None
        # A cycle without statements would repeat without end, and never let other tasks run.
        if ran:
            machine.task.step()
        ran = True
        return entry

    return cycles


def _with_abilities(own: Mapping[str, Ability]) -> Abilities:
    """Return the abilities of every controller, and those of this one."""
    if not own:
        return _ABILITIES
    added = {name.lower(): as_function(does) for name, does in own.items()}
    return Abilities({**_FUNCTIONS, **added}, {**_INSTRUCTIONS, **added}, call_routine)


def _ending(machine: Machine, does: Callable[[], None]) -> Ending | None:
    """None if it goes to its own end."""
    try:
        does()
    except Fault as fault:
        return Ending("error", _messages(machine, str(fault)))
    except NotSimulated as unknown:
        return Ending("unknown", _messages(machine, str(unknown)))
    # Python's own limit; a controller may go deeper, so that this is no error of the program.
    except RecursionError:
        return Ending("unknown", _messages(machine, "statements nested so deep"))
    except Over as over:
        return Ending(over.ended, _messages(machine, str(over)) if str(over) else "")
    return None


def _standing_arm(kernel: Kernel) -> Pose | None:
    """The flange where the arm stands, where its motion tells."""
    standing = kernel.motion.where()
    return None if standing is None else standing[0]


def _begin_cycle(machine: Machine, cells: Sequence[Cell], cycles: Cycles, once: bool) -> None:
    """Every datum of a module has its value before the first statement.

    One of what is not simulated ends the run only when something asks for it. once: whether
    ExitCycle ends the task.
    """
    unit = Unit(None)
    machine.frames.append(Frame(unit, None))
    for cell in cells:
        with suppress(NotSimulated):
            settled(machine, cell)
    while (entry := cycles(machine)) is not None:
        first = machine.meaning(entry)
        if not isinstance(first, Known):
            raise Fault(f"there is no routine `{entry}` to begin with")
        try:
            machine.abilities.call(machine, first, ())
        except Cycled:
            if once:
                raise


def _messages(machine: Machine, message: str) -> str:
    """The message with the place of the statement at hand."""
    place = machine.place()
    # Without a file, `:12: ` would begin with a colon.
    return message if place is None else f"{place[0]}:{place[1]}: {message}".lstrip(":")


STATEMENT_TIME: Final = 0.0001
"""Seconds that a statement may be taken to last in a run with motions that take time: a guess, for
no reference at hand states a figure. The controllers vary with their load.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskProgram:
    """modules: parsed. kind, moves: see `start_task`."""

    name: str
    modules: Sequence[s.File]
    kind: Kind = "normal"
    entry: str = "main"
    moves: bool | None = None


def run_tasks(
    tasks: Sequence[TaskProgram],
    inputs: Inputs | None = None,
    robot: Robot | None = None,
    *,
    motion: Motion | None = None,
    script: Script | None = None,
    statement_time: float = 0.0,
    pace: float | None = None,
    most_steps: int = MOST_STEPS,
    most_time: float = math.inf,
    start: Pose | None = None,
    controller: Controller | None = None,
) -> Run:
    """Runs one cycle of the normal tasks, and the others again and again until those have ended.

    inputs, robot, start, controller: as `run` has them. motion: how the arm follows, None where
    motions take no time. script: inputs that change and answers to what programs ask.
    statement_time: seconds that each statement takes, see `STATEMENT_TIME`. pace, most_time: of
    the simulated clock, see `Kernel`.
    """
    happens = script or Script()
    if inputs is None:
        # Without an input of its own, each signal that the script changes begins at 0.
        inputs = dict.fromkeys((change.name for change in happens.changes), 0.0)
    kernel = Kernel(
        Board(Signals(inputs)),
        motion=motion or Instant(),
        most_steps=most_steps,
        most_time=most_time,
        statement_time=statement_time,
        busy_time=BUSY_TIME,
        pace=pace,
    )
    shared = controller or Controller()
    for task in tasks:
        start_task(
            kernel,
            task.modules,
            name=task.name,
            robot=robot,
            entry=task.entry,
            start=start,
            controller=shared,
            kind=task.kind,
            moves=task.moves,
        )
    sources = [tree.source for task in tasks for tree in task.modules if tree.source is not None]
    follow(kernel, happens, sources)
    return kernel.run()
