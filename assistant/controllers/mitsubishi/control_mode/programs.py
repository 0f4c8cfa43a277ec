"""The three programs of data link control mode, and how they get onto a controller."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers.controller import Controller
from assistant.controllers.mitsubishi.data_link import rules
from assistant.controllers.states import State
from assistant.resources import resource

STARTING_PROGRAM: Final = "MULTITASK"
"""Starts and stops the others."""
PROGRAM_NAMES: Final = (STARTING_PROGRAM, "DATALINK", "CONTROLLINK")
SHARED_VARIABLES: Final = ("M_01", "M_02", "M_03", "M_04")
"""External variables by which they signal each other."""
MEASURING_PROGRAM: Final = "MEASURE"
"""Sends the status by itself, beside what another slot does."""


def program_texts(names: Sequence[str] = PROGRAM_NAMES) -> dict[str, bytes]:
    """The programs by name. They are the same in all versions of the language."""
    folder = "melfa/datalink"
    return {name: resource("samples", f"{folder}/{name}.prg").read_bytes() for name in names}


def install_programs(
    controller: Controller, names: Sequence[str] = PROGRAM_NAMES, *, replace: bool = False
) -> None:
    """Writes the programs that are not there yet.

    replace: other programs of these names, too; they are refused else.
    """
    wanted = program_texts(names)
    there = {name: controller.read(name) for name in wanted}
    missing = [
        name
        for name, data in there.items()
        if data is None or _steps(controller, data) != _steps(controller, wanted[name])
    ]
    others = [name for name in missing if there[name] is not None]
    if others and not replace:
        raise Refused(
            rules.NOT_READY(
                place=str(controller.address),
                reason=f"other programs are called {', '.join(others)} there",
                cure="back them up, then allow to replace them",
            )
        )
    for name in missing:
        controller.write(name, wanted[name])


def _steps(controller: Controller, data: bytes) -> list[bytes]:
    """The lines of a program without the variables, which it gives other values as it runs."""
    return [line for line in controller.stored(data).splitlines() if line[:1].isdigit()]


def check_idle(controller: Controller) -> None:
    """Raises Refused for what programs cannot be started in."""
    state = controller.state()
    reason = next(iter(troubles(state)), "a program runs" if state.running else "")
    if reason:
        cure = "put right what it says, stop the programs, then begin anew"
        finding = rules.NOT_READY(place=str(controller.address), reason=reason, cure=cure)
        raise Refused(finding)


def troubles(state: State) -> list[str]:
    """What a controller stands still for, in words."""
    found = ["the emergency stop is pressed"] if state.emergency else []
    return found + [f"error {fault.number} ({fault.text})" for fault in state.faults]
