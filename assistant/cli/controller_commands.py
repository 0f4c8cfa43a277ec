"""The commands that look at a controller or set what moves no arm.

`ls`, `log`, `inputs`, `outputs`, `parameters`, `variables`, `reset`, `stop` and `monitor` are
carried out here; `get`, `put`, `rm`, `backup` and `restore` by `controller_files`, `teach` by
`teaching` and `pointing_input`. Setting an output asks before, as what hangs on it may move.
`monitor` reads until its time is over or Ctrl-C.
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from assistant.base.diagnostics import Refused, error
from assistant.base.termination import is_ctrl_c
from assistant.cli.controller_session import (
    Session,
    assignments,
    confirm,
    connected,
    fault_line,
    joints_line,
    output_value,
    pose_line,
    record,
    state_lines,
)
from assistant.cli.options import FormatOption, RobotOption
from assistant.cli.presentation import Format, print_json, say

if TYPE_CHECKING:
    from rich.table import Table

    from assistant.controllers.states import Sample, State


def complete_controller(incomplete: str) -> list[str]:
    from assistant.controllers import controllers_of

    return [name for name in controllers_of(Path.cwd()) if name.startswith(incomplete)]


CellArgument = Annotated[
    str,
    typer.Argument(
        metavar="CONTROLLER",
        help="Its name in [controllers] of assistant.toml, or its address.",
        autocompletion=complete_controller,
    ),
]
YesOption = Annotated[
    bool, typer.Option("--yes", help="Do it without asking. Look that nobody is near.")
]
ReplaceOption = Annotated[bool, typer.Option("--replace", help="Also what is there already.")]


def ls(cell: CellArgument, format: FormatOption = Format.TEXT) -> None:
    """List the programs on a controller."""
    raise typer.Exit(_run_ls(cell, format))


def get(
    cell: CellArgument,
    names: Annotated[list[str], typer.Argument(help="Programs, as `ls` lists them.")],
    output: Annotated[
        str | None, typer.Option("--output", "-o", help="File, folder, or - to print.")
    ] = None,
    replace: ReplaceOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Copy programs from a controller."""
    from assistant.cli.controller_files import run_get

    raise typer.Exit(run_get(cell, names, output, replace, format))


