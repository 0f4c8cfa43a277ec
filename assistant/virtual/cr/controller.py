"""A virtual CR controller on this computer: the controller link over TCP and serial lines.

    with VirtualCr("rv-2aj") as controller:
        connect(f"melfa://127.0.0.1:{controller.port}")

`_execute` answers a command of the link; answers, arguments and error numbers are those of the
manual BFP-A4288 and of the controllers' error lists, and each command is a row in the table of its
subject. `_DataLines` are the lines of the data link, which `Open "COM2:"` of a program leads to.
"""

from __future__ import annotations

import contextlib
import math
import re
import socket
import socketserver
import threading
import time
from collections.abc import Callable, Container, Mapping
from dataclasses import replace
from datetime import datetime
from pathlib import Path as FilePath
from typing import Final, Literal, Self

from assistant import languages
from assistant.virtual.cr import (
    execution_commands,
    maintenance_commands,
    program_commands,
    status_commands,
)
from assistant.virtual.cr.command import Command
from assistant.virtual.cr.real_time import RealTime
from assistant.virtual.cr.session import (
    MOST_BYTES,
    Faults,
    Plain,
    Procedural,
    SerialPort,
    SocketPort,
)
from assistant.virtual.cr.slots_and_arm import Contact, Equipment
from assistant.virtual.cr.state import (
    SUFFIXES,
    TASKMAX,
    CrSession,
    CrState,
    Parameters,
    error_level,
)
from assistant.virtual.cr.store import CAPACITY, CrRefusal, CrStore
from assistant.virtual.melfa.communication import LOOPBACK
from assistant.virtual.melfa.communication_lines import (
    MADE,
    Descriptor,
    Line,
    Rate,
    TcpClient,
    TcpServer,
)
from assistant.virtual.melfa.world import Commands

COMMANDS: Final[Mapping[str, Command]] = {
    **status_commands.SESSION_COMMANDS,
    **program_commands.EDIT_COMMANDS,
    **program_commands.LIST_COMMANDS,
    **program_commands.VARIABLE_COMMANDS,
    **program_commands.FILE_COMMANDS,
    **execution_commands.SLOT_COMMANDS,
    **execution_commands.RUN_COMMANDS,
    **status_commands.STATE_COMMANDS,
    **status_commands.SIGNAL_COMMANDS,
    **maintenance_commands.ERROR_COMMANDS,
    **maintenance_commands.PARAMETER_COMMANDS,
    **maintenance_commands.MAINTENANCE_COMMANDS,
}

_BY_LENGTH: Final = sorted(COMMANDS, key=len, reverse=True)
"""Longest first, so that OVRD= is not taken for OVRD."""

_MOST_ROBOTS: Final = 3
_LINE_ENDS: Final = re.compile(r"[\r\n\0]")
"""A frame can hold them, but no line of a program and no name."""
_EDIT_SLOT: Final = TASKMAX + 1


def _execute(session: CrSession, text: str) -> str:
    """The answer to `[robot];[slot];COMMAND`, without `QoK`; raises CrRefusal."""
    head = re.match(r"(\d*);(\d*); *", text, re.ASCII)
    if head is None or _LINE_ENDS.search(text):
        raise CrRefusal(6010)
    # Three digits are more than any number that there is; int() of thousands is slow.
    if int(head[1][:3] or 1) > _MOST_ROBOTS:
        raise CrRefusal(5430)
    session.slot = int(head[2][:3] or 1)
    if session.slot > _EDIT_SLOT:
        raise CrRefusal(5420)
    body = text[head.end() :]
    name = next((n for n in _BY_LENGTH if body.startswith(n)), None)
    if name is None:
        raise CrRefusal(6010)
    command, argument = COMMANDS[name], body[len(name) :]
    if command.right and session.state.right is not session:
        raise CrRefusal(6020)
    return command.handler(session, argument)


