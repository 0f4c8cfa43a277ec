"""What controllers get is the lines that were read, over every way to them, or nothing."""

from __future__ import annotations

import re
from contextlib import ExitStack
from functools import partial

import pytest

from assistant import deploy as deploying
from assistant.base.diagnostics import Refused
from assistant.controllers import backup_folder, connect
from assistant.virtual.cr import VirtualCr
from assistant.virtual.irc5 import VirtualIrc5
from tests.controllers.abb.sftp_server import SftpServer

ENDS = "\r\v\f\x1c\x1d\x1e\x85\u2028\u2029\0\x03\x04\x1a"
"""Characters that end a line, or the text, for some reader."""
ANY_END = re.compile("[\n\r\v\f\x1c-\x1e\x85\u2028\u2029\x00\x03\x04\x1a]")

RAPID = {
    "comment": "MODULE m\r\nPROC main()\r\n! a {}WaitTime 9;\r\nENDPROC\r\nENDMODULE\r\n",
    "behind": "MODULE m\r\nPROC main()\r\nStop; ! a {}WaitTime 9;\r\nENDPROC\r\nENDMODULE\r\n",
    "string": 'MODULE m\r\nPROC main()\r\nTPWrite "{}WaitTime 9;";\r\nENDPROC\r\nENDMODULE\r\n',
    "name": "MODULE m{}a\r\nPROC main()\r\nENDPROC\r\nENDMODULE\r\n",
    "last": "MODULE m\r\nPROC main()\r\nENDPROC\r\nENDMODULE\r\n! {}LOCAL VAR num x;",
}
MELFA = {
    "comment": "10 ' a {}15 HLT\r\n20 END\r\n",
    "behind": "10 DLY 1 'a {}15 HLT\r\n20 END\r\n",
    "string": '10 C1$="a{}15 HLT"\r\n20 END\r\n',
    "name": "10 GOSUB *A{}15 HLT\r\n20 END\r\n",
    "last": "10 END\r\n20 ' a {}30 HLT",
}


class Cell:
    """A controller, how clients connect, and the texts to send. opened: closes all at the end."""

    name, texts, language, mark = "m.mod", RAPID, "rapid", "!"

    def __init__(self, kind, folder, opened):
        home = folder / "home"
        home.mkdir()
        if kind == "sftp":
            server = opened.enter_context(SftpServer(home))
            self.connect = server.client
        elif kind == "melfa":
            self.name, self.texts, self.language, self.mark = "M", MELFA, "melfa-basic-4", "'"
            there = opened.enter_context(VirtualCr("rv-2aj", servo_time=0.02))
            self.connect = partial(connect, there.address, timeout=5)
        else:
            there = opened.enter_context(VirtualIrc5(home, password="pw"))
            address = there.address if kind == "ftp" else there.rws_address
            self.connect = partial(connect, address, password="pw", timeout=5)

    def statements(self, text):
        """Lines of code as the strictest of all readers sees them."""
        pieces = (re.sub(r"^\s*\d+\s*", "", piece).strip() for piece in ANY_END.split(text))
        return [piece for piece in pieces if piece and not piece.startswith(self.mark)]


@pytest.fixture(params=["ftp", "sftp", "rws", "melfa"])
def cell(request, tmp_path):
    with ExitStack() as opened:
        yield Cell(request.param, tmp_path, opened)


def codes(refused):
    return {finding.code for finding in refused.value.findings}


@pytest.fixture
def client(cell):
    with cell.connect() as client:
        yield client


def test_what_may_end_a_line_sooner_goes_to_no_controller(cell, client):
    for text in cell.texts.values():
        for end in ENDS:
            data = text.format(end).encode("latin-1" if end < "\x80" else "utf-8")
            with pytest.raises(Refused) as refused:
                client.write(cell.name, data)
            assert codes(refused) <= {"IN008", "IN021", "CN305"}, (text, end)
            assert all(finding.line for finding in refused.value.findings)
    assert client.names() == ()


