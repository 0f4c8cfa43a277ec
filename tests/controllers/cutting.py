"""A proxy between a client and a controller that cuts, delays, spoils or repeats what passes.

with Cutting(controller.port, cut=17) as proxy:
    connect(f"melfa://127.0.0.1:{proxy.port}")   # hangs up after 17 bytes, both ways counted
"""

import contextlib
import heapq
import itertools
import selectors
import socket
import struct
import threading
import time

NO_LINGER = struct.pack("ii", 1, 0)


def cuts(length, *, first=300, then=97):
    """Numbers of bytes after which a conversation of that length is cut."""
    return [*range(1, min(first, length) + 1), *range(first + then, length, then)]


def late(which, seconds):
    """Holds the answer of that number (from 0) back."""
    return lambda n, data: [(seconds if n == which else 0.0, data)]


def garbage(which, instead=bytes(range(256))):
    """Puts other bytes in the place of an answer."""
    return lambda n, data: [(0.0, instead if n == which else data)]


def twice(which):
    """Gives an answer two times, one behind the other."""
    return lambda n, data: [(0.0, data)] * (2 if n == which else 1)


class Cutting:
    """Listens on a port of its own and passes on what comes; a context manager.

    cut: bytes, of both ways and all connections together, after which every connection is cut.
    reset: cut by a reset instead of an end. again: whether later connections come through
    then; they are refused else. answers: what becomes of the nth piece from the controller
    (from 0): pairs of a delay in seconds and bytes. `passed` counts bytes, `pieces` answers,
    `connections` those that were accepted.
    """

    def __init__(self, port, *, cut=None, reset=False, again=True, answers=None):
        self.passed = self.pieces = self.connections = 0
        self.was_cut = threading.Event()
        self._target = ("127.0.0.1", port)
        self._cut, self._reset, self._again = cut, reset, again
        self._answers = answers or (lambda n, data: [(0.0, data)])
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._wake, self._waker = socket.socketpair()
        self._selector = selectors.DefaultSelector()
        self._other = {}
        self._of_controller = set()
        self._later = []
        self._order = itertools.count()
        self._thread = threading.Thread(target=self._run, name="cutting", daemon=True)

    @property
    def port(self):
        return self._listener.getsockname()[1]

    def cut_now(self):
        """Cuts every connection, whatever has passed."""
        self._waker.sendall(b"!")
        assert self.was_cut.wait(10)

    def __enter__(self):
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._selector.register(self._wake, selectors.EVENT_READ)
        self._thread.start()
        return self

    def __exit__(self, *error):
        self._waker.close()
        self._thread.join(10)
        assert not self._thread.is_alive()

    def _run(self):
        try:
            while True:
                wait = max(0.0, self._later[0][0] - time.monotonic()) if self._later else None
                for key, _ in self._selector.select(wait):
                    if key.fileobj is self._wake:
                        if not self._wake.recv(1):
                            return
                        self._cut_all()
                    if key.fileobj is self._listener:
                        self._accept()
                    elif key.fileobj in self._other:
                        self._read(key.fileobj)
                while self._later and self._later[0][0] <= time.monotonic():
                    _, _, to, data = heapq.heappop(self._later)
                    self._pass_on(to, data)
        finally:
            for connection in list(self._other):
                self._hang_up(connection)
            self._selector.close()
            self._listener.close()
            self._wake.close()

    def _accept(self):
        client, _ = self._listener.accept()
        if self.was_cut.is_set() and not self._again:
            client.close()
            return
        try:
            controller = socket.create_connection(self._target, timeout=5)
        except OSError:
            client.close()
            return
        self.connections += 1
        self._of_controller.add(controller)
        for one, other in ((client, controller), (controller, client)):
            one.settimeout(5)
            one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._other[one] = other
            self._selector.register(one, selectors.EVENT_READ)

    def _read(self, connection):
        try:
            data = connection.recv(65536)
        except OSError:
            data = b""
        if not data:
            self._hang_up(connection)
            return
        pieces = [(0.0, data)]
        if connection in self._of_controller:
            pieces = self._answers(self.pieces, data)
            self.pieces += 1
        to = self._other[connection]
        for delay, piece in pieces:
            if delay:
                heapq.heappush(
                    self._later, (time.monotonic() + delay, next(self._order), to, piece)
                )
            else:
                self._pass_on(to, piece)

    def _pass_on(self, to, data):
        """Sends what may still pass; what is late for a connection that is gone is lost."""
        if to not in self._other:
            return
        if self._cut is not None and not self.was_cut.is_set():
            ends = self.passed + len(data) >= self._cut
            data = data[: self._cut - self.passed]
        else:
            ends = False
        self.passed += len(data)  # before it can be received
        try:
            to.sendall(data)
        except OSError:
            self._hang_up(to)
        if ends:
            self._cut_all()

    def _cut_all(self):
        self.was_cut.set()  # before anybody can see it
        for connection in list(self._other):
            self._hang_up(connection, reset=self._reset)

    def _hang_up(self, connection, *, reset=False):
        """Closes a connection and the one that it is passed on to."""
        other = self._other.get(connection)
        for one in (connection, other):
            if self._other.pop(one, None) is None:
                continue
            self._selector.unregister(one)
            self._of_controller.discard(one)
            with contextlib.suppress(OSError):
                if reset:
                    one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, NO_LINGER)
                one.close()
