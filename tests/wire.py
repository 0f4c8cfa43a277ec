"""A bare client of the controller link, for tests that look at single bytes."""

import contextlib
import socket


class Wire:
    """Sends bytes as they are; `ask` is one command with CR and its answer without."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=10)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._rest = b""

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.socket.close()

    def send(self, data):
        self.socket.sendall(data)

    def answer(self, end=b"\r"):
        while end not in self._rest:
            piece = self.socket.recv(65536)
            assert piece, "the controller hung up"
            self._rest += piece
        answer, _, self._rest = self._rest.partition(end)
        return answer.decode("latin-1")

    def ask(self, command):
        self.send(command.encode("latin-1") + b"\r")
        return self.answer()

    def closed_by_peer(self):
        with contextlib.suppress(ConnectionResetError):
            return self.socket.recv(1) == b""
        return True
