"""A cycle of a RAPID program, told as events."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Final

from assistant.base.diagnostics import has_errors
from assistant.languages.rapid.tree import syntax as s
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.virtual.events import Run
from assistant.virtual.kernel import MOST_STEPS, Board, Ending, Kernel, Signals, Task
from assistant.virtual.kernel.signals import Source
from assistant.virtual.rapid.arm import Arm
from assistant.virtual.rapid.calls import call_routine
from assistant.virtual.rapid.controller import Controller, Kind
from assistant.virtual.rapid.ends import Cycled, Fault, NotSimulated, Over
from assistant.virtual.rapid.expressions import settled
from assistant.virtual.rapid.functions import FUNCTIONS
from assistant.virtual.rapid.given import Ability, as_function
from assistant.virtual.rapid.instructions import INSTRUCTIONS
from assistant.virtual.rapid.loading import load_modules, used_signals
from assistant.virtual.rapid.looking import call_levels
from assistant.virtual.rapid.machine import Abilities, Machine
from assistant.virtual.rapid.predefined import predefined
from assistant.virtual.rapid.scopes import Cell, Frame, Known, Unit
from assistant.virtual.rapid.signals import Signals as OwnSignals
from assistant.virtual.rapid.traps import run_trap
from assistant.virtual.rapid.types import Types

ABILITIES: Final = Abilities(FUNCTIONS, INSTRUCTIONS, call_routine)
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

    modules: parsed, of one task. inputs: what each input reads, by name in lower case; of a
    table those that are not 0. They stay as they are: a wait for another value ends the run as
    `stopped`. robot: the arm, without which a motion to joints ends nowhere that is known.
    start: the flange in the base before the first motion, None where it is not known.
    controller: what tasks share, and what differs between controllers; a new one if there is none.
    abilities: instructions and functions of an option or an add-in, by name; see the package.
    most_cycles: if more than one, as in continuous running, where the run is over behind them.
    Motions take no time, and outputs are 0 before they are set.
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
    task = kernel.task(name, lambda _: ending(), essential=kind == "normal")
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
    task.where, task.levels = machine.place, lambda: call_levels(machine)
    shared.tasks.append(task)
    cells: list[Cell] = []

    def prepare() -> None:
        if any(has_errors(file.findings) for file in files):
            raise Fault("the text of a module has errors")
        loaded = load_modules(files, machine.types, shared.persistents)
        machine.named, machine.modules = dict(loaded.named), dict(loaded.units)
        cells.extend(loaded.cells)
        shared.programs.append((loaded, machine.types))

    wrong = _ending(machine, prepare)
    if made is not None:
        made(machine)
    turns, once = cycles or _initial_pose(entry, kind), cycles is None and kind == "normal"

    def ending() -> Ending:
        try:
            ended = wrong or _ending(machine, lambda: _begin_cycle(machine, cells, turns, once))
        finally:
            for end in machine.at_end:
                end()
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
        if ran:
            machine.task.step()
        ran = True
        return entry

    return cycles


def _with_abilities(own: Mapping[str, Ability]) -> Abilities:
    """What every controller can do, and what is its own."""
    if not own:
        return ABILITIES
    added = {name.lower(): as_function(does) for name, does in own.items()}
    return Abilities({**FUNCTIONS, **added}, {**INSTRUCTIONS, **added}, call_routine)


def _ending(machine: Machine, does: Callable[[], None]) -> Ending | None:
    """None if it goes to its own end."""
    try:
        does()
    except Fault as fault:
        return Ending("error", _messages(machine, str(fault)))
    except NotSimulated as unknown:
        return Ending("unknown", _messages(machine, str(unknown)))
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
    return message if place is None else f"{place[0]}:{place[1]}: {message}".lstrip(":")
