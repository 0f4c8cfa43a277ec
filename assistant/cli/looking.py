"""Commands that look at a controller, or set what moves no arm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from assistant.cli.cells import (
    Session,
    assignments,
    connected,
    fault_line,
    output_value,
    record,
    state_lines,
)
from assistant.cli.confirming import confirm
from assistant.cli.presentation import Format, print_json, say

if TYPE_CHECKING:
    from assistant.controllers.states import State


def run_ls(cell: str, format: Format) -> int:
    with connected(cell, "ls") as there:
        names = there.session.names()
    if format is Format.JSON:
        print_json({"address": str(there.one.address), "programs": list(names)})
    else:
        for name in names:
            say(name)
    return 0


def run_log(cell: str, most: int, format: Format) -> int:
    with connected(cell, "log") as there:
        faults = there.controller.log(most)
    if format is Format.JSON:
        print_json({"address": str(there.one.address), "log": record(faults)})
        return 0
    for fault in faults:
        say(fault_line(fault))
        if fault.cure:
            say(f"       = {fault.cure}")
    return 0


def run_reset(cell: str, format: Format) -> int:
    """0 if nothing keeps programs from being started any more."""
    with connected(cell, "reset") as there:
        there.controller.reset()
        state = there.controller.state()
    _print_state(there, state, "errors acknowledged", format)
    return 1 if state.faults or state.emergency else 0


def run_stop(cell: str, format: Format) -> int:
    with connected(cell, "stop") as there:
        there.controller.stop()
        state = there.controller.state()
    _print_state(there, state, "stopped", format)
    return 1 if state.running else 0


def run_inputs(cell: str, names: Sequence[str], format: Format) -> int:
    with connected(cell, "inputs") as there:
        found = there.controller.inputs(names)
    return _print_values(there, "inputs", {n: f"{v:g}" for n, v in found.items()}, found, format)


def run_outputs(cell: str, given: Sequence[str], yes: bool, format: Format) -> int:
    """Outputs that are set may move what hangs on them, so that is asked for."""
    names, written = assignments(given)
    values = {name: output_value(name, value) for name, value in written.items()}
    with connected(cell, "outputs") as there:
        controller = there.controller
        if values:
            what = ", ".join(f"`{name}` to {value:g}" for name, value in values.items())
            confirm(there.one, f"sets {what}: what hangs on it may move", yes)
        for name, value in values.items():
            controller.set_output(name, value)
        found = controller.outputs([*names, *values])
    return _print_values(there, "outputs", {n: f"{v:g}" for n, v in found.items()}, found, format)


def run_parameters(cell: str, given: Sequence[str], yes: bool, format: Format) -> int:
    names, written = assignments(given)
    with connected(cell, "parameters") as there:
        controller = there.controller
        _ask_if_running(there, written, yes)
        for name, value in written.items():
            controller.set_parameter(name, value)
        found = controller.parameters([*names, *written])
    return _print_values(there, "parameters", found, found, format)


def run_variables(
    cell: str, given: Sequence[str], program: str, task: str, yes: bool, format: Format
) -> int:
    names, written = assignments(given)
    with connected(cell, "variables") as there:
        controller = there.controller
        _ask_if_running(there, written, yes)
        for name, value in written.items():
            controller.set_variable(name, value, program, task)
        found = {name: controller.variable(name, program, task) for name in (*names, *written)}
    return _print_values(there, "variables", found, found, format)


def _ask_if_running(there: Session, written: Mapping[str, str], yes: bool) -> None:
    """What a program that runs meets may send its arm elsewhere."""
    if written and there.controller.state().running:
        names = ", ".join(f"`{name}`" for name in written)
        confirm(there.one, f"changes {names} under a program that runs", yes)


def _print_values(
    there: Session, what: str, shown: Mapping[str, str], found: object, format: Format
) -> int:
    if format is Format.JSON:
        print_json({"address": str(there.one.address), what: record(found)})
    else:
        for name, value in shown.items():
            say(f"{name} = {value}")
    return 0


def _print_state(there: Session, state: State, done: str, format: Format) -> None:
    if format is Format.JSON:
        print_json({"address": str(there.one.address), "state": record(state)})
        return
    say(f"{there.one.name}: {done}")
    for line in state_lines(state):
        say(line)
