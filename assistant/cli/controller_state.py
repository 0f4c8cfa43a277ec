"""Look at a controller, or set what moves no arm: `ls`, `log`, `inputs`, `outputs` and others.

Setting an output asks before, as what hangs on it may move. `monitor` reads until its time is over
or Ctrl-C.
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error
from assistant.base.termination import is_ctrl_c
from assistant.cli.command import argument, command, option
from assistant.cli.controller_session import (
    CellArgument,
    Session,
    YesOption,
    assignments,
    confirm,
    connected,
    fault_line,
    joints_line,
    output_value,
    pose_line,
    print_state,
    print_there,
    record,
    state_lines,
)
from assistant.cli.options import FormatOption
from assistant.cli.presentation import Format, say

if TYPE_CHECKING:
    from rich.table import Table

    from assistant.controllers.states import Sample


@command
class Ls:
    """List the programs on a controller."""

    cell: CellArgument
    format: FormatOption

    def run(self) -> int:
        with connected(self.cell, "ls") as there:
            names = there.session.names()
        print_there(there, self.format, {"programs": list(names)}, names)
        return 0


@command
class Monitor:
    """Show again and again what a controller does and where its arm is. Changes nothing."""

    cell: CellArgument
    log: Path | None = option("Write a row each.", metavar="FILE.csv")
    signals: tuple[str, ...] = option("A signal to show; repeatable.")
    interval: float = option("Seconds between two looks.", default=0.5)
    seconds: float | None = option("How long; default until Ctrl-C.")
    format: FormatOption

    def run(self) -> int:
        """Until the time is over or Ctrl-C, which is how it usually ends: no error."""
        for named, value in (("interval", self.interval), ("seconds", self.seconds)):
            if value is not None and not value > 0:
                raise Refused(_NO_INTERVAL(option=named, value=value), exit_status=2)
        with ExitStack() as opened:
            there = opened.enter_context(connected(self.cell, "monitor"))
            identity = there.controller.identify()
            # Not before: a controller that is not reached leaves no empty log.
            log = None if self.log is None else _csv_log(self.log, self._names)
            logged = None if log is None else opened.enter_context(log)
            names = (identity.robot, identity.controller, identity.version)
            title = f"{there.one.name}  {' '.join(filter(None, names))}"
            tell = opened.enter_context(_presentation(title, self.format))
            try:
                for sample in there.controller.watch(self.interval, self._names):
                    if logged is not None:
                        logged(sample)
                    tell(sample)
                    if self.seconds is not None and sample.seconds >= self.seconds:
                        break
            except KeyboardInterrupt as caught:
                if not is_ctrl_c(caught):
                    raise
        return 0

    @property
    def _names(self) -> list[str]:
        return [name for given in self.signals for name in given.split(",") if name]


@command
class Log:
    """Print the latest errors and events of a controller, the newest first."""

    cell: CellArgument
    most: int = option("How many.", default=50, min=1)
    format: FormatOption

    def run(self) -> int:
        with connected(self.cell, "log") as there:
            faults = there.controller.log(self.most)
        lines = []
        for fault in faults:
            lines += [fault_line(fault), *([f"       = {fault.cure}"] if fault.cure else [])]
        print_there(there, self.format, {"log": faults}, lines)
        return 0


@command
class Inputs:
    """Print what inputs read."""

    cell: CellArgument
    names: tuple[str, ...] = argument("Names or numbers of inputs.")
    format: FormatOption

    def run(self) -> int:
        with connected(self.cell, "inputs") as there:
            found = there.controller.inputs(self.names)
        return _print_values(
            there, "inputs", {n: f"{v:g}" for n, v in found.items()}, found, self.format
        )


@command
class Outputs:
    """Print outputs, or set them; connected equipment may move, so setting asks first."""

    cell: CellArgument
    names: tuple[str, ...] = argument("Outputs.", metavar="NAME[=VALUE]...")
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        """Print outputs, or set them after confirmation, as connected equipment may move."""
        names, written = assignments(self.names)
        values = {name: output_value(name, value) for name, value in written.items()}
        with connected(self.cell, "outputs") as there:
            controller = there.controller
            if values:
                what = ", ".join(f"`{name}` to {value:g}" for name, value in values.items())
                confirm(there.one, f"sets {what}: what hangs on it may move", self.yes)
            for name, value in values.items():
                controller.set_output(name, value)
            found = controller.outputs([*names, *values])
        return _print_values(
            there, "outputs", {n: f"{v:g}" for n, v in found.items()}, found, self.format
        )


@command
class Parameters:
    """Print parameters, or set them."""

    cell: CellArgument
    names: tuple[str, ...] = argument(
        "Default: those that were changed.", default=(), metavar="[NAME[=VALUE]]..."
    )
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        names, written = assignments(self.names)
        with connected(self.cell, "parameters") as there:
            controller = there.controller
            _ask_if_running(there, written, self.yes)
            for name, value in written.items():
                controller.set_parameter(name, value)
            found = controller.parameters([*names, *written])
        return _print_values(there, "parameters", found, found, self.format)


@command
class Variables:
    """Print variables of programs, or set them, as the controller's language writes values."""

    cell: CellArgument
    names: tuple[str, ...] = argument("Variables.", metavar="NAME[=VALUE]...")
    program: str = option("Program or module that they are in.", default="")
    task: str = option("Task or slot; default the first.", default="")
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        names, written = assignments(self.names)
        with connected(self.cell, "variables") as there:
            controller = there.controller
            _ask_if_running(there, written, self.yes)
            for name, value in written.items():
                controller.set_variable(name, value, self.program, self.task)
            found = {
                name: controller.variable(name, self.program, self.task)
                for name in (*names, *written)
            }
        return _print_values(there, "variables", found, found, self.format)


