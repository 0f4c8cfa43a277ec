"""What clients of controllers read: listings, answers, packets, backups, whoever made them."""

from __future__ import annotations

import hashlib
import io
import json
import math
import shutil
import socket
import threading
import zipfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import Final

from assistant.controllers import Controller, Programs, backup_folder, connect
from assistant.controllers.abb import egm, ftp
from assistant.controllers.abb.exchange import files as exchange
from assistant.controllers.abb.exchange import protocols
from assistant.controllers.abb.ftp import Ftp
from assistant.controllers.abb.rws import protocol as rws
from assistant.controllers.mitsubishi import backup, external_control, link, programs, values
from assistant.controllers.mitsubishi.data_link import Form
from assistant.deploy.history import archived_programs
from tests.fuzz.target import Target, file, folder, promise, refusing

CUT: Final = b"\n=====\n"
"""Between the answers to commands and what comes on a line of its own."""
MOST_COMMANDS: Final = 200
"""After which the server hangs up."""
PATIENCE: Final = 0.05
"""Seconds that a client waits for what never comes."""


# ------------------------------------------------------------------------- whole conversations


@contextmanager
def conversation(table: bytes, end: bytes, usual: bytes, *, greets: bool = False) -> Iterator[int]:
    """A server that answers commands by a table; its port.

    table: lines of a beginning of commands, a blank, and the answers with `|` between; of several
    for one beginning each is taken once, the last one for ever. usual: what all else gets.
    """
    rows: dict[bytes, list[bytes]] = {}
    for line in table.split(b"\n"):
        beginning, _, answers = line.partition(b" ")
        rows.setdefault(beginning, []).append(answers)

    def answer(command: bytes) -> bytes:
        for beginning in sorted(rows, key=len, reverse=True):
            if beginning and command.startswith(beginning):
                told = rows[beginning]
                return (told.pop(0) if len(told) > 1 else told[0]).replace(b"|", end) + end
        return usual + end

    with socket.create_server(("127.0.0.1", 0)) as listener:

        def talk() -> None:
            with suppress(OSError):
                channel, _ = listener.accept()
                with channel:
                    channel.settimeout(5.0)
                    if greets:
                        channel.sendall(answer(b"HELLO"))
                    for _ in range(MOST_COMMANDS):
                        commands = channel.recv(4096)
                        if not commands:
                            return
                        channel.sendall(answer(commands.split(b";", 2)[-1]))

        thread = threading.Thread(target=talk, daemon=True)
        thread.start()
        try:
            yield int(listener.getsockname()[1])
        finally:
            with suppress(OSError):
                listener.shutdown(socket.SHUT_RDWR)
            thread.join(10)


@contextmanager
def transfers(data: bytes) -> Iterator[int]:
    """A port at which whoever comes gets these bytes."""
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def serve() -> None:
            with suppress(OSError):
                while True:
                    channel, _ = listener.accept()
                    with channel, suppress(OSError):
                        channel.sendall(data)

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        try:
            yield int(listener.getsockname()[1])
        finally:
            with suppress(OSError):
                listener.shutdown(socket.SHUT_RDWR)
            thread.join(10)


def asked_all(client: Programs, tries: Iterable[Callable[[], object]]) -> None:
    """Each thing that is asked is answered or refused by itself."""
    with refusing(), client:
        for ask in tries:
            with refusing():
                ask()


def ftp_client(data: bytes) -> None:
    """Answers of a file server by its commands; behind the cut, what its transfers bring."""
    table, _, data = data.partition(CUT)
    with transfers(data) as port:
        table = table.replace(b"{PORT}", b"127,0,0,1,%d,%d" % divmod(port, 256))
        with conversation(table, b"\r\n", b"200 ok", greets=True) as port:
            client = connect(f"ftp://u@127.0.0.1:{port}", password="secret", timeout=PATIENCE)
            assert isinstance(client, Ftp)
            place = folder() / "fetched"
            shutil.rmtree(place, ignore_errors=True)
            fetch = partial(client.fetch_folder, "", place)
            read = partial(client.read, "a.mod")
            asked_all(client, (client.names, read, fetch, partial(client.write, "a.mod", b"x")))


