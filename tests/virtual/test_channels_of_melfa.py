"""Open, Print #, Input # and Close in RAPID: what both say over real lines, in files."""

from __future__ import annotations

import socket
import threading
from pathlib import Path

import pytest

from assistant import languages
from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import Translation, translate
from assistant.virtual.kernel import Kernel
from assistant.virtual.melfa import Controller, Entry
from assistant.virtual.melfa.communication_lines import TcpServer
from assistant.virtual.melfa.world import STEP_TIME
from assistant.virtual.rapid.controller import Controller as Irc5
from assistant.virtual.rapid.disk import Disk
from assistant.virtual.rapid.interpreter import start_task

CELL = """
[lines.line_3]
role = "{role}"
port = {port}
address = "127.0.0.1"

[lines.line_1]
role = "serial"
port = 1
"""
HEAD = "Tool P_NTool\nBase P_NBase\nSpd 100\nCnt 0\nMvs P1\n"
END = "\nMvs P1*(0,0,20,0,0,0)\nEnd\nP1=(400,0,400,180,0,180)(7,0)\n"
TALK = """Open "COM3:" As #1
*WT
If M_Open(1)<>1 Then *WT
Print #1,"HELLO"
Input #1,C1$
Input #1,M1
Print #1,"got ";C1$
Close #1
Open "LOG.TXT" For Output As #2
Print #2,C1$;" is ";
Print #2,M1
Close #2"""


def translated(tmp_path: Path, body: str, role: str = "server", port: int = 10003) -> Translation:
    (tmp_path / "TALK.prg").write_text(HEAD + body + END, "ascii")
    (tmp_path / "cell.toml").write_text(CELL.format(role=role, port=port), "ascii")
    return translate(
        tmp_path / "TALK.prg",
        to="rapid",
        process=tmp_path / "cell.toml",
        language="melfa-basic-6",
        proving=Proving(runs=3, seconds=5.0),
    )


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as one:
        return int(one.getsockname()[1])


def peer(port: int, heard: list[bytes]) -> None:
    """Connects, hears a greeting, says a name and a number in one line, hears the answer."""
    for _ in range(200):
        try:
            own = socket.create_connection(("127.0.0.1", port), 0.1)
            break
        except OSError:
            threading.Event().wait(0.05)
    with own:
        own.settimeout(20.0)
        heard.append(own.recv(100))
        own.sendall(b"part,7\r")
        heard.append(own.recv(100))


def test_a_line_that_listens_is_a_socket_and_a_file_a_file(tmp_path: Path) -> None:
    port = free_port()
    done = translated(tmp_path, TALK, port=port)
    assert done.ok and done.motion is not None and done.motion.holds, done.findings
    source = languages.get("melfa-basic-6").parse(HEAD + TALK + END)
    heard: list[list[bytes]] = []
    for first in (True, False):
        heard.append([])
        person = threading.Thread(target=peer, args=(port, heard[-1]))
        person.start()
        if first:
            kernel = Kernel(statement_time=STEP_TIME, most_time=60.0)
            line = TcpServer(port)
            controller = Controller(
                kernel, {"A": source}, {1: Entry("A", "CYC")}, lines={"COM3:": line}
            )
            controller.start()
            ended = kernel.run()
            line.shut()
        else:
            (data,) = done.files.values()
            kernel, home = Kernel(), tmp_path / "home"
            home.mkdir()
            module = languages.get("rapid").parse(data.decode("latin-1"))
            start_task(kernel, [module], controller=Irc5(disk=Disk(home)))
            ended = kernel.run()
        person.join(20.0)
        assert ended.ended == "end", ended.message
    assert heard[0] == heard[1] == [b"HELLO\r", b"got part\r"]
    told = (home / "LOG.TXT").read_bytes()
    assert controller.stored["LOG.TXT"].replace(b"\r", b"\n") == told == b"part is 7\n"


BOTH = {
    "a file is read": 'Open "A.TXT" For Output As #1\nPrint #1,"5"\nClose #1\n'
    'Open "A.TXT" For Input As #1\nInput #1,M1\nClose #1\nIf M1=5 Then Dly 1',
    "a serial line": 'Open "COM1:" As #3\nPrint #3,"x"\nInput #3,C1$\nClose #3\n'
    'If C1$="1" Then Dly 1',
    "a file is appended": 'Open "A.TXT" For Append As #1\nPrint #1,"5";\nPrint #1\nClose #1',
}


@pytest.mark.parametrize("body", BOTH.values(), ids=BOTH)
def test_both_sides_do_the_same(tmp_path: Path, body: str) -> None:
    done = translated(tmp_path, body)
    assert done.ok and done.motion is not None and done.motion.holds, done.findings
    assert done.totals["not"] == 0


def test_a_client_connects(tmp_path: Path) -> None:
    done = translated(tmp_path, TALK, role="client")
    (data,) = done.files.values()
    assert b'SocketConnect channel_1,"127.0.0.1",10003\\Time:=WAIT_MAX;' in data


@pytest.mark.parametrize(
    "line",
    ['Open "COM4:" As #1', 'Open "ENET:127.0.0.1" As #1', "Print #1,1,2", 'Open "A.TXT" As #1'],
)
def test_what_nothing_says_is_not_said(tmp_path: Path, line: str) -> None:
    """A line that the process file does not state, a column, a file of no mode."""
    done = translated(tmp_path, line)
    assert [row.text for row in done.rows if row.level == "not"] == [line]
