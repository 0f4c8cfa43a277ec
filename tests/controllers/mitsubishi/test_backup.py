"""Backup and restore of a whole controller: what they hold, leave out, and do when things fail."""

import json
import subprocess

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import backup_folder, connect
from assistant.controllers.mitsubishi.values import SECRET_PARAMETER, why_left_out
from assistant.controllers.rules import Lost
from assistant.virtual.cr import VirtualCr
from tests.controllers.cutting import Cutting
from tests.wire import Wire

SEAM = b"10 M1=M1+1\r\n20 MVS P1\r\n30 END\r\nP1=(+1.00,+2.00,+3.00,+0.00,+180.00,+0.00)(6,0)\r\n"
HAND = b"10 HOPEN 1\r\n20 END\r\n"


def codes(refused):
    return [finding.code for finding in refused.value.findings]


@pytest.fixture
def cell():
    """A controller with two programs, variables and changed parameters, and its client."""
    with VirtualCr() as controller, connect(controller.address, timeout=5) as client:
        client.write("SEAM", SEAM)
        client.write("HAND", HAND)
        client.set_variable("M1", "4", "SEAM")
        client.set_parameter("MEXTL", "0, 0, 100, 0, 0, 0")
        client.set_parameter("NETIP", "192.168.0.77")
        with Wire(controller.port) as wire:
            assert wire.ask("1;9;VAL=M_01=7") == "QoK"
        yield controller, client


def test_a_backup_is_plain_text(cell, tmp_path):
    _, client = cell
    folder = tmp_path / "cell"
    assert client.backup(folder) == (
        "backup.json",
        "identity.json",
        "parameters.txt",
        "programs/HAND.prg",
        "programs/SEAM.prg",
        "variables/SEAM.txt",
        "variables/externals.txt",
    )
    assert (folder / "programs/SEAM.prg").read_bytes() == SEAM
    assert (folder / "variables/SEAM.txt").read_text() == "M1=+4\n"
    assert (folder / "variables/externals.txt").read_text() == "M_01=+7\n"
    lines = (folder / "parameters.txt").read_text().splitlines()
    assert lines == ["MEXTL=0, 0, 100, 0, 0, 0", "NETIP=192.168.0.77"]
    assert json.loads((folder / "identity.json").read_text())["robot"] == "RV-2AJ"


def test_two_backups_of_the_same_do_not_differ(cell, tmp_path):
    _, client = cell
    for name in ("one", "two"):
        client.backup(tmp_path / name)
    difference = subprocess.run(["diff", "-r", "one", "two"], cwd=tmp_path, capture_output=True)
    assert (difference.returncode, difference.stdout) == (0, b"")


def test_nothing_differs_right_after_a_backup(cell, tmp_path):
    _, client = cell
    client.backup(tmp_path / "cell")
    restoring = client.restore(tmp_path / "cell")
    assert restoring.changes == {} and restoring.left_out == {} and not restoring.needs_restart
    restoring.apply()
    assert [path.name for path in tmp_path.iterdir()] == ["cell"]


def test_a_program_called_as_a_device_is_a_file_in_every_system(cell, tmp_path):
    _, client = cell
    client.write("CON", b"10 M1=1\r\n20 END\r\n")
    client.backup(tmp_path / "cell")
    assert (tmp_path / "cell/programs/CON_.prg").is_file()
    client.write("CON", b"10 END\r\n")
    restoring = client.restore(tmp_path / "cell")
    assert [*restoring.changes] == ["programs/CON_.prg"] and restoring.left_out == {}
    restoring.apply()
    assert client.read("CON").splitlines()[0] == b"10 M1=1"


def change(client):
    """Makes the controller another one."""
    client.write("SEAM", b"10 END\r\n")
    client.remove("HAND")
    client.write("NEW", b"10 END\r\n")
    client.set_parameter("MEXTL", "0, 0, 50, 0, 0, 0")
    client.set_parameter("NETIP", "192.168.0.78")