_DATA_LINK: Final = "2"
"""Protocol of a line that programs open (CPRCE11 to CPRCE19, CPRC232)."""
_SERIAL_PORT: Final = "RS232"
_FIRST_OPTION: Final = 11


class _DataLines:
    """lines: by what programs open, as `COM2:`. ports: (host, port) that clients connect to, by the
    same names. first_port: of the first network line, the others follow; 0 for any that are free.
    without: names that lead elsewhere.
    """

    def __init__(
        self,
        parameters: Parameters,
        host: str,
        first_port: int,
        serial: Line | None,
        *,
        without: Container[str] = (),
    ) -> None:
        """Raises OSError if a port is taken."""
        self.lines: dict[str, Line] = {}
        self.ports: dict[str, tuple[str, int]] = {}
        self._ends: list[Callable[[], None]] = []
        try:
            for number, device in enumerate(parameters["COMDEV"], start=1):
                if f"COM{number}:" in without:
                    continue
                if device == _SERIAL_PORT and serial is not None:
                    self.lines[f"COM{number}:"] = serial
                elif device.startswith("OPT"):
                    self._network(f"COM{number}:", device, parameters, (host, first_port))
        except OSError:
            self.shut()
            raise

    def _network(
        self, name: str, device: str, parameters: Parameters, first: tuple[str, int]
    ) -> None:
        """A line OPT11 to OPT19, if it is one of the data link."""
        option = device.removeprefix("OPT")
        index = int(option) - _FIRST_OPTION if option.isdigit() else -1
        if not 0 <= index < len(parameters["NETMODE"]):
            return
        if parameters[f"CPRCE{option}"] != (_DATA_LINK,):
            return
        host, port = first
        if parameters["NETMODE"][index] == "0":
            target = parameters["NETHSTIP"][index], int(parameters["NETPORT"][index + 1])
            if target[0] in LOOPBACK:  # a virtual controller connects to no other computer
                self.lines[name] = TcpClient(*target)
            return
        server = TcpServer(port + index if port else 0, host)
        self.lines[name], self.ports[name] = server, server.address
        self._ends.append(server.shut)

    def shut(self) -> None:
        for end in self._ends:
            end()
        self._ends.clear()


_FRAMINGS: Final = {"plain": "0", "procedural": "1", "data link": "2"}
"""Framing of the serial line → the parameter CPRC232."""
_PARITIES: Final[Mapping[str, Literal["even", "odd", "none"]]] = {
    "0": "none",
    "1": "odd",
    "2": "even",
}
"""Values of the parameter CPRTY232 → parity."""
MOST_CONNECTIONS: Final = 9
"""Lines OPT11 to OPT19 of a controller, one client each."""
_SPARE: Final = "OPT19"
"""Device of a line that a computer of ours takes the place of."""
_ENCODING: Final = "latin-1"
_FIRST_LINE: Final = "10 END"
"""Is read when a controller starts: a client waits for the answer to its first program only so
long, and not for the grammar as well.
"""


