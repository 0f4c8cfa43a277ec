"""Sockets of RAPID programs, with real ones at the other end."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import pytest

from assistant import languages
from assistant.virtual.events import Run, Said
from assistant.virtual.kernel import Kernel
from assistant.virtual.rapid.controller import Controller, Options
from assistant.virtual.rapid.interpreter import start_task

SERVER = """
MODULE Server
VAR socketdev server;
VAR socketdev client;
VAR string line;
VAR string who;
PROC main()
SocketCreate server;
SocketBind server,"127.0.0.1",PORT;
SocketListen server;
SocketAccept server,client\\ClientAddress:=who;
TPWrite who;
WHILE TRUE DO
SocketReceive client\\Str:=line;
TPWrite line;
SocketSend client\\Str:="got "+line;
ENDWHILE
ERROR
IF ERRNO=ERR_SOCK_CLOSED TPWrite "closed";
SocketClose client;
SocketClose server;
RETURN;
ENDPROC
ENDMODULE
"""


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as one:
        return int(one.getsockname()[1])


def ran(*modules: str, port: int = 0, addresses: dict[str, str] | None = None) -> Run:
    kernel, controller = Kernel(), Controller(Options(addresses=addresses or {}))
    for number, module in enumerate(modules, 1):
        file = languages.get("rapid").parse(module.replace("PORT", str(port)))
        assert not file.findings
        start_task(kernel, [file], name=f"T_ROB{number}", controller=controller)
    return kernel.run()


def said(run: Run) -> list[str]:
    return [event.text for event in run.events if isinstance(event, Said)]


def main(body: str, data: str = "") -> str:
    return f"MODULE Client\nVAR socketdev link;\n{data}\nPROC main()\n{body}\nENDPROC\nENDMODULE\n"


@contextmanager
def beside(does: Callable[[], None]) -> Iterator[None]:
    """Runs what is at the other end; what goes wrong there is raised here."""
    with ThreadPoolExecutor(1) as pool:
        done = pool.submit(does)
        yield
        done.result()


def connected(port: int) -> socket.socket:
    """Tries until the program listens."""
    for _ in range(1000):
        try:
            return socket.create_connection(("127.0.0.1", port), timeout=10.0)
        except ConnectionRefusedError:
            threading.Event().wait(0.002)
    raise AssertionError("nobody listens")


def test_a_program_serves_a_client() -> None:
    port = free_port()
    answers: list[bytes] = []

    def client() -> None:
        with connected(port) as link:
            for line in (b"one", b"two"):
                link.sendall(line)
                answers.append(link.recv(100))

    with beside(client):
        run = ran(SERVER, port=port)
    assert (run.ended, run.message) == ("end", "")
    assert said(run) == ["127.0.0.1", "one", "two", "closed"]
    assert answers == [b"got one", b"got two"]


def test_a_program_is_the_client() -> None:
    asked: list[bytes] = []
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            link, _ = server.accept()
            with link:
                asked.append(link.recv(100))
                link.sendall(b"[1.5,2,3]" + b"x" * 71 + b"rest")

        body = """
SocketCreate link;
TPWrite ""\\Num:=SocketGetStatus(link);
SocketConnect link,"localhost",PORT;
TPWrite ""\\Num:=SocketGetStatus(link);
SocketSend link\\Str:="where?";
SocketReceive link\\Str:=line\\ReadNoOfBytes:=9\\NoRecBytes:=count;
TPWrite line\\Num:=count;
SocketReceive link\\Str:=line\\ReadNoOfBytes:=71;
TPWrite line;
SocketReceive link\\Data:=bytes\\ReadNoOfBytes:=4;
TPWrite ""\\Num:=bytes{1};
SocketClose link;
TPWrite ""\\Num:=SocketGetStatus(link);
"""
        data = "VAR string line; VAR num count; VAR byte bytes{8};"
        with beside(serve):
            run = ran(main(body, data), port=server.getsockname()[1])
    assert (run.ended, run.message) == ("end", "")
    assert said(run) == ["1", "2", "[1.5,2,3]9", "x" * 71, "114", "5"]
    assert asked == [b"where?"]


def test_two_tasks_talk_to_each_other_and_neither_holds_up_the_other() -> None:
    client = main(
        """
SocketCreate link;
SocketConnect link,"127.0.0.1",PORT;
WaitTime 0.01;
SocketSend link\\Str:="from the other task";
SocketReceive link\\Str:=line;
TPWrite line;
SocketClose link;
""",
        "VAR string line;",
    )
    run = ran(SERVER, client, port=free_port())
    assert (run.ended, run.message) == ("end", "")
    assert said(run) == ["127.0.0.1", "from the other task", "got from the other task", "closed"]


def test_packets_of_bytes() -> None:
    port = free_port()
    client = main(
        """
SocketCreate link;
SocketConnect link,"127.0.0.1",PORT;
SocketSend link\\Data:=bytes\\NoOfBytes:=3;
SocketReceive link\\Str:=line;
TPWrite line;
""",
        "VAR string line; VAR byte bytes{5}:=[82,65,80,73,68];",
    )
    assert said(ran(SERVER, client, port=port))[1:3] == ["RAP", "got RAP"]


def test_packed_bytes() -> None:
    client = main(
        """
