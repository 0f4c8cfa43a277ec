"""That what is sent can be read on the way is said once, and can be accepted for good."""

import json

import pytest

from assistant.cli import main
from assistant.controllers import parse
from assistant.controllers.address import clear_text_finding
from tests.controllers.abb.bad_ftp import FtpPeer


@pytest.fixture
def peer(tmp_path, monkeypatch):
    """A server whose address is not one of this computer alone, though it is there."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "seam.mod").write_text("MODULE seam\nENDMODULE\n", newline="")
    with FtpPeer({}) as peer:
        monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", peer.password)
        peer.address = str(peer.connect().address).replace("127.0.0.1", "0.0.0.0")
        yield peer


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        main(list(arguments))
    assert ended.value.code == 0
    return capsys.readouterr()


ADDRESSES = {
    "ftp://anna@192.168.125.1": "CN115",
    "rws://anna@irc5": "CN116",
    "melfa://cr": "CN116",
    "ftps://anna@irc5": None,
    "sftp://anna@irc5": None,
    "rwss://anna@irc5": None,
    "melfa-serial://COM3": None,
    "ftp://anna@127.0.0.1": None,
    "rws://a@[::1]": None,
    "melfa://localhost": None,
}


def test_what_is_not_encrypted_on_its_way():
    told = {text: clear_text_finding(parse(text)) for text in ADDRESSES}
    assert {text: finding and finding.code for text, finding in told.items()} == ADDRESSES


def test_it_is_said_once_in_text_and_json(peer, capsys):
    said = run(capsys, "deploy", "seam.mod", "--to", peer.address)
    assert said.err.count("CN115 warning") == 1 and "CN115" not in said.out
    said = run(capsys, "ls", peer.address)
    assert said.err.count("CN115 warning") == 1 and "seam.mod\n" in said.out
    for command in (("ls", peer.address), ("plan", "seam.mod", "--to", peer.address)):
        said = run(capsys, *command, "--format", "json")
        found = [finding["code"] for finding in json.loads(said.out)["findings"]]
        assert found == ["CN115"] and "CN115" not in said.err


def test_a_project_accepts_it_once(peer, capsys, tmp_path):
    (tmp_path / "assistant.toml").write_text('[severity]\nCN115 = "off"\n')
    said = run(capsys, "ls", peer.address)
    assert said.err == ""
    assert "findings" not in json.loads(run(capsys, "ls", peer.address, "--format", "json").out)