class VirtualCr:
    """A controller of one robot on 127.0.0.1; a context manager, or `start` and `stop`.

    robot: name in the catalogue. language: version of MELFA-BASIC, None for the robot's first.
    port: 0 for any free one. folder: directory of the stored programs, None for memory. terminator:
    end of an answer (CR, CR LF or nothing). quiet: seconds of silence that end a command without
    end code. report: is called with each command and its answer. serial: True for a pseudo
    terminal, whose path is `serial_path`, `pty:LINK` for one with a link to it, or the path of a
    serial port. framing: that of the serial line (CPRC232). faults: faults to inject on purpose.
    pace: simulated seconds for each real one. servo_time: seconds until the servos are on.
    data_port: port of the line OPT11, the next ones are those of OPT12 and so on; 0 for any that
    are free (`data_ports`). mxt_port, monitor_port: UDP ports of real-time control and of the
    monitor (MONMODE), 0 for any that are free. lines: further lines that programs open, beside
    those of the data link. commands: plug-ins of the interpreter. lock_step: simulated time starts
    at 0 and passes only as far as `advance` allows, with servos that are on at once; packets of
    real-time control still follow real time. contact: an input that is on while the arm touches
    something.
    """

    def __init__(
        self,
        robot: str = "rv-2aj",
        *,
        language: str | None = None,
        host: str = "127.0.0.1",
        port: int = 0,
        folder: str | FilePath | None = None,
        capacity: int = CAPACITY,
        terminator: bytes = b"\r",
        quiet: float = 0.05,
        clock: Callable[[], datetime] = datetime.now,
        report: Callable[[str], None] | None = None,
        serial: bool | str = False,
        framing: Literal["plain", "procedural", "data link"] = "plain",
        faults: Faults | None = None,
        pace: float = 1.0,
        servo_time: float = 0.1,
        data_port: int = 0,
        mxt_port: int = 0,
        monitor_port: int = 0,
        lines: Mapping[str, Line] | None = None,
        commands: Commands | None = None,
        lock_step: bool = False,
        contact: Contact | None = None,
    ) -> None:
        from assistant import robots

        arm = robots.get(robot)
        spoken = language or arm.languages[0]
        if spoken not in SUFFIXES:
            raise ValueError(f"a CR controller speaks {', '.join(SUFFIXES)}, not {spoken}")
        store = CrStore(FilePath(folder) if folder else None, capacity=capacity)
        ready = 0.0 if lock_step else servo_time
        self.state = CrState(arm, spoken, store, clock, servo_time=ready, report=report)
        self._equipment = Equipment(
            pace, dict(lines or {}), commands, lock_step=lock_step, contact=contact
        )
        self._first_port = data_port
        self._data: _DataLines | None = None
        self._real_time = RealTime(self.state, host, mxt_port, monitor_port)
        self._place = (host, port)
        self._terminator = terminator
        self._quiet = quiet
        self._report = report
        self.faults = faults or Faults()
        self._serial_target = serial if isinstance(serial, str) else MADE if serial else ""
        self._serial: SerialPort | None = None
        self._serial_thread: threading.Thread | None = None
        self.state.parameters.write("CPRC232", _FRAMINGS[framing], all_levels=True)
        self._name_lines()
        self._server: _Server | None = None
        self._thread: threading.Thread | None = None

    def _name_lines(self) -> None:
        """COMDEV has a network option where a line of ours takes the place of the serial one."""
        given = self.state.parameters["COMDEV"]
        devices = [
            _SPARE
            if f"COM{number}:" in self._equipment.lines and not one.startswith("OPT")
            else one
            for number, one in enumerate(given, start=1)
        ]
        if devices != [*given]:
            self.state.parameters.write("COMDEV", ", ".join(devices), all_levels=True)

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.stop()

    @property
    def port(self) -> int:
        assert self._server is not None, "the controller is not started"
        return int(self._server.server_address[1])

    @property
    def address(self) -> str:
        return f"melfa://{self._place[0]}:{self.port}"

    @property
    def has_serial(self) -> bool:
        return self._serial is not None

    @property
    def serial_path(self) -> str:
        """The serial port, or the pseudo terminal that clients open, by its link if it has one."""
        assert self._serial is not None, "the controller has no serial line, or is not started"
        return self._serial.path

    @property
    def serial_address(self) -> str:
        framing = "?framing=procedural" if self.state.parameters["CPRC232"] == ("1",) else ""
        return f"melfa-serial://{self.serial_path}{framing}"

    def start(self) -> None:
        """Listens; raises OSError if the port is taken, or the serial port is not there."""
        languages.get(self.state.language).parse(_FIRST_LINE)
        self._server = _Server(self._place, self._converse)
        try:
            self._start_serial()
            self._start_machinery()
        except BaseException:
            self._server.server_close()
            self._server = None
            self._close_serial()
            raise
        if self._serial_thread is not None:
            self._serial_thread.start()
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=(0.02,), name="virtual-cr", daemon=True
        )
        self._thread.start()

    def _start_serial(self) -> None:
        if not self._serial_target:
            return
        self._serial = SerialPort(self._serial_target, _rate(self.state))
        self._serial_thread = threading.Thread(
            target=self._converse_serially, args=(self._serial,), name="virtual-cr", daemon=True
        )

    def _start_machinery(self) -> None:
        serial = None
        if self._serial is not None and self.state.parameters["CPRC232"] == (_DATA_LINK,):
            # The programs read this line, so that no thread may take commands from it.
            serial, self._serial_thread = Descriptor(self._serial.descriptor), None
        self._data = _DataLines(
            self.state.parameters,
            self._place[0],
            self._first_port,
            serial,
            without=self._equipment.lines,
        )
        # Lines of the caller replace those of the controller.
        lines = {**self._data.lines, **self._real_time.lines, **self._equipment.lines}
        commands = {**self._real_time.commands, **(self._equipment.commands or {})}
        try:
            self._real_time.start()
            self.state.start(replace(self._equipment, lines=lines, commands=commands))
        except BaseException:
            self._real_time.shut()
            self._data.shut()
            raise

    def _close_serial(self) -> None:
        if self._serial is not None:
            self._serial.close()
        self._serial = self._serial_thread = None

    def stop(self) -> None:
        """Hangs up on every client and frees the port."""
        server, self._server = self._server, None
        if server is None or self._thread is None:
            return
        server.shutdown()
        # The threads of the clients end, for which server_close() waits.
        server.hang_up()
        if self._serial is not None and self._serial_thread is not None:
            self._serial.hang_up()
        self._real_time.shut()
        self.state.stop()
        if self._serial_thread is not None:
            self._serial_thread.join()
        self._close_serial()
        if self._data is not None:
            self._data.shut()
        server.server_close()
        self._thread.join()
        self._thread = None

    def alarm(self, number: int, level: int | None = None) -> None:
        """Brings the controller into an error state; RSTALRM ends it.

        level: 1 high, 2 low, 3 caution; None for that of the error list.
        """
        with self.state.lock:
            self.state.alert(number, level or error_level(number))

    def emergency_stop(self, pressed: bool = True) -> None:
        """Presses or releases the emergency stop of the operating panel."""
        with self.state.lock:
            self.state.press_emergency(pressed)

    def advance(self, moment: float) -> None:
        """With `lock_step`: lets time pass to a moment; all until then has happened then."""
        self.state.machinery.stepped.advance(moment)

    def free(self) -> None:
        """With `lock_step`: time passes as real time does until `advance` is called."""
        self.state.machinery.stepped.free()

    @property
    def executing(self) -> bool:
        """True if a single statement is running or waits for its turn."""
        return self.state.machinery.executing

    @property
    def data_ports(self) -> dict[str, tuple[str, int]]:
        """Host and port of each line of the data link, by the name that programs open: `COM2:`."""
        return {} if self._data is None else dict(self._data.ports)

    @property
    def mxt_port(self) -> int:
        """UDP, where packets are taken while a program is in `Mxt`."""
        return self._real_time.port

    @property
    def monitor_port(self) -> int | None:
        """UDP, of the real-time monitor; None while MONMODE is 0."""
        return self._real_time.monitor_port

    def text(self, name: str) -> str | None:
        """Return the text of a stored program, None if no program has that name."""
        with self.state.lock:
            return self.state.store[name].text() if name in self.state.store else None

    def names(self) -> tuple[str, ...]:
        with self.state.lock:
            return tuple(self.state.store)

    def answer(self, session: CrSession, command: bytes) -> str:
        """`QoK…` or `QeR…` for one command, third letter lower case in an error state."""
        text = command.decode(_ENCODING)
        with self.state.lock:
            # A command that takes long is no silence of the client.
            session.heard = math.inf
            try:
                if len(command) > MOST_BYTES:
                    raise CrRefusal(6080)
                if (number := self.faults.error(text)) is not None:
                    raise CrRefusal(number)
                head, body = "Qo", _execute(session, text)
            except CrRefusal as error:
                head = "Qe"
                body = ";".join([f"{error.number:04}", *map(str, error.places)])
            session.heard = time.monotonic()
            letter = ("k", "r") if self.state.alarm else ("K", "R")
        answer = head + letter[head == "Qe"] + body
        if self._report is not None:
            self._report(f"{text!r} -> {answer!r}")
        return answer

    def _converse(self, connection: socket.socket) -> None:
        """Serves one client until it or the controller hangs up."""
        session = CrSession(self.state)
        talk = Plain(self._terminator, self._quiet, self.faults)
        try:
            talk.converse(SocketPort(connection), lambda command: self._encoded(session, command))
        except OSError:
            return  # the client is gone; what it held is given back below
        finally:
            with self.state.lock:
                session.hang_up()

    def _converse_serially(self, port: SerialPort) -> None:
        """Serves the serial line, whose one session lasts as long as the controller does."""
        session = CrSession(self.state)
        while self._server is not None:
            talk = self._serial_talk()
            try:
                talk.converse(port, lambda command: self._encoded(session, command))
            except OSError:
                continue  # a fault cut the conversation; the line is still there
            if self._server is not None:
                return
        with self.state.lock:
            session.hang_up()

    def _serial_talk(self) -> Plain | Procedural:
        """Return the protocol that the parameters CPRC232 and CTERM232 select."""
        parameters = self.state.parameters
        if parameters["CPRC232"] == ("1",):
            return Procedural(self.faults)
        end = b"\r\n" if parameters["CTERM232"] == ("1",) else b"\r"
        return Plain(end, self._quiet, self.faults)

    def _encoded(self, session: CrSession, command: bytes) -> bytes:
        try:
            return self.answer(session, command).encode(_ENCODING)
        except RuntimeError:
            if self._server is not None:
                raise
            raise ConnectionAbortedError("the controller was switched off") from None


