"""The virtual IRC5 through the standard library's FTP client."""

import contextlib
import ftplib
import io
import logging
import socket
import threading
import time

import pytest

from assistant.virtual.irc5 import VirtualIrc5

GOOD = b"MODULE Seam\r\n  PROC main()\r\n    WaitTime 1;\r\n  ENDPROC\r\nENDMODULE\r\n"
BROKEN = GOOD.replace(b"WaitTime 1;", b"WaitTime (1;")
FILES = {"rws": None, "rwss": None}
"""Serves files alone."""


@pytest.fixture
def reports():
    return []


@pytest.fixture
def controller(tmp_path, reports):
    (tmp_path / "outside.txt").write_text("secret")
    with VirtualIrc5(tmp_path / "home", report=reports.append, **FILES) as controller:
        yield controller


@contextlib.contextmanager
def session(controller):
    with ftplib.FTP() as ftp:
        ftp.connect("127.0.0.1", controller.port, timeout=10)
        ftp.login(controller.user, controller.password)
        yield ftp


@pytest.fixture
def ftp(controller):
    with session(controller) as ftp:
        yield ftp


def store(ftp, name, data):
    return ftp.storbinary(f"STOR {name}", io.BytesIO(data))


def retrieve(ftp, name):
    data = io.BytesIO()
    ftp.retrbinary(f"RETR {name}", data.write)
    return data.getvalue()


def test_a_good_module_is_stored_and_loaded(controller, ftp, reports):
    assert store(ftp, "seam.mod", GOOD).startswith("226")
    assert retrieve(ftp, "seam.mod") == GOOD
    assert ftp.nlst() == ["seam.mod"]
    assert (controller.folder / "seam.mod").read_bytes() == GOOD
    modules = controller.modules()
    assert [(m.name, m.file, m.findings) for m in modules] == [("Seam", "seam.mod", ())]
    assert reports == [f"stored seam.mod ({len(GOOD)} bytes)"]


@pytest.mark.parametrize("path", ["/HOME:/a.mod", "HOME:/a.mod", "home:/a.mod", "/a.mod", "a.mod"])
def test_the_unit_may_stand_in_front(controller, ftp, path):
    store(ftp, path, GOOD)
    assert [f.name for f in controller.folder.iterdir()] == ["a.mod"]
    ftp.cwd("HOME:")
    assert retrieve(ftp, "a.mod") == GOOD
    ftp.mkd("HOME:/parts")
    ftp.cwd("/HOME:/parts")
    store(ftp, "b.mod", GOOD)
    assert (controller.folder / "parts" / "b.mod").read_bytes() == GOOD


@pytest.mark.parametrize(
    "data",
    [
        BROKEN,
        GOOD[: len(GOOD) // 2],
        GOOD.replace(b"ENDPROC", b""),
        b"",
        b"\xff\xfe\0\0",
        b"no module at all",
        b"10 MOV P1\r\n",
    ],
)
def test_a_broken_module_is_refused_and_replaces_nothing(controller, ftp, data, reports):
    store(ftp, "seam.mod", GOOD)
    with pytest.raises(ftplib.error_perm) as refused:
        store(ftp, "seam.mod", data)
    assert str(refused.value).startswith("550") and "seam.mod" in str(refused.value)
    assert retrieve(ftp, "seam.mod") == GOOD
    assert [f.name for f in controller.folder.iterdir()] == ["seam.mod"]
    assert "refused seam.mod" in reports[-1]


def test_the_refusal_names_line_and_code(controller, ftp):
    with pytest.raises(ftplib.error_perm) as refused:
        store(ftp, "seam.mod", BROKEN)
    assert "seam.mod:3:" in str(refused.value) and " RA" in str(refused.value)


TARGET = b"[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
ZONE = GOOD.replace(b"WaitTime 1;", b"MoveL " + TARGET + b", v150, z3, tool0;")


def test_names_that_no_loaded_module_declares_are_refused(controller, ftp):
    with pytest.raises(ftplib.error_perm, match="z3"):
        store(ftp, "seam.mod", ZONE)
    declared = b"CONST zonedata z3 := [FALSE,3,4,4,0.4,4,0.4];"
    store(ftp, "zones.mod", b"MODULE Zones\r\n  " + declared + b"\r\nENDMODULE\r\n")
    store(ftp, "seam.mod", ZONE)
    assert retrieve(ftp, "seam.mod") == ZONE


def test_files_of_two_programs_may_both_have_a_main(controller, ftp):
    store(ftp, "a.mod", GOOD)
    store(ftp, "b.mod", GOOD.replace(b"Seam", b"Other"))
    assert sorted(ftp.nlst()) == ["a.mod", "b.mod"]


def test_renaming_does_not_smuggle_a_broken_module_in(controller, ftp):
    store(ftp, "seam.mod", GOOD)
    store(ftp, "seam.txt", BROKEN)
    with pytest.raises(ftplib.error_perm):
        ftp.rename("seam.txt", "seam.mod")
    assert retrieve(ftp, "seam.mod") == GOOD
    store(ftp, "next.mod", GOOD.replace(b"1;", b"2;"))
    ftp.rename("next.mod", "seam.mod")
    assert retrieve(ftp, "seam.mod") == GOOD.replace(b"1;", b"2;")


@pytest.mark.parametrize("command", ["APPE", "STOR"])
def test_a_file_is_not_sent_in_parts(controller, ftp, command):
    store(ftp, "seam.mod", GOOD)
    rest = None if command == "APPE" else 5
    with pytest.raises(ftplib.error_perm):
        ftp.storbinary(f"{command} seam.mod", io.BytesIO(b"rest"), rest=rest)
    assert retrieve(ftp, "seam.mod") == GOOD


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"<Program><Module>seam.mod</Module></Program>", None),
        (b"<Program><Module>gone.mod</Module></Program>", "gone.mod"),
        (b"<Program></Program>", "names no modules"),
        (b"<Program><Module>seam.mod</Module>", "no element found"),
        (b'<!DOCTYPE x [<!ENTITY e "y">]><Program><Module>&e;</Module></Program>', "document type"),
        (b"\xff\xfe", "program file"),
    ],
)
def test_program_files_name_modules_that_are_there(controller, ftp, data, said):
    store(ftp, "seam.mod", GOOD)
    if said is None:
        assert store(ftp, "seam.pgf", data).startswith("226")
    else:
        with pytest.raises(ftplib.error_perm, match=said):
            store(ftp, "seam.pgf", data)
        assert ftp.nlst() == ["seam.mod"]