SocketCreate link;
SocketConnect link,"127.0.0.1",PORT;
PackRawBytes "pos",sent,1\\ASCII;
SocketSend link\\RawData:=sent;
SocketReceive link\\RawData:=came\\ReadNoOfBytes:=7;
UnpackRawBytes came,5,line\\ASCII:=3;
TPWrite line;
""",
        "VAR string line; VAR rawbytes sent; VAR rawbytes came;",
    )
    assert said(ran(SERVER, client, port=free_port()))[1:3] == ["pos", "pos"]


@pytest.mark.parametrize(
    ("body", "number"),
    [
        ('SocketConnect link,"127.0.0.1",PORT;', "ERR_SOCK_CLOSED"),
        ("SocketCreate link; SocketListen link;", "ERR_SOCK_NOT_BOUND"),
        ('SocketCreate link; SocketSend link\\Str:="x";', "ERR_SOCK_NOT_CONN"),
        ("SocketCreate link; SocketReceive link\\Str:=line;", "ERR_SOCK_NOT_CONN"),
        ('SocketCreate link; SocketConnect link,"127.0.0.1",PORT\\Time:=0.02;', "ERR_SOCK_TIMEOUT"),
        (
            'SocketCreate link; SocketBind link,"127.0.0.1",PORT; SocketListen link;'
            " SocketAccept link,other\\Time:=0.02;",
            "ERR_SOCK_TIMEOUT",
        ),
        ('SocketCreate link; SocketConnect link,"nowhere",PORT;', "ERR_SOCK_ADDR_INVALID"),
        ('SocketCreate link; SocketBind link,"127.0.0.1",70000;', "ERR_SOCK_ADDR_INVALID"),
        (
            'SocketCreate link; SocketBind link,"127.0.0.1",PORT; SocketListen link; SocketCreate '
            'other; SocketBind other,"127.0.0.1",PORT;',
            "ERR_SOCK_ADDR_INUSE",
        ),
    ],
)
def test_errors_are_for_the_handler(body: str, number: str) -> None:
    handler = f'ERROR\nIF ERRNO={number} TPWrite "handled";\nRETURN;'
    data = "VAR socketdev other; VAR string line;"
    run = ran(main(f"{body}\n{handler}", data), port=free_port())
    assert (run.ended, said(run)) == ("end", ["handled"])


def test_the_other_end_says_nothing_in_time() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        body = """
SocketCreate link;
SocketConnect link,"127.0.0.1",PORT;
TPWrite ""\\Num:=SocketPeek(link);
SocketReceive link\\Str:=line\\Time:=0.02;
ERROR
IF ERRNO=ERR_SOCK_TIMEOUT TPWrite "silence";
TRYNEXT;
"""
        run = ran(main(body, "VAR string line;"), port=server.getsockname()[1])
    assert said(run) == ["0", "silence"]


@pytest.mark.parametrize(
    ("sent", "message"),
    [
        ('\\Str:="four"\\NoOfBytes:=2', ""),
        ('\\Str:="fo"', ""),
        ('\\Str:="four"\\NoOfBytes:=-1', "-1 bytes of 4"),
        ('\\Str:="four"\\NoOfBytes:=5', "5 bytes of 4"),
        ('\\Str:="four"\\NoOfBytes:=1.5', "no whole number"),
    ],
)
def test_no_more_bytes_are_sent_than_there_are(sent: str, message: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        body = f'SocketCreate link;\nSocketConnect link,"127.0.0.1",PORT;\nSocketSend link{sent};'
        run = ran(main(body), port=server.getsockname()[1])
        link, _ = server.accept()
        with link:
            assert link.recv(100) == (b"" if message else b"fo")
    assert run.ended == ("error" if message else "end")
    assert message in run.message


def test_a_character_that_no_controller_has_is_sent_as_a_question_mark() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        body = (
            'SocketCreate link;\nSocketConnect link,"127.0.0.1",PORT;\nSocketSend link\\Str:="€";'
        )
        run = ran(main(body), port=server.getsockname()[1])
        link, _ = server.accept()
        with link:
            assert (run.ended, link.recv(100)) == ("end", b"?")


def test_only_this_computer_is_reached_unless_the_run_says_more() -> None:
    body = 'SocketCreate link;\nSocketBind link,"192.168.125.1",PORT;\nTPWrite "bound";'
    run = ran(main(body), port=free_port())
    assert run.ended == "unknown"
    assert "192.168.125.1" in run.message
    run = ran(main(body), port=free_port(), addresses={"192.168.125.1": "127.0.0.1"})
    assert (run.ended, said(run)) == ("end", ["bound"])


def test_a_run_that_ends_leaves_no_socket_open() -> None:
    port = free_port()
    body = 'SocketCreate link;\nSocketBind link,"127.0.0.1",PORT;\nSocketListen link;\nEXIT;'
    for _ in range(2):
        assert ran(main(body), port=port).ended == "end"


def test_packets_over_udp_are_not_simulated() -> None:
    run = ran(main("SocketCreate link\\UDP;"))
    assert (run.ended, "udp" in run.message) == ("unknown", True)


def test_raw_bytes_go_through_a_socket() -> None:
    port = free_port()
    server = main(
        'SocketCreate link;\nSocketBind link,"127.0.0.1",PORT;\nSocketListen link;\n'
        "SocketAccept link,client;\nSocketReceive client\\RawData:=raw;\n"
        "UnpackRawBytes raw\\Network,1,n\\IntX:=UINT;\n"
        'TPWrite ""\\Num:=n;\nTPWrite ""\\Num:=RawBytesLen(raw);\n'
        'ClearRawBytes raw;\nPackRawBytes "ok\\00",raw,1\\ASCII;\nSocketSend client\\RawData:=raw;',
        "VAR socketdev client;\nVAR rawbytes raw;\nVAR num n;",
    )
    answers: list[bytes] = []

    def asks() -> None:
        with connected(port) as link:
            link.sendall(b"\x01\x02\x03")
            answers.append(link.recv(10))

    with beside(asks):
        found = ran(server, port=port)
    assert (said(found), found.ended) == (["258", "3"], "end")
    assert answers == [b"ok\0"]
