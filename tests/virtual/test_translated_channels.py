"""Files, serial lines and sockets of RAPID in MELFA-BASIC: both programs on real ones."""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from assistant import languages
from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import Translation, translate
from assistant.virtual.kernel import Kernel
from assistant.virtual.melfa import Controller, Entry
from assistant.virtual.melfa.communication_lines import Line, Serial, TcpClient, TcpServer
from assistant.virtual.melfa.world import STEP_TIME
from assistant.virtual.rapid import disk
from assistant.virtual.rapid.controller import Controller as Irc5
from assistant.virtual.rapid.interpreter import start_task

PROGRAM = r"""MODULE m
VAR num x:=3.5;
VAR string s;
VAR string t;
VAR iodev log;
VAR socketdev server;
VAR socketdev peer;
CONST robtarget p1:=[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
MoveL p1,v100,fine,tool0;
{}
MoveL Offs(p1,0,0,x),v100,fine,tool0;
ENDPROC
ENDMODULE
"""


def translated(tmp_path: Path, body: str, to: str = "melfa-basic-6") -> Translation:
    (tmp_path / "m.mod").write_text(PROGRAM.format(body), "latin-1")
    done = translate(tmp_path / "m.mod", to=to, proving=Proving(runs=3, seconds=5.0))
    assert done.ok and done.motion is not None and done.motion.holds, done.findings
    return done


def melfa(done: Translation, lines: Mapping[str, Line] | None = None) -> Controller:
    (data,) = done.files.values()
    language = languages.get(done.language)
    program = language.parse(language.decode(data, "A.prg"))
    kernel = Kernel(statement_time=STEP_TIME, most_time=60.0)
    controller = Controller(kernel, {"A": program}, {1: Entry("A", "CYC")}, lines=lines)
    controller.start()
    run = kernel.run()
    assert run.ended == "end", run.message
    return controller


def rapid(tmp_path: Path, folder: Path) -> None:
    kernel, controller = Kernel(), Irc5(disk=disk.Disk(folder))
    file = languages.get("rapid").parse((tmp_path / "m.mod").read_text("latin-1"))
    start_task(kernel, [file], controller=controller)
    run = kernel.run()
    assert run.ended == "end", run.message


FILES = {
    "lines": r'Write log,"a ";Write log,"b"\NoNewLine;Write log,"c";',
    "a number": r'Write log,"x "\Num:=x;Write log,"y "\Num:=12;',
    "a long line": 'Write log,"' + '"+NumToStr(x,1)+"'.join("ab" * 9) + '";',
    "a truth": r'Write log,"is "\Bool:=x>3;Write log,"is "\Bool:=FALSE;',
    "a position": r'Write log,"at "\Pos:=[1,-2,x];Write log,"at "\Pos:=p1.trans;',
    "an orientation": r'Write log,"as "\Orient:=[1,0,0,0];',
}


@pytest.mark.parametrize("written", FILES.values(), ids=FILES)
def test_a_file_has_the_same_lines_with_other_ends(tmp_path: Path, written: str) -> None:
    body = rf'Open "HOME:"\File:="log.txt",log\Write;{written}Close log;'
    done = translated(tmp_path, body)
    assert "MB262" in {f.code for f in done.findings}
    home = tmp_path / "home"
    home.mkdir()
    rapid(tmp_path, home)
    told = (home / "log.txt").read_bytes()
    assert told.endswith(b"\n")
    assert melfa(done).stored["LOG.TXT"] == told.replace(b"\n", b"\r")


def test_a_file_is_appended_and_read(tmp_path: Path) -> None:
    done = translated(
        tmp_path,
        r'Open "HOME:"\File:="log.txt",log\Append;'
        r'Write log,"50";Close log;Open "log.txt",log\Read;x:=ReadNum(log);Close log;'
        r'Open "log.txt",log\Read;s:=ReadStr(log);Close log;IF s="50" x:=x+1;',
    )
    codes = {f.code for f in done.findings}
    assert {"RA332", "MB262"} <= codes
    assert done.motion is not None and done.motion.found is not None
    assert done.motion.found.visits == 2