def put(
    cell: CellArgument,
    files: Annotated[list[Path], typer.Argument(help="Programs.")],
    replace: ReplaceOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Copy programs to a controller as they are; `deploy` also checks, keeps and compares."""
    from assistant.cli.controller_files import run_put

    raise typer.Exit(run_put(cell, files, replace, format))


def rm(
    cell: CellArgument,
    names: Annotated[list[str], typer.Argument(help="Programs or other files, as `ls` lists.")],
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Delete programs on a controller that nothing there has loaded. Asks before."""
    from assistant.cli.controller_files import run_rm

    raise typer.Exit(run_rm(cell, names, yes, format))


def backup(
    cell: CellArgument,
    folder: Annotated[Path, typer.Argument(help="A folder that is not there yet.")],
    format: FormatOption = Format.TEXT,
) -> None:
    """Write programs, parameters and variables of a controller into a folder."""
    from assistant.cli.controller_files import run_backup

    raise typer.Exit(run_backup(cell, folder, format))


def restore(
    cell: CellArgument,
    folder: Annotated[Path, typer.Argument(help="A folder that `backup` has written.")],
    only: Annotated[
        list[str] | None,
        typer.Option(help="Only this file or parameter, also of those left out; repeatable."),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only show what would change.")
    ] = False,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Show what differs from a backup, and bring it back; origin, safety, network only by name."""
    from assistant.cli.controller_files import run_restore

    raise typer.Exit(run_restore(cell, folder, only or (), dry_run, yes, format))


def monitor(
    cell: CellArgument,
    log: Annotated[
        Path | None, typer.Option("--log", help="Write a row each.", metavar="FILE.csv")
    ] = None,
    signals: Annotated[
        list[str] | None, typer.Option("--signals", help="A signal to show; repeatable.")
    ] = None,
    interval: Annotated[float, typer.Option(help="Seconds between two looks.")] = 0.5,
    seconds: Annotated[float | None, typer.Option(help="How long; default until Ctrl-C.")] = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Show again and again what a controller does and where its arm is. Changes nothing."""
    names = [name for given in signals or () for name in given.split(",") if name]
    raise typer.Exit(_run_monitor(cell, _MonitorOptions(names, interval, seconds, log, format)))


def log(
    cell: CellArgument,
    most: Annotated[int, typer.Option(min=1, help="How many.")] = 50,
    format: FormatOption = Format.TEXT,
) -> None:
    """Print the latest errors and events of a controller, the newest first."""
    raise typer.Exit(_run_log(cell, most, format))


def inputs(
    cell: CellArgument,
    names: Annotated[list[str], typer.Argument(help="Names or numbers of inputs.")],
    format: FormatOption = Format.TEXT,
) -> None:
    """Print what inputs read."""
    raise typer.Exit(_run_inputs(cell, names, format))


def outputs(
    cell: CellArgument,
    names: Annotated[list[str], typer.Argument(metavar="NAME[=VALUE]...", help="Outputs.")],
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Print outputs, or set them; connected equipment may move, so setting asks first."""
    raise typer.Exit(_run_outputs(cell, names, yes, format))


def parameters(
    cell: CellArgument,
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME[=VALUE]]...", help="Default: those that were changed."),
    ] = None,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Print parameters, or set them."""
    raise typer.Exit(_run_parameters(cell, names or (), yes, format))


def variables(
    cell: CellArgument,
    names: Annotated[list[str], typer.Argument(metavar="NAME[=VALUE]...", help="Variables.")],
    program: Annotated[str, typer.Option(help="Program or module that they are in.")] = "",
    task: Annotated[str, typer.Option(help="Task or slot; default the first.")] = "",
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Print variables of programs, or set them, as the controller's language writes values."""
    raise typer.Exit(_run_variables(cell, names, program, task, yes, format))


def reset(cell: CellArgument, format: FormatOption = Format.TEXT) -> None:
    """Acknowledge the errors of a controller. Nothing moves."""
    raise typer.Exit(_run_reset(cell, format))


def stop(cell: CellArgument, format: FormatOption = Format.TEXT) -> None:
    """Stop all programs where they are. Never asks; no emergency stop."""
    raise typer.Exit(_run_stop(cell, format))


def teach(
    cell: Annotated[
        str | None,
        typer.Argument(
            metavar="CONTROLLER",
            help="Its name in [controllers] of assistant.toml, or its address; --point needs none.",
            autocompletion=complete_controller,
        ),
    ] = None,
    names: Annotated[
        list[str] | None, typer.Argument(help="Targets, in this order; default p1, p2 …")
    ] = None,
    into: Annotated[
        Path, typer.Option(help="File of taught targets, which keeps all else.", metavar="FILE")
    ] = Path("taught.toml"),
    on: Annotated[
        str | None, typer.Option(help="Store when this input comes, not at a key.", metavar="INPUT")
    ] = None,
    now: Annotated[bool, typer.Option("--now", help="Store one target at once.")] = False,
    joints: Annotated[bool, typer.Option("--joints", help="As joint angles.")] = False,
    tool: Annotated[
        str | None, typer.Option(help="Tool of the file that the controller shows the pose of.")
    ] = None,
    frame: Annotated[str | None, typer.Option(help="Frame that it shows it in.")] = None,
    replace: ReplaceOption = False,
    point: Annotated[
        Path | None,
        typer.Option(help="Store places that are shown to these cameras.", metavar="CAMERAS.toml"),
    ] = None,
    camera: Annotated[
        list[str] | None, typer.Option(help="Camera that looks; repeatable, default all.")
    ] = None,
    device: Annotated[
        str, typer.Option(help="wand, ball, light, or a file.", metavar="DEVICE")
    ] = "wand",
    frames: Annotated[int, typer.Option(help="Pictures for which a place is held.")] = 30,
    rate: Annotated[float, typer.Option(help="Pictures a second of files.")] = 30.0,
    residual: Annotated[float, typer.Option(help="Pixels by which pictures may disagree.")] = 0.5,
    fastest: Annotated[float, typer.Option(help="mm/s that a hand moves.")] = 1500.0,
    robot: RobotOption = None,
    world: Annotated[
        str | None, typer.Option(help="Frame of the file in which the cameras stand.")
    ] = None,
    stroke: Annotated[
        bool, typer.Option("--stroke", help="Store the way between two places, as a .csv.")
    ] = False,
    step: Annotated[float, typer.Option(help="mm between waypoints of a stroke.")] = 5.0,
    go: Annotated[
        bool, typer.Option("--go", help="Lead the arm there; store what it reached.")
    ] = False,
    by: Annotated[str, typer.Option(help="Way to lead it, as of `follow`.")] = "data-link",
    port: Annotated[
        int | None, typer.Option(help="UDP port of that way.", min=1, max=65535)
    ] = None,
    lines: Annotated[
        list[str] | None, typer.Option("--line", help="Line of that way; repeatable.")
    ] = None,
    above: Annotated[
        float, typer.Option(help="mm before a place from which it is led straight.")
    ] = 50.0,
    servo: Annotated[
        Path | None,
        typer.Option(help="Lead it from there by what is seen of its tool.", metavar="TASK.toml"),
    ] = None,
    speed: Annotated[float, typer.Option(help="Percent of what the file says.")] = 10.0,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Store where the arm is, or places that are shown to cameras, under names.

    At a key press, when an input comes, or when a device is held still. Nothing moves but with
    --go, which asks before.
    """
    from assistant.compiler.taught_targets import TargetOptions

    wanted = TargetOptions(joints, tool, frame, replace)
    if point is not None:
        from assistant.cli.pointing_input import PointingOptions as Pointing
        from assistant.cli.pointing_input import run_point
        from assistant.controllers.trajectory_execution import LinkOptions

        words = [cell, *(names or ())] if cell is not None else []
        pointing = Pointing(
            cameras=point,
            into=into,
            wanted=wanted,
            use=tuple(camera or ()),
            device=device,
            frames=frames,
            rate=rate,
            residual=residual,
            fastest=fastest,
            robot=robot,
            world=world,
            stroke=stroke,
            step=step,
            go=go,
            by=by,
            wishes=LinkOptions(port, tuple(lines or ()), None, replace),
            above=above,
            speed=speed,
            servo=servo,
            yes=yes,
            format=format,
        )
        raise typer.Exit(run_point(words, on, now, pointing))
    from assistant.cli.teaching import TeachOptions, run_teach

    options = TeachOptions(into, on, now, wanted, format)
    raise typer.Exit(run_teach(cell, names or (), options, {"--go": go, "--stroke": stroke}))


def _run_ls(cell: str, format: Format) -> int:
    with connected(cell, "ls") as there:
        names = there.session.names()
    if format is Format.JSON:
        print_json({"address": str(there.one.address), "programs": list(names)})
    else:
        for name in names:
            say(name)
    return 0


def _run_log(cell: str, most: int, format: Format) -> int:
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


def _run_reset(cell: str, format: Format) -> int:
    """0 if nothing keeps programs from being started any more."""
    with connected(cell, "reset") as there:
        there.controller.reset()
        state = there.controller.state()
    _print_state(there, state, "errors acknowledged", format)
    return 1 if state.faults or state.emergency else 0


def _run_stop(cell: str, format: Format) -> int:
    with connected(cell, "stop") as there:
        there.controller.stop()
        state = there.controller.state()
    _print_state(there, state, "stopped", format)
    return 1 if state.running else 0


def _run_inputs(cell: str, names: Sequence[str], format: Format) -> int:
    with connected(cell, "inputs") as there:
        found = there.controller.inputs(names)
    return _print_values(there, "inputs", {n: f"{v:g}" for n, v in found.items()}, found, format)


def _run_outputs(cell: str, given: Sequence[str], yes: bool, format: Format) -> int:
    """Print outputs, or set them after confirmation, as connected equipment may move."""
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


def _run_parameters(cell: str, given: Sequence[str], yes: bool, format: Format) -> int:
    names, written = assignments(given)
    with connected(cell, "parameters") as there:
        controller = there.controller
        _ask_if_running(there, written, yes)
        for name, value in written.items():
            controller.set_parameter(name, value)
        found = controller.parameters([*names, *written])
    return _print_values(there, "parameters", found, found, format)


def _run_variables(
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
    """Ask for confirmation if a program runs, as the change may send its arm elsewhere."""
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


_LOG_THERE: Final = error(
    "CL220", "`{name}` is there already", "name a file that is not there, or delete it"
)
_NO_LOG: Final = error("CL221", "`{name}` cannot be written: {reason}", "name another file")
_NO_INTERVAL: Final = error("CL222", "--{option} is {value:g}", "write a number above 0")
_MOST_JOINTS: Final = 8


@dataclass(frozen=True, slots=True)
class _MonitorOptions:
    """interval, seconds: s; None for as long as nobody ends it."""

    signals: Sequence[str]
    interval: float
    seconds: float | None
    log: Path | None
    format: Format


_Watcher = Callable[["Sample"], None]


def _run_monitor(cell: str, options: _MonitorOptions) -> int:
    """Until the time is over or Ctrl-C, which is how it usually ends: no error."""
    for option, value in (("interval", options.interval), ("seconds", options.seconds)):
        if value is not None and not value > 0:
            raise Refused(_NO_INTERVAL(option=option, value=value), exit_status=2)
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
def _presentation(title: str, options: _MonitorOptions) -> Iterator[_Watcher]:
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
def _csv_log(options: _MonitorOptions) -> Iterator[_Watcher]:
    """A CSV file that gets a row each; none that is there is written over."""
    assert options.log is not None
    try:
        file = options.log.open("x", newline="", encoding="utf-8")
    except FileExistsError:
        raise Refused(_LOG_THERE(path=str(options.log), name=options.log), exit_status=2) from None
    except OSError as error:
        finding = _NO_LOG(path=str(options.log), name=options.log, reason=error.strerror or error)
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
