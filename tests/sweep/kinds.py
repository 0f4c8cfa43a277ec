"""What happens at a call that changes files."""

from __future__ import annotations

import errno
import signal
from dataclasses import dataclass
from typing import Final

from tests.sweep import shim


@dataclass(frozen=True, slots=True)
class Kind:
    """what: the number of a signal or of an error. again: calls until the signal comes again."""

    name: str
    kind: int
    what: int
    again: int = 0

    @property
    def kills(self) -> bool:
        return self.kind == shim.SIGNAL and self.what == signal.SIGKILL


KINDS: Final = (
    Kind("killed", shim.SIGNAL, signal.SIGKILL),
    Kind("SIGTERM", shim.SIGNAL, signal.SIGTERM),
    Kind("Ctrl-C", shim.SIGNAL, signal.SIGINT),
    Kind("Ctrl-C twice", shim.SIGNAL, signal.SIGINT, 1),
    Kind("Ctrl-C and again", shim.SIGNAL, signal.SIGINT, 4),
    Kind("SIGHUP", shim.SIGNAL, signal.SIGHUP),
    Kind("disk full", shim.FULL, errno.ENOSPC),
    Kind("read-only", shim.ALWAYS, errno.EROFS),
    Kind("refused", shim.ONCE, errno.EACCES),
    Kind("disk fails once", shim.ONCE, errno.EIO),
    Kind("disk fails for good", shim.ALWAYS, errno.EIO),
)