def test_what_was_changed_comes_back(cell, tmp_path):
    controller, client = cell
    folder = tmp_path / "cell"
    client.backup(folder)
    change(client)
    restoring = client.restore(folder)
    assert set(restoring.changes) == {
        *("programs/SEAM.prg", "programs/HAND.prg", "variables/SEAM.txt", "MEXTL"),
    }
    assert "-10 END\n+10 M1=M1+1\n" in restoring.changes["programs/SEAM.prg"]
    assert "-MEXTL=0, 0, 50, 0, 0, 0\n+MEXTL=0, 0, 100, 0, 0, 0\n" in restoring.changes["MEXTL"]
    assert restoring.changes["programs/HAND.prg"].startswith("--- /dev/null")
    left_out = restoring.left_out
    assert set(left_out) == {"NETIP", "programs/NEW.prg"} and "lines" in left_out["NETIP"]
    assert "it stays" in left_out["programs/NEW.prg"]
    assert controller.text("SEAM") == "10 END\r\n", "nothing is changed before apply"
    restoring.apply()
    assert controller.text("SEAM").encode() == SEAM and controller.text("HAND").encode() == HAND
    assert client.variable("M1", "SEAM") == "+4"
    told = client.parameters(["MEXTL", "NETIP"])
    assert told == {"MEXTL": "0, 0, 100, 0, 0, 0", "NETIP": "192.168.0.78"}
    assert controller.text("NEW") == "10 END\r\n", "what no backup has stays"
    kept = restoring.kept
    assert kept == tmp_path / "cell.before-1"
    assert backup_folder.backup_contents(kept, "melfa") == {
        "programs/SEAM.prg": b"10 END\r\n",
        "parameters.txt": b"MEXTL=0, 0, 50, 0, 0, 0\n",
    }
    assert client.restore(folder).changes == {}
    back = client.restore(kept)  # what was there before can be brought back itself
    back.apply()
    assert controller.text("SEAM") == "10 END\r\n"
    assert client.parameters(["MEXTL"]) == {"MEXTL": "0, 0, 50, 0, 0, 0"}


def test_only_what_is_named(cell, tmp_path):
    controller, client = cell
    folder = tmp_path / "cell"
    client.backup(folder)
    change(client)
    restoring = client.restore(folder, only=["NETIP", "programs/HAND.prg"])
    assert set(restoring.changes) == {"NETIP", "programs/HAND.prg"} and not restoring.left_out
    assert restoring.needs_restart
    restoring.apply()
    assert client.parameters(["NETIP"]) == {"NETIP": "192.168.0.77"}
    assert controller.text("SEAM") == "10 END\r\n"
    whole = client.restore(folder, only=["parameters.txt"])
    assert set(whole.changes) == {"MEXTL"}
    with pytest.raises(Refused) as refused:
        client.restore(folder, only=["programs/OTHER.prg"])
    assert codes(refused) == ["CN404"] and refused.value.exit_status == 2


@pytest.mark.parametrize(
    ("name", "word"),
    [
        *((name, "origin") for name in ("DATINST1", "JRCORG", "HOMEPOS", "USRORG", "MEORGNO")),
        *((name, "origin") for name in ("USERORG", "MORG", "MEINSZ", "MEINST", "MEOFFZ", "DJNT")),
        *((name, "limits") for name in ("MEJAR", "MEPAR", "AREA1P1", "SFC1P", "COLLVL", "SLSDLY")),
        ("AUTOENA", "limits"),
        *((name, "lines") for name in ("NETIP", "NETPORT", "CPRCE11", "CBAU232", "COMDEV")),
    ],
)
def test_origin_safety_and_network_are_left_out(name, word):
    assert word in (why_left_out(name) or "")


@pytest.mark.parametrize("name", ["MEXTL", "MEXBS", "TASKMAX", "HANDINIT", "SLT1", "JOGJSP"])
def test_other_parameters_are_not(name):
    assert why_left_out(name) is None


def test_passwords_are_in_no_backup():
    assert SECRET_PARAMETER.fullmatch("NETPSSWD") and not SECRET_PARAMETER.fullmatch("NETIP")


