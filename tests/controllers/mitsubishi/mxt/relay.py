"""What lies between a client and a controller in `Mxt`: a line that spoils, or others that send."""

import random
import socket
import threading
from contextlib import contextmanager


class Line:
    """port: that the client sends to. told: answers that came through."""

    def __init__(self, port):
        self._near = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._near.bind(("127.0.0.1", 0))
        self._far = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._far.connect(("127.0.0.1", port))
        for end in (self._near, self._far):
            end.settimeout(0.05)
        self.port = self._near.getsockname()[1]
        self.over = threading.Event()
        self.client = None

    def asked(self):
        while not self.over.is_set():
            try:
                packet, self.client = self._near.recvfrom(2048)
                self.go(packet, self._far.send)
            except OSError:
                continue

    def answered(self):
        while not self.over.is_set():
            try:
                packet = self._far.recv(2048)
                self.come(packet, lambda data: self._near.sendto(data, self.client))
            except OSError:
                continue

    def go(self, packet, send):
        send(packet)

    def come(self, packet, send):
        send(packet)

    def close(self):
        self._near.close()
        self._far.close()


class Early(Line):
    """Before the first answer comes one of an earlier run."""

    def __init__(self, port, packet):
        super().__init__(port)
        self._packet = packet

    def come(self, packet, send):
        if self._packet:
            send(self._packet)
            self._packet = b""
        send(packet)


class Bad(Line):
    """Loses, doubles and swaps packets both ways; others send to the client meanwhile."""

    def __init__(self, port, seed, share=0.1):
        super().__init__(port)
        self._random, self._share = random.Random(seed), share
        self._kept = {}
        self._stranger = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def go(self, packet, send):
        self._spoil("go", packet, send)

    def come(self, packet, send):
        self._stranger.sendto(packet, self.client)
        self._spoil("come", packet, send)

    def _spoil(self, way, packet, send):
        lot = self._random.random() / self._share
        kept = self._kept.pop(way, None)
        if lot < 1.0:
            pass
        elif lot < 2.0:
            send(packet)
            send(packet)
        elif lot < 3.0:
            self._kept[way] = packet
        else:
            send(packet)
        if kept is not None:
            send(kept)

    def close(self):
        super().close()
        self._stranger.close()


@contextmanager
def through(line):
    threads = [threading.Thread(target=way) for way in (line.asked, line.answered)]
    for thread in threads:
        thread.start()
    try:
        yield line
    finally:
        line.over.set()
        for thread in threads:
            thread.join()
        line.close()
