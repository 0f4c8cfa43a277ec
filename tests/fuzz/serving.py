"""What virtual controllers are sent: commands, requests, packets, however wrong they are."""

from __future__ import annotations

import atexit
import errno
import logging
import socket
import threading
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from typing import Final

from assistant.virtual.cr import VirtualCr
from assistant.virtual.cr import session as cr_framing
from assistant.virtual.cr.controller import COMMANDS, CrSession
from assistant.virtual.irc5 import VirtualIrc5, egm_packets
from assistant.virtual.irc5.rws_http import Connection, Server
from tests.fuzz.target import Target, folder, promise

PASSWORD: Final = "secret"
AROUND: Final = ("beside.txt", "home")
"""What is in the folder above the one that a controller serves, before and after every input."""
IN_TIME: Final = 20.0
"""Seconds in which every server answers, or hangs up."""


# ------------------------------------------------------------------------------ MELFA controllers


@cache
def cr() -> VirtualCr:
    """One for all inputs, whose programs are those of the last one only."""
    controller = VirtualCr("rv-2aj", servo_time=0.0)
    controller.start()
    atexit.register(controller.stop)
    return controller


def link_commands(data: bytes) -> None:
    """Commands of a session, a line each; every one has an answer."""
    controller = cr()
    session = CrSession(controller.state)
    framing = cr_framing.Framing()
    try:
        for command in [*framing.feed(data), *framing.silence()][:40]:
            answer = controller.answer(session, command)
            promise(answer[:2] in ("Qo", "Qe"), "no answer", answer[:40])
            promise(len(answer) < 100_000, "an answer without end", len(answer))
            answer.encode("latin-1")
    finally:
        with controller.state.lock:
            session.hang_up()
        last = CrSession(controller.state)
        for command in (b"1;1;CNTLON", b"1;1;STOP", b"1;1;RSTALRM", b"1;1;SLOTINIT", b"1;1;FINIT"):
            controller.answer(last, command)
        with controller.state.lock:
            last.hang_up()


def frames(data: bytes) -> None:
    """Of the procedure on a serial line."""
    text = cr_framing.from_frame(data)
    if text is not None:
        promise(cr_framing.from_frame(cr_framing.in_frame(text)[:-1]) == text, "framed anew")


# ------------------------------------------------------------------------------- ABB controllers


@cache
def irc5() -> VirtualIrc5:
    """One for all inputs, which serves a folder that is empty before each of them."""
    place = folder() / "irc5"
    place.mkdir()
    (place / "beside.txt").write_text("beside")
    logging.getLogger("pyftpdlib").addHandler(FAILED)
    controller = VirtualIrc5(place / "home", password=PASSWORD, rwss=None)
    controller.start()
    atexit.register(controller.stop)
    return controller


class Failed(logging.Handler):
    """Hears what a server logs of its own failures. heard: what it was.

    A client that goes while its failed login is kept waiting is a failure of pyftpdlib alone, which
    ends that session.
    """

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.heard: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        error = record.exc_info[1] if record.exc_info else None
        if isinstance(error, OSError) and error.errno == errno.EBADF:
            return
        self.heard.append(logging.Formatter().format(record))


FAILED: Final = Failed()


def cleared(controller: VirtualIrc5) -> None:
    """Looks that nothing happened outside of the folder, and empties it."""
    around = controller.folder.parent
    promise(tuple(sorted(one.name for one in around.iterdir())) == AROUND, "outside of its folder")
    promise((around / "beside.txt").read_text() == "beside", "changed outside of its folder")
    for path in sorted(controller.folder.rglob("*"), reverse=True):
        if path.is_dir() and not path.is_symlink():
            path.rmdir()
        else:
            path.unlink()


def ftp_commands(data: bytes) -> None:
    """Commands of a session that is logged in, if the first byte is odd."""
    controller = irc5()
    login = f"USER {controller.user}\r\nPASS {PASSWORD}\r\n".encode()
    FAILED.heard.clear()
    with (
        socket.create_connection(("127.0.0.1", controller.port), IN_TIME) as line,
        suppress(ConnectionError),
    ):
        line.sendall((login if data[:1] > b"\x7f" else b"") + data[1:] + b"\r\nQUIT\r\n")
        line.shutdown(socket.SHUT_WR)
        received = 0
        while piece := line.recv(65536):
            received += len(piece)
            promise(received < 10_000_000, "answers without end")
    promise(not FAILED.heard, "the file server failed", "".join(FAILED.heard[:1])[-1500:])
    cleared(controller)


def rws_request(data: bytes) -> None:
    """A request line, headers, an empty line and a body, in a session that is logged in."""
    controller = irc5()
    server = _server(controller)
    head, _, body = data.partition(b"\n\n")
    line, _, headers = head.partition(b"\n")
    told = [line, *(one for one in headers.split(b"\n") if one), b"Content-Length: %d" % len(body)]
    session = controller.sessions.begin()
    assert session is not None, "sessions are left open"
    told += [b"Cookie: " + session.cookies[0].partition(";")[0].encode(), b"Connection: close"]
    sent = b"\r\n".join([*told, b"", body])
    here, there = _connected()
    answer = bytearray()

    def read() -> None:
        with suppress(OSError):
            while piece := here.recv(65536):
                answer.extend(piece)

    reader = threading.Thread(target=read, daemon=True)
    with here, there:
        here.settimeout(IN_TIME)
        there.settimeout(IN_TIME)
        here.sendall(sent)
        here.shutdown(socket.SHUT_WR)
        reader.start()
        with suppress(OSError):
            Connection(there, ("127.0.0.1", 0), server)
        there.close()
        reader.join(IN_TIME)
    controller.sessions.end(session)
    promise(not reader.is_alive(), "an answer without end")
    promise(bool(answer) or not line.endswith(b" HTTP/1.1"), "no answer")
    promise(not answer.startswith(b"HTTP/1.1 500"), "an internal failure", bytes(answer[:300]))
    cleared(controller)


