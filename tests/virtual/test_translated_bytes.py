"""Bytes over sockets in MELFA-BASIC by way of a gateway: both programs on real connections."""

from __future__ import annotations

import asyncio
import socket
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from assistant import languages
from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import Translation, translate
from assistant.controllers.gateway import Gateway
from assistant.virtual.kernel import Kernel
from assistant.virtual.melfa import Controller, Entry
from assistant.virtual.melfa.communication_lines import Line, TcpClient, TcpServer
from assistant.virtual.melfa.world import STEP_TIME
from assistant.virtual.rapid.controller import Controller as Irc5
from assistant.virtual.rapid.interpreter import start_task

HERE = "127.0.0.1"
LASTS = 12.0
"""Seconds of a run: a cycle, and what is left of them in the next one."""
SERVER = r"""MODULE m
VAR socketdev server;
VAR socketdev peer;
CONST robtarget p1:=[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC listen(VAR socketdev at,num port)
  IF SocketGetStatus(at)=SOCKET_CLOSED SocketCreate at;
  IF SocketGetStatus(at)=SOCKET_CREATED SocketBind at,"127.0.0.1",port;
  IF SocketGetStatus(at)=SOCKET_BOUND SocketListen at;
ENDPROC
PROC take(VAR socketdev line,VAR rawbytes raw,num count,\num most)
  VAR num wait:=WAIT_MAX;
  IF Present(most) wait:=most;
  SocketReceive line\RawData:=raw\ReadNoOfBytes:=count\Time:=wait;
ERROR
  RAISE;
ENDPROC
PROC main()
  VAR rawbytes raw;
  VAR byte list{4};
  VAR num size;
  VAR num x;
  VAR num late:=0;
  listen server,<PORT>;
  SocketAccept server,peer\Time:=WAIT_MAX;
  take peer,raw,4;
  UnpackRawBytes raw\Network,1,size\IntX:=UDINT;
  take peer,raw,size;
  UnpackRawBytes raw,1,x\Float4;
  MoveL Offs(p1,0,0,x),v100,fine,tool0;
  ClearRawBytes raw;
  PackRawBytes RawBytesLen(raw)+x,raw,size-3\Float4;
  SocketSend peer\RawData:=raw;
  SocketReceive peer\Data:=list\ReadNoOfBytes:=2;
  list{1}:=list{1}+list{2};
  SocketSend peer\Data:=list\NoOfBytes:=1;
  take peer,raw,3\most:=0.3;
  SocketSend peer\RawData:=raw;
  take peer,raw,3;
ERROR
  IF ERRNO=ERR_SOCK_TIMEOUT THEN
    PackRawBytes "late",raw,1\ASCII;
    TRYNEXT;
  ELSEIF ERRNO=ERR_SOCK_CLOSED THEN
    MoveL Offs(p1,0,0,99),v100,fine,tool0;
    SocketClose peer;
    RETURN;
  ENDIF
ENDPROC
ENDMODULE
"""
CLIENT = r"""MODULE m
VAR socketdev peer;
PROC main()
  VAR rawbytes raw;
  VAR string said;
  VAR num got;
  SocketCreate peer;
  SocketConnect peer,"127.0.0.1",<PORT>;
  PackRawBytes 513,raw,1\IntX:=INT;
  SocketSend peer\RawData:=raw;
  SocketReceive peer\RawData:=raw\NoRecBytes:=got\Time:=5;
  PackRawBytes got,raw,RawBytesLen(raw)+1\IntX:=USINT;
  SocketSend peer\RawData:=raw;
  greet peer,"job "+ValToStr(got);
  SocketReceive peer\Str:=said\ReadNoOfBytes:=5;
  SocketSend peer\Str:=said\NoOfBytes:=4;
  SocketClose peer;
ENDPROC
PROC greet(VAR socketdev at,string name)
  SocketSend at\Str:=name;
ENDPROC
ENDMODULE
"""


def free_port() -> int:
    with socket.create_server((HERE, 0)) as one:
        port: int = one.getsockname()[1]
        return port


def asks(peer: socket.socket) -> list[bytes]:
    """A host that speaks with the program that listens."""
    data = struct.pack("<f", 12.5) + bytes(range(20))
    peer.sendall(struct.pack(">I", len(data)) + data[:7])
    peer.sendall(data[7:])
    heard = [taken(peer, len(data))]
    peer.sendall(b"\x05\x07")
    heard.append(taken(peer, 1))
    heard.append(taken(peer, 4))
    return heard


def answers(peer: socket.socket) -> list[bytes]:
    heard = [taken(peer, 2)]
    peer.sendall(bytes((0, 13, 44, 255)))
    heard += [taken(peer, 5), taken(peer, 5)]
    peer.sendall(b"x,y\rz")
    return [*heard, taken(peer, 4), peer.recv(10)]


def taken(peer: socket.socket, count: int) -> bytes:
    peer.settimeout(20.0)
    found = b""
    while len(found) < count and (data := peer.recv(count - len(found))):
        found += data
    return found


@contextmanager
def person(connect: Callable[[], socket.socket], speak: Callable[[socket.socket], list[bytes]],
           heard: list[bytes]) -> Iterator[None]:  # fmt: skip
    def work() -> None:
        with connect() as peer:
            heard.extend(speak(peer))

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    yield
    thread.join(20.0)


