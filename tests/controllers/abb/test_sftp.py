"""The client for OmniCore controllers against a real SSH server; keys are never taken unseen."""

import logging
import socket
import sys
import threading

import asyncssh
import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import backup_folder
from assistant.controllers.address import parse
from assistant.controllers.rules import Lost
from tests.controllers.abb.sftp_server import SftpServer
from tests.controllers.abb.test_ftp_files import TREE, fill

BIG = bytes(range(256)) * 1000


def codes(refused):
    return [finding.code for finding in refused.value.findings]


@pytest.fixture
def server(tmp_path):
    root = tmp_path / "root"
    root.mkdir()
    with SftpServer(root) as server:
        yield server


def test_files_go_there_and_come_back(server):
    with server.client() as client:
        assert client.names() == () and client.read("a.mod") is client.look("a.mod") is None
        for data in (BIG, b"shorter\r\n", b""):
            client.write("a.mod", data, as_it_was=True)
            assert client.read("a.mod") == client.look("a.mod") == data
        client.hand_over("a.mod", b"handed over")
        assert client.names() == ("a.mod",) and client.read("a.mod") == b"handed over"
        client.remove("a.mod")
        client.take_away("a.mod")
        assert client.names() == ()
    assert (client.name_for("out/seam 1.mod"), client.stored(b"x")) == ("seam 1.mod", b"x")


def test_folders_are_told_from_files(server):
    with server.client() as client:
        client.write("seam.mod", b"one")
        client.claim("parts")
        assert client.is_folder("parts")
        assert not client.is_folder("seam.mod") and not client.is_folder("none")


def test_a_server_that_never_replaces_by_renaming(tmp_path):
    with SftpServer(tmp_path, replaces=False) as server, server.client() as client:
        for data in (b"one", b"two"):
            client.write("a.mod", data)
            assert client.read("a.mod") == data and client.names() == ("a.mod",)


def test_folders_are_gone_to_and_fetched_whole(server, tmp_path):
    fill(server.root, TREE)
    (server.root / "parts" / "link").symlink_to(server.root)
    with server.client() as client:
        assert client.fetch_folder("", tmp_path / "all") == tuple(sorted(TREE))
        with pytest.raises(Refused) as refused:
            client.fetch_folder("nowhere", tmp_path / "nowhere")
        assert codes(refused) == ["CN205"] and not (tmp_path / "nowhere").exists()
    assert backup_folder.backup_contents(tmp_path / "all", "abb files") == TREE
    with server.client(options=f"/parts/deep?fingerprint={server.fingerprint}") as client:
        assert client.names() == ("er",)
    missing = server.client(options=f"/no?fingerprint={server.fingerprint}")
    with pytest.raises(Refused) as refused, missing:
        pass
    assert codes(refused) == ["CN203"]


def test_a_key_of_the_known_hosts_is_trusted(server, tmp_path):
    known = tmp_path / "known_hosts"
    known.write_text(server.known_hosts)
    with server.client(options="", certificate=known) as client:
        assert client.names() == ()


def other_key():
    return asyncssh.generate_private_key("ssh-ed25519")


@pytest.mark.parametrize("known", ["none", "other", "unreadable", "fingerprint", "users"])
def test_a_key_that_is_not_known_ends_it_before_a_password_is_sent(
    server, tmp_path, monkeypatch, known
):
    file, options, more = tmp_path / "known_hosts", "", {}
    if known == "none":
        file.write_text("")
        more = {"certificate": file}
    elif known == "other":
        file.write_text(f"[127.0.0.1]:{server.port} {other_key().export_public_key().decode()}")
        more = {"certificate": file}
    elif known == "unreadable":
        more = {"certificate": tmp_path / "nowhere"}
    elif known == "fingerprint":
        options = f"?fingerprint={other_key().get_fingerprint()}"
    else:
        monkeypatch.setenv("HOME", str(tmp_path))
    with pytest.raises(Refused) as refused, server.client(options=options, **more):
        pass
    assert codes(refused) == ["CN211"] and refused.value.exit_status == 2
    assert server.logins == 0


def test_a_wrong_password_is_a_finding_without_it(server, caplog):
    caplog.set_level(logging.DEBUG)
    with pytest.raises(Refused) as refused, server.client(password="hunter2"):
        pass
    assert codes(refused) == ["CN202"] and refused.value.exit_status == 2
    assert "hunter2" not in str(refused.value) + caplog.text and server.logins