def test_what_a_controller_gets_has_no_more_code_than_was_read(cell, client):
    for kind in ("comment", "behind", "string", "last"):
        for newline in ("\r\n", "\n"):
            sent = cell.texts[kind].format("\t").replace("\r\n", newline)
            client.write(cell.name, sent.encode())
            there = client.read(cell.name).decode()
            assert len(cell.statements(there)) == len(cell.statements(sent))


def test_lines_of_carriage_returns_alone_go_as_lines_or_not_at_all(cell, client):
    sent = cell.texts["comment"].format("").replace("\r\n", "\r").encode()
    if cell.language == "rapid":
        with pytest.raises(Refused) as refused:
            client.write(cell.name, sent)
        assert codes(refused) == {"IN023"} and client.names() == ()
    else:
        client.write(cell.name, sent)
        assert client.read(cell.name) == b"10 ' a 15 HLT\r\n20 END\r\n"


def test_a_deployment_is_not_even_planned(cell, tmp_path):
    file = tmp_path / ("m.mod" if cell.language == "rapid" else "m.prg")
    for end in "\r\v\x1a":
        file.write_bytes(cell.texts["comment"].format(end).encode())
        with pytest.raises(Refused) as refused:
            deploying.plan([file], cell.connect(), history=tmp_path / "history")
        assert codes(refused) <= {"IN008", "IN021"}
        assert {finding.path for finding in refused.value.findings} == {str(file)}
    with cell.connect() as client:
        assert client.names() == ()


def test_lists_of_modules_and_wide_texts_are_looked_at_too(tmp_path):
    with VirtualIrc5(tmp_path / "home", password="pw", rws=None, rwss=None) as irc5:
        client = connect(irc5.address, password="pw", timeout=5)
        (tmp_path / "m.mod").write_bytes(RAPID["comment"].format("").encode())
        (tmp_path / "all.pgf").write_bytes(
            b'<?xml version="1.0"?>\r\n<Program>\r\n<!-- \v --><Module>m.mod</Module>\r\n</Program>'
        )
        with pytest.raises(Refused) as refused:
            deploying.plan([tmp_path / "all.pgf"], client, history=tmp_path / "history")
        assert codes(refused) == {"IN008"}
        (tmp_path / "m.mod").write_bytes(RAPID["comment"].format("").encode("utf-16"))
        with pytest.raises(Refused) as refused:
            deploying.plan([tmp_path / "m.mod"], client, history=tmp_path / "history")
        assert "IN024" in codes(refused)


def test_what_was_there_goes_back_as_it_was(tmp_path):
    (tmp_path / "home").mkdir()
    with SftpServer(tmp_path / "home") as server:
        there, old = tmp_path / "home" / "m.mod", RAPID["comment"].format("\v").encode()
        there.write_bytes(old)
        file, history = tmp_path / "m.mod", tmp_path / "history"
        file.write_bytes(RAPID["comment"].format("").encode())
        plan = deploying.plan([file], server.client(), history=history, replace=["*"])
        assert deploying.deploy(plan, history=history, files_only=True).ok
        assert there.read_bytes() == file.read_bytes()
        assert deploying.rollback(server.client(), history=history).ok
        assert there.read_bytes() == old


def other_backup(source, target, kind, **texts):
    files = {**backup_folder.backup_contents(source, kind), **texts}
    with backup_folder.appearing_folder(target, kind) as place:
        for name, data in files.items():
            backup_folder.put_file(place, name, data)


@pytest.mark.parametrize("cell", ["rws", "melfa"], indirect=True)
def test_a_backup_brings_back_no_such_lines(cell, client, tmp_path):
    client.write(cell.name, cell.texts["comment"].format("").encode())
    client.backup(tmp_path / "saved")
    kind, name = ("melfa", "programs/M.prg") if cell.mark == "'" else ("abb", "HOME/m.mod")
    odd = cell.texts["comment"].format("\v").encode()
    other_backup(tmp_path / "saved", tmp_path / "other", kind, **{name: odd})
    with pytest.raises(Refused) as refused:
        client.restore(tmp_path / "other")
    assert codes(refused) <= {"IN008", "CN305"}