@contextmanager
def running(gateway: Gateway) -> Iterator[int]:
    """A gateway that runs beside the test; the port that it listens at."""
    loop = asyncio.new_event_loop()
    server = loop.run_until_complete(gateway.start())
    thread = threading.Thread(target=loop.run_forever, daemon=True)
    thread.start()
    try:
        yield gateway.at[1]
    finally:
        loop.call_soon_threadsafe(loop.stop)
        thread.join(5.0)
        server.close()
        loop.run_until_complete(_ended(asyncio.all_tasks(loop)))
        loop.close()


async def _ended(tasks: set[asyncio.Task[object]]) -> None:
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
    await asyncio.sleep(0.01)  # lines that were closed let go of their sockets in the next round


def translated(folder: Path, text: str, proving: Proving | None = None) -> Translation:
    (folder / "m.mod").write_text(text.replace("<PORT>", "4000"), "latin-1")
    done = translate(folder / "m.mod", to="melfa-basic-6", proving=proving)
    assert done.ok and (done.motion is None) is (proving is None), [
        f.message for f in done.findings
    ]
    told = [row.text for row in done.rows if any(f.code == "RA333" for f in row.reasons)]
    assert told and all(text.startswith(("SocketSend", "SocketReceive")) for text in told)
    return done


def melfa(done: Translation, line: Line) -> list[object]:
    (data,) = done.files.values()
    language = languages.get(done.language)
    program = language.parse(language.decode(data, "A.prg"))
    kernel = Kernel(statement_time=STEP_TIME, most_time=LASTS)
    lines = {"COM3:": line}
    controller = Controller(kernel, {"A": program}, {1: Entry("A", "CYC")}, lines=lines)
    controller.start()
    run = kernel.run()
    assert run.ended in ("end", "time"), run.message  # its next cycle waits for somebody
    return moves(run.events)


def rapid(text: str) -> list[object]:
    kernel = Kernel()
    start_task(kernel, [languages.get("rapid").parse(text)], controller=Irc5())
    run = kernel.run()
    assert run.ended == "end", run.message
    return moves(run.events)


def moves(events: tuple[object, ...]) -> list[object]:
    """Heights that the arm goes to."""
    poses = [getattr(one, "flange", None) for one in events]
    return [round(pose.position[2], 2) for pose in poses if pose is not None]


def dialled(port: int) -> Callable[[], socket.socket]:
    def connect() -> socket.socket:
        for _ in range(400):
            try:
                return socket.create_connection((HERE, port))
            except OSError:
                threading.Event().wait(0.02)
        raise AssertionError

    return connect


TEXTS = r"""MODULE m
VAR socketdev peer;
PROC main()
  VAR rawbytes raw;
  VAR string said;
  SocketCreate peer;
  SocketConnect peer,"127.0.0.1",<PORT>;
  greet peer,"job "+ValToStr(3);
  SocketReceive peer\RawData:=raw\ReadNoOfBytes:=2;
  SocketReceive peer\Str:=said\ReadNoOfBytes:=3;
  SocketSend peer\Str:=said\NoOfBytes:=2;
  SocketClose peer;
ENDPROC
PROC greet(VAR socketdev at,string name)
  SocketSend at\Str:=name;
ENDPROC
ENDMODULE
"""


def test_texts_of_another_socket_stay_texts(tmp_path: Path) -> None:
    other = 'SocketCreate log;\n  SocketConnect log,"127.0.0.1",4001;\n'
    other += '  SocketSend log\\Str:="on"+"\\0D";\n  SocketClose log;\n  SocketClose peer;'
    text = TEXTS.replace("  SocketClose peer;", f"  {other}")
    text = text.replace("VAR socketdev peer;", "VAR socketdev peer;\nVAR socketdev log;")
    (tmp_path / "m.mod").write_text(text.replace("<PORT>", "4000"), "latin-1")
    done = translate(tmp_path / "m.mod", to="melfa-basic-6")
    assert done.ok and not done.totals["not"]
    told = {row.text for row in done.rows if any(f.code == "RA333" for f in row.reasons)}
    assert len(told) == 4 and not any(" log" in text for text in told)


@pytest.mark.slow
def test_a_program_that_listens_says_and_takes_the_same_bytes(tmp_path: Path) -> None:
    port, first, second = free_port(), list[bytes](), list[bytes]()
    with person(dialled(port), asks, first):
        moved = rapid(SERVER.replace("<PORT>", str(port)))
    done = translated(tmp_path, SERVER, Proving(runs=1, seconds=20.0))
    line = TcpServer()
    gateway = Gateway((HERE, 0), line.address, for_controller=False)
    with running(gateway) as at, person(dialled(at), asks, second):
        again = melfa(done, line)
    line.shut()
    assert first == second
    assert [len(one) for one in first] == [24, 1, 4] and first[2] == b"late"
    assert moved == again[: len(moved)] and len(moved) == 2


@pytest.mark.slow
def test_a_program_that_connects_says_and_takes_the_same_bytes(tmp_path: Path) -> None:
    heard: list[list[bytes]] = [[], []]
    with socket.create_server((HERE, 0)) as server:
        port = server.getsockname()[1]
        accept = lambda: server.accept()[0]  # noqa: E731
        with person(accept, answers, heard[0]):
            rapid(CLIENT.replace("<PORT>", str(port)))
        done = translated(tmp_path, CLIENT)
        gateway = Gateway((HERE, 0), (HERE, port), for_controller=True)
        with running(gateway) as at, person(accept, answers, heard[1]):
            melfa(done, TcpClient(HERE, at))
    assert (
        heard[0] == heard[1] == [b"\x01\x02", bytes((0, 13, 44, 255, 4)), b"job 4", b"x,y\r", b""]
    )
