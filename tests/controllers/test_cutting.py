"""The proxy that the fault tests of all clients go through."""

import contextlib
import socketserver
import threading

import pytest

from tests.controllers.cutting import Cutting, cuts, garbage, late, twice
from tests.wire import Wire


class _Echo(socketserver.StreamRequestHandler):
    def handle(self):
        with contextlib.suppress(OSError):
            for line in self.rfile:
                self.wfile.write(line)


@pytest.fixture
def port():
    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), _Echo) as server:
        server.daemon_threads = True
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        yield server.server_address[1]
        server.shutdown()
        thread.join()


def test_everything_passes_and_is_counted(port):
    with Cutting(port) as proxy, Wire(proxy.port) as wire:
        wire.send(b"abc\n")
        assert wire.answer(b"\n") == "abc"
        assert (proxy.passed, proxy.pieces, proxy.connections) == (8, 1, 1)
        assert not proxy.was_cut.is_set()


@pytest.mark.parametrize("reset", [False, True])
@pytest.mark.parametrize("cut", [2, 4, 6, 8])
def test_the_line_is_cut_after_so_many_bytes(port, cut, reset):
    with Cutting(port, cut=cut, reset=reset) as proxy:
        with Wire(proxy.port) as wire:
            wire.send(b"abc\n")
            got = b""
            with contextlib.suppress(ConnectionResetError):
                while piece := wire.socket.recv(10):
                    got += piece
            assert b"abc\n"[: max(cut - 4, 0)].startswith(got)
            assert reset or len(got) == max(cut - 4, 0)
        assert proxy.was_cut.is_set() and proxy.passed == cut
        with Wire(proxy.port) as again:
            again.send(b"x\n")
            assert again.answer(b"\n") == "x"


def test_no_way_back_after_a_cut(port):
    with Cutting(port, cut=1, again=False) as proxy:
        for _ in range(2):
            with Wire(proxy.port) as wire:
                with contextlib.suppress(OSError):
                    wire.send(b"abc\n")
                assert wire.closed_by_peer()
        assert proxy.passed == 1


def test_a_line_can_be_cut_at_any_time(port):
    with Cutting(port, again=False) as proxy, Wire(proxy.port) as wire:
        wire.send(b"abc\n")
        assert wire.answer(b"\n") == "abc"
        proxy.cut_now()
        assert wire.closed_by_peer()


def test_answers_are_held_back_spoiled_and_repeated(port):
    def answers(n, data):
        return {0: late(0, 0.02), 1: garbage(1, b"zz\n"), 2: twice(2)}[n](n, data)

    with Cutting(port, answers=answers) as proxy, Wire(proxy.port) as wire:
        for sent, got in ((b"a\n", ["a"]), (b"b\n", ["zz"]), (b"c\n", ["c", "c"])):
            wire.send(sent)
            assert [wire.answer(b"\n") for _ in got] == got


def test_where_conversations_are_cut():
    assert cuts(5) == [1, 2, 3, 4, 5]
    assert cuts(20_000)[298:302] == [299, 300, 397, 494]
    assert len(cuts(20_000)) > 500
