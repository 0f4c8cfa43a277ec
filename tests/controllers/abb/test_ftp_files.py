"""Transfers that go on, whole folders, and both ways of connecting, with real FTP servers.

Servers that are not installed are skipped, and counted so.
"""

import json
import os
import socket

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import backup_folder
from assistant.controllers.abb import ftp
from assistant.controllers.abb.ftp import Entry
from assistant.controllers.rules import Lost
from tests.controllers.abb.ftp_servers import SERVERS, pyftpdlib

BIG = bytes(range(256)) * 3000
TREE = {
    "seam.mod": b"MODULE seam\r\nENDMODULE\r\n",
    "parts/one.mod": b"\x00\xff\r\n\n",
    "parts/deep/er/two words.txt": b"two",
    "empty.txt": b"",
}


def codes(refused):
    return [finding.code for finding in refused.value.findings]


@pytest.fixture(params=SERVERS)
def server(request, tmp_path):
    root = tmp_path / "root"
    root.mkdir()
    with SERVERS[request.param](root) as server:
        yield server


@pytest.fixture
def plain(tmp_path):
    root = tmp_path / "root"
    root.mkdir()
    with pyftpdlib(root) as server:
        yield server


def fill(folder, files):
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)


@pytest.mark.parametrize("options", ["", "?mode=active"])
def test_files_go_there_and_come_back(server, options):
    with server.client(options) as client:
        assert (
            client.names() == () and client.read("a.bin") is None and client.look("a.bin") is None
        )
        for data in (BIG[:70000], b"shorter", b""):
            client.write("a.bin", data)
            assert client.read("a.bin") == client.look("a.bin") == data
        client.hand_over("a.bin", b"handed over")
        assert (client.names(), client.size("a.bin")) == (("a.bin",), 11)
        client.take_away("a.bin")
        client.take_away("a.bin")
        assert client.names() == () and client.size("a.bin") is None


def test_folders_are_fetched_whole(server, tmp_path):
    fill(server.home, TREE)
    with server.client() as client:
        entries = client.tree()
        assert [e.path for e in entries if e.kind == "file"] == sorted(TREE)
        assert [e.path for e in entries if e.kind == "folder"] == [
            "parts", "parts/deep", "parts/deep/er",
        ]  # fmt: skip
        assert {e.path: e.size for e in entries if e.kind == "file"} == {
            name: len(data) for name, data in TREE.items()
        }
        assert client.fetch_folder("", tmp_path / "all") == tuple(sorted(TREE))
        assert client.fetch_folder("parts", tmp_path / "parts") == (
            "deep/er/two words.txt", "one.mod",
        )  # fmt: skip
        assert client.names() == ("empty.txt", "parts", "seam.mod")
        with pytest.raises(Refused) as refused:
            client.fetch_folder("", tmp_path / "all")
        assert codes(refused) == ["CN401"]
        with pytest.raises(Refused) as refused:
            client.fetch_folder("nowhere", tmp_path / "nowhere")
        assert codes(refused) == ["CN205"] and not (tmp_path / "nowhere").exists()
        assert client.read("seam.mod") == TREE["seam.mod"]
    assert backup_folder.backup_contents(tmp_path / "all", "abb files") == TREE


@pytest.mark.parametrize(
    "without", [("MLSD",), ("MLSD", "LIST")], ids=["by LIST", "by NLST"]
)  # fmt: skip
def test_folders_are_fetched_from_servers_that_know_less(tmp_path, without):
    root = tmp_path / "root"
    root.mkdir()
    with pyftpdlib(root, without=without) as server, server.client() as client:
        fill(server.home, TREE)
        (server.home / "link").symlink_to(server.home)
        if "LIST" in without:  # names alone do not tell a link
            (server.home / "link").unlink()
        assert client.fetch_folder("", tmp_path / "all") == tuple(sorted(TREE))
        assert set(server.commands) & {"MLSD", "LIST"} == {"MLSD", "LIST"}
    assert backup_folder.backup_contents(tmp_path / "all", "abb files") == TREE