def test_files_one_after_the_other_share_numbers(tmp_path: Path) -> None:
    """Twelve of them, of which six stay open beside the others."""
    more = "".join(f"VAR iodev f{n};\n" for n in range(1, 13))
    long = range(1, 7)
    body = "".join(rf'Open "HOME:"\File:="f{n}.txt",f{n}\Write;' for n in long)
    body += "FOR i FROM 1 TO 2 DO write_late i;\nENDFOR\n"
    body += "".join(f'Write f{n},"{n}";Close f{n};' for n in long)
    late = "".join(
        rf'IF i=1 THEN Open "HOME:"\File:="f{n}.txt",f{n}\Append;Write f{n},"{n}";Close f{n};ENDIF '
        for n in range(7, 12)
    )
    late += r'Open "HOME:"\File:="f12.txt",f12\Append;Write f12,"12";Close f12;'
    text = PROGRAM.format(body).replace("ENDMODULE", f"PROC write_late(num i)\n{late}\nENDPROC\n")
    text = text.replace("VAR num x", more + "VAR num x") + "ENDMODULE\n"
    (tmp_path / "m.mod").write_text(text, "latin-1")
    done = translate(tmp_path / "m.mod", to="melfa-basic-6")
    assert done.ok and done.totals["not"] == 0, done.findings
    home = tmp_path / "home"
    home.mkdir()
    rapid(tmp_path, home)
    stored = melfa(done).stored
    assert len(stored) == 12
    for file in home.iterdir():
        told = file.read_bytes()
        assert told and stored[file.name.upper()] == told.replace(b"\n", b"\r")


def test_more_files_than_numbers_at_once_are_refused(tmp_path: Path) -> None:
    more = "".join(f"VAR iodev f{n};\n" for n in range(1, 10))
    body = "".join(rf'Open "HOME:"\File:="f{n}.txt",f{n}\Write;' for n in range(1, 10))
    body += "".join(f'Write f{n},"{n}";Close f{n};' for n in range(1, 10))
    text = PROGRAM.format(body).replace("VAR num x", more + "VAR num x")
    (tmp_path / "m.mod").write_text(text, "latin-1")
    done = translate(tmp_path / "m.mod", to="melfa-basic-6")
    refused = [row.text for row in done.rows if row.level == "not"]
    assert len(refused) == 3


def test_a_file_that_is_opened_for_nothing_is_what_the_program_does_with_it(tmp_path: Path) -> None:
    body = r'Open "HOME:"\File:="log.txt",log;Write log,"a";Close log;'
    (tmp_path / "m.mod").write_text(PROGRAM.format(body), "latin-1")
    done = translate(tmp_path / "m.mod", to="melfa-basic-6")
    assert done.totals["not"] == 0
    assert "RA392" in {f.code for f in done.findings}
    (tmp_path / "m.mod").write_text(PROGRAM.format(body + "Rewind log;s:=ReadStr(log);"), "latin-1")
    done = translate(tmp_path / "m.mod", to="melfa-basic-6")
    assert "reading and writing" in " ".join(f.message for f in done.findings)


def conversation(connect: Callable[[], socket.socket], heard: list[bytes], end: bytes) -> None:
    """Reads a greeting, says a name, reads the answer."""
    with connect() as peer:
        peer.settimeout(20.0)
        heard.append(peer.recv(100))
        peer.sendall(b"part 7" + end)
        heard.append(peer.recv(100))


def both(
    tmp_path: Path,
    done: Translation,
    connect: Callable[[], socket.socket],
    line: Callable[[], Line],
) -> tuple[list[bytes], list[bytes]]:
    """What the other end hears of the source, and of what was written."""
    found: list[list[bytes]] = []
    for end in (b"", b"\r"):
        heard: list[bytes] = []
        person = threading.Thread(target=conversation, args=(connect, heard, end))
        person.start()
        if end:
            melfa(done, {"COM3:": (own := line())})
            if isinstance(own, TcpServer):
                own.shut()
        else:
            rapid(tmp_path, tmp_path)
        person.join(20.0)
        found.append(heard)
    first, second = found
    return first, second


