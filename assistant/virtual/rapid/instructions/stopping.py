"""Stops of the arm on its way, and the path that is left then."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.kernel import Instant
from assistant.virtual.rapid.ends import NotSimulated
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function

NO_PATH: Final = "`{}`: motions take no time here, so that none is stopped on its way"


def _stop_motion(given: Given) -> None:
    """Motions that come later wait too, until StartMove."""
    kernel = given.machine.task.kernel
    given.machine.controller.held = given.machine.task
    kernel.motion.hold(kernel)


def _start_motion(given: Given) -> None:
    kernel = given.machine.task.kernel
    given.machine.controller.held = None
    kernel.motion.resume(kernel)


def _clear_path(given: Given) -> None:
    """The arm stays where it is; it is still stopped."""
    machine = given.machine
    standing = machine.task.kernel.motion.cut(machine.task)
    if standing is not None:
        machine.arm.flange, machine.arm.joints = standing[0], standing[1][:6]
        machine.task.kernel.motion.hold(machine.task.kernel)


def _store_path(given: Given) -> None:
    """Stops the arm; the motions that follow are made on a path of their own."""
    kernel = given.machine.task.kernel
    kernel.motion.store(kernel)


def _restore_path(given: Given) -> None:
    """The path that was kept goes on with StartMove."""
    task = given.machine.task
    task.kernel.motion.restore(task)


def _is_stopped(given: Given) -> bool:
    """Tasks are taken for those that move the arm, as the one that asks."""
    held = given.machine.controller.held
    if held not in (None, given.machine.task):
        raise NotSimulated("whether another task moves an arm")
    return held is not None and not given.has("fromnonmovetask")


def _stop_row(name: str, does: Callable[[Given], None], options: str = "") -> tuple[str, Function]:
    """An instruction that does nothing, and says so, where motions take no time."""

    def checked(given: Given) -> None:
        kernel = given.machine.task.kernel
        if isinstance(kernel.motion, Instant):
            kernel.note(NO_PATH.format(name))
        does(given)

    return table_row(name, 0, checked, options)


STOP_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        _stop_row("StopMove", _stop_motion, "quick allmotiontasks"),
        _stop_row("StartMove", _start_motion, "allmotiontasks"),
        _stop_row("StopMoveReset", _start_motion, "allmotiontasks"),
        _stop_row("ClearPath", _clear_path),
        _stop_row("StorePath", _store_path, "keepsync"),
        _stop_row("RestoPath", _restore_path),
    )
)
STOP_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (table_row("IsStopMoveAct", 0, _is_stopped, "frommovetask fromnonmovetask"),)
)
