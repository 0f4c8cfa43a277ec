"""`monitor`: what a controller does, again and again, as a table, lines, JSON or CSV."""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error
from assistant.base.termination import is_ctrl_c
from assistant.cli.cells import connected, joints_line, pose_line, record, state_lines
from assistant.cli.presentation import Format, say

if TYPE_CHECKING:
    from rich.table import Table

    from assistant.controllers.states import Sample

LOG_THERE: Final = error(
    "CL220", "`{name}` is there already", "name a file that is not there, or delete it"
)
NO_LOG: Final = error("CL221", "`{name}` cannot be written: {reason}", "name another file")
NO_INTERVAL: Final = error("CL222", "--{option} is {value:g}", "write a number above 0")
MOST_JOINTS: Final = 8


@dataclass(frozen=True, slots=True)
class MonitorOptions:
    """interval, seconds: s; None for as long as nobody ends it."""

    signals: Sequence[str]
    interval: float
    seconds: float | None
    log: Path | None
    format: Format


Watcher = Callable[["Sample"], None]


def run_monitor(cell: str, options: MonitorOptions) -> int:
    """Until the time is over or Ctrl-C, which is how it usually ends: no error."""
    for option, value in (("interval", options.interval), ("seconds", options.seconds)):
        if value is not None and not value > 0:
            raise Refused(NO_INTERVAL(option=option, value=value), exit_status=2)
    with ExitStack() as opened:
        there = opened.enter_context(connected(cell, "monitor"))
        identity = there.controller.identify()
        # Not before: a controller that is not reached leaves no empty log.
        logged = opened.enter_context(_csv_log(options)) if options.log is not None else None
        names = (identity.robot, identity.controller, identity.version)
        title = f"{there.one.name}  {' '.join(filter(None, names))}"
        tell = opened.enter_context(_presentation(title, options))
        try:
            for sample in there.controller.watch(options.interval, options.signals):
                if logged is not None:
                    logged(sample)
                tell(sample)
                if options.seconds is not None and sample.seconds >= options.seconds:
                    break
        except KeyboardInterrupt as caught:
            if not is_ctrl_c(caught):
                raise
    return 0


@contextmanager
def _presentation(title: str, options: MonitorOptions) -> Iterator[Watcher]:
    """A live table on a terminal, plain lines elsewhere, a line of JSON each for programs."""
    if options.format is Format.JSON:
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
def _csv_log(options: MonitorOptions) -> Iterator[Watcher]:
    """A CSV file that gets a row each; none that is there is written over."""
    assert options.log is not None
    try:
        file = options.log.open("x", newline="", encoding="utf-8")
    except FileExistsError:
        raise Refused(LOG_THERE(path=str(options.log), name=options.log), exit_status=2) from None
    except OSError as error:
        finding = NO_LOG(path=str(options.log), name=options.log, reason=error.strerror or error)
        raise Refused(finding, exit_status=2) from None
    with file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(_log_header(options.signals))
        file.flush()

        def logged(sample: Sample) -> None:
            writer.writerow(_log_row(sample, options.signals))
            file.flush()

        yield logged


def _log_header(signals: Sequence[str]) -> list[str]:
    """Columns as tables of targets name them, so that a log can be read as one."""
    return [
        *("_seconds", "_mode", "_motors", "_running", "_emergency", "_override"),
        *("_programs", "_faults"),
        *("x_mm", "y_mm", "z_mm", "q_w", "q_x", "q_y", "q_z"),
        *(f"_j{i}_deg" for i in range(1, MOST_JOINTS + 1)),
        *(f"_{name}" for name in signals),
    ]


def _log_row(sample: Sample, signals: Sequence[str]) -> list[object]:
    state, position = sample.state, sample.position
    programs = (f"{t.program}:{t.line or ''}" for t in state.tasks if t.program)
    joints = (*position.joints, *[None] * MOST_JOINTS)[:MOST_JOINTS]
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