@pytest.mark.parametrize(
    "path",
    ["../outside.txt", "/../outside.txt", "HOME:/../outside.txt", "HOME:/../../etc/passwd",
     "parts/../../outside.txt", "/HOME:/HOME:/../../outside.txt"],
)  # fmt: skip
def test_nothing_outside_is_reached(controller, ftp, path):
    outside = controller.folder.parent / "outside.txt"
    with pytest.raises(ftplib.error_perm):
        retrieve(ftp, path)
    with contextlib.suppress(ftplib.error_perm):
        store(ftp, path, b"overwritten")
    with contextlib.suppress(ftplib.error_perm):
        ftp.delete(path)
    with contextlib.suppress(ftplib.error_perm):
        ftp.cwd("..")
        ftp.cwd("../..")
    assert "outside.txt" not in ftp.nlst("/") or (controller.folder / "outside.txt").is_file()
    assert outside.read_text() == "secret"
    assert sorted(f.name for f in controller.folder.parent.iterdir()) == ["home", "outside.txt"]


@pytest.mark.parametrize("command", ["SIZE", "MLST", "DELE", "CWD", "RNFR", "SITE CHMOD 777"])
def test_a_nul_in_a_name_is_refused(ftp, command, caplog):
    with pytest.raises(ftplib.error_perm):
        ftp.sendcmd(f"{command} a\0b")
    assert not caplog.records and ftp.voidcmd("NOOP").startswith("200")


def test_a_link_out_of_home_is_not_followed(controller, ftp):
    (controller.folder / "link").symlink_to(controller.folder.parent)
    with pytest.raises(ftplib.error_perm):
        retrieve(ftp, "link/outside.txt")
    with pytest.raises(ftplib.error_perm):
        store(ftp, "link/new.txt", b"x")
    assert sorted(f.name for f in controller.folder.parent.iterdir()) == ["home", "outside.txt"]


def test_a_full_disk(tmp_path):
    with VirtualIrc5(tmp_path / "home", quota=200) as controller, session(controller) as ftp:
        store(ftp, "seam.mod", GOOD)
        with pytest.raises(ftplib.error_perm, match="552"):
            store(ftp, "long.mod", GOOD + b" " * 200)
        store(ftp, "seam.mod", GOOD + b" " * 50)  # what it replaces does not count
        assert ftp.nlst() == ["seam.mod"]


def test_a_client_that_dies_in_the_middle_stores_nothing(controller, ftp):
    store(ftp, "data.txt", b"old")
    with session(controller) as dying:
        channel = dying.transfercmd("STOR data.txt")
        channel.sendall(b"half")
        dying.sock.shutdown(socket.SHUT_RDWR)  # the control connection goes first
        dying.sock.close()
        for _ in range(3):
            assert retrieve(ftp, "data.txt") == b"old"
        channel.close()
        dying.sock = None
    for _ in range(3):
        assert retrieve(ftp, "data.txt") == b"old"
    assert [f.name for f in controller.folder.iterdir()] == ["data.txt"]


