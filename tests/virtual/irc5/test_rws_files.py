"""The file service of the virtual IRC5, and its backups."""

from __future__ import annotations

import contextlib
import ftplib
import io
import os
import socket

import pytest

from assistant.virtual.irc5 import VirtualIrc5
from tests.virtual.irc5.web import One, Robot, Two, wait_for


@pytest.fixture(autouse=True)
def empty(irc5):
    for folder in (irc5.folder, *map(irc5.cabinet.disk.folder, ("BACKUP", "TEMP"))):
        for path in sorted(folder.rglob("*"), reverse=True):
            path.rmdir() if path.is_dir() else path.unlink()


def act(robot, name, action, **form):
    """`fs-action` of 1.0 is the end of the path of 2.0."""
    one = {"fs_action": action} if robot.client.dialect == 1 else {}
    end = robot.either("", f"/{action}")
    return robot.client.post(robot.file(name) + end, **one, **form)


def names(robot, path=""):
    answer = robot.client.get(robot.file(path).rstrip("/"))
    return sorted((row["_type"], row["_title"]) for row in answer.items())


def test_a_file_goes_there_and_back(robot, irc5):
    data = bytes(range(256)) * 40
    assert robot.client.put(robot.file("a.bin"), data).status == 201
    assert robot.client.put(robot.file("a.bin"), data).status == 200
    answer = robot.client.send("GET", robot.file("a.bin"))
    assert (answer.status, answer.data) == (200, data)
    assert (irc5.folder / "a.bin").read_bytes() == data
    row = robot.client.get(robot.file("").rstrip("/")).items("fs-file")[0]
    assert (row["_title"], row["fs-size"], row["fs-readonly"]) == ("a.bin", "10240", "false")
    assert robot.client.send("DELETE", robot.file("a.bin")).status in (200, 204)
    assert robot.client.send("GET", robot.file("a.bin")).status == 404
    assert robot.client.send("DELETE", robot.file("a.bin")).status == 404


@pytest.mark.skipif(not hasattr(os, "symlink"), reason="no symbolic links")
def test_a_file_that_vanishes_hides_no_other(robot, irc5):
    """A link to nothing stands for a file that is deleted as its folder is listed."""
    assert robot.client.put(robot.file("there.txt"), b"x").status == 201
    (irc5.folder / "gone.txt").symlink_to(irc5.folder / "nothing")
    assert names(robot) == [("fs-file", "there.txt")]


def test_folders_copies_and_names(robot):
    assert act(robot, "", "create", fs_newname="parts").status == 201
    assert act(robot, "", "create", fs_newname="parts").status == 400
    assert robot.client.put(robot.file("parts/a%20b.txt"), b"x").status == 201
    assert act(robot, "parts/a%20b.txt", "copy", fs_newname="c.txt").status == 201
    assert act(robot, "parts/a%20b.txt", "copy", fs_newname="c.txt").status == 400
    assert act(robot, "parts/c.txt", "rename", fs_newname="d.txt").status == 204
    assert names(robot) == [("fs-dir", "parts")]
    assert names(robot, "parts") == [("fs-file", "a b.txt"), ("fs-file", "d.txt")]
    for wrong in ("../e", "a/b", "", "..", "a\nb"):
        assert act(robot, "parts/d.txt", "rename", fs_newname=wrong).status == 400
    assert robot.client.send("DELETE", robot.file("parts")).status in (200, 204)
    assert names(robot) == []


@pytest.mark.parametrize(
    "path",
    ["../outside.txt", "parts/../../outside.txt", "%2e%2e/outside.txt", "..%2foutside.txt",
     "a%00b", "../../../etc/passwd", "a%0ab"],
)  # fmt: skip
def test_nothing_outside_is_reached(robot, irc5, path):
    outside = irc5.folder.parent / "outside.txt"
    outside.write_text("secret")
    assert robot.client.send("GET", robot.file(path)).status in (400, 404)
    assert robot.client.put(robot.file(path), b"x").status in (400, 404)
    assert robot.client.send("DELETE", robot.file(path)).status in (400, 404)
    assert outside.read_text() == "secret"
    assert names(robot) == []


def test_the_volumes(robot):
    listed = robot.client.get("/fileservice").items(robot.either("fs-device", "fs-dir"))
    assert [row["_title"] for row in listed] == [
        robot.either("$", "") + name for name in ("HOME", "TEMP", "BACKUP", "RAMDISK")
    ]
    temp = robot.either("/fileservice/$TEMP/t.txt", "/fileservice/TEMP/t.txt")
    assert robot.client.put(temp, b"t").status == 201
    assert (
        robot.client.send("DELETE", robot.either("/fileservice/$HOME", "/fileservice/HOME")).status
        == 403
    )
    assert robot.client.send("GET", "/fileservice/%24HOME/x").status in (400, 404)


def test_ftp_serves_the_same_folder(robot, irc5):
    with ftplib.FTP() as ftp:
        ftp.connect("127.0.0.1", irc5.port, timeout=10)
        ftp.login(irc5.user, irc5.password)
        ftp.storbinary("STOR pose.txt", io.BytesIO(b"by FTP"))
        assert robot.client.send("GET", robot.file("pose.txt")).data == b"by FTP"
        robot.client.put(robot.file("answer.txt"), b"by RWS")
        found = io.BytesIO()
        ftp.retrbinary("RETR answer.txt", found.write)
        assert found.getvalue() == b"by RWS"