@command
class Reset:
    """Acknowledge the errors of a controller. Nothing moves."""

    cell: CellArgument
    format: FormatOption

    def run(self) -> int:
        """0 if nothing keeps programs from being started any more."""
        with connected(self.cell, "reset") as there:
            there.controller.reset()
            state = there.controller.state()
        print_state(there, state, "errors acknowledged", self.format)
        return 1 if state.faults or state.emergency else 0


@command
class Stop:
    """Stop all programs where they are. Never asks; no emergency stop."""

    cell: CellArgument
    format: FormatOption

    def run(self) -> int:
        with connected(self.cell, "stop") as there:
            there.controller.stop()
            state = there.controller.state()
        print_state(there, state, "stopped", self.format)
        return 1 if state.running else 0


def _ask_if_running(there: Session, written: Mapping[str, str], yes: bool) -> None:
    """Ask for confirmation if a program runs, as the change may send its arm elsewhere."""
    if written and there.controller.state().running:
        names = ", ".join(f"`{name}`" for name in written)
        confirm(there.one, f"changes {names} under a program that runs", yes)


def _print_values(
    there: Session, what: str, shown: Mapping[str, str], found: object, format: Format
) -> int:
    lines = (f"{name} = {value}" for name, value in shown.items())
    print_there(there, format, {what: found}, lines)
    return 0


_LOG_THERE: Final = error(
    "CL220", "`{name}` is there already", "name a file that is not there, or delete it"
)
_NO_LOG: Final = error("CL221", "`{name}` cannot be written: {reason}", "name another file")
_NO_INTERVAL: Final = error("CL222", "--{option} is {value:g}", "write a number above 0")
_MOST_JOINTS: Final = 8


_Watcher = Callable[["Sample"], None]


@contextmanager
def _presentation(title: str, format: Format) -> Iterator[_Watcher]:
    """A live table on a terminal, plain lines elsewhere, a line of JSON each for programs."""
    if format is Format.JSON:
        yield _print_json_sample
    elif not sys.stdout.isatty():
        say(title)
        yield _print_plain_sample
    else:
        from rich.console import Console
        from rich.live import Live

        screen = Console(highlight=False, emoji=False, markup=False)
        with Live(console=screen, auto_refresh=False) as live:
            yield lambda sample: live.update(_sample_table(title, sample), refresh=True)


def _print_json_sample(sample: Sample) -> None:
    say(json.dumps(record(sample), ensure_ascii=False))
    sys.stdout.flush()


def _print_plain_sample(sample: Sample) -> None:
    lines = [*state_lines(sample.state), joints_line(sample.position), pose_line(sample.position)]
    lines += [f"{name} = {value:g}" for name, value in sample.signals.items()]
    say(f"{sample.seconds:>10.3f}  " + "; ".join(lines))
    sys.stdout.flush()


def _sample_table(title: str, sample: Sample) -> Table:
    """Two columns: what, and how it is."""
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(title), show_header=False)
    first, *rest = state_lines(sample.state)
    warns = sample.state.emergency or sample.state.faults
    table.add_row("state", Text(first, style="bold red" if warns else "bold"))
    for line in rest:
        table.add_row("", Text(line))
    table.add_row("joints", Text(joints_line(sample.position)))
    table.add_row("pose", Text(pose_line(sample.position)))
    for name, value in sample.signals.items():
        table.add_row(Text(name), Text(f"{value:g}"))
    table.add_row("seconds", Text(f"{sample.seconds:.1f}"))
    return table


@contextmanager
def _csv_log(path: Path, signals: Sequence[str]) -> Iterator[_Watcher]:
    """A CSV file that gets a row each; none that is there is written over."""
    try:
        file = path.open("x", newline="", encoding="utf-8")
    except FileExistsError:
        raise Refused(_LOG_THERE(path=str(path), name=path), exit_status=2) from None
    except OSError as error:
        finding = _NO_LOG(path=str(path), name=path, reason=error.strerror or error)
        raise Refused(finding, exit_status=2) from None
    with file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(_log_header(signals))
        file.flush()

        def logged(sample: Sample) -> None:
            writer.writerow(_log_row(sample, signals))
            file.flush()

        yield logged


def _log_header(signals: Sequence[str]) -> list[str]:
    """Columns as tables of targets name them, so that a log can be read as one."""
    return [
        *("_seconds", "_mode", "_motors", "_running", "_emergency", "_override"),
        *("_programs", "_faults"),
        *("x_mm", "y_mm", "z_mm", "q_w", "q_x", "q_y", "q_z"),
        *(f"_j{i}_deg" for i in range(1, _MOST_JOINTS + 1)),
        *(f"_{name}" for name in signals),
    ]


def _log_row(sample: Sample, signals: Sequence[str]) -> list[object]:
    state, position = sample.state, sample.position
    programs = (f"{t.program}:{t.line or ''}" for t in state.tasks if t.program)
    joints = (*position.joints, *[None] * _MOST_JOINTS)[:_MOST_JOINTS]
    return [
        f"{sample.seconds:.3f}",
        state.mode,
        *(int(value) for value in (state.motors, state.running, state.emergency)),
        "" if state.override is None else state.override,
        " ".join(programs),
        " ".join(str(fault.number) for fault in state.faults),
        *(f"{value:.4f}" for value in position.position),
        *(f"{value:.8f}" for value in position.quaternion),
        *("" if joint is None else f"{joint:.4f}" for joint in joints),
        *(sample.signals.get(name, "") for name in signals),
    ]
