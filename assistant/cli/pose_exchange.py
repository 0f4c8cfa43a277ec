"""Exchange poses with a running program by files: `exchange …`.

`module` writes the robot's side; `pose` asks where the robot is; `follow` sends poses one after
the other and asks before; `stop` ends the program, without asking. A plain exchange uses text
files with fixed names and no numbers or checksums. Lengths are mm, times seconds.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

from assistant.base.diagnostics import Refused, Severity, error, warning
from assistant.cli.command import Option, argument, command_group, command_of, option, options
from assistant.cli.controller_session import (
    CellArgument,
    Session,
    YesOption,
    confirm,
    connected,
    print_there,
)
from assistant.cli.options import FormatOption
from assistant.cli.presentation import LengthUnit, console, print_findings, say

if TYPE_CHECKING:
    from assistant.controllers import Programs
    from assistant.controllers.abb.exchange import (
        Answer,
        PlainExchange,
        PlainFiles,
        PoseExchange,
        PoseSender,
    )
    from assistant.program.geometry import Target
    from assistant.program.motion import Path as Poses
    from assistant.program.statements import Motion


exchange: Final = command_group(
    "Exchange poses with a running program, by files on the controller."
)
PrefixOption = Annotated[str, Option("How the names of the files begin.", default="exchange")]
TimeoutOption = Annotated[
    float, Option("Seconds for an answer without a motion.", default=10.0, min=0.1)
]


@options
class PlainOptions:
    """Files of a plain exchange."""

    plain: bool = option("Plain text files, without numbers and checksums.")
    files: str | None = option(
        "With --plain: names of the files from the PC, the one that is waited for first.",
        metavar="POSITION,ORIENTATION,CONFIGURATION",
    )
    answers: str | None = option(
        "With --plain: names of the files from the robot.",
        metavar="POSITION,ORIENTATION,CONFIGURATION",
    )

    def names(self, others: Mapping[str, bool]) -> PlainFiles | None:
        """Return the file names of a plain exchange; None for the numbered one.

        others: options that only the numbered one has, and whether they are given. Raises Refused
        for them with --plain, and for --files and --answers without it.
        """
        from assistant.controllers.abb.exchange import PlainFiles

        if not self.plain:
            for option, given in (("--files", self.files), ("--answers", self.answers)):
                if given is not None:
                    raise Refused(_ONLY_PLAIN(option=option), exit_status=2)
            return None
        for option, is_given in others.items():
            if is_given:
                reason = "the robot stands still at each pose"
                raise Refused(_NOT_PLAIN(option=option, reason=reason), exit_status=2)
        usual = PlainFiles()
        return PlainFiles(
            usual.sent if self.files is None else _answer_names(self.files),
            usual.answers if self.answers is None else _answer_names(self.answers),
        )


@command_of(exchange)
class Module:
    """Write the robot's side: a module that waits for poses, goes there and answers."""

    output: str = option(
        "File to write; - prints it.", "--output", "-o", default="PoseExchange.mod"
    )
    name: str | None = option("Name of the module.")
    tool: str | None = option("Tool that is moved.")
    tip: str | None = option("x,y,z[,w,x,y,z] of its tip, mm on the flange: declares the tool.")
    mass: float = option("Of that tool, kg.", default=1.0)
    centre: str = option("x,y,z of its centre of gravity, mm.", default="0,0,50")
    work_object: str | None = option("Frame that poses are in.")
    speed: str | None = option("Name of the speed.")
    zone: str | None = option("Name of the zone of poses on the way.")
    folder: str | None = option("Folder of the files there.")
    prefix: PrefixOption
    longest: float = option("Seconds without a request after which it ends.", default=240.0)
    plain: PlainOptions

    def run(self) -> int:
        """Prints the module, looks through it as `check` does, and writes it."""
        given = {
            "module": self.name,
            "tool": self.tool,
            "work_object": self.work_object,
            "speed": self.speed,
            "zone": self.zone,
            "folder": self.folder,
        }
        named = {key: value for key, value in given.items() if value is not None}
        plain = self.plain.names({"--zone": self.zone is not None})
        from assistant import languages
        from assistant.base.file_sets import write_files
        from assistant.controllers.abb.exchange import LANGUAGE, Module, Tool

        tool = None
        if self.tip is not None:
            place, turn = _tool_pose(self.tip)
            middle = _listed_numbers(self.centre, (3,), "x,y,z")
            tool = Tool(place, turn, self.mass, (middle[0], middle[1], middle[2]))
        usual = Module()
        text = Module(
            module=named.get("module", usual.module),
            tool=named.get("tool", usual.tool),
            work_object=named.get("work_object", usual.work_object),
            speed=named.get("speed", usual.speed),
            zone=named.get("zone", usual.zone),
            folder=named.get("folder", usual.folder),
            prefix=self.prefix,
            longest=self.longest,
            tool_data=tool,
            plain=plain,
        ).text()
        language = languages.get(LANGUAGE)
        tree = language.parse(text)
        found = [*tree.findings, *language.check([tree])]
        wrong = [finding for finding in found if finding.severity is Severity.ERROR]
        if wrong:
            raise Refused(*wrong)
        print_findings(found)
        if self.output == "-":
            sys.stdout.write(text)
            return 0
        target = Path(self.output)
        write_files({target.name: text.encode("ascii")}, target.parent)
        say(f"{target}: copy it to the controller, load it, and start it from its first line")
        return 0


