"""A session with a controller: found by name or address, connected to, confirmed and described.

The user at a terminal is prompted for a password. A connection without encryption is noted once.
Commands that may move an arm are confirmed by `--yes`, or by typing the controller's name.
"""

from __future__ import annotations

import getpass
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.cli.command import Argument, Option
from assistant.cli.presentation import Format, note, print_json, say
from assistant.controllers.states import record as record

if TYPE_CHECKING:
    from assistant.controllers import Controller, Named, Programs
    from assistant.controllers.states import Fault, Position, State
    from assistant.robots import Robot


_NO_VALUE: Final = error("CL201", "`{given}` gives nothing a value", "write NAME=VALUE")
_NO_NUMBER: Final = error("CL202", "`{given}` is no number", "write NAME=NUMBER, as doGrip=1")


def complete_controller(incomplete: str) -> list[str]:
    from assistant.controllers import controllers_of

    return [name for name in controllers_of(Path.cwd()) if name.startswith(incomplete)]


CellArgument = Annotated[
    str,
    Argument(
        "Its name in [controllers] of assistant.toml, or its address.",
        metavar="CONTROLLER",
        completions=complete_controller,
    ),
]
YesOption = Annotated[bool, Option("Do it without asking. Look that nobody is near.", "--yes")]
ReplaceOption = Annotated[bool, Option("Also what is there already.", "--replace")]


def named_by(text: str) -> Named:
    from assistant.controllers import named

    return named(text)


def new_client(one: Named, timeout: float | None = None) -> Programs:
    """Return a client that is not connected yet; it asks for a password if a user can answer."""
    from assistant.controllers import connect

    _note_clear_text(one)
    client = connect(one, ask=_ask_password if sys.stdin.isatty() else None, timeout=timeout)
    if hasattr(client, "tell"):
        client.tell = lambda finding: note(str(one.address), finding)
    return client


def _note_clear_text(one: Named) -> None:
    """Says that what is sent can be read on the way, once, unless the project has accepted it."""
    from assistant.controllers.address import clear_text_finding
    from assistant.findings.severities import severities_for

    told = clear_text_finding(one.address)
    wanted = told and severities_for(Path.cwd()).of(told)
    if wanted:
        note(str(one.address), wanted)


def _ask_password(prompt: str) -> str | None:
    return getpass.getpass(prompt)


@dataclass(frozen=True, slots=True)
class Session:
    """A controller that is connected to. command: that is carried out, for what it cannot do."""

    one: Named
    session: Programs
    command: str

    @property
    def controller(self) -> Controller:
        """The session, to look at the controller and to operate it; raises Refused."""
        from assistant.controllers import Controller

        if not isinstance(self.session, Controller):
            raise Refused(_not_supported(self.one, self.command), exit_status=2)
        return self.session


def _not_supported(one: Named, command: str) -> Diagnostic:
    from assistant.controllers import rules
    from assistant.controllers.address import SCHEMES

    title = SCHEMES[one.address.scheme].title
    return rules.NOT_HERE(
        place=str(one.address),
        address=one.address,
        what=f"do `{command}`",
        reason=f"{title} keeps programs and no more",
        cure="name an address by which the controller is operated, as docs/controllers lists them",
    )


def _open_client(one: Named) -> AbstractContextManager[Programs]:
    """A client that is not connected yet; a virtual controller of the project runs meanwhile."""
    if one.virtual is None:
        return nullcontext(new_client(one))
    from assistant.project import project_of
    from assistant.project.virtual_controllers import running_client

    return running_client(one, project_of().kept)


@contextmanager
def connected(text: str, command: str) -> Iterator[Session]:
    """A controller by its name or address, connected to. What it cannot do is wrong usage."""
    from assistant.controllers import rules

    one = named_by(text)
    try:
        with _open_client(one) as client, client as session:
            yield Session(one, session, command)
    except Refused as refused:
        if any(finding.code == rules.NOT_HERE.code for finding in refused.findings):
            raise Refused(*refused.findings, exit_status=2) from None
        raise


def robot_of_cell(one: Named) -> Robot | None:
    """The arm that the project says a controller moves, None if it does not say."""
    from assistant.compiler.arms import robot_of

    return robot_of(one.robot)


