"""Stops of the arm on its way, and the path that is left then."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.kernel import Instant
from assistant.virtual.rapid.ends import NotSimulated
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.machine import Function

NO_WAY: Final = "`{}`: motions take no time here, so that none is stopped on its way"


def _stop(given: Given) -> None:
    """Motions that come later wait too, until StartMove."""
    kernel = given.machine.task.kernel
    given.machine.controller.held = given.machine.task
    kernel.motion.hold(kernel)


def _start(given: Given) -> None:
    kernel = given.machine.task.kernel
    given.machine.controller.held = None
    kernel.motion.resume(kernel)


def _clear(given: Given) -> None:
    """The arm stays where it is; it is still stopped."""
    machine = given.machine
    standing = machine.task.kernel.motion.cut(machine.task)
    if standing is not None:
        machine.arm.flange, machine.arm.joints = standing[0], standing[1][:6]
        machine.task.kernel.motion.hold(machine.task.kernel)


def _store(given: Given) -> None:
    """Stops the arm; the motions that follow are made on a path of their own."""
    kernel = given.machine.task.kernel
    kernel.motion.store(kernel)


def _restore(given: Given) -> None:
    """The path that was kept goes on with StartMove."""
    task = given.machine.task
    task.kernel.motion.restore(task)


def _is_held(given: Given) -> bool:
    """Tasks are taken for those that move the arm, as the one that asks."""
    held = given.machine.controller.held
    if held not in (None, given.machine.task):
        raise NotSimulated("whether another task moves an arm")
    return held is not None and not given.has("fromnonmovetask")


def _row(name: str, does: Callable[[Given], None], options: str = "") -> tuple[str, Function]:
    """An instruction that does nothing, and says so, where motions take no time."""

    def checked(given: Given) -> None:
        kernel = given.machine.task.kernel
        if isinstance(kernel.motion, Instant):
            kernel.note(NO_WAY.format(name))
        does(given)

    return takes(name, 0, checked, options)


TABLE: Final[Mapping[str, Function]] = dict(
    (
        _row("StopMove", _stop, "quick allmotiontasks"),
        _row("StartMove", _start, "allmotiontasks"),
        _row("StopMoveReset", _start, "allmotiontasks"),
        _row("ClearPath", _clear),
        _row("StorePath", _store, "keepsync"),
        _row("RestoPath", _restore),
    )
)
FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (takes("IsStopMoveAct", 0, _is_held, "frommovetask fromnonmovetask"),)
)
