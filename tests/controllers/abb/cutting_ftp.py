"""A cutting proxy for FTP: transfers go through it as well, in passive mode."""

import re

from tests.controllers.cutting import Cutting

PASSIVE = re.compile(
    rb"(?P<head>227 [^(]*\()127,0,0,1,(?P<high>\d+),(?P<low>\d+)(?P<tail>\).*)", re.S
)
EXTENDED = re.compile(rb"(?P<head>229 [^(]*\(\|\|\|)(?P<port>\d+)(?P<tail>\|\).*)", re.S)


class CuttingFtp(Cutting):
    """Answers that name a port for a transfer name its own instead."""

    def __init__(self, port, *, answers=None, **more):
        self._transfers = []
        self._told = False
        what = answers or (lambda n, data: [(0.0, data)])
        super().__init__(
            port,
            answers=lambda n, data: [(t, self._rewritten(piece)) for t, piece in what(n, data)],
            **more,
        )
        self._control = self._target

    def _rewritten(self, data):
        passive, extended = PASSIVE.fullmatch(data), EXTENDED.fullmatch(data)
        if passive:
            port = int(passive["high"]) * 256 + int(passive["low"])
            own = b"127,0,0,1,%d,%d" % divmod(self.port, 256)
            data = passive["head"] + own + passive["tail"]
        elif extended:
            port = int(extended["port"])
            data = extended["head"] + b"%d" % self.port + extended["tail"]
        else:
            return data
        self._transfers = [port]
        return data

    def _accept(self):
        if self.was_cut.is_set() and not self._told:
            self._told = True
            self._transfers.clear()  # a transfer that was announced, but never connected to
        port = self._transfers.pop() if self._transfers else None
        self._target = self._control if port is None else ("127.0.0.1", port)
        super()._accept()
