"""Backups of the virtual IRC5, and what is restored of them."""

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import backup_folder, connect
from assistant.controllers.rules import Lost
from tests.controllers.abb.rws.seam import SEAM, codes
from tests.controllers.cutting import Cutting

ONE = pytest.mark.parametrize("client", ["rws"], indirect=True)


def changed(source, target, **texts):
    """A backup with other texts in some of its files."""
    files = dict(backup_folder.backup_contents(source, "abb"))
    with backup_folder.appearing_folder(target, "abb") as place:
        for name, data in (files | {k: texts[k] for k in texts}).items():
            backup_folder.put_file(place, name, data)


MODULE = "RAPID/TASK1/PROGMOD/Seam.mod"


@ONE
def test_a_backup_and_what_differs(loaded, tmp_path):
    files = loaded.backup(tmp_path / "saved")
    assert {"BACKINFO/backinfo.txt", "HOME/seam.mod", MODULE, "SYSPAR/MOC.cfg"} <= set(files)
    assert (tmp_path / "saved" / "HOME" / "seam.mod").read_bytes() == SEAM
    restoring = loaded.restore(tmp_path / "saved")
    assert restoring.changes == {} and restoring.left_out == {}
    with pytest.raises(Refused) as refused:
        loaded.backup(tmp_path / "saved")
    assert codes(refused) == ["CN401"]


def test_a_backup_is_restored(loaded, tmp_path):
    loaded.backup(tmp_path / "saved")
    loaded.write("seam.mod", SEAM.replace(b"WaitTime 0.1", b"WaitTime 9"))
    loaded.load("seam.mod")
    restoring = loaded.restore(tmp_path / "saved")
    assert list(restoring.changes) == ["HOME/seam.mod", MODULE]
    assert "-    WaitTime 9;\n+    WaitTime 0.1;" in restoring.changes[MODULE]
    assert loaded.restore(tmp_path / "saved", only=["Seam.mod"]).left_out == {}
    restoring.apply()
    assert loaded.read("seam.mod") == SEAM and not restoring.needs_restart
    assert loaded.module_text("Seam").replace(b"\r\n", b"\n") == SEAM
    assert loaded.restore(tmp_path / "saved").changes == {}


@ONE
def test_what_is_left_out_of_a_restore(loaded, tmp_path):
    loaded.backup(tmp_path / "saved")
    new = {"SYSPAR/MOC.cfg": b"m", "SYSPAR/SIO.cfg": b"s", "HOME/Safety/user.sxml": b"x"}
    new["SYSPAR/EIO.cfg"] = b"e"
    changed(tmp_path / "saved", tmp_path / "other", **new, **{"HOME/a.mod": b"a"})
    restoring = loaded.restore(tmp_path / "other")
    assert list(restoring.changes) == ["HOME/a.mod"] and set(restoring.left_out) == set(new)
    named = loaded.restore(tmp_path / "other", only=["MOC.cfg", "HOME/Safety"])
    assert set(named.changes) == {"SYSPAR/MOC.cfg", "HOME/Safety/user.sxml"} and named.needs_restart
    folder = loaded.restore(tmp_path / "other", only=["SYSPAR"])
    assert not folder.changes and "network" in folder.left_out["SYSPAR/SIO.cfg"]
    changed(tmp_path / "saved", tmp_path / "lies", **{"SYSPAR/EIO.cfg": b"SIO:CFG_1.0:6:1::\n"})
    lies = loaded.restore(tmp_path / "lies", only=["EIO.cfg"])
    assert not lies.changes and "network" in lies.left_out["SYSPAR/EIO.cfg"]
    with pytest.raises(Refused) as refused:
        loaded.restore(tmp_path / "other", only=["NONE.cfg"])
    assert codes(refused) == ["CN404"]


@ONE
def test_a_restore_that_fails_brings_back_what_was_there(loaded, tmp_path):
    loaded.backup(tmp_path / "saved")
    other = SEAM.replace(b"WaitTime 0.1", b"WaitTime 9")
    new = {
        "HOME/seam.mod": other,
        "HOME/new/a.mod": b"a",
        MODULE: SEAM.replace(b"count+1", b"count+"),
    }
    changed(tmp_path / "saved", tmp_path / "other", **new)
    with pytest.raises(Refused) as refused:
        loaded.restore(tmp_path / "other").apply()
    assert codes(refused) == ["CN301"]
    assert loaded.restore(tmp_path / "saved").changes == {}
    assert loaded.read("seam.mod") == SEAM


@ONE
def test_a_restore_waits_for_programs_to_end(loaded, tmp_path):
    loaded.backup(tmp_path / "saved")
    loaded.write("seam.mod", SEAM.replace(b"0.1", b"9"))
    restoring = loaded.restore(tmp_path / "saved")
    loaded.motors(True)
    loaded.start(forever=True)
    with pytest.raises(Refused) as refused:
        restoring.apply()
    assert codes(refused) == ["CN209"]
    loaded.stop()


def test_a_backup_that_is_cut_leaves_nothing(irc5, tmp_path):
    with connect(irc5.rws_address, password=irc5.password, timeout=5) as client:
        client.write("seam.mod", SEAM)
    address = irc5.rws_address.replace(f":{irc5.rws_port}", ":{}")
    with Cutting(irc5.rws_port) as proxy:
        with connect(address.format(proxy.port), password=irc5.password, timeout=5) as client:
            client.backup(tmp_path / "whole")
        length = proxy.passed
    for cut in range(length // 4, length - 2000, length // 4):
        with (
            Cutting(irc5.rws_port, cut=cut) as proxy,
            pytest.raises(Lost),
            connect(address.format(proxy.port), password=irc5.password, timeout=5) as client,
        ):
            client.backup(tmp_path / "cut")
        assert [path.name for path in tmp_path.iterdir()] == ["whole"]
