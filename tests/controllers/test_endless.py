"""Peers whose answer goes on for ever, byte by byte or as fast as the line is."""

import contextlib
import itertools
import socket
import threading

import pytest

from assistant.controllers import connect
from assistant.controllers.abb.ftp import Ftp
from assistant.controllers.rules import Lost

BEGIN = {
    "ftp": (b"220-hello", b"x"),
    "rws": (b"HTTP/1.1 200 OK\r\nX: ", b"x"),
    "melfa": (b"QoK", b";"),
}
FLOODS = {"ftp": (b"", b"220-hello\r\n" * 1000), "melfa": (b"QoK", b";" * 4096)}
CASES = [*((scheme, said, 0.02) for scheme, said in BEGIN.items())]
CASES += [(scheme, said, 0.0) for scheme, said in FLOODS.items()]
BODIES = [b"HTTP/1.1 200 OK\r\n\r\n", b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n0"]
CASES += [("rws", (begin, b"0"), 0.02) for begin in BODIES]


@contextlib.contextmanager
def endless(begin, more, pause):
    """A server that says `begin`, and then `more` again and again; its port."""
    over = threading.Event()

    def talk(connection):
        with connection, contextlib.suppress(OSError):
            connection.settimeout(0.5)  # if nobody reads it any more
            for piece in itertools.chain([begin], itertools.repeat(more)):
                connection.sendall(piece)
                if over.wait(pause):
                    return

    def accept():
        with contextlib.suppress(OSError):
            while True:
                threads.append(threading.Thread(target=talk, args=(listener.accept()[0],)))
                threads[-1].start()

    with socket.create_server(("127.0.0.1", 0)) as listener:
        threads = [threading.Thread(target=accept)]
        threads[0].start()
        try:
            yield listener.getsockname()[1]
        finally:
            over.set()
            listener.shutdown(socket.SHUT_RDWR)
            for thread in threads:
                thread.join()


@pytest.mark.parametrize(("scheme", "said", "pause"), CASES)
def test_an_answer_that_does_not_end_is_given_up(scheme, said, pause):
    with endless(*said, pause) as port, pytest.raises(Lost) as lost:
        user = "" if scheme == "melfa" else "somebody@"
        login = {} if scheme == "melfa" else {"password": "secret"}
        with connect(f"{scheme}://{user}127.0.0.1:{port}", timeout=0.2, **login):
            pass
    finding = lost.value.findings[0]
    assert finding.code in ("CN201", "CN204", "CN302") and "secret" not in str(lost.value)


def listing(data_port):
    """The control side of an FTP server whose transfers come from another port; its port."""
    high, low = divmod(data_port, 256)
    said = {b"USER": b"331 ", b"PASV": b"227 (127,0,0,1,%d,%d)" % (high, low)}
    said |= dict.fromkeys([b"NLST", b"MLSD", b"RETR"], b"150 ")

    def talk():
        with contextlib.suppress(OSError):
            connection, _ = listener.accept()
            with connection, connection.makefile("rb") as commands:
                connection.sendall(b"220 hello\r\n")
                for command in commands:
                    connection.sendall(said.get(command[:4].strip(), b"250 ") + b"\r\n")

    listener = socket.create_server(("127.0.0.1", 0))
    thread = threading.Thread(target=talk)
    thread.start()
    return listener, thread


@pytest.mark.parametrize("more", [b"x.mod\r\n", b"x"])
@pytest.mark.parametrize("ask", [Ftp.names, Ftp.tree, lambda client: client.look("seam.mod")])
def test_a_transfer_that_does_not_end_is_given_up(ask, more):
    with endless(b"", more, 0.01) as data_port:
        listener, thread = listing(data_port)
        with listener, pytest.raises(Lost) as lost:
            address = f"ftp://somebody@127.0.0.1:{listener.getsockname()[1]}"
            with connect(address, password="secret", timeout=0.05) as client:
                ask(client)
        thread.join()
    assert "no answer in time" in lost.value.findings[0].message