@command_of(exchange)
class Pose:
    """Ask the program where the robot is. Nothing moves."""

    cell: CellArgument
    prefix: PrefixOption
    timeout: TimeoutOption
    plain: PlainOptions
    format: FormatOption

    def run(self) -> int:
        plain = self.plain.names({})
        with connected(self.cell, "exchange pose") as there:
            exchange = _pose_sender(there.session, self.prefix, self.timeout, self.timeout, plain)
            answer = exchange.current_pose()
        _warn_without_checksum(answer.checked if plain is None else None, str(there.one.address))
        print_there(there, self.format, _answer_record(answer), (_answer_line(answer),))
        return 0


@command_of(exchange)
class Follow:
    """Send poses one after the other; the arm goes to each. Asks before; Ctrl-C stops it."""

    cell: CellArgument
    trajectory: Path = argument("Poses: csv, json, npy, npz, toml.")
    through: bool = option("Without standing still at each pose.")
    record: Path | None = option("Write what was answered.", metavar="FILE.csv|npz")
    plot: Path | None = option("Draw what was answered.", metavar="FILE.png|svg")
    plot_unit: LengthUnit = option("Unit of the positions that are drawn.", default=LengthUnit.MM)
    prefix: PrefixOption
    timeout: TimeoutOption
    longest: float = option("Seconds for one motion.", default=240.0, min=0.1)
    plain: PlainOptions
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        plain = self.plain.names({"--through": self.through})
        from assistant.controllers.recording import check_place
        from assistant.report import figures

        if self.plot is not None:
            figures.format_of(self.plot.name)
            figures.new_figure(1.0, 1.0)  # before the arm moves, whether a picture can be drawn
        if self.record is not None:
            check_place(self.record)
        path = _read_poses(self.trajectory)
        with connected(self.cell, "exchange follow") as there:
            how = "through" if self.through else "to"
            confirm(
                there.one, f"moves the arm {how} {len(path)} poses of `{self.trajectory}`", self.yes
            )
            exchange = _pose_sender(there.session, self.prefix, self.timeout, self.longest, plain)
            try:
                with (
                    _ended_otherwise(str(there.one.address), exchange),
                    exchange,
                    _progress_bar(len(path)) as advance,
                ):
                    _warn_without_checksum(exchange.checked, str(there.one.address))
                    exchange.follow(
                        path,
                        configurations=_configurations(path),
                        through=self.through,
                        progress=lambda *_: advance(),
                    )
            finally:
                self._write_answers(exchange)
        self._print_round_trips(exchange, there)
        return 0

    def _write_answers(self, exchange: PoseSender) -> None:
        """Writes what was answered, also of an exchange that was broken off."""
        if not len(exchange.recording):
            return
        if self.record is not None:
            exchange.recording.save(self.record)
            say(f"wrote {self.record}")
        if self.plot is not None:
            from assistant.base.file_sets import write_files
            from assistant.report import figures

            column = exchange.recording.column
            picture = figures.exchange_plot(
                column("seconds"),
                column("position"),
                column("quaternion"),
                f"{self.trajectory.name}: the TCP over the time",
                figures.format_of(self.plot.name),
                self.plot_unit.value,
            )
            write_files({self.plot.name: picture}, self.plot.parent)
            say(f"wrote {self.plot}")

    def _print_round_trips(self, exchange: PoseSender, there: Session) -> None:
        """Print the duration of the round trips, split into their parts."""
        parts = ["round_trip", "hand_over", "waiting", "fetching"]
        if not self.plain.plain:  # whose files do not tell how long a motion took
            parts.append("motion")
        taken = {part: float(exchange.recording.column(part)[1:].mean()) for part in parts}
        count = len(exchange.recording) - 1
        lines = [
            f"{count} poses; each took {taken['round_trip']:.3f} s on average:",
            f"  {taken['hand_over']:.3f} s until the request was there",
        ]
        if self.plain.plain:
            said = "for the motion, and until both sides had looked for files"
            lines.append(f"  {taken['waiting']:.3f} s {said}")
        else:
            looking = max(0.0, taken["waiting"] - taken["motion"])
            lines += [
                f"  {taken['motion']:.3f} s for the motion, as the controller measured",
                f"  {looking:.3f} s until both sides had looked for a file",
            ]
        lines.append(f"  {taken['fetching']:.3f} s to fetch the answer")
        print_there(there, self.format, {"poses": count, "seconds": taken}, lines)


