"""Run programs on a virtual controller: `run`, and `debug` for an editor.

No robot moves. `run` prints a log of outputs, waits and motions, or writes a trace; times of
motions need a robot. `debug` speaks the Debug Adapter Protocol on standard input and output.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from io import FileIO
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import (
    Diagnostic,
    Refused,
    Rule,
    Severity,
    error,
    fold,
    info,
    warning,
)
from assistant.base.source_text import SourceText, visible
from assistant.cli.command import argument, command, option
from assistant.cli.options import (
    DrawingOptions,
    EntryOption,
    FormatOption,
    FromLanguage,
    RobotOption,
    SightOptions,
)
from assistant.cli.presentation import Format, print_findings, print_json, say, working
from assistant.cli.source_input import (
    NO_FILE_NAME,
    STANDARD,
    TWICE,
    cell_of,
    keep_sources,
    standard_input,
)

if TYPE_CHECKING:
    from assistant.robots import Robot
    from assistant.virtual.debugging.break_points import Lines
    from assistant.virtual.debugging.messages import Object
    from assistant.virtual.events import Place
    from assistant.virtual.events import Run as EndedRun
    from assistant.virtual.kernel import Kernel, Task
    from assistant.virtual.kernel.script import Script
    from assistant.virtual.tasks import Programs, SignalNames


@command
class Run:
    """Run programs on a virtual controller and tell what they do. No robot moves."""

    programs: tuple[str, ...] = argument(
        "A program, the programs of several slots, the modules or folder of a task, a "
        "backup, or any other source; - for standard input."
    )
    robot: RobotOption
    cell: Path | None = option(
        "File of what programs use and do not declare; default cell.toml beside them."
    )
    signals: Path | None = option("Script of inputs and answers, in TOML.", metavar="FILE")
    until: str | None = option(
        "End the run there: seconds, or FILE:LINE.", metavar="TIME|FILE:LINE"
    )
    breaks: tuple[str, ...] = option(
        "Hold the run there; repeatable.", "--break", metavar="FILE:LINE"
    )
    step: bool = option("Hold the run at its first statement.")
    trace: Path | None = option("Write the run in columns.", metavar="FILE.npz")
    plot: Path | None = option("Draw the run over time.", metavar="FILE.png|.svg")
    period: float | None = option("Seconds between samples; default 0.01, or what fits.")
    max_steps: int = option("Statements after which the run is broken off.", default=1_000_000)
    max_time: float = option("Simulated seconds after which the run is broken off.", default=3600.0)
    real_time: bool = option("As slowly as it would really be.")
    disk: Path | None = option(
        "Folder with the files of the controller, which others may change meanwhile.",
        metavar="FOLDER",
    )
    hosts: tuple[str, ...] = option(
        "Host that an address of the programs stands for; repeatable.",
        "--host",
        metavar="ADDRESS=HOST",
    )
    lines: tuple[str, ...] = option(
        "What a line of the programs leads to: a port for others to call, the "
        "HOST:PORT of a server, the path of a serial port, or `pty:FILE` to make one; "
        "repeatable.",
        "--line",
        metavar="NAME=TARGET",
    )
    ask: bool = option("Have what the programs ask answered on standard input.")
    reader: DrawingOptions
    from_language: FromLanguage
    entry: EntryOption
    sight: SightOptions
    format: FormatOption

    def run(self) -> int:
        """0 if the programs came to their end, 1 if they did not."""
        from assistant.compiler.arms import known_robot, robot_of
        from assistant.compiler.simulated_run import read_script
        from assistant.virtual.kernel.script import Script

        self._check()
        if self.format is Format.JSON and (self.step or self.breaks):
            raise Refused(_STEPPED_AS_JSON(), exit_status=2)
        arm = robot_of(self.robot)
        script = read_script(self.signals) if self.signals is not None else Script()
        programs = self._load(arm)
        if arm is None and programs.program is not None:
            arm = known_robot(programs.program.robot)
        if self.plot is not None and arm is None:
            raise Refused(_PLOT_WITHOUT_ROBOT(), exit_status=2)
        files = [path for path in (self.trace, self.plot) if path is not None]
        keep_sources([*self.programs, *([str(self.signals)] if self.signals else [])], files)
        return _PrintedRun(programs, self, arm, script).run()

    def _check(self) -> None:
        """Raises Refused for what no program could be run with."""
        if self.trace is not None and self.trace.suffix.lower() != ".npz":
            raise Refused(_NOT_A_TRACE(name=self.trace), exit_status=2)
        check_disk_folder(self.disk)
        if self.plot is not None:
            from assistant.report.figures import format_of

            format_of(self.plot.name)
        for path in (self.trace, self.plot):
            if path is not None and not path.stem.strip("."):
                raise Refused(NO_FILE_NAME(path=str(path), name=path), exit_status=2)
        limits = {"max-steps": self.max_steps, "max-time": self.max_time}
        if self.period is not None:
            limits["period"] = self.period
        for named, value in limits.items():
            if not value > 0:
                raise Refused(_BAD_LIMIT(option=named, value=value), exit_status=2)

    def _load(self, arm: Robot | None) -> Programs:
        from assistant.compiler.simulated_run import programs, programs_of_text

        if self.programs.count(STANDARD) > 1 or (
            STANDARD in self.programs and len(self.programs) > 1
        ):
            raise Refused(TWICE(), exit_status=2)
        if STANDARD in self.programs and self.ask:
            raise Refused(INPUT_IS_PROGRAM(), exit_status=2)
        if STANDARD in self.programs:
            text, spoken = standard_input(self.from_language)
            return programs_of_text(
                text, language=spoken, robot=arm, entry=self.entry, seeing=self.sight.seeing
            )
        return programs(
            self.programs,
            language=self.from_language,
            robot=arm,
            process=self.reader.process,
            unit=self.reader.unit,
            placement=self.reader.placement,
            entry=self.entry,
            cell=self.cell or cell_of(self.programs[0]),
            seeing=self.sight.seeing,
        )


@command
class Debug:
    """Run a program as an editor says, over the Debug Adapter Protocol; see docs/debugging.md."""

    def run(self) -> int:
        """0 when the editor has left, 2 if what it said was no message."""
        from assistant.virtual.debugging import Adapter

        # Not buffered: a reading thread that holds the buffer's lock would stop Python from ending.
        source = FileIO(sys.stdin.fileno(), closefd=False)
        adapter = Adapter(source, sys.stdout.buffer, _launched_programs)
        adapter.serve()
        if adapter.broken:
            print_findings([_BROKEN_MESSAGE(reason=adapter.broken)], explained=True)
            return 2
        return 0


_NOT_A_TRACE: Final = error("CL021", "a trace is not written as `{name}`", "end its name in .npz")
_STEPPED_AS_JSON: Final = error(
    "CL028", "a run is not stepped through as JSON", "leave out --format json, --step and --break"
)
_PLOT_WITHOUT_ROBOT: Final = error(
    "CL029", "without a robot there is no motion to draw", "name one with --robot"
)
_BAD_LIMIT: Final = error("CL023", "--{option} is {value:g}", "write a number above 0")
_NOT_REACHED: Final = warning(
    "CL024", "the run never came to {where}", "name a line with a statement that is run"
)
_NO_MOTION: Final = info(
    "CL025",
    "no robot is named, so motions take no time and reach anything",
    "name one with --robot; `robot-assistant robots` lists them",
)
_NOT_USED: Final = warning("CL026", "no program uses the signal `{name}` of the script", "{cure}")


class _PrintedRun:
    """One run, with what is printed of it."""

    def __init__(
        self,
        programs: Programs,
        options: Run,
        arm: Robot | None,
        script: Script,
    ) -> None:
        from assistant.compiler.simulated_run import unknown_visits
        from assistant.virtual.kernel.script import follow
        from assistant.virtual.program_run import Settings, prepared
        from assistant.virtual.run_log import ColumnWidths

        self.programs, self.options, self.format = programs, options, options.format
        self.names = programs.names()
        script = self.names.keyed(script)
        self.arm, self.sources = arm, programs.sources()
        self.read = list(fold(finding.within(programs.title) for finding in programs.findings))
        self.findings = [
            *self.read,
            *_unused_signals(programs, self.names, script),
            *unknown_visits(script, self.sources),
        ]
        settings = Settings(
            robot=arm,
            entry=options.entry,
            # Names that only an expression reads are signals if they are inputs.
            inputs=programs.known_inputs() | {one.name: 0.0 for one in script.changes},
            most_steps=options.max_steps,
            most_time=options.max_time,
            pace=1.0 if options.real_time else None,
            disk=options.disk,
            hosts=hosts_of(options.hosts),
            lines=line_targets(options.lines),
            options=script.options,
        )
        self.kernel = prepared(programs, settings)
        if arm is None:
            self.findings.append(_NO_MOTION())
        self.given = follow(self.kernel, script, self.sources)
        self.tasks = [task.name for task in self.kernel.tasks]
        self.columns = ColumnWidths.of(self.tasks, self.sources)
        self.printed = self.changed = 0
        self.until = time_or_line(options.until, self.sources)
        self.points = [line_named(point, self.sources) for point in options.breaks]
        self.reached: set[Place] = set()
        self.interrupted = False
        if self.live:
            self.kernel.told.append(lambda _: self.flush())
        if options.ask:
            answer_from_input(self.kernel, self.flush if self.live else lambda: None)

    @property
    def live(self) -> bool:
        """True if events are printed while they happen."""
        one = self.options
        lasts = one.real_time or one.ask or one.disk is not None or bool(one.lines)
        return lasts and self.format is Format.TEXT

    def run(self) -> int:
        from assistant.virtual.run_log import NOTED, end_finding, summary

        self._prepare_stops()
        quiet = self.live or self.options.step or bool(self.points)
        shown = nullcontext() if quiet else working(f"running {self.programs.title}")
        with shown, self._ended_by_hand():
            run = self.kernel.run()
        wrong = end_finding(run, self.sources)
        notes = [NOTED(what=note) for note in run.notes]
        findings = [*self.findings, *notes, *self._missed(), *([] if wrong is None else [wrong])]
        written = self._written(run)
        if self.format is Format.JSON:
            print_json(self._answer(run, findings, written))
        else:
            self.flush()
            say(f"{self.programs.title}: {_ENDINGS[run.ended]}: {summary(run)}")
            sys.stdout.flush()
            print_findings(findings, explained=True)
            for path in written:
                say(f"wrote {path}")
        # What is odd about a source, as a drawing, keeps nothing from running.
        bad = (f for f in findings if f not in self.read and f.severity is not Severity.INFO)
        if self.interrupted:
            raise KeyboardInterrupt
        return 1 if any(bad) else 0

    @contextmanager
    def _ended_by_hand(self) -> Iterator[None]:
        """End the run before its next statement on Ctrl-C; its events until then are reported.

        SIGTERM and SIGHUP do the same; a second signal ends the command at once.
        """
        from assistant.base.termination import ORDINARY_SIGNALS, Terminated, signals_handled
        from assistant.virtual.kernel import Ending

        def interrupt(number: int, _frame: object) -> None:
            if self.interrupted:
                raise Terminated(number)
            self.interrupted = True
            self.kernel.watch = lambda task: self.kernel.halt(task, Ending("until"))

        if self.options.step or self.points or self.options.ask:
            yield  # A person is asked there, who can end the run.
            return
        with signals_handled(interrupt, ORDINARY_SIGNALS):
            yield

    # ------------------------------------------------------------------------------- stops

    def _prepare_stops(self) -> None:
        """Has the run end or be held where the options say."""
        from assistant.cli.step_console import StepConsole
        from assistant.virtual.kernel import Ending

        stepping = None
        if self.options.step or self.points:
            stepping = StepConsole(self.kernel, self.sources, self.names, self.flush)
            stepping.begin(self.points, at_once=self.options.step)
        place = None
        if isinstance(self.until, float):
            self.kernel.at(self.until, lambda: self.kernel.end(Ending("until")))
        else:
            place = self.until
        wanted = {*self.points, *([] if place is None else [place])}
        if not wanted and stepping is None:
            return

        def watch(task: Task) -> None:
            here = task.where()
            if here in wanted:
                self.reached.add(here)
            if here is not None and here == place:
                self.kernel.halt(task, Ending("until"))
            if stepping is not None:
                stepping.watch(task)

        self.kernel.watch = watch

    def _missed(self) -> Iterator[Diagnostic]:
        wanted = [*self.points, *([self.until] if isinstance(self.until, tuple) else [])]
        for place in dict.fromkeys(wanted):
            if place not in self.reached:
                yield _NOT_REACHED(path=place[0], line=place[1], where=f"{place[0]}:{place[1]}")

    # ---------------------------------------------------------------------------- printing

    def flush(self) -> None:
        """Prints what happened since the last time."""
        from assistant.virtual.events import Logged
        from assistant.virtual.run_log import ColumnWidths, log_rows

        first, log = self.printed, self.kernel.log[self.printed :]
        given = self.given[self.changed :]
        self.printed, self.changed = first + len(log), len(self.given)
        if not {row.task for row in log} <= {*self.tasks}:  # that others have started
            self.tasks = list(dict.fromkeys((*self.tasks, *(row.task for row in log))))
            self.columns = ColumnWidths.of(self.tasks, self.sources)
        for row in map(self.names.shown, log_rows(log, given, first)):
            if isinstance(row, Logged):
                say(self.columns.line(row.time, row.task, row.place, row.what))
            else:
                say(self.columns.line(row.time, "", None, row))
        if self.live:
            sys.stdout.flush()

    def _answer(
        self, run: EndedRun, findings: Sequence[Diagnostic], written: Sequence[Path]
    ) -> dict[str, Any]:
        from assistant.findings.formats import records_of
        from assistant.virtual.run_log import json_record, log_rows

        path, line = run.place or (None, None)
        return {
            "programs": self.programs.title,
            "robot": None if self.arm is None else self.arm.name,
            "ended": run.ended,
            "message": run.message,
            "task": run.task or None,
            "file": path,
            "line": line,
            "seconds": run.seconds,
            "statements": run.steps,
            "events": list(map(json_record, map(self.names.shown, log_rows(run.log, self.given)))),
            "findings": records_of(findings),
            "written": [str(path) for path in written],
        }

    def _written(self, run: EndedRun) -> list[Path]:
        from assistant.base.file_sets import write_all
        from assistant.virtual.run_log import event_columns, motion_columns, npz

        trace, plot = self.options.trace, self.options.plot
        if trace is None and plot is None:
            return []
        run = replace(run, log=tuple(map(self.names.logged, run.log)))
        given = list(map(self.names.changed, self.given))
        samples = motion_columns(run, given, self.kernel.motion, self.options.period)
        files: dict[Path, bytes] = {}
        if trace is not None:
            files[trace] = npz({**event_columns(run, given), **samples})
        if plot is not None and self.arm is not None:
            from assistant.report.figures import format_of, run_plot

            title = f"{PurePath(self.programs.title).name} on {self.arm.title}"
            files[plot] = run_plot(samples, self.arm, title, format_of(plot.name))
        return list(write_all(files))


def _unused_signals(programs: Programs, names: SignalNames, script: Script) -> Iterator[Diagnostic]:
    """Signals of a script that no program uses, most likely misspelled."""
    from assistant.base.near_names import near_name
    from assistant.virtual.kernel.script import When

    known = programs.signals()
    if known is None and names.numbered:
        known = frozenset(name.lower() for name in (*names.inputs.values(), *names.groups))
    if known is None:
        return
    for name in dict.fromkeys(
        [one.name for one in script.changes]
        + [one.when.name for one in script.changes if isinstance(one.when, When)]
    ):
        if name not in known and not (names.numbered and name.isdecimal()):
            near = near_name(name, known)
            if names.numbered and not near:
                continue  # a hand or another name that no header lists
            cure = f"write `{near}`" if near else "name a signal that they use"
            yield _NOT_USED(name=name, cure=cure)


_ENDINGS: Final = {
    "end": "came to its end",
    "stopped": "stands and cannot go on",
    "steps": "was broken off",
    "time": "was broken off",
    "error": "ended with an error",
    "unknown": "was broken off",
    "until": "was ended as asked",
}


_NOT_A_HOST: Final = error(
    "CL030",
    "`{given}` names no host for an address",
    "write ADDRESS=HOST, as 192.168.125.1=127.0.0.1",
)
_NO_FOLDER: Final = error("CL031", "there is no folder `{folder}`", "make it, or name another one")
INPUT_IS_PROGRAM: Final = error(
    "CL032", "the program itself is read from standard input", "name its file, or leave --ask out"
)


_NOT_A_LINE: Final = error(
    "CL033",
    "`{given}` leads no line anywhere",
    "write NAME=PORT, NAME=HOST:PORT or NAME=PATH, as COM1=10003",
)
_NAMED_TWICE: Final = error("CL043", "`{name}` is led to two places", "name it once")


def check_disk_folder(folder: Path | None) -> None:
    if folder is not None and not folder.is_dir():
        raise Refused(_NO_FOLDER(folder=folder), exit_status=2)


def hosts_of(given: Sequence[str]) -> dict[str, str]:
    """Hosts by address; raises Refused for what names none."""
    return _named_values(given, _NOT_A_HOST)


def line_targets(given: Sequence[str]) -> dict[str, str]:
    """Return the endpoint of each line by its name; raise Refused for an argument without a
    name.
    """
    return _named_values(given, _NOT_A_LINE)


def _named_values(given: Sequence[str], wrong: Rule) -> dict[str, str]:
    pairs: dict[str, str] = {}
    named: set[str] = set()
    for pair in given:
        name, _, value = (part.strip() for part in pair.partition("="))
        if not name or not value:
            raise Refused(wrong(given=pair), exit_status=2)
        known = name.rstrip(":").upper()
        if known in named:
            raise Refused(_NAMED_TWICE(name=name), exit_status=2)
        named.add(known)
        pairs[name] = value
    return pairs


def answer_from_input(kernel: Kernel, flush: Callable[[], None]) -> None:
    """Has what programs ask answered on standard input, as long as there is more of it.

    flush: prints what happened until then.
    """

    def asked(question: str) -> str | None:
        kernel.catch_up()
        flush()
        sys.stderr.write(f"answer to `{visible(question)}`: ")
        sys.stderr.flush()
        line = sys.stdin.readline()
        return line.strip() if line else None

    kernel.person.console = asked


_NOT_A_TIME: Final = error("CL022", "`{given}` is no time", "write seconds, 0 or more")
_NOT_A_LINE_OF_PROGRAM: Final = error(
    "CL027",
    "`{given}` is no place in the programs",
    "write FILE:LINE, the file one of {names}, and one of its lines",
)


def time_or_line(given: str | None, sources: Sequence[SourceText]) -> float | Place | None:
    """Seconds, or a file and a line."""
    if given is None:
        return None
    try:
        seconds = float(given)
    except ValueError:
        return line_named(given, sources)
    if not 0.0 <= seconds < float("inf"):
        raise Refused(_NOT_A_TIME(given=given), exit_status=2)
    return seconds


def line_named(given: str, sources: Sequence[SourceText]) -> Place:
    """FILE:LINE, the file as the programs' own is named, with or without folder and suffix."""
    name, _, number = given.rpartition(":")
    wanted = name.replace("\\", "/").casefold()
    shapes: tuple[Callable[[PurePath], str], ...] = (
        PurePath.as_posix,
        lambda path: path.name,
        lambda path: path.stem,
    )
    for shape in shapes:
        found = [s for s in sources if shape(PurePath(s.path or "")).casefold() == wanted]
        if len(found) == 1 and number.isascii() and number.isdecimal():
            line = int(number)
            if 1 <= line <= found[0].text.count("\n") + 1:
                return found[0].path or "", line
    raise Refused(_NOT_A_LINE_OF_PROGRAM(given=given, names=_file_names(sources)), exit_status=2)


