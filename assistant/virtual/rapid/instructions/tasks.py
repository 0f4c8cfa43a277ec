"""Tasks that wait for each other, and share what only one of them may use at a time.

Instructions manual, WaitSyncTask, WaitTestAndSet, TestAndSet, TaskRunRob, GetTaskName.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid import poses
from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.expressions import place
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.values import Array, Record


def _wait_for_tasks(given: Given) -> None:
    """Until every task of the list has come as often as this one to the point of that name."""
    machine = given.machine
    if given.has("inpos"):
        machine.settle()
    point = given.required[0]
    if not isinstance(point, s.NameRef):
        raise NotSimulated("a synchronization point that is no variable by its name")
    name, own = point.name.lower(), machine.task.name.lower()
    names = _task_names(given, 1)
    if own not in names:
        raise Fault(f"`{machine.task.name}` waits for tasks and is not in their list")
    come = machine.controller.come
    turn = come[name, own] = come.get((name, own), 0) + 1
    what = f"`{point.name}`, to which not all of {', '.join(names)} come"

    def all_there() -> bool:
        return all(come.get((name, task), 0) >= turn for task in names)

    if not machine.task.wait(all_there, given.optional_number("timeout"), what):
        come[name, own] -= 1
        raise Fault(f"{what} in time", "ERR_WAITSYNCTASK")


def _task_names(given: Given, index: int) -> list[str]:
    listed = given.place(index).get()
    items = listed.items if isinstance(listed, Array) else ()
    tasks = [poses.record(item, "tasks") for item in items if isinstance(item, Record)]
    return [poses.text(task.parts["taskname"]).lower() for task in tasks]


def _test_and_set(given: Given) -> bool:
    """TestAndSet: whether it was free, which it now is not."""
    taken = given.place(0)
    was = poses.truth(taken.get())
    taken.set(True)
    return not was


def _wait_test_and_set(given: Given) -> None:
    taken = given.place(0)
    if taken.storage != "PERS":
        raise Fault("WaitTestAndSet of what is no persistent")
    name = given.required[0]
    shown = name.name if isinstance(name, s.NameRef) else "it"
    what = f"`{shown}` is TRUE, and nobody sets it to FALSE"
    given.machine.task.wait(lambda: not poses.truth(taken.get()), None, what)
    taken.set(True)


def _has_robot(given: Given) -> bool:
    moves = given.machine.moves
    if moves is None:
        raise NotSimulated("whether the task has a robot, which nothing states")
    return moves


def _task_name(given: Given) -> str:
    machine = given.machine
    number = given.options.get("taskno")
    if number is not None:
        place(machine, number).set(float(machine.controller.tasks.index(machine.task) + 1))
    return machine.task.name


TASK_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("WaitSyncTask", 2, _wait_for_tasks, "inpos timeout"),
        table_row("WaitTestAndSet", 1, _wait_test_and_set),
    )
)
TASK_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("TestAndSet", 1, _test_and_set),
        table_row("TaskRunRob", 0, _has_robot),
        table_row("TaskRunMec", 0, _has_robot),
        table_row("GetTaskName", 0, _task_name, "taskno"),
    )
)