TALK = (
    r'SocketSend peer\Str:="hello"+"\0D";SocketReceive peer\Str:=s;'
    r'SocketSend peer\Str:="got "+s+"\0D";SocketClose peer;'
)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as one:
        return int(one.getsockname()[1])


def test_a_server_talks_as_a_line_that_listens(tmp_path: Path) -> None:
    port = free_port()
    body = rf'SocketCreate server;SocketBind server,"127.0.0.1",{port};SocketListen server;'
    body += rf"SocketAccept server,peer\Time:=WAIT_MAX;{TALK}SocketClose server;"
    done = translated(tmp_path, body)
    (told,) = (f for f in done.findings if f.code == "MB261")
    assert f'COMDEV(3)="OPT13", CPRCE13=2, NETMODE(3)=1, NETPORT(4)={port}' in (told.cure or "")

    def connect() -> socket.socket:
        for _ in range(200):
            try:
                return socket.create_connection(("127.0.0.1", port), 0.1)
            except OSError:
                threading.Event().wait(0.05)
        raise TimeoutError

    first, second = both(tmp_path, done, connect, lambda: TcpServer(port))
    assert first == second == [b"hello\r", b"got part 7\r"]


def test_a_client_talks_as_a_line_that_connects(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(20.0)
        port = server.getsockname()[1]
        body = rf'SocketCreate peer;SocketConnect peer,"127.0.0.1",{port};{TALK}'
        done = translated(tmp_path, body)
        assert any(f.code == "MB261" and "NETMODE(3)=0" in (f.cure or "") for f in done.findings)
        line = lambda: TcpClient("127.0.0.1", port)  # noqa: E731
        first, second = both(tmp_path, done, lambda: server.accept()[0], line)
    assert first == second == [b"hello\r", b"got part 7\r"]


@pytest.mark.skipif(os.name == "nt", reason="serial ports are opened on Linux and macOS only")
def test_a_serial_port_is_the_line_of_its_number(tmp_path: Path) -> None:
    body = r'Open "com1:",log;Write log,"hello";s:=ReadStr(log);'
    done = translated(tmp_path, body + r'Write log,"got "+s;Close log;')
    master, slave = os.openpty()
    heard: list[bytes] = []

    def serve() -> None:
        heard.append(os.read(master, 100))
        os.write(master, b"part 7\r")
        heard.append(os.read(master, 100))

    person = threading.Thread(target=serve, daemon=True)
    person.start()
    melfa(done, {"COM1:": Serial(os.ttyname(slave))})
    person.join(20.0)
    os.close(master)
    os.close(slave)
    assert heard == [b"hello\r", b"got part 7\r"]


NOT_SAID = {
    "bytes": r"WriteAnyBin log,x;",
    "no port": r"SocketAccept server,peer;",
    "a long name": r'Open "HOME:"\File:="a_file_of_a_long_name.txt",log\Write;',
}


@pytest.mark.parametrize("statement", NOT_SAID.values(), ids=NOT_SAID)
def test_what_cannot_be_said_keeps_only_itself(tmp_path: Path, statement: str) -> None:
    body = r'Open "a.txt",log\Write;Write log,"a";Close log;' + "\n" + statement
    (tmp_path / "m.mod").write_text(PROGRAM.format(body), "latin-1")
    done = translate(tmp_path / "m.mod", to="melfa-basic-6", draft=True)
    levels = {row.text.rstrip(";"): row.level for row in done.rows}
    assert [text for text, level in levels.items() if level == "not"] == [statement.rstrip(";")]
    assert done.draft


@pytest.mark.parametrize("to", ["melfa-basic-4", "melfa-basic-5"])
def test_older_dialects_have_the_same_statements(tmp_path: Path, to: str) -> None:
    done = translated(tmp_path, r'Open "a.txt",log\Write;Write log,"a"\Num:=x;Close log;', to)
    (data,) = done.files.values()
    text = data.decode("ascii").upper()
    assert 'PRINT #1,"A";MX' in text and "CLOSE #1" in text