def _rate(state: CrState) -> Rate:
    """Return the rate of the serial line from the parameters."""
    parameters = state.parameters
    parity = _PARITIES.get(parameters["CPRTY232"][0], "even")
    stops: Literal[1, 2] = 1 if parameters["CSTOP232"] == ("1",) else 2
    return Rate(int(parameters["CBAU232"][0]), parity, stops)


class _Server(socketserver.ThreadingTCPServer):
    """Accepts clients up to `MOST_CONNECTIONS` and can hang up on all of them."""

    allow_reuse_address = True
    daemon_threads = False
    block_on_close = True

    def __init__(self, place: tuple[str, int], converse: Callable[[socket.socket], None]) -> None:
        self._converse = converse
        self._open: set[socket.socket] = set()
        self._guard = threading.Lock()
        super().__init__(place, socketserver.BaseRequestHandler)

    def verify_request(self, request: object, client_address: object) -> bool:
        del request, client_address
        with self._guard:
            return len(self._open) < MOST_CONNECTIONS

    def process_request(self, request: object, client_address: object) -> None:
        assert isinstance(request, socket.socket)
        with self._guard:
            # Before the thread starts: `verify_request` of the next client counts it.
            self._open.add(request)
        super().process_request(request, client_address)

    def finish_request(self, request: object, client_address: object) -> None:
        del client_address
        assert isinstance(request, socket.socket)
        try:
            # Short answers are not held back.
            request.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._converse(request)
        finally:
            with self._guard:
                self._open.discard(request)

    def hang_up(self) -> None:
        with self._guard:
            for connection in self._open:
                with contextlib.suppress(OSError):
                    # shutdown() wakes the thread that reads; close() would not.
                    connection.shutdown(socket.SHUT_RDWR)