def link_client(data: bytes) -> None:
    """Answers of a controller link by its commands."""
    with conversation(data, b"\r", b"QoK") as port:
        client = connect(f"melfa://127.0.0.1:{port}", timeout=PATIENCE)
        assert isinstance(client, Controller)
        looks = (client.names, client.state, client.position, client.identify)
        more = (
            partial(client.log, 3),
            partial(client.parameters, ()),
            partial(client.variable, "M1"),
            partial(client.inputs, ["5"]),
            partial(client.read, "1"),
        )
        asked_all(client, (*looks, *more))


# ------------------------------------------------------------------------------ single answers


def listings(data: bytes) -> None:
    lines = data.decode("latin-1").split("\n")
    for read in (ftp.parse_list, ftp.parse_mlsd):
        for entry in read(lines) or ():
            promise(entry.size is None or entry.size >= 0, "a file of less than no bytes")


def rws_answer(data: bytes) -> None:
    with suppress(ValueError):
        rows, following, number, text = rws.parse_answer(data)
        promise(isinstance(following, str) and isinstance(text, str), "no text")
        promise(number is None or abs(number) < 10**12, "a number without end")
        for row in rows:
            rws.plain_message(row.title)
            with suppress(ValueError):
                rws.numbers(row, tuple(row.values))


def link_answer(data: bytes) -> None:
    text = data.decode("latin-1")
    link.parse_answer(text)
    link.unframed(data)
    promise(link.unframed(link.frame(data[:200])[1:-1]) in (None, data[:200]), "framed anew")
    for line in programs.program_lines(data):
        programs.statement_form(line.text)
        programs.rounded_values(line.text)
    again = programs.listed_form(data)
    promise(programs.listed_form(again) == again, "a listing that is another one when listed")
    backup.assignments(data)


def egm_packet(data: bytes) -> None:
    for kind in ("EgmRobot", "EgmSensor"):
        with suppress(ValueError):
            message = egm.decode(kind, data)
            egm.decode(kind, egm.encode(kind, message))
            message.number("seqno")
            message.all("feedBack", "joints", "joints")


def mxt_packet(data: bytes) -> None:
    fields = external_control.unpack_packet(data)
    promise(
        (fields is None) == (len(data) != external_control.PACKET_SIZE),
        "a packet of another length",
    )
    if fields is not None:
        promise(
            external_control.unpack_packet(external_control.pack_packet(fields)) == fields,
            "packed again it is another one",
        )


def record_line(data: bytes) -> None:
    form = Form.parse("M_TIMER(1) | P_CURR | J_FBC | M_RSPD(3) | C_PRG")
    recording = form.recording()
    with suppress(ValueError):
        form.record(recording, form.read(data.decode("latin-1")))


def exchange_answer(data: bytes) -> None:
    answer = exchange.parse_answer(data)
    if answer is not None:
        exchange.is_of(answer, 1)


def plain_answer(data: bytes) -> None:
    texts = [*data.split(b"|"), b"", b"", b""][:3]
    answer = protocols.parse_plain_answer(1, texts)
    if answer is not None:
        numbers = (*answer.pose.position, *answer.pose.quaternion)
        promise(all(map(math.isfinite, numbers)), "an answer is of finite numbers", numbers)


def parameters(data: bytes) -> None:
    with refusing():
        values.parameter_kinds([file("input.PRM", data)])


# -------------------------------------------------------------------------- what was kept there