@pytest.mark.parametrize("server", ["vsftpd", "proftpd", "pure-ftpd"], indirect=True)
def test_names_in_whatever_spelling_stop_nothing(server, tmp_path):
    """Latin-1 beside UTF-8, in folders as well: all of it is listed, and fetched as it is."""
    named = {b"a/\xc3\xa4.txt": b"utf-8", b"b/M\xe4rz.mod": b"latin-1", b"\xfcber/c.mod": b"c"}
    for name, data in named.items():
        fill(server.home, {os.fsdecode(name): data})
    fill(server.home, {"seam.mod": TREE["seam.mod"]})
    with server.client() as client:
        assert "seam.mod" in client.names() and len(client.names()) == 4
        assert client.read("seam.mod") == TREE["seam.mod"]
        client.write("other.mod", b"other")
        assert len(client.fetch_folder("", tmp_path / "all")) == 5
        assert client.read("other.mod") == b"other"
    fetched = backup_folder.backup_contents(tmp_path / "all", "abb files")
    assert sorted(fetched.values()) == sorted([*named.values(), TREE["seam.mod"], b"other"])


class Cut(Exception):
    """A download that somebody ends."""


def cut_off(after):
    def progress(done, whole):
        assert whole in (None, len(BIG))
        if done > after:
            raise Cut

    return progress


def test_a_download_goes_on_where_it_was_cut(server, tmp_path):
    fill(server.home, {"parts/big.bin": BIG})
    to = tmp_path / "big.bin"
    with pytest.raises(Cut), server.client() as client:
        client.download("parts/big.bin", to, progress=cut_off(200_000))
    assert not to.exists() and (tmp_path / "big.bin.part").stat().st_size > 190_000
    seen = []
    with server.client() as client:
        client.download("parts/big.bin", to, progress=lambda done, whole: seen.append(done))
    assert to.read_bytes() == BIG and seen[0] > 190_000
    assert sorted(file.name for file in tmp_path.glob("big*")) == ["big.bin"]


@pytest.mark.parametrize("change", ["time", "size", "part", "note", "longer"])
def test_a_download_begins_anew_where_it_is_not_the_same_file(plain, tmp_path, change):
    fill(plain.home, {"big.bin": BIG})
    to, part, note = (tmp_path / f"big.bin{end}" for end in ("", ".part", ".part.json"))
    with pytest.raises(Cut), plain.client() as client:
        client.download("big.bin", to, progress=cut_off(200_000))
    now = BIG
    if change == "size":
        now = BIG[::-1] + b"more"
        fill(plain.home, {"big.bin": now})
    elif change == "time":
        stamp = json.loads(note.read_text())
        note.write_text(json.dumps([stamp[0], "19990101000000"]))
    elif change == "part":
        part.write_bytes(part.read_bytes()[:-1] + b"\x07")
    elif change == "note":
        note.write_text("{")
    else:
        part.write_bytes(BIG * 2)
    with plain.client() as client:
        assert client.download("big.bin", to) == len(now)
    assert to.read_bytes() == now and not part.exists() and not note.exists()


def test_an_upload_goes_on_with_what_is_the_same(server):
    with server.client() as client:
        for there in (BIG[:300_000], b"x" * 300_000, BIG + b"longer", b"", BIG):
            client.write("big.bin", b"old")
            (server.home / "~big.bin").write_bytes(there)
            (server.home / "~big.bin").chmod(0o666)
            client.upload("big.bin", BIG)
            assert client.read("big.bin") == BIG
            assert client.names() == ("big.bin",)


def test_an_upload_is_appended_only_to_what_was_compared(plain):
    with plain.client() as client:
        fill(plain.home, {"~big.bin": BIG[:300_000]})
        client.upload("big.bin", BIG)
        assert "APPE" in plain.commands and "STOR" not in plain.commands
        plain.commands.clear()
        fill(plain.home, {"~big.bin": b"x" + BIG[1:300_000]})
        client.upload("big.bin", BIG)
        assert "STOR" in plain.commands and "APPE" not in plain.commands
    assert "REST" not in plain.commands[: plain.commands.index("STOR")]