def test_a_program_that_is_open_elsewhere_leaves_no_backup(cell, tmp_path):
    controller, client = cell
    with Wire(controller.port) as other:
        other.ask("1;1;LOAD=SEAM")
        with pytest.raises(Refused) as refused:
            client.backup(tmp_path / "cell")
        assert codes(refused) == ["CN301"]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "saved", "now"),
    [("M2", "+0.004", "0.001"), ("C1$", '"  a"', '"a"'), ("C2$", '"\x83L\x83\x85"', '"x"')],
)
def test_small_numbers_blanks_and_japanese_letters_come_back(cell, tmp_path, name, saved, now):
    """Half of such a letter ends a line for some readers."""
    _, client = cell
    client.set_variable(name, saved, "SEAM")
    assert client.variable(name, "SEAM") == saved
    client.backup(tmp_path / "cell")
    client.set_variable(name, now, "SEAM")
    restoring = client.restore(tmp_path / "cell")
    assert set(restoring.changes) == {"variables/SEAM.txt"}
    restoring.apply()
    assert client.variable(name, "SEAM") == saved


def test_a_backup_of_another_robot_is_told(cell, tmp_path):
    _, client = cell
    client.backup(tmp_path / "cell")
    with VirtualCr(robot="rv-2fr") as other, connect(other.address, timeout=5) as one:
        left_out = one.restore(tmp_path / "cell").left_out
    assert "RV-2AJ" in left_out["identity.json"] and "RV-2FR" in left_out["identity.json"]


def test_a_backup_that_was_made_up_sets_no_outputs(cell, tmp_path):
    _, client = cell
    client.backup(tmp_path / "cell")
    files = dict(backup_folder.backup_contents(tmp_path / "cell", "melfa"))
    files["variables/externals.txt"] += b"M_OUT(8)=1\nm_Hnd(1)=1\n"
    with backup_folder.appearing_folder(tmp_path / "other", "melfa") as place:
        for name, data in files.items():
            backup_folder.put_file(place, name, data)
    restoring = client.restore(tmp_path / "other")
    assert not restoring.changes and {*restoring.left_out} == {"M_OUT(8)", "m_Hnd(1)"}
    for name in restoring.left_out:
        with pytest.raises(Refused) as refused:
            client.set_variable(name, "1")
        assert codes(refused) == ["CN308"]
    assert client.outputs(["8"]) == {"8": 0.0}


def test_a_folder_that_is_there(cell, tmp_path):
    _, client = cell
    client.backup(tmp_path / "cell")
    with pytest.raises(Refused) as refused:
        client.backup(tmp_path / "cell")
    assert codes(refused) == ["CN401"]


def test_a_restore_that_stops_in_the_middle_says_how_far_it_came(cell, tmp_path):
    controller, client = cell
    folder = tmp_path / "cell"
    client.backup(folder)
    change(client)
    restoring = client.restore(folder)
    with Wire(controller.port) as other:
        other.ask("1;1;LOAD=SEAM")
        with pytest.raises(Refused) as refused:
            restoring.apply()
    assert codes(refused) == ["CN301", "CN405"]
    last = refused.value.findings[-1]
    assert "`programs/SEAM.prg`" in last.message and "HAND" in last.message
    assert str(restoring.kept) in last.cure
    assert controller.text("SEAM") == "10 END\r\n"


def test_a_backup_that_was_edited_is_refused(cell, tmp_path):
    _, client = cell
    folder = tmp_path / "cell"
    client.backup(folder)
    (folder / "programs/SEAM.prg").write_bytes(b"10 END\r\n")
    with pytest.raises(Refused) as refused:
        client.restore(folder)
    assert codes(refused) == ["CN403"]


@pytest.mark.parametrize("cut", [20, 200, 800])
def test_a_line_that_is_cut_leaves_no_backup(cell, tmp_path, cut):
    controller, _ = cell
    with (
        Cutting(controller.port, cut=cut) as proxy,
        pytest.raises(Lost),
        connect(f"melfa://127.0.0.1:{proxy.port}", timeout=5) as client,
    ):
        client.backup(tmp_path / "cell")
    assert list(tmp_path.iterdir()) == []