def print_there(
    there: Session, format: Format, answer: Mapping[str, object], lines: Iterable[str]
) -> None:
    """Print an answer of a controller: a record with its address for programs, or lines."""
    if format is Format.JSON:
        print_json(record({"address": str(there.one.address), **answer}))
        return
    for line in lines:
        say(line)


def print_state(there: Session, state: State, done: str, format: Format) -> None:
    """Print the state of a controller after a command. done: what the command did."""
    lines = (f"{there.one.name}: {done}", *state_lines(state))
    print_there(there, format, {"state": state}, lines)


# ---------------------------------------------------------------------------------- arguments


def assignments(given: Sequence[str]) -> tuple[list[str], dict[str, str]]:
    """Names to read, and names with the values that they get; raises Refused."""
    read, written = [], {}
    for one in given:
        name, is_set, value = one.partition("=")
        name = name.strip()
        if not name or (is_set and not value.strip()):
            raise Refused(_NO_VALUE(given=one), exit_status=2)
        if is_set:
            written[name] = value.strip()
        else:
            read.append(name)
    return read, written


def output_value(name: str, value: str) -> float:
    """Return the value to set an output to; `on` and `off` count as numbers."""
    words = {"on": 1.0, "off": 0.0}
    try:
        found = float(words.get(value.lower(), value))
    except ValueError:
        found = float("nan")
    if not abs(found) < float("inf"):
        raise Refused(_NO_NUMBER(given=f"{name}={value}"), exit_status=2)
    return found


# ------------------------------------------------------------------------------------ answers


def joints_line(position: Position) -> str:
    """`J1 0.00  J2 10.00  …` of the axes that there are."""
    there = ((i, j) for i, j in enumerate(position.joints, 1) if j is not None)
    return "  ".join(f"J{i} {round(j, 2) + 0.0:.2f}" for i, j in there)


def pose_line(position: Position) -> str:
    """Position in mm and quaternion of the tool."""
    x, y, z = (round(part, 2) + 0.0 for part in position.position)
    q = ", ".join(f"{round(part, 5) + 0.0:.5f}" for part in position.quaternion)
    return f"x {x:.2f}  y {y:.2f}  z {z:.2f} mm  quaternion ({q})"


def state_lines(state: State) -> Iterator[str]:
    """Return the state of a controller, one line per task and per fault."""
    words = [
        state.mode or "mode unknown",
        "motors on" if state.motors else "motors off",
        "running" if state.running else "standing",
    ]
    if state.override is not None:
        words.append(f"override {state.override} %")
    if state.emergency:
        words.append("EMERGENCY STOP")
    yield ", ".join(words)
    for task in state.tasks:
        line = "" if task.line is None else f" line {task.line}"
        does = "running" if task.running else "stopped"
        if task.program:
            yield f"task {task.name}: {task.program}{line}, {does}"
    for fault in state.faults:
        yield fault_line(fault)


def fault_line(fault: Fault) -> str:
    when = f"{fault.time:%Y-%m-%d %H:%M:%S}  " if fault.time is not None else ""
    return f"{when}{fault.level} {fault.number}: {fault.text}"


_NOT_CONFIRMED: Final = error(
    "CL203",
    "this {what}, and nobody confirmed it; nothing was changed",
    "look that nobody is near, then add --yes, or run it in a terminal and type `{word}`",
)
_OTHER_WORD: Final = error(
    "CL204",
    "`{word}` was not typed, so nothing was changed",
    "type it as it stands there to confirm",
)


def confirm(one: Named, what: str, yes: bool) -> None:
    """Returns if somebody wants it; raises Refused else. what: it does, to be read after "this"."""
    if yes:
        return
    if not sys.stdin.isatty():
        raise Refused(
            _NOT_CONFIRMED(place=str(one.address), what=what, word=one.word), exit_status=2
        )
    sys.stderr.write(f"{one.name}: this {what}.\nType `{one.word}` to confirm: ")
    sys.stderr.flush()
    if sys.stdin.readline().strip() != one.word:
        raise Refused(_OTHER_WORD(place=str(one.address), word=one.word), exit_status=2)