def test_a_server_that_takes_no_parts_gets_the_whole(tmp_path):
    root = tmp_path / "root"
    root.mkdir()
    with pyftpdlib(root, without=("APPE", "REST", "MDTM", "SIZE")) as server:
        with server.client() as client:
            fill(server.home, {"~big.bin": BIG[:300_000]})
            client.upload("big.bin", BIG)
            with pytest.raises(Cut):
                client.download("big.bin", tmp_path / "big.bin", progress=cut_off(200_000))
        with server.client() as client:
            client.download("big.bin", tmp_path / "big.bin")
        assert (tmp_path / "big.bin").read_bytes() == BIG


@pytest.mark.parametrize("name", ["../x", "a//b", "/x", "a/..", "a/b\r\nDELE c", "HOME:/x"])
def test_paths_that_are_refused_before_anything_is_sent(plain, tmp_path, name):
    with plain.client() as client:
        for act in (lambda: client.download(name, tmp_path / "x"), lambda: client.size(name)):
            with pytest.raises(Refused) as refused:
                act()
            assert codes(refused) == ["CN207"]


def test_a_place_that_cannot_be_written_is_a_finding(plain, tmp_path):
    fill(plain.home, {"big.bin": BIG})
    with plain.client() as client, pytest.raises(Refused) as refused:
        client.download("big.bin", tmp_path / "nowhere" / "big.bin")
    assert codes(refused) == ["CN219"] and not isinstance(refused.value, Lost)


def test_a_connection_that_is_cut_leaves_no_folder(plain, tmp_path):
    fill(plain.home, TREE)
    with plain.client() as client:
        retrieve = client.retrieve

        def dying(name, *more):
            if name == "parts/one.mod":
                client._ftp.sock.shutdown(socket.SHUT_RDWR)
            return retrieve(name, *more)

        client.retrieve = dying
        with pytest.raises(Lost):
            client.fetch_folder("", tmp_path / "all")
    assert list(tmp_path.iterdir()) == [tmp_path / "root"]


LINES = {
    "-rw-r--r--   1 owner    group         1024 Jan 01  1980 seam.mod": Entry(
        "seam.mod", "file", 1024
    ),
    "-rwxrwxrwx 1 A 2310 Nov 3 12:05 two words.txt": Entry("two words.txt", "file", 2310),
    "drwxrwxrwx   2 0  0   512 Mar 12 09:41 parts": Entry("parts", "folder"),
    "lrwxrwxrwx 1 a b 3 Mar 12 09:41 x -> parts": Entry("x", "other"),
    "01-23-20  10:15AM       <DIR>          parts": Entry("parts", "folder"),
    "01-23-2020  10:15                 77 a b.mod": Entry("a b.mod", "file", 77),
}


@pytest.mark.parametrize("line", LINES)
def test_lines_of_listings(line):
    assert ftp.parse_list(["total 12", line, ""]) == [LINES[line]]


@pytest.mark.parametrize("line", ["seam.mod", "-rw 1 x", "+i8388621.48594,m825718503,r,\teplf"])
def test_lines_of_no_known_listing(line):
    assert ftp.parse_list([line]) is None


def test_facts_of_listings():
    lines = [
        "type=cdir;size=4096; .", "Type=pdir; ..", "type=file;size=12;modify=20200101; a b.mod",
        "type=dir; parts", "type=OS.unix=slink:/x; link",
    ]  # fmt: skip
    assert ftp.parse_mlsd(lines) == [
        Entry("a b.mod", "file", 12), Entry("parts", "folder"), Entry("link", "other"),
    ]  # fmt: skip
    for line in ("seam.mod", "size=3; seam.mod", "type=file;size=3;"):
        assert ftp.parse_mlsd([line]) is None
