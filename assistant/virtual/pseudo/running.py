"""A cycle of a pseudo-program, told as events."""

from __future__ import annotations

from typing import Final

from assistant.base.source_text import SourceText
from assistant.program.geometry import Pose
from assistant.program.program import Program
from assistant.robots import Robot
from assistant.virtual.kernel import Ending, Kernel, Task
from assistant.virtual.pseudo.data import Cell, first_value
from assistant.virtual.pseudo.ends import Fault, NotRun, Over
from assistant.virtual.pseudo.expressions import evaluate
from assistant.virtual.pseudo.interrupts import Interrupts
from assistant.virtual.pseudo.machine import Machine
from assistant.virtual.pseudo.statements import call, call_statement

TASK_NAME: Final = "program"
"""Of its task."""


def start_program(
    kernel: Kernel,
    program: Program,
    *,
    robot: Robot | None = None,
    start: Pose | None = None,
    text: SourceText | None = None,
    cycles: int = 1,
) -> Task:
    """A task that runs one cycle of a program, from the call of its first procedure to its end.

    robot: the arm, without which a motion to joints ends nowhere that is known. start: the flange
    in the base before the first motion. text: that the program was read from, for places in it.
    cycles: how often that procedure is called; if more than once, the run is over behind them.
    """

    def body(task: Task) -> Ending:
        machine = Machine(task, program, robot, text, flange=start)
        machine.interrupts = Interrupts(machine, lambda node: call_statement(machine, node))
        task.where, task.levels = machine.where, machine.levels
        try:
            _declare_variables(machine)
            entry = program.procedure(program.entry) if program.entry else None
            if entry is None:
                raise Fault("the program has no procedure to begin with")
            call(machine, entry, ())
            for _ in range(cycles - 1):
                task.step()
                call(machine, entry, ())
        except Fault as fault:
            return Ending("error", str(fault))
        except NotRun as unknown:
            return Ending("unknown", str(unknown))
        except RecursionError:
            return Ending("unknown", "statements nested so deep")
        except Over:
            return Ending()
        return Ending() if cycles == 1 else Ending("steps", f"more than {cycles} cycles")

    return kernel.task(TASK_NAME, body)


def _declare_variables(machine: Machine) -> None:
    """The program's targets and variables with their first values."""
    program, shared = machine.program, machine.shared
    for name, target in program.targets.items():
        shared[name.lower()] = Cell(target)
    for name, joints in program.joint_targets.items():
        shared[name.lower()] = Cell(joints)
    for name, variable in program.variables.items():
        first = None if variable.initial is None else evaluate(machine, variable.initial)
        constant = variable.storage == "constant"
        shared[name.lower()] = Cell(first_value(variable, first), constant)
    for name, tool in program.tools.items():
        shared.setdefault(name.lower(), Cell(tool.tip))
    for name, frame in program.frames.items():
        shared.setdefault(name.lower(), Cell(frame.pose))