@cache
def _listener() -> socket.socket:
    return socket.create_server(("127.0.0.1", 0))


def _connected() -> tuple[socket.socket, socket.socket]:
    """The two ends of a line of TCP."""
    here = socket.create_connection(_listener().getsockname()[:2], IN_TIME)
    return here, _listener().accept()[0]


def _server(controller: VirtualIrc5) -> Server:
    return controller._servers[1]


def egm(data: bytes) -> None:
    """A packet of a sensor, as joints and as a pose."""
    for kind, count in (("joints", 6), ("pose", 7)):
        heard = egm_packets.read_sensor_packet(data, kind, count)  # type: ignore[arg-type]
        promise(heard is None or len(heard.values) == count, "another number of values")


# ---------------------------------------------------------------------------------------- seeds


def _link() -> Iterable[bytes]:
    begin = b"1;1;OPEN=USERTOOL\r1;1;CNTLON\r1;1;SRVON\r"
    edit = (
        b"1;9;LOAD=A\r1;9;EMDAT10 M1=1\v20 MOV P1\v30 END\r1;9;EMDATP1=(1,2,3,4,5)(6,0)\r1;9;SAVE\r"
    )
    run = b"1;1;RUNA;1\r1;1;STATE\r1;1;DSTATE\r1;1;STOP\r1;1;RSTALRM\r1;1;PPOSF\r1;1;JPOSF\r"
    names = list(COMMANDS)
    rest = [
        b"\r".join(f"1;1;{name}1;2".encode() for name in names[start : start + 8])
        for start in range(0, len(names), 8)
    ]
    return [begin + edit + run, *(begin + some for some in rest)]


def _ftp() -> Iterable[bytes]:
    some = ("TYPE I", "PWD", "CWD HOME:", "MKD a", "CWD ..", "PASV", "EPSV", "SIZE a", "MLST a")
    more = ("RNFR a", "RNTO ../b", "DELE x", "REST 5", "APPE a", "PORT 127,0,0,1,0,9", "FEAT")
    rest = (
        "SITE CHMOD 777 a",
        "STAT /",
        "MDTM a",
        "ALLO 5",
        "NLST",
        "EPRT |1|127.0.0.1|9|",
        "ABOR",
    )
    said = ["\r\n".join(commands).encode() for commands in (some, more, rest)]
    return [*(b"\xff" + commands for commands in said), b"\0USER x\r\nPASS y\r\nPWD"]


def _rws() -> Iterable[bytes]:
    get = (
        *("/rw/system", "/rw/panel/ctrlstate", "/rw/rapid/execution", "/rw/rapid/tasks"),
        *("/rw/rapid/modules?task=T_ROB1", "/rw/iosystem/signals", "/rw/elog/0?lang=en"),
        *("/fileservice/$home", "/rw/motionsystem/mechunits/ROB_1/jointtarget", "/rw/cfg"),
        "/rw/rapid/symbol/data/RAPID/T_ROB1/m/x?json=1",
    )
    form = "Content-Type: application/x-www-form-urlencoded"
    post = {
        "/rw/mastership?action=request": "",
        "/rw/rapid/execution?action=start": "regain=continue&execmode=continue&cycle=once",
        "/rw/rapid/symbols?action=search-symbols": "view=block&blockurl=RAPID&symtyp=any",
        "/rw/panel/ctrlstate?action=setctrlstate": "ctrl-state=motoron",
        "/fileservice/$home?action=createdir": "fs-newname=a",
        "/rw/rapid/tasks/T_ROB1?action=loadmod": "modulepath=HOME:/a.mod&replace=true",
        "/subscription": "resources=1&1=/rw/panel/ctrlstate&1-p=1",
    }
    return [
        *(f"GET {path} HTTP/1.1\nAccept: */*\n\n".encode() for path in get),
        *(f"POST {path} HTTP/1.1\n{form}\n\n{body}".encode() for path, body in post.items()),
        b"PUT /fileservice/$home/a.mod HTTP/1.1\n\nMODULE a\nENDMODULE\n",
        b"DELETE /fileservice/$home/a.mod HTTP/1.1\n\n",
    ]


def _egm() -> Iterable[bytes]:
    header = bytes.fromhex("0a06080a10141803")
    joints = bytes.fromhex("1238") + bytes.fromhex("0a36")
    return [header, header + joints + b"".join(b"\x09" + bytes(8) for _ in range(6))]


PLACES: Final = ("../", "$home", "/", "%2e%2e/", "HOME:", "\x00")
TARGETS: Final = (
    Target("link-commands", link_commands, _link, lambda: (*COMMANDS, "1;9;", "\v", ";"), tried=8),
    Target("link-frames", frames, lambda: [cr_framing.in_frame(b"1;1;STATE")[:-1], b"\x02D003R"]),
    Target("ftp-commands", ftp_commands, _ftp, lambda: PLACES, tried=8),
    Target("rws-requests", rws_request, _rws, lambda: PLACES, tried=12),
    Target("egm-sensor", egm, _egm),
)
