"""The client of the IRC5's file server against the virtual controller and against bad servers."""

import logging
import socket

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import Credentials, connect
from assistant.controllers.abb.files import first_difference
from assistant.controllers.rules import Lost
from assistant.virtual.irc5 import VirtualIrc5
from tests.controllers.abb.bad_ftp import FtpPeer

GOOD = b"MODULE Seam\r\n  PROC main()\r\n    WaitTime 1;\r\n  ENDPROC\r\nENDMODULE\r\n"
OTHER = GOOD.replace(b"1;", b"2;")
BROKEN = GOOD.replace(b"1;", b"(1;")


def codes(refused):
    return [finding.code for finding in refused.value.findings]


def client_of(controller, **options):
    password = options.pop("password", controller.password)
    return connect(controller.address, password=password, timeout=10, **options)


@pytest.fixture
def controller(tmp_path):
    with VirtualIrc5(tmp_path / "home", rws=None, rwss=None) as controller:
        yield controller


@pytest.fixture
def client(controller):
    with client_of(controller) as client:
        yield client


def test_a_module_goes_there_and_comes_back(controller, client):
    assert client.names() == () and client.read("seam.mod") is None
    client.write("seam.mod", GOOD)
    assert client.read("seam.mod") == GOOD and client.names() == ("seam.mod",)
    client.write("seam.mod", OTHER)
    assert client.read("SEAM.MOD".lower()) == OTHER
    assert [f.name for f in controller.folder.iterdir()] == ["seam.mod"]
    client.remove("seam.mod")
    client.remove("seam.mod")
    assert client.names() == ()


def test_every_byte_is_kept(client):
    data = bytes(range(256)) * 400 + b"\r\n\n\r\r\n"
    client.write("data.bin", data)
    assert client.read("data.bin") == data


def test_a_folder_of_the_address_is_gone_to(controller):
    (controller.folder / "parts").mkdir()
    address = f"{controller.address}/HOME:/parts"
    with connect(address, password=controller.password) as client:
        client.write("seam.mod", GOOD)
    assert (controller.folder / "parts" / "seam.mod").read_bytes() == GOOD
    missing = f"{controller.address}/HOME:/nowhere"
    with pytest.raises(Refused) as refused, connect(missing, password=controller.password):
        pass
    assert codes(refused) == ["CN203"]


def test_a_refused_module_leaves_the_old_one(controller, client):
    client.write("seam.mod", GOOD)
    with pytest.raises(Refused) as refused:
        client.write("seam.mod", BROKEN)
    assert codes(refused) == ["CN205"] and not isinstance(refused.value, Lost)
    message = refused.value.findings[0].message
    assert "as it was" in message and ":3:" in message
    assert client.read("seam.mod") == GOOD
    assert client.names() == ("seam.mod",)


def test_a_full_disk_leaves_the_old_one(tmp_path):
    with VirtualIrc5(tmp_path / "home", quota=300) as controller, client_of(controller) as client:
        client.write("seam.mod", GOOD)
        with pytest.raises(Refused) as refused:
            client.write("seam.mod", GOOD + b" " * 400)
        assert codes(refused) == ["CN205"] and "full" in refused.value.findings[0].message
        assert client.read("seam.mod") == GOOD and client.names() == ("seam.mod",)


def test_a_wrong_password_is_a_finding_without_it(controller, caplog):
    caplog.set_level(logging.DEBUG)
    with pytest.raises(Refused) as refused, client_of(controller, password="hunter2"):
        pass
    assert codes(refused) == ["CN202"] and refused.value.exit_status == 2
    assert "hunter2" not in str(refused.value) + caplog.text


@pytest.mark.parametrize("password", ["a\r\nDELE seam.mod", "a\nb", "a\rb"])
def test_a_line_end_in_a_password_is_no_command(controller, password):
    with pytest.raises(Refused) as refused, client_of(controller, password=password):
        pass
    assert codes(refused) == ["CN202"]


def test_nobody_there():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    with pytest.raises(Lost) as refused, connect(f"ftp://u@127.0.0.1:{port}", password="p"):
        pass
    assert codes(refused) == ["CN201"] and refused.value.exit_status == 2


def test_nobody_who_answers():
    with (
        socket.create_server(("127.0.0.1", 0)) as listener,
        pytest.raises(Lost) as refused,
        connect(f"ftp://u@127.0.0.1:{listener.getsockname()[1]}", password="p", timeout=0.2),
    ):
        pass
    assert codes(refused) == ["CN201"] and "in time" in refused.value.findings[0].message


@pytest.mark.parametrize(
    "name",
    ["", "../x.mod", "a/b.mod", "a\\b.mod", "x\r\nDELE y", "~x.mod", ".hidden", "-la", "ä.mod",
     "x.mod~", "HOME:x", "a" * 65, "*.mod"],
)  # fmt: skip
def test_names_that_are_refused_before_anything_is_sent(client, name):
    for act in (client.read, client.remove, lambda n: client.write(n, GOOD)):
        with pytest.raises(Refused) as refused:
            act(name)
        assert codes(refused) == ["CN207"]


