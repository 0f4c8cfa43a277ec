"""The client on a line that is cut, late, spoilt or repeats itself.

Whatever happens: a typed finding within the time-out, files whole or not at all, and the
mastership given back, after one new connection where the line was cut.
"""

import sys
import time

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from assistant.controllers.rules import Lost
from assistant.virtual.irc5 import VirtualIrc5
from tests.controllers.abb.rws.literal import ONE, TWO
from tests.controllers.abb.rws.peer import Rws1, Rws2
from tests.controllers.abb.rws.seam import SIGNALS
from tests.controllers.cutting import Cutting, cuts, garbage, late, twice


class Virtual:
    """The virtual IRC5 as the peers are."""

    home = "HOME:"

    def __init__(self, irc5, scheme):
        self._irc5, self._scheme = irc5, scheme
        self.port = {"rws": irc5.rws_port, "rwss": irc5.rwss_port}[scheme]

    @property
    def held(self):
        """Held by programs that run, too, which the conversation has not."""
        until = time.monotonic() + SLACK
        while (held := dict(self._irc5.cabinet.mastership.holders)) and time.monotonic() < until:
            time.sleep(0.01)
        return held

    def forget(self):
        self._irc5.cabinet.mastership.holders.clear()

    @property
    def files(self):
        return {f"HOME:/{path.name}": path.read_bytes() for path in self._irc5.folder.iterdir()}

    @files.setter
    def files(self, files):
        for path in self._irc5.folder.iterdir():
            path.unlink()
        for name, data in files.items():
            (self._irc5.folder / name.removeprefix("HOME:/")).write_bytes(data)

    def connect(self, port, timeout):
        irc5 = self._irc5
        address = f"{self._scheme}://{irc5.user}@127.0.0.1:{port}"
        trusted = {"password": irc5.password, "certificate": irc5.certificate}
        return connect(address, timeout=timeout, **trusted)


PEERS = {"1.0": (Rws1, ONE), "2.0": (Rws2, TWO)}
OLD = b"MODULE Seam\nPERS num reg1:=0;\nPROC main()\nENDPROC\nENDMODULE\n"
NEW = OLD + b"! and what follows it\n" * 20
TIMEOUT = 2.0
SLACK = 3.0
"""Seconds in which a program that a cut line has started ends, on a busy computer."""


def conversation(client, module):
    """What a client does in a day."""
    client.identify()
    client.state()
    client.position()
    client.write("seam.mod", NEW)
    client.load("seam.mod")
    client.set_variable("reg1", "42", module)
    client.set_output("doGripper", 1)
    client.log(5)


def speak(peer, **options):
    """The conversation through a proxy; the finding's codes, and the bytes that passed.

    Nothing is waited for that never comes: without an answer it ends by a finding or not at all.
    """
    with Cutting(peer.port, **options) as proxy:
        try:
            with peer.connect(port=proxy.port, timeout=TIMEOUT) as client:
                conversation(client, "Seam" if isinstance(peer, Virtual) else "user")
        except Refused as error:
            assert isinstance(error, Lost) or error.findings[0].code != "CN204"
            codes = [finding.code for finding in error.findings]
        else:
            codes = []
        return codes, proxy.passed, proxy.pieces


@pytest.fixture(params=PEERS)
def peer(request):
    kind, answers = PEERS[request.param]
    with kind(answers) as peer:
        peer.files = {f"{peer.home}/seam.mod": OLD}
        yield peer


def check(peer, codes):
    """What holds after any of these faults; files are those that the controller has left."""
    home = peer.home
    data = peer.files.get(f"{home}/seam.mod", peer.files.get(f"{home}/seam.mod~"))
    assert data in (OLD, NEW)
    assert "CN221" in codes or peer.held == {}
    peer.files = {f"{home}/seam.mod": OLD}
    peer.forget()


