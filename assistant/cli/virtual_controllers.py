"""Serve a virtual controller until Ctrl-C: `virtual irc5` and `virtual cr`.

A generated password is printed, as the user has no other way to learn it. Lines of a program can
lead to files, sockets or serial lines of this computer.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Container, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, TypeVar

from assistant.base.diagnostics import Refused, error
from assistant.base.termination import defer_termination, is_ctrl_c, wait_for_termination
from assistant.cli.command import command_group, command_of, option
from assistant.cli.options import complete_robot
from assistant.cli.presentation import say
from assistant.controllers.address import PASSWORD_VARIABLE

if TYPE_CHECKING:
    from assistant.robots import Robot
    from assistant.virtual.cr import VirtualCr
    from assistant.virtual.irc5 import Signal, VirtualIrc5
    from assistant.virtual.melfa.communication_lines import Line


virtual: Final = command_group("Run a virtual controller on this computer.")


class _Framing(StrEnum):
    """Framing of a serial line."""

    PLAIN = "plain"
    PROCEDURAL = "procedural"
    DATA_LINK = "data-link"


_FRAMINGS: Final[dict[_Framing, Literal["plain", "procedural", "data link"]]] = {
    _Framing.PLAIN: "plain",
    _Framing.PROCEDURAL: "procedural",
    _Framing.DATA_LINK: "data link",
}


@command_of(virtual)
class Irc5:
    """A virtual IRC5: FTP and Robot Web Services over a folder, programs that run in real time."""

    folder: Path = option("Folder that is its HOME:.", default=Path("home"))
    port: int = option("FTP port here; 0 takes a free one.", default=2121)
    user: str = option("Its user.", default="robot")
    robot: str = option(
        "Its arm.", "--robot", "-r", default="irb1200-7-0.7", completions=complete_robot
    )
    rws_port: int = option("Port of Robot Web Services 1.0; 0 takes a free one.", default=0)
    rwss_port: int = option("Port of Robot Web Services 2.0; 0 takes a free one.", default=0)
    signal: tuple[str, ...] = option(
        "A signal of its I/O configuration, as do_grip=DO; repeatable."
    )
    egm: tuple[str, ...] = option(
        "A UdpUc device of EGM and where it sends to, as UCdevice=127.0.0.1:6510; repeatable."
    )
    manual: bool = option("Begin in manual mode.")
    grant: bool = option("Let whoever asks modify in manual mode.")
    pace: float = option("Simulated seconds for each real one.", default=1, min=0.01)
    delay: float = option("Seconds before each answer of Robot Web Services.", default=0.0, min=0.0)

    def run(self) -> int:
        from assistant.compiler.arms import robot_of
        from assistant.virtual.irc5 import VirtualIrc5
        from assistant.virtual.irc5.controller import DEVICES
        from assistant.virtual.irc5.rws_faults import Fault

        arm, given = robot_of(self.robot), os.environ.get(PASSWORD_VARIABLE)
        assert arm is not None
        controller = VirtualIrc5(
            self.folder,
            port=self.port,
            user=self.user,
            password=given,
            report=_print_flushed,
            robot=arm.name,
            rws=self.rws_port,
            rwss=self.rwss_port,
            signals=[_signal_of(text) for text in self.signal],
            devices=DEVICES if not self.egm else dict(_udp_device(text) for text in self.egm),
            mode="MANR" if self.manual else "AUTO",
            grants=self.grant,
            rate=self.pace,
        )
        if self.delay:
            controller.faults.add(Fault("delay", seconds=self.delay))
        about = f"HOME: is {controller.folder}"
        _serve_until_end(controller, about, None if given else controller.password, _print_services)
        return 0


@command_of(virtual)
class Cr:
    """A virtual CR controller: controller link, data link, programs that run in real time."""

    robot: str = option("Its arm.", "--robot", "-r", default="rv-2aj", completions=complete_robot)
    port: int = option(
        "Controller-link port on this computer; 0 takes a free one.",
        default=10001,
        min=0,
        max=65535,
    )
    folder: Path | None = option("Folder of its programs; in memory if left out.")
    data_port: int = option(
        "Port of the line OPT11; those of the data link follow, COM2: at the next one. "
        "0 takes free ones.",
        default=0,
        min=0,
        max=65500,
    )
    mxt_port: int = option(
        "UDP port of real-time external control; 0 takes a free one.",
        default=10000,
        min=0,
        max=65535,
    )
    serial: str | None = option(
        "A serial port to serve too, `pty` to make a line, or `pty:FILE` to make one that"
        " clients find by that name.",
        metavar="PORT",
    )
    framing: _Framing = option("Of the serial line.", default=_Framing.PLAIN)
    line: tuple[str, ...] = option(
        "What a line of its programs leads to, as COM1=10003: a port for others to call,"
        " the HOST:PORT of a server, the path of a serial port, or `pty:FILE` to make one;"
        " repeatable.",
        metavar="NAME=TARGET",
    )
    pace: float = option("Simulated seconds for each real one.", default=1, min=0.01)
    delay: float = option("Seconds before each answer.", default=0.0, min=0.0)
    broken: int = option("How many characters apart one comes broken.", default=0, min=0)
    refuse: tuple[str, ...] = option(
        "A command it refuses, with the error, as SRVON=5600; repeatable."
    )
    contact: str | None = option("Input that is on while the arm touches something of --cell.")
    cell: Path | None = option("File of the cell that the arm is in.")
    log: bool = option("Print each command and answer.")

    def run(self) -> int:
        from assistant.cli.virtual_runs import line_targets
        from assistant.compiler.arms import robot_of
        from assistant.compiler.exploration import contact_test
        from assistant.virtual.cr import Contact, Faults

        arm = robot_of(self.robot)
        assert arm is not None
        felt = None
        if self.contact is not None or self.cell is not None:
            if (
                self.contact is None
                or self.cell is None
                or not re.fullmatch(r"\d{1,5}", self.contact, re.ASCII)
            ):
                raise Refused(_INCOMPLETE_CONTACT(), exit_status=2)
            felt = Contact(str(int(self.contact)), contact_test(self.cell, arm.name))
        faults = Faults(delay=self.delay, broken=self.broken)
        faults.errors = dict(map(_refused_command, self.refuse))
        with ExitStack() as open_:
            given, made = line_targets(self.line), {}
            for name, target in given.items():
                made[f"{name.rstrip(':').upper()}:"] = open_.enter_context(_open_line(name, target))
            _serve_cr(
                arm,
                [f"line {name} leads to {target}" for name, target in given.items()],
                port=self.port,
                folder=self.folder,
                data_port=self.data_port,
                mxt_port=self.mxt_port,
                serial=self.serial or False,
                framing=_FRAMINGS[self.framing],
                lines=made,
                pace=self.pace,
                faults=faults,
                report=_print_flushed if self.log else None,
                contact=felt,
            )
        return 0


_NOT_STARTED = error(
    "CL101",
    "the virtual controller cannot start: {reason}",
    "name another port or folder; ports below 1024 need more rights",
)


_NOT_A_REFUSAL = error(
    "CL103",
    "`{text}` is no command with the number of an error",
    "write them as SRVON=5600",
)
_INCOMPLETE_CONTACT = error(
    "CL105",
    "the contact input needs its number and a cell",
    "add `--contact 10 --cell cell.toml`, with an input of the controller and the file of its cell",
)
_NOT_A_SIGNAL = error(
    "CL102",
    "`{text}` is no signal",
    "write its name and type, as do_grip=DO; types are DI, DO, GI, GO, AI, AO",
)


_NOT_A_DEVICE = error(
    "CL104",
    "`{text}` is no UdpUc device",
    "write its name and where it sends to, as UCdevice=127.0.0.1:6510",
)


def _udp_device(text: str) -> tuple[str, tuple[str, int]]:
    name, _, place = text.partition("=")
    host, _, port = place.rpartition(":")
    if not name.strip() or not host.strip() or not port.isdecimal() or int(port) > 65535:
        raise Refused(_NOT_A_DEVICE(text=text), exit_status=2)
    return name.strip(), (host.strip(), int(port))


def _signal_of(text: str) -> Signal:
    from assistant.virtual.irc5 import Signal
    from assistant.virtual.irc5.cabinet import SIGNAL_TYPES

    name, _, type = text.partition("=")
    found = SIGNAL_TYPES.get(type.strip().upper())
    if found is None or not name.strip().isidentifier():
        raise Refused(_NOT_A_SIGNAL(text=text), exit_status=2)
    return Signal(name.strip(), found)


def _print_services(controller: VirtualIrc5) -> None:
    say(f"Robot Web Services 1.0 at {controller.rws_address}")
    say(f"Robot Web Services 2.0 at {controller.rwss_address}")
    say(f"its certificate: {controller.certificate}")


@contextmanager
def _open_line(name: str, target: str) -> Iterator[Line]:
    """Open the target of a line until the controller ends; raises Refused."""
    from assistant.virtual.melfa.communication_lines import line_to

    try:
        line, leave = line_to(target)
    except OSError as error:
        reason = f"{name} cannot lead to {target}: {error.strerror or error}"
        raise Refused(_NOT_STARTED(reason=reason), exit_status=2) from None
    try:
        yield line
    finally:
        leave()


def _serve_cr(arm: Robot, notes: Sequence[str], **options: Any) -> None:
    """Serve the controller. notes: printed once it listens. options: of `VirtualCr`."""
    from assistant.languages import get
    from assistant.virtual.cr import VirtualCr

    try:
        controller = VirtualCr(arm.name, **options)
    except (ValueError, OSError) as error:
        raise Refused(_NOT_STARTED(place=arm.name, reason=error), exit_status=2) from None
    about = f"{arm.title}, {get(controller.state.language).title}"

    def tell(running: VirtualCr) -> None:
        _print_lines(running, options["lines"])
        for text in notes:
            say(text)

    _serve_until_end(controller, about, None, tell)


def _refused_command(text: str) -> tuple[str, int]:
    command, sign, number = text.rpartition("=")
    if not sign or not command or not re.fullmatch(r"\d{1,4}", number, re.ASCII):
        raise Refused(_NOT_A_REFUSAL(text=text), exit_status=2)
    return command, int(number)


def _print_lines(controller: VirtualCr, others: Container[str]) -> None:
    """Print where its lines can be reached. others: lines with another target."""
    if controller.has_serial:
        is_link = controller.state.parameters["CPRC232"] != ("2",)
        say(f"serial line at {controller.serial_address if is_link else controller.serial_path}")
    for name, (host, port) in controller.data_ports.items():
        if name not in others:
            say(f"data link {name} at {host}:{port}")
    say(f"real-time control at UDP port {controller.mxt_port}, while a program waits for it")


C = TypeVar("C", "VirtualIrc5", "VirtualCr")


def _serve_until_end(
    controller: C, about: str, password: str | None, tell: Callable[[C], None] | None = None
) -> None:
    """Run until Ctrl-C. A generated password is printed, as the user has no other way to learn it.

    tell: prints more about the controller once it runs.
    """
    try:
        controller.start()
    except OSError as error:
        reason = error.strerror or str(error)
        raise Refused(_NOT_STARTED(reason=reason), exit_status=2) from None
    try:
        say(f"listening at {controller.address} ({about}); Ctrl-C ends it")
        if tell is not None:
            tell(controller)
        if password is not None:
            say(f"password: {password} (set {PASSWORD_VARIABLE} to choose one)")
        sys.stdout.flush()
        wait_for_termination()
    except KeyboardInterrupt as caught:
        say("ended")
        if not is_ctrl_c(caught):
            raise
    finally:
        with defer_termination():
            controller.stop()


def _print_flushed(line: str) -> None:
    say(line)
    sys.stdout.flush()
