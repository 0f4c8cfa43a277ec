"""A small interpreter of MELFA-BASIC IV, V and VI: what a program does, without a controller.

It reads the typed trees and knows the language from its manuals alone: nothing of what lifts or
lowers programs is used, so that it can judge them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from assistant.base.diagnostics import has_errors
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.geometry import Pose
from assistant.virtual.events import Run
from assistant.virtual.kernel import MOST_STEPS, Board, Ending, Kernel, Signals, Task
from assistant.virtual.melfa.arm_state import Arm
from assistant.virtual.melfa.code import code_of
from assistant.virtual.melfa.controller import Controller, Entry
from assistant.virtual.melfa.machine import Machine, call_levels, statement_place
from assistant.virtual.melfa.options import Options
from assistant.virtual.melfa.values import Cell, Failed, Unknown, Value, is_external
from assistant.virtual.melfa.world import (
    STEP_TIME,
    Command,
    Given,
    Inputs,
    World,
    commands_by_name,
    inputs_of,
)

if TYPE_CHECKING:
    from assistant.robots import Robot
    from assistant.virtual.melfa.world import Commands

__all__ = ["Command", "Controller", "Entry", "Given", "Options", "run", "start_slot"]


def run(
    trees: s.File | Sequence[s.File],
    *,
    inputs: Mapping[int, int] | Inputs | None = None,
    robot: Robot | None = None,
    start: Pose | None = None,
    names: Sequence[str] = (),
    most_steps: int = MOST_STEPS,
    options: Options | None = None,
    commands: Commands | None = None,
    repeat: bool = False,
) -> Run:
    """One cycle of a program, from its first line to `End`.

    trees: the program first, then those that it calls. inputs: 0 or 1 by number, the same all the
    time. start: the flange in the robot's base before the first move, None where it is not known.
    names: of the programs, in the order of the trees, where they call each other. most_steps:
    statements after which the run is over. options: what the manuals leave open. commands: by
    name, commands, functions and status variables that are not simulated, or not as they should
    be. repeat: at its end the program begins again (REP), instead of stopping (CYC).

    A wait for an input that does not come ends the run as `stopped`. What the controller would
    refuse it with `error` and its number; what nothing tells, or what is not simulated, with
    `unknown`.
    """
    files = [trees] if isinstance(trees, s.File) else list(trees)
    board = Board(Signals(inputs_of(inputs)))
    kernel = Kernel(board, most_steps=most_steps, statement_time=STEP_TIME)
    start_slot(
        kernel,
        files,
        robot=robot,
        start=start,
        names=names,
        options=options,
        commands=commands,
        repeat=repeat,
    )
    return kernel.run()


def start_slot(
    kernel: Kernel,
    files: Sequence[s.File],
    *,
    slot: int = 1,
    robot: Robot | None = None,
    start: Pose | None = None,
    joints: tuple[float, ...] | None = None,
    names: Sequence[str] = (),
    options: Options | None = None,
    commands: Commands | None = None,
    repeat: bool = False,
    shared: Mapping[str, str] | None = None,
) -> Task:
    """A slot of a controller that runs one cycle of a program; see `run`.

    joints: degrees where it starts, None where they are not known. shared: names that the kernel
    tells values of variables by, by their own in lower case; those without a value are 0.
    """

    def body(task: Task) -> Ending:
        world = World(task, Arm(robot, start, joints))
        world.options, world.commands = options or Options(), commands_by_name(commands)
        standing = None if start is not None else kernel.motion.where()
        if standing is not None:
            world.arm.at_joints(standing[1])
        try:
            machines = [_machine(file, world, {}) for file in files]
            programs = dict(zip((name.upper() for name in names), machines, strict=False))
            for machine in machines:
                machine.programs = programs
            if shared:
                kernel.kept = lambda: _held(machines[0], shared)
            task.where = lambda: statement_place(world)
            task.levels = lambda: call_levels(world)
            machines[0].run()
            while repeat:
                task.step()
                machines[0].run()
        except Failed as failed:
            return Ending("error", str(failed))
        except Unknown as unknown:
            return Ending("unknown", str(unknown))
        return Ending()

    return kernel.task(str(slot), body)


def _held(machine: Machine, names: Mapping[str, str]) -> dict[str, float | str]:
    found: dict[str, float | str] = {}
    for own, name in names.items():
        key = own.upper()
        places = machine.world.shared if is_external(key) else machine.main
        cell = places.places.get(key, places.scope.cell(key))
        kind = cell.kind if isinstance(cell, Cell) else "number"
        value: Value = "" if kind == "text" or key.endswith("$") else 0
        if isinstance(cell, Cell) and not cell.size and cell.is_set():
            value = cell.get()
        if isinstance(value, int | float | str):
            found[name] = value if isinstance(value, str) else float(value)
    return found


def _machine(file: s.File, world: World, programs: Mapping[str, Machine]) -> Machine:
    if has_errors(file.findings):
        raise Failed(4220, "; ".join(f.message for f in file.findings))
    return Machine(code_of(file), world, programs)