@command_of(exchange)
class Stop:
    """Stop the arm where it is and end the program. Never asks; no emergency stop."""

    cell: CellArgument
    prefix: PrefixOption
    timeout: TimeoutOption
    format: FormatOption

    def run(self) -> int:
        from assistant.controllers.abb.exchange import PoseExchange

        with connected(self.cell, "exchange stop") as there:
            exchange = PoseExchange(there.session, prefix=self.prefix, timeout=self.timeout)
            answer = exchange.stop()
        if answer is None:
            raise Refused(_NOT_STOPPED(place=str(there.one.address), ended=exchange.ended))
        lines = (f"{there.one.name}: {exchange.ended}", _answer_line(answer))
        print_there(there, self.format, _answer_record(answer), lines)
        return 0


_BAD_LIST: Final = error("CL261", "`{given}` is not {wanted}", "write them with commas between")
_NOT_ONE_PATH: Final = error(
    "CL262",
    "`{name}` holds {found} paths of poses, and an exchange follows one",
    "name a table of poses, one in each row",
)
_SEVERAL: Final = error(
    "CL265",
    "the poses of `{name}` are of several {what} ({first}, {second}); an exchange has one of each, "
    "which its module names",
    "divide the table",
)
_BROKEN_OFF: Final = warning(
    "CL263", "broken off: {ended}", "look at the robot before anything else"
)
_NOT_STOPPED: Final = error(
    "CL264", "{ended}", "press the emergency stop if the arm moves, and look at it"
)
_NOT_PLAIN: Final = error(
    "CL266", "a plain exchange has no `{option}`: {reason}", "leave one of both out"
)
_ONLY_PLAIN: Final = error(
    "CL267", "`{option}` names files of a plain exchange, and --plain is missing", "add --plain"
)


def _answer_names(given: str) -> tuple[str, str, str]:
    names = [name.strip() for name in given.split(",")]
    if len(names) != 3:
        wanted = "three names: of position, orientation and configuration"
        raise Refused(_BAD_LIST(given=given, wanted=wanted), exit_status=2)
    return names[0], names[1], names[2]


def _pose_sender(
    programs: Programs,
    prefix: str,
    timeout: float,
    longest: float,
    plain: PlainFiles | None,
) -> PoseExchange | PlainExchange:
    from assistant.controllers.abb.exchange import PlainExchange, PoseExchange

    if plain is None:
        return PoseExchange(programs, prefix=prefix, timeout=timeout, longest=longest)
    return PlainExchange(programs, files=plain, prefix=prefix, timeout=timeout, longest=longest)