def test_clients_at_once(controller):
    errors = []

    def work(number):
        module = GOOD.replace(b"Seam", b"Seam%d" % number)
        try:
            with session(controller) as ftp:
                for _ in range(3):
                    store(ftp, f"seam{number}.mod", module)
                    with contextlib.suppress(ftplib.error_perm):
                        store(ftp, f"seam{number}.mod", BROKEN)
                    if retrieve(ftp, f"seam{number}.mod") != module:
                        errors.append(number)
        except ftplib.Error as error:
            errors.append(error)

    threads = [threading.Thread(target=work, args=(n,)) for n in range(5)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors == []
    assert [m.name for m in controller.modules()] == [f"Seam{n}" for n in range(5)]


def test_two_files_with_one_module_are_a_finding(controller, ftp):
    store(ftp, "a.mod", GOOD)
    store(ftp, "b.mod", GOOD)
    assert [[f.code for f in m.findings] for m in controller.modules()] == [[], ["VC104"]]


def test_the_user_has_to_be_right_and_no_password_is_logged(controller, caplog):
    caplog.set_level(logging.DEBUG)
    with ftplib.FTP() as ftp:
        ftp.connect("127.0.0.1", controller.port, timeout=10)
        with pytest.raises(ftplib.error_perm, match="530"):
            ftp.login(controller.user, "guessed-wrong")
    with ftplib.FTP() as ftp:
        ftp.connect("127.0.0.1", controller.port, timeout=10)
        with pytest.raises(ftplib.error_perm):
            ftp.login()  # anonymous
    with session(controller) as ftp:
        assert ftp.nlst() == []
    assert controller.password not in caplog.text and "guessed-wrong" not in caplog.text
    assert len(controller.password) >= 12 and controller.password not in repr(controller)


@pytest.mark.slow  # a failed login is kept waiting
def test_a_failed_login_that_goes_takes_nobody_else_along(controller):
    """The one that comes next has the number of its socket."""
    for _ in range(3):
        with socket.create_connection(("127.0.0.1", controller.port), 5) as line:
            line.sendall(b"USER x\r\nPASS y\r\nQUIT\r\n")
            line.shutdown(socket.SHUT_WR)
            while line.recv(100):
                pass
        with session(controller) as ftp:
            time.sleep(0.25)  # as long as a failed login is kept waiting
            assert ftp.voidcmd("NOOP").startswith("200")


def test_a_given_port_and_password(tmp_path):
    with VirtualIrc5(tmp_path, user="u", password="p") as first:
        port = first.port
        with pytest.raises(OSError), VirtualIrc5(tmp_path, port=port):
            pass
    with VirtualIrc5(tmp_path, port=port, user="u", password="p") as again, session(again) as ftp:
        assert again.port == port and ftp.pwd() == "/"
        assert again.address == f"ftp://u@127.0.0.1:{port}"


def test_two_controllers_do_not_share_anything(tmp_path):
    with VirtualIrc5(tmp_path / "a") as one, VirtualIrc5(tmp_path / "b") as two:
        with session(one) as ftp:
            store(ftp, "seam.mod", GOOD)
        with session(two) as ftp:
            assert ftp.nlst() == []
        with ftplib.FTP() as ftp:
            ftp.connect("127.0.0.1", two.port, timeout=10)
            with pytest.raises(ftplib.error_perm):
                ftp.login(one.user, one.password)


def test_a_module_without_end_does_not_keep_the_controller(controller, ftp, monkeypatch):
    store(ftp, "seam.mod", GOOD)  # which reads the grammar
    monkeypatch.setenv("ROBOT_ASSISTANT_BUDGET", "0.002")
    body = b"".join(b"    x%d := x%d + (%d * 2);\r\n" % (i, i, i) for i in range(6000))
    with pytest.raises(ftplib.error_perm, match=r"LM00[12]"):  # whichever is looked at first
        store(ftp, "heavy.mod", GOOD.replace(b"    WaitTime 1;\r\n", body))
    (controller.folder / "heavy.mod").write_bytes(GOOD.replace(b"    WaitTime 1;\r\n", body))
    heavy, seam = controller.modules()
    assert heavy.findings[0].code in ("LM001", "LM002") and not seam.findings
    with session(controller) as other:
        assert store(other, "seam.mod", GOOD).startswith("226")
