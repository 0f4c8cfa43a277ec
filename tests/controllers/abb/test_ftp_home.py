"""Servers that have their root elsewhere than the client assumes: where the programs are found."""

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from tests.cli.test_commands import run
from tests.controllers.abb import ftp_servers

TEXT = b"MODULE seam\nENDMODULE\n"


def at(root, folders, begins="", folder="", server=ftp_servers.proftpd):
    """The folder that a client uses on a server with these folders, and the codes it reports."""
    root.mkdir()
    for name in folders:
        (root / name).mkdir(parents=True)
    options = {"begins": begins} if begins else {}
    with server(root, **options) as there:
        if "HOME:" not in folders:
            there.home.rmdir()
        told = []
        address = f"ftp://{there.user}@127.0.0.1:{there.port}{folder}"
        client = connect(address, password=ftp_servers.PASSWORD, timeout=10.0)
        client.tell = told.append
        with client:
            client.write("seam.mod", TEXT)
            assert client.names() == ("seam.mod",)
            assert not client.is_folder("seam.mod") and client.read("seam.mod") == TEXT
    (file,) = root.rglob("seam.mod")
    return str(file.parent.relative_to(root)), [finding.code for finding in told]


@pytest.mark.parametrize(
    ("folders", "begins", "found", "codes"),
    [
        (["HOME:"], "", "HOME:", []),
        (["HOME"], "", "HOME", ["CN223"]),
        (["hd0a/SYS_1/HOME", "hd0a/temp"], "", "hd0a/SYS_1/HOME", ["CN223"]),
        (["hd0a/SYS_1/HOME", "hd0a/SYS_2/HOME"], "hd0a/SYS_2/HOME", "hd0a/SYS_2/HOME", ["CN223"]),
        (["hd0a/SYS_1/HOME", "hd0a/SYS_2/HOME"], "hd0a/SYS_2", "hd0a/SYS_2/HOME", ["CN223"]),
        (["disk/SYS_1/HOME"], "disk", "disk/SYS_1/HOME", ["CN223"]),
        (["HOME", "users/robot"], "users/robot", "HOME", ["CN223"]),
        (["users/robot"], "users/robot", "users/robot", ["CN224"]),
        ([], "", ".", ["CN224"]),
    ],
)
def test_an_address_without_a_folder_finds_that_of_the_programs(
    tmp_path, folders, begins, found, codes
):
    assert at(tmp_path / "root", folders, begins) == (found, codes)


def test_another_server_answers_in_other_words(tmp_path):
    folders = ["hd0a/SYS_1/HOME"]
    found = at(tmp_path / "root", folders, server=ftp_servers.pyftpdlib)
    assert found == ("hd0a/SYS_1/HOME", ["CN223"])


def test_a_folder_of_the_address_is_entered_from_the_root_too(tmp_path):
    folders = ["hd0a/SYS_1/HOME", "users/robot"]
    found = at(tmp_path / "root", folders, "users/robot", "/hd0a/SYS_1/HOME")
    assert found == ("hd0a/SYS_1/HOME", ["CN223"])


def test_several_systems_are_a_finding_whose_cure_helps(tmp_path):
    folders = ["hd0a/SYS_1/HOME", "hd0a/SYS_2/HOME"]
    with pytest.raises(Refused) as refused:
        at(tmp_path / "one", folders)
    (finding,) = refused.value.findings
    assert finding.code == "CN225" and refused.value.exit_status == 2
    assert "`/hd0a/SYS_1/HOME`, `/hd0a/SYS_2/HOME`" in finding.message
    assert "`ftp://user@host/hd0a/SYS_1/HOME`" in finding.cure
    found = at(tmp_path / "two", folders, folder="/hd0a/SYS_1/HOME")
    assert found == ("hd0a/SYS_1/HOME", [])


def test_a_folder_that_is_not_there_is_not_replaced_by_another(tmp_path):
    with pytest.raises(Refused) as refused:
        at(tmp_path / "root", ["HOME"], folder="/parts")
    assert [finding.code for finding in refused.value.findings] == ["CN203"]


def test_commands_report_what_was_found(tmp_path, capsys, monkeypatch):
    root = tmp_path / "root"
    (root / "hd0a" / "SYS_1" / "HOME").mkdir(parents=True)
    monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", ftp_servers.PASSWORD)
    with ftp_servers.proftpd(root) as server:
        server.home.rmdir()
        status, out, said = run(capsys, "ls", f"ftp://user@127.0.0.1:{server.port}")
    assert (status, out) == (0, "")
    assert "CN223" in said and "`/hd0a/SYS_1/HOME` is used instead" in said