def test_a_program_reads_and_writes_these_files(robot, irc5):
    lines = (
        "MODULE Ask",
        "VAR iodev file;",
        "VAR string said;",
        "PROC main()",
        'WHILE NOT IsFile("HOME:/ask.txt") DO',
        "WaitTime 0.01;",
        "ENDWHILE",
        'Open "HOME:/ask.txt", file \\Read;',
        "said := ReadStr(file);",
        "Close file;",
        'Open "HOME:/answer.txt", file \\Write;',
        "Write file, said + said;",
        "Close file;",
        "ENDPROC",
        "ENDMODULE",
    )
    (irc5.folder / "ask.mod").write_text("\n".join(lines))
    irc5.run_modules("ask.mod")
    assert robot.state() == "running"
    robot.client.put(robot.file("ask.txt"), b"twice\n")
    wait_for(lambda: robot.state() == "stopped")
    assert robot.client.send("GET", robot.file("answer.txt")).data.split() == [b"twicetwice"]


def test_a_backup_is_a_folder_that_a_restore_takes(robot, irc5):
    robot.take()
    text = "MODULE Kept\nPERS num n := 1;\nPROC main()\nn := 7;\nENDPROC\nENDMODULE\n"
    robot.load("kept.mod", text)
    robot.set("T_ROB1/Kept/n", "5")
    place = robot.either("/fileservice/$BACKUP/b1", "/fileservice/BACKUP/b1")
    made = robot.post("/ctrl/backup?action=backup", "/ctrl/backup/create", backup=place)
    assert made.status == 202
    assert robot.client.get("/ctrl/backup").items()[0]["progress-state"] == "idle"
    folder = irc5.cabinet.disk.folder("BACKUP") / "b1"
    assert sorted(path.name for path in folder.iterdir()) == ["BACKINFO", "HOME", "RAPID", "SYSPAR"]
    kept = robot.client.send("GET", f"{place}/RAPID/TASK1/PROGMOD/Kept.mod").text
    assert kept == text.replace(":= 1;", ":= 5;")
    assert "TASK1: (T_ROB1,,)" in robot.client.send("GET", f"{place}/BACKINFO/backinfo.txt").text
    again = robot.post("/ctrl/backup?action=backup", "/ctrl/backup/create", backup=place)
    assert again.status == 400
    robot.client.put(robot.file("kept.mod"), b"spoiled")
    robot.client.put(robot.file("new.txt"), b"new")
    other = "MODULE Other\nPROC main()\nENDPROC\nENDMODULE\n"
    robot.load("other.mod", other)
    back = robot.post("/ctrl/backup?action=restore", "/ctrl/backup/restore", backup=place)
    assert back.status == 202
    assert names(robot) == [("fs-file", "kept.mod")]
    assert robot.value("T_ROB1/Kept/n") == "5"
    none = robot.post("/ctrl/backup?action=restore", "/ctrl/backup/restore", backup=f"{place}x")
    assert none.status == 400


def test_a_dying_client_leaves_no_half_file(irc5):
    one = One(irc5)
    one.get("/rw/system")
    cookie = "; ".join(f"{cookie.name}={cookie.value}" for cookie in one.cookies)
    with socket.create_connection(("127.0.0.1", irc5.rws_port), timeout=10) as line:
        head = f"PUT /fileservice/$HOME/half.mod HTTP/1.1\r\nHost: x\r\nCookie: {cookie}\r\n"
        line.sendall((head + "Content-Length: 1000\r\n\r\nhalf").encode())
    assert one.get("/rw/system").status == 200
    assert list(irc5.folder.iterdir()) == []
    one.get("/logout")


def test_a_controller_without_robot_web_services(tmp_path):
    with VirtualIrc5(tmp_path, rws=None, rwss=None) as controller:
        assert controller.address.endswith(str(controller.port))
        with pytest.raises(AssertionError):
            _ = controller.cabinet


def started_again(stack, folder):
    """A second controller at the ports of one that has ended, and these ports.

    Another process may take a port that was just freed: then others are tried.
    """
    for _ in range(20):
        with VirtualIrc5(folder, robot=None) as first:
            ports = {"rws": first.rws_port, "rwss": first.rwss_port}
        with contextlib.suppress(OSError):
            return stack.enter_context(VirtualIrc5(folder, robot=None, **ports)), ports
    pytest.fail("its ports were always taken by others")


def test_given_ports(tmp_path):
    with VirtualIrc5(tmp_path, robot=None) as first:
        port = first.rws_port
        with pytest.raises(OSError), VirtualIrc5(tmp_path, robot=None, rws=port):
            pass
    with contextlib.ExitStack() as stack:
        again, ports = started_again(stack, tmp_path)
        assert (again.rws_port, again.rwss_port) == tuple(ports.values())
        assert again.rws_address == f"rws://engineer@127.0.0.1:{ports['rws']}"
        assert Robot(Two(again)).state() == "stopped"
        refused = Two(again).get("/rw/motionsystem/mechunits/ROB_1/jointtarget")
        assert refused.status == 400
    assert not again.folder.joinpath("virtual-irc5.pem").exists()