def cut_at(peer, places, **options):
    seen = set()
    for place in places:
        codes, _, _ = speak(peer, cut=place, **options)
        check(peer, codes)
        seen.update(codes)
        if options.get("again", True) or codes != ["CN301"]:
            # What a line brought that was cut for good may be done after `forget`.
            assert set(codes) <= {"CN201", "CN204", "CN221"}, (place, codes)
    return seen


def test_a_line_that_is_cut(peer):
    codes, length, _ = speak(peer)
    assert codes == [] and length > 10_000
    check(peer, codes)
    places = cuts(length, first=3, then=4999)
    assert len(places) >= 8
    assert cut_at(peer, places) == {"CN201", "CN204"}


def test_a_line_that_stays_cut(peer):
    """The mastership may then still be held, which is said."""
    _, length, _ = speak(peer)
    check(peer, [])
    assert cut_at(peer, range(length // 2, length, 4100), again=False) >= {"CN204"}


@pytest.fixture(params=["rws", "rwss"])
def virtual(request, tmp_path):
    """One of its own: sessions that are cut for good stay."""
    with VirtualIrc5(tmp_path / "home", signals=SIGNALS) as irc5:
        peer = Virtual(irc5, request.param)
        peer.files = {"HOME:/seam.mod": OLD}
        yield peer


def test_the_virtual_controllers_line_that_is_cut(virtual):
    codes, length, _ = speak(virtual)
    assert codes == []
    check(virtual, codes)
    assert cut_at(virtual, range(1, length, length // 4)) >= {"CN201", "CN204"}


@pytest.mark.slow
def test_the_virtual_controllers_line_that_is_cut_anywhere(virtual, capsys):
    test_a_line_that_is_cut_anywhere(virtual, capsys)


@pytest.mark.slow
def test_a_line_that_is_cut_anywhere(peer, capsys):
    _, length, _ = speak(peer)
    check(peer, [])
    places = cuts(length)
    assert cut_at(peer, places) >= {"CN201", "CN204"}
    # Sessions that are cut for good stay until their time is over: 70 at most.
    for_good = places[::12]
    assert "CN204" in cut_at(peer, for_good, again=False, reset=True)
    with capsys.disabled():
        sys.stdout.write(f"\n{len(places)} cuts of {length} bytes, {len(for_good)} for good\n")
    assert places[:300] == list(range(places[0], places[0] + 300)) and places[-1] >= length - 97


def test_an_answer_that_is_late(peer, monkeypatch):
    monkeypatch.setitem(globals(), "TIMEOUT", 0.3)
    for which in (0, 9, 33):
        with (
            Cutting(peer.port, answers=late(which, 5.0)) as proxy,
            pytest.raises(Lost) as lost,
            peer.connect(port=proxy.port, timeout=TIMEOUT) as client,
        ):
            conversation(client, "user")
        codes = [finding.code for finding in lost.value.findings]
        assert codes[0] in ("CN201", "CN204") and set(codes[1:]) <= {"CN221"}, which
        check(peer, codes)


@pytest.mark.parametrize("spoilt", [garbage, twice])
def test_an_answer_that_is_garbage_or_comes_twice(peer, spoilt):
    _, _, pieces = speak(peer)
    check(peer, [])
    for which in range(0, pieces, 17):
        codes, _, _ = speak(peer, answers=spoilt(which))
        check(peer, codes)
        assert set(codes) <= {"CN201", "CN204", "CN221", "CN222"}, which


def test_an_answer_twice_is_never_taken_for_the_next_one():
    """Without TLS it could be: each request has a connection of its own."""
    with Rws1(ONE) as peer:
        for which in range(3, 9):
            with (
                Cutting(peer.port, answers=twice(which)) as proxy,
                peer.connect(port=proxy.port, timeout=TIMEOUT) as client,
            ):
                assert client.variable("reg1", "user") == "42.5"
                assert client.outputs(["doGripper"]) == {"doGripper": 1.0}
                assert client.modules() == ("BASE", "Seam")
