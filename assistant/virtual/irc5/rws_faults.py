"""Faults on purpose and the self-signed certificate of a virtual IRC5, for tests of clients.

Controllers are delivered with a self-signed certificate; this one is for this computer.
"""

from __future__ import annotations

import re
import ssl
import threading
from dataclasses import field
from pathlib import Path as FilePath
from typing import Literal

from assistant.base import certificate
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.base.installation import missing_extra

FaultKind = Literal["delay", "cut", "garbage", "twice"]


@dataclass(frozen=True, slots=True)
class Fault:
    """Something that happens to answers.

    kind: `delay` sends them late, `cut` hangs up after some bytes, `garbage` sends what is no
    answer, `twice` sends them two times over. path: pattern of the paths whose answers it happens
    to. seconds: of a delay. after: bytes that are sent before the line is cut. times: how often
    it happens, None for ever.
    """

    kind: FaultKind
    path: str = ""
    seconds: float = 0.0
    after: int = 0
    times: int | None = None


@dataclass(eq=False)
class Faults:
    """Those that wait to happen, in their order."""

    waiting: list[Fault] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._lock = threading.Lock()
        self._left: dict[int, int] = {}

    def add(self, fault: Fault) -> None:
        with self._lock:
            self.waiting.append(fault)
            if fault.times is not None:
                self._left[id(fault)] = fault.times

    def clear(self) -> None:
        with self._lock:
            self.waiting.clear()
            self._left.clear()

    def next(self, path: str) -> Fault | None:
        """The fault of the answer to a request, which is then one less."""
        with self._lock:
            for fault in self.waiting:
                if not re.search(fault.path, path):
                    continue
                if id(fault) in self._left:
                    self._left[id(fault)] -= 1
                    if self._left[id(fault)] <= 0:
                        self.waiting.remove(fault)
                        del self._left[id(fault)]
                return fault
        return None


GARBLED_ANSWER = b"\x00\xff\x7f not a protocol \r\n\x16\x03"
"""Bytes that are sent instead of an answer."""


NEEDS_PACKAGE = missing_extra(
    "VC002",
    "the virtual IRC5 needs {package} for Robot Web Services, which is not installed",
    "virtual",
)


def certify(host: str, file: FilePath) -> ssl.SSLContext:
    """See `certificate.certify`; raises Refused if a package is missing, OSError for the file."""
    try:
        return certificate.self_signed_context(host, "virtual-irc5", file)
    except ImportError:
        raise Refused(NEEDS_PACKAGE(package="cryptography")) from None
