"""Programs of MELFA-BASIC on real lines: connections of both directions, and who waits for them."""

from __future__ import annotations

import socket
import threading
from collections.abc import Mapping

from assistant import languages
from assistant.virtual.events import Run
from assistant.virtual.kernel import Kernel
from assistant.virtual.melfa import Controller, Entry
from assistant.virtual.melfa.communication_lines import Line, Serial, TcpServer
from assistant.virtual.melfa.world import STEP_TIME
from tests.virtual.melfa_cell import START, outputs


def run(text: str, lines: Mapping[str, Line] | None = None) -> Run:
    program = languages.get("melfa-basic-5").parse(text.strip())
    assert not program.findings
    kernel = Kernel(statement_time=STEP_TIME, most_time=30.0)
    Controller(kernel, {"A": program}, {1: Entry("A", "CYC")}, start=START, lines=lines).start()
    return kernel.run()


def test_a_program_connects_to_a_server() -> None:
    """C_Com names it before the line is opened (BFP-A3379 4.1)."""
    heard: list[bytes] = []
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            server.settimeout(20.0)
            peer = server.accept()[0]
            peer.settimeout(20.0)
            with peer:
                heard.append(peer.recv(100))
                peer.sendall(b"5\r")
                heard.append(peer.recv(100))

        person = threading.Thread(target=serve)
        person.start()
        done = run(
            f"""
1 C_Com(2)="ETH:127.0.0.1,{server.getsockname()[1]}"
2 *OPN
3 Open "COM2:" As #1
4 If M_Open(1)<>1 Then Close #1
5 If M_Open(1)<>1 Then GoTo *OPN
6 Print #1,"HELLO"
7 Input #1,M1
8 M_Out(M1)=1
9 End"""
        )
        person.join()
    assert (done.ended, outputs(done)) == ("end", [("5", 1.0)]), done.message
    assert heard == [b"HELLO\r", b""]


def test_nobody_listens() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    done = run(
        f"""
1 C_Com(1)="ETH:127.0.0.1,{port}"
2 M_Out(1)=M_Open(1)+2
3 Open "COM1:" As #1
4 M_Out(2)=M_Open(1)+1
5 End"""
    )
    assert outputs(done) == [("1", 1.0), ("2", 1.0)]


def test_another_computer_is_not_connected_to() -> None:
    done = run('1 C_Com(1)="ETH:192.0.2.1,10001"\n2 End')
    assert done.ended == "unknown" and "another computer" in done.message


def test_a_program_waits_for_a_client_and_sees_it_go() -> None:
    """`Def Act 1,M_Open(1)=0 GoSub *DOWN` watches a link (BFP-A3379 4.1)."""
    line = TcpServer()

    def client() -> None:
        with socket.create_connection(line.address, 20.0) as peer:
            assert peer.recv(100) == b"READY\r"

    person = threading.Thread(target=client)
    person.start()
    done = run(
        """
1 Open "ENET:127.0.0.1" As #1
2 Wait M_Open(1)=1
3 Print #1,"READY"
4 Def Act 1,M_Open(1)=0 GoSub *DOWN
5 Act 1=1
6 Wait M_In(1)=1
7 M_Out(2)=1
8 End
9 *DOWN
10 M_Out(1)=1
11 Act 1=0
12 Return 1""",
        {"ENET:": line},
    )
    person.join()
    line.shut()
    assert (done.ended, outputs(done)) == ("end", [("1", 1.0), ("2", 1.0)]), done.message


def test_a_port_that_is_none(tmp_path: object) -> None:
    done = run('1 Open "COM1:" As #1\n2 End', {"COM1:": Serial(f"{tmp_path}/none")})
    assert done.ended == "error" and "error 3140" in done.message


def test_a_line_that_leads_nowhere() -> None:
    done = run('1 Open "COM1:" As #1\n2 End')
    assert done.ended == "error"
    assert "error 3140" in done.message and "COM1:" in done.message