@pytest.mark.parametrize("name", ["", "../x.mod", "a/b.mod", "x\r\ny", "~x.mod", ".hidden", "ä"])
def test_names_that_are_refused_before_anything_is_sent(server, name):
    with server.client() as client:
        for act in (client.read, client.remove, lambda n: client.write(n, b"")):
            with pytest.raises(Refused) as refused:
                act(name)
            assert codes(refused) == ["CN207"]


def test_what_the_server_refuses_leaves_the_session_alive(server):
    (server.root / "folder.mod").mkdir()
    with server.client() as client:
        with pytest.raises(Refused) as refused:
            client.write("folder.mod", b"x")
        assert codes(refused) == ["CN205"] and not isinstance(refused.value, Lost)
        assert client.names() == ("folder.mod",)


def test_a_server_that_is_gone_is_found(server):
    with server.client() as client:
        client.write("a.mod", b"old")
        client._ssh.get_transport().sock.shutdown(socket.SHUT_RDWR)
        with pytest.raises(Lost) as lost:
            client.write("a.mod", b"new")
        assert codes(lost) == ["CN204"]
        with pytest.raises(Lost):
            client.names()
    assert (server.root / "a.mod").read_bytes() == b"old"


def test_a_file_that_drips_and_never_ends_is_given_up(tmp_path):
    (tmp_path / "seam.mod").write_bytes(b"MODULE Seam\nENDMODULE\n")
    with (
        SftpServer(tmp_path, drip=0.01) as server,
        server.client(timeout=0.4) as client,
        pytest.raises(Lost) as lost,
    ):
        client.look("seam.mod")
    assert codes(lost) == ["CN204"]


@pytest.mark.parametrize(
    "name", [b"../x", b"/etc/x", b"a\\..\\x", b"C:x", b"nul", b"con.mod", b"x\r\ny", b"x\0", b"x."]
)
def test_names_of_a_hostile_server_become_no_files(tmp_path, name):
    root = tmp_path / "root"
    root.mkdir()
    (root / "seam.mod").write_bytes(b"")
    with SftpServer(root, also=[name]) as server, server.client() as client:
        with pytest.raises(Refused) as refused:
            client.fetch_folder("", tmp_path / "here")
        assert codes(refused) == ["CN207"]
        if not name.decode().isprintable():
            with pytest.raises(Refused):
                client.names()
    assert [path.name for path in tmp_path.iterdir()] == ["root"]


def test_nobody_there():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    server = SftpServer(None)
    with pytest.raises(Lost) as lost, server.client(port=port):
        pass
    assert codes(lost) == ["CN201"]


def test_somebody_who_says_nothing_or_garbage():
    server = SftpServer(None)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        with pytest.raises(Lost) as lost, server.client(port=port, timeout=0.2):
            pass
        assert codes(lost) == ["CN201"]
        listener.accept()[0].close()

        def garbage():
            connection = listener.accept()[0]
            connection.sendall(bytes(range(128, 256)) * 50)
            connection.close()

        thread = threading.Thread(target=garbage)
        thread.start()
        with pytest.raises(Lost) as lost, server.client(port=port, timeout=2.0):
            pass
        assert codes(lost) == ["CN201"]
        thread.join()


def test_without_the_extra_it_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "paramiko", None)
    with pytest.raises(Refused) as refused, SftpServer(None).client(port=22):
        pass
    assert codes(refused) == ["CN212"]


def test_a_fingerprint_is_a_part_of_an_address(server):
    text = f"sftp://user@omnicore:22/x?fingerprint={server.fingerprint}"
    address = parse(text)
    assert parse(str(address)) == address
    for wrong in ("SHA256:short", "MD5:ab:cd", ""):
        with pytest.raises(Refused) as refused:
            parse(f"sftp://user@omnicore?fingerprint={wrong}")
        assert codes(refused) == ["CN101"]
    assert "user@" in str(address)


def test_a_tree_that_never_ends_is_given_up(server, tmp_path, monkeypatch):
    monkeypatch.setattr("assistant.controllers.abb.sftp.MOST_ENTRIES", 5)
    for number in range(9):
        (server.root / f"folder{number}" / "inside").mkdir(parents=True)
    with server.client() as client, pytest.raises(Refused) as refused:
        client.fetch_folder("", tmp_path / "here")
    assert codes(refused) == ["CN205"] and not (tmp_path / "here").exists()