def test_names_of_files(client):
    assert client.name_for("out/folder/seam 1.mod") == "seam 1.mod"


def test_a_controller_that_stops_in_the_middle(controller):
    with client_of(controller) as client:
        client.write("seam.mod", GOOD)
        controller.stop()
        with pytest.raises(Lost) as refused:
            client.write("seam.mod", OTHER)
        assert codes(refused) == ["CN204"]
        with pytest.raises(Lost) as again:
            client.read("seam.mod")
        assert codes(again) == ["CN204"]
    assert (controller.folder / "seam.mod").read_bytes() == GOOD


@pytest.mark.parametrize("after", [0, 20, len(OTHER)])
def test_a_server_that_dies_while_receiving(tmp_path, after):
    with FtpPeer({"seam.mod": GOOD}, die_after=after) as peer:
        with pytest.raises(Lost) as refused, peer.connect() as client:
            client.write("seam.mod", OTHER)
        assert codes(refused) == ["CN204"]
        assert "as it was" in refused.value.findings[0].message
        assert peer.files["seam.mod"] == GOOD


def test_a_server_that_alters_a_byte_replaces_nothing():
    with FtpPeer({"seam.mod": GOOD}, alter=lambda data: data.replace(b"2;", b"3;")) as peer:
        with pytest.raises(Refused) as refused, peer.connect() as client:
            client.write("seam.mod", OTHER)
        assert codes(refused) == ["CN206"]
        assert f"byte {OTHER.index(b'2;')}" in refused.value.findings[0].message
        assert peer.files == {"seam.mod": GOOD}


def test_a_server_that_translates_line_ends_is_caught():
    with FtpPeer({}, alter=lambda data: data.replace(b"\r\n", b"\n")) as peer:
        with pytest.raises(Refused) as refused, peer.connect() as client:
            client.write("seam.mod", GOOD)
        assert codes(refused) == ["CN206"] and peer.files == {}


def test_a_server_that_never_replaces_by_renaming():
    with FtpPeer({"seam.mod": GOOD}, replaces=False) as peer, peer.connect() as client:
        client.write("seam.mod", OTHER)
        assert peer.files == {"seam.mod": OTHER}


def test_no_file_of_somebody_else_is_in_the_way_or_lost():
    other = {"seam.mod~": b"somebody kept this"}
    with FtpPeer({"seam.mod": GOOD, **other}, replaces=False) as peer:
        with peer.connect() as client:
            client.write("seam.mod", OTHER)
        assert peer.files == {"seam.mod": OTHER, **other}


def test_a_server_that_refuses_the_new_name_gets_the_old_file_back():
    def forbidden(source, target):
        return source.startswith("~") and target == "seam.mod"

    with FtpPeer({"seam.mod": GOOD}, forbid=forbidden) as peer, peer.connect() as client:
        with pytest.raises(Refused) as refused:
            client.write("seam.mod", OTHER)
        assert codes(refused) == ["CN205"]
        assert peer.files == {"seam.mod": GOOD}


def test_a_listing_that_is_refused_is_not_taken_for_an_empty_folder():
    with FtpPeer({"seam.mod": GOOD}, listing=False) as peer, peer.connect() as client:
        for act in (client.names, lambda: client.read("seam.mod")):
            with pytest.raises(Refused) as refused:
                act()
            assert codes(refused) == ["CN205"]


def test_a_server_that_repeats_the_password_does_not_get_it_shown():
    with FtpPeer({}, login=False) as peer:
        with pytest.raises(Refused) as refused, peer.connect():
            pass
        assert codes(refused) == ["CN202"]
        assert peer.password not in str(refused.value) and "***" in str(refused.value)


def test_ftps_is_encrypted_and_trusts_only_what_it_is_told_to():
    with FtpPeer({}, tls=True) as peer:
        with peer.connect(certificate=peer.certificate) as client:
            client.write("seam.mod", GOOD)
            assert client.read("seam.mod") == GOOD
        assert peer.files == {"seam.mod": GOOD} and peer.encrypted == {True}
        with pytest.raises(Refused) as refused, peer.connect():
            pass
        assert codes(refused) == ["CN208"]
        with pytest.raises(Refused) as refused, peer.connect(certificate="nowhere.pem"):
            pass
        assert codes(refused) == ["CN208"]


def test_ftps_never_falls_back_to_plain(controller):
    address = controller.address.replace("ftp://", "ftps://")
    with pytest.raises(Refused) as refused, connect(address, password=controller.password):
        pass
    assert codes(refused) == ["CN214"]


def test_a_session_that_was_never_opened_is_a_finding():
    client = connect("ftp://u@127.0.0.1", credentials=Credentials("u", "p"))
    with pytest.raises(Lost):
        client.names()


@pytest.mark.parametrize(
    ("left", "right", "at"),
    [(b"abc", b"abd", 2), (b"abc", b"ab", 2), (b"", b"x", 0), (b"xa", b"ya", 0), (b"a", b"a", 1)],
)
def test_first_difference(left, right, at):
    assert first_difference(left, right) == at