def _file_names(sources: Sequence[SourceText]) -> str:
    return ", ".join(f"`{PurePath(source.path or '').name}`" for source in sources) or "none"


_WRONG_LAUNCH: Final = error(
    "CL120",
    "the editor's launch request is wrong: {reason}",
    "name program, and where wanted {known}, in the configuration that the editor launches",
)
_BROKEN_MESSAGE: Final = error(
    "CL121",
    "what was read is no message of the Debug Adapter Protocol: {reason}",
    "let an editor start this command; to run a program in a terminal there is `run`",
)
LAUNCH_KEYS: Final[Mapping[str, type]] = {
    "program": str,
    "robot": str,
    "language": str,
    "signals": str,
    "entry": str,
    "maxSteps": int,
    "stopOnEntry": bool,
}
"""Keys of a launch configuration; `program` may be a list of texts too."""
_EDITOR_KEY_PREFIX: Final = frozenset({"type", "request", "name", "cwd", "noDebug", "presentation"})
"""Keys that editors add, besides names that begin with two underscores."""


def _launched_programs(wanted: Object) -> tuple[Kernel, Lines, SignalNames]:
    """The programs of a launch request, ready to run, their lines, and the names of their signals.

    Raises Refused.
    """
    from assistant.compiler.arms import robot_of
    from assistant.compiler.simulated_run import programs
    from assistant.virtual.debugging.break_points import statement_lines
    from assistant.virtual.program_run import MOST_STEPS, Settings, prepared

    for name, value in wanted.items():
        if name.startswith("__") or name in _EDITOR_KEY_PREFIX:
            continue
        if name not in LAUNCH_KEYS:
            raise _wrong_launch(f"`{name}` is not known")
        if name == "program" and isinstance(value, list):
            continue
        if not isinstance(value, LAUNCH_KEYS[name]):
            raise _wrong_launch(f"`{name}` is no {_TYPE_NAMES[LAUNCH_KEYS[name]]}")
    program = wanted.get("program")
    named = program if isinstance(program, list) else [program]
    if not named or not all(isinstance(one, str) and one for one in named):
        raise _wrong_launch("`program` names no file")
    texts = {name: value for name, value in wanted.items() if isinstance(value, str)}
    robot = robot_of(texts.get("robot"))
    steps = wanted.get("maxSteps")
    found = programs(
        [str(one) for one in named],
        language=texts.get("language"),
        robot=robot,
        entry=texts.get("entry"),
        cell=cell_of(str(named[0])),
    )
    most = steps if isinstance(steps, int) and steps > 0 else MOST_STEPS
    settings = Settings(
        robot=robot, entry=texts.get("entry"), most_steps=most, inputs=found.known_inputs()
    )
    return prepared(found, settings), statement_lines(found), found.names()


def _wrong_launch(reason: str) -> Refused:
    known = ", ".join(name for name in LAUNCH_KEYS if name != "program")
    return Refused(_WRONG_LAUNCH(reason=reason, known=known), exit_status=2)


_TYPE_NAMES: Final[Mapping[type, str]] = {str: "text", int: "whole number", bool: "truth"}