def backed_up(data: bytes) -> None:
    """The index of a backup, and a file of it behind the cut."""
    index, _, content = data.partition(CUT)
    place = folder() / "backup"
    shutil.rmtree(place, ignore_errors=True)
    (place / "programs").mkdir(parents=True)
    (place / "programs" / "A.prg").write_bytes(content)
    (place / backup_folder.INDEX).write_bytes(index)
    with refusing():
        found = backup_folder.backup_contents(place, backup.KIND)
        promise(set(found.values()) <= {content, index}, "bytes from elsewhere")


def archive(data: bytes) -> None:
    """An archive as a deployment leaves it on a controller, or the files of one by turns."""
    if not data.startswith(b"PK"):
        made = io.BytesIO()
        names = ("record.json", "programs.json", "after/1-a.mod", "../../out", "/out")
        with zipfile.ZipFile(made, "w") as packed:
            for name, part in zip(names, data.split(CUT), strict=False):
                packed.writestr(name, part)
        data = made.getvalue()
    before = {path.name for path in folder().iterdir()}
    with refusing():
        archived_programs(data)
    promise({path.name for path in folder().iterdir()} == before, "a file outside of its folder")


# ---------------------------------------------------------------------------------------- seeds


def _ftp() -> Iterable[bytes]:
    begin = b"HELLO 220 ready\nUSER 331 password\nPASS 230 in\nCWD 250 in\nPASV 227 ({PORT})\n"
    names = (
        b"NLST 150 opening|226 done\nRETR 150 Opening (5 bytes)|226 done\nSIZE 213 5\nTYPE 200 I\n"
    )
    tree = b'PWD 257 "/HOME:"\nLIST 150 x|226 y\nMLSD 500 no\nSTOR 150 x|226 y\nRNFR 350 x\n'
    whole = begin + names + tree + b"RNTO 550 no\n"
    unix = b"-rw-r--r-- 1 a b 5 Jan 01 1980 a.mod\r\ndrwxr-xr-x 2 a b 0 Jan 1 10:00 parts\r\n"
    facts = b"type=file;size=12; a.mod\r\ntype=dir; parts\r\ntype=cdir; .\r\n"
    return [
        whole + CUT + b"a.mod\r\nM\xe4rz.mod\r\n",
        whole + CUT + unix,
        whole.replace(b"500 no", b"150 x|226 y") + CUT + facts,
        b"HELLO 220-a|220 b\nUSER 230-x|230 in\nPASV 227 (1,2)\nCWD 421 bye\nNLST 550 empty" + CUT,
        b"HELLO 220 x\nUSER 530 no" + CUT,
    ]


def _link() -> Iterable[bytes]:
    whole = (
        b"OPEN QoK3F;3F;7,0;3,5,A,1E,32,46,64;MB4;PRM;RV-3SB;CRn-5xx;MELFA;05-07-14;V;ENG;C;1;1;2;",
        b"PDIRTOP QoK1.MB4;4767;24-02-2821:05:14;2;220160;12;;9;82;135256;6848;9661;14",
        b"STATE QoK1.MB4;10;30;2;E9050;1;1;;;;;;;;;REP;START;1;1",
        b"JPOSF QoKJ1;10.00;J2;20.00;J3;90.00;J4;0.00;J5;5.00;J6;0.00;;****,****;50;0.00;00000000",
        b"PPOSF QoKX;176.01;Y;33.14;Z;541.62;A;77.9;B;-25.5;C;106.8;;6,15728640;100;0.00;00000000",
        b"ERRORLOGTOP QoK24-02-28;21:05:01;4140;text of the controller;2;1;30;414000000",
        b"PMR=0 QoK1;2;MEXTL\vRLNG",
        b"PNRMEXTL QoKMEXTL;0.00, 0.00;6",
        b"PNRRLNG QoKRLNG;1;1",
        b"VAL QoKM1=+3",
        b"IN QoK0000",
        b"LISTL QoK10 M1=1\v20 END",
        b"LISTP QoKP1=(+1.00,+0.00)(6,0)",
    )
    return [b"\n".join(whole), b"\n".join(whole[:3]) + b"\nPPOSF QeR4140000000", whole[0]]