def _warn_without_checksum(checked: bool | None, place: str) -> None:
    """Report a module that writes no checksum."""
    if checked is False:
        from assistant.controllers.abb.exchange import rules

        print_findings([rules.UNCHECKED(place=place)])


@contextmanager
def _ended_otherwise(place: str, exchange: PoseSender) -> Iterator[None]:
    """Says in which state the robot is if the exchange ends otherwise than it should."""
    try:
        yield
    except BaseException:
        if exchange.ended:
            rule = _BROKEN_OFF if exchange.stands else _NOT_STOPPED
            print_findings([rule(place=place, ended=exchange.ended)])
        raise


@contextmanager
def _progress_bar(total: int) -> Iterator[Callable[[], None]]:
    """A progress bar on a terminal; nothing elsewhere."""
    if not sys.stderr.isatty():
        yield lambda: None
        return
    from rich.progress import Progress

    with Progress(console=console(), transient=True) as progress:
        task = progress.add_task("poses", total=total)
        yield lambda: progress.advance(task)


def _read_poses(source: Path) -> Poses:
    """The one path of a table, of one pose too; raises Refused if there is not one."""
    from assistant import sources
    from assistant.program.expressions import Name
    from assistant.program.statements import Follow, Move

    reading = sources.read(source)
    print_findings(reading.findings)
    found: list[Poses] = []
    for statement in (one for procedure in reading.program.procedures for one in procedure.body):
        match statement:
            case Follow(path):
                found.append(path)
            case Move(target=Name(name), motion=motion):
                found.append(_single_pose(reading.program.targets[name], motion))
    if len(found) != 1 or not len(found[0]):
        raise Refused(_NOT_ONE_PATH(path=str(source), name=source.name, found=len(found)))
    path = found[0]
    for what, names, rows in (
        ("frames", path.frames, path.frame),
        ("tools", path.tools, path.tool),
    ):
        used = sorted({names[row] for row in set(rows.tolist())})
        if len(used) > 1:
            raise Refused(
                _SEVERAL(
                    path=str(source), name=source.name, what=what, first=used[0], second=used[1]
                )
            )
    return path


def _single_pose(target: Target, motion: Motion) -> Poses:
    from assistant.program.motion import Path as Rows
    from assistant.program.motion import configuration_row

    speed, blend = motion.fixed
    return Rows.of(
        "pose",
        target.pose.position,
        target.pose.quaternion,
        configurations=[configuration_row(target.configuration)],
        external=[target.external],
        speeds=(speed,),
        blends=(blend,),
        tools=(motion.tool,),
        frames=(motion.frame,),
    )


def _configurations(path: Poses) -> list[tuple[int, int, int, int]] | None:
    """Return the configurations in the controller's notation, if every pose states one."""
    from assistant.program.motion import UNSTATED
    from assistant.robots.configurations import to_confdata

    if (path.configurations[:, 0] == UNSTATED).any():
        return None
    rows = to_confdata(path.configurations).tolist()
    return [(one, four, six, x) for one, four, six, x in rows]


def _answer_record(answer: Answer) -> dict[str, object]:
    return {
        "position": list(answer.pose.position),
        "quaternion": list(answer.pose.quaternion),
        "configuration": list(answer.configuration),
    }


def _answer_line(answer: Answer) -> str:
    x, y, z = answer.pose.position
    turn = ", ".join(f"{part:.6f}" for part in answer.pose.quaternion)
    return f"x {x:.2f}  y {y:.2f}  z {z:.2f} mm  quaternion ({turn})  {answer.configuration}"


def _tool_pose(
    tip: str,
) -> tuple[tuple[float, float, float], tuple[float, float, float, float]]:
    x, y, z, *turn = _listed_numbers(tip, (3, 7), "x,y,z or x,y,z,w,x,y,z")
    a, b, c, d = turn or (1.0, 0.0, 0.0, 0.0)
    return (x, y, z), (a, b, c, d)


def _listed_numbers(given: str, counts: tuple[int, ...], wanted: str) -> list[float]:
    try:
        found = [float(part) for part in given.split(",")]
    except ValueError:
        found = []
    if len(found) not in counts:
        raise Refused(_BAD_LIST(given=given, wanted=wanted), exit_status=2)
    return found