def _rws() -> Iterable[bytes]:
    xhtml = (
        b'<?xml version="1.0"?><html xmlns="http://www.w3.org/1999/xhtml"><head><base href="x"/>'
        b'</head><body><div class="state"><a href="x?a=2" rel="next"/><ul><li class="ios-li" '
        b'title="doGrip"><a href="signals/doGrip" rel="self"/><span class="lvalue">1</span></li>'
        b'</ul></div><div class="status"><span class="code">-1073445881</span></div></body></html>'
    )
    hal = {
        "_links": {"next": {"href": "x?a=1&amp;b=2"}},
        "_embedded": {"_state": [{"_type": "rap-data", "_title": "x", "value": "9E9"}]},
        "state": [{"_type": "ms", "rax_1": "1.5", "_links": {"self": {"href": "y"}}}],
        "status": {"code": 1, "msg": "a"},
    }
    return [xhtml, json.dumps(hal).encode(), b""]


def _egm() -> Iterable[bytes]:
    header = bytes.fromhex("0a06080a10141802")
    joints = bytes.fromhex("0a12") + b"".join(b"\x09" + bytes(8) for _ in range(2))
    return [header, header + b"\x12" + bytes([len(joints)]) + joints, header + b"\x1a\x00"]


def _backup() -> Iterable[bytes]:
    content = b"10 END\r\n"
    digest = hashlib.sha256(content).hexdigest()
    index = {"format": backup_folder.FORMAT, "kind": "melfa", "files": {"programs/A.prg": digest}}
    return [json.dumps(index).encode() + CUT + content, b"{}"]


def _archive() -> Iterable[bytes]:
    empty = io.BytesIO()
    with zipfile.ZipFile(empty, "w"):
        pass
    return [CUT.join((b"{}", b"[]", b"a", b"b", b"c")), empty.getvalue()]


def _packets() -> Iterable[bytes]:
    return [bytes(external_control.PACKET_SIZE), bytes(range(external_control.PACKET_SIZE)), b""]


def _records() -> Iterable[bytes]:
    return [b"1.5|(1,2,3,4,5,6)(7,0)|(1,2,3,4,5,6,0,0)|3|A", b"1|(1)()|()|1e9|"]


def _exchange() -> Iterable[bytes]:
    return [b"1\nok\n[1,2,3]\n[1,0,0,0]\n[0,0,0,0]\n[9E9,9E9,9E9,9E9,9E9,9E9]\n0\nEND 1\n"]


def _plain() -> Iterable[bytes]:
    return [b"[1,2,3]\n|[1,0,0,0]\n|[0,0,0,0]\n", b"1\n2\n3\n|0.5 0.5 0.5 0.5\n|0,-1,0,1\n"]


def _parameters() -> Iterable[bytes]:
    return [b'#"MELFA";MEXTL,"6,R,0,-9999,9999"\r\nRLNG,"1,I"\r\n', b"; a\r\nA,1\r\n"]


TARGETS: Final = (
    Target("ftp-client", ftp_client, _ftp, lambda: ("|226 x", "213 5", '257 "', "{PORT}"), tried=8),
    Target("link-client", link_client, _link, lambda: ("QoK", "Qer4170", ";;", "\v"), tried=2),
    Target("ftp-listing", listings, lambda: [part.partition(CUT)[2] for part in _ftp()]),
    Target("rws-answer", rws_answer, _rws, lambda: ("<!DOCTYPE html>", "<!ENTITY a 'b'>", "&a;")),
    Target("link-answer", link_answer, _link),
    Target("egm-packet", egm_packet, _egm),
    Target("mxt-packet", mxt_packet, _packets),
    Target("data-link", record_line, _records),
    Target("exchange", exchange_answer, _exchange),
    Target("plain-exchange", plain_answer, _plain),
    Target("parameter-file", parameters, _parameters),
    Target("backup", backed_up, _backup),
    Target("archive", archive, _archive),
)
