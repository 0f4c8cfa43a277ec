"""What there is outside of a simulated run: a folder, hosts, and somebody who answers."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.program.diagnostics import Refused, error

if TYPE_CHECKING:
    from assistant.virtual.kernel import Kernel

NO_HOST: Final = error(
    "CL030",
    "`{given}` names no host for an address",
    "write ADDRESS=HOST, as 192.168.125.1=127.0.0.1",
)
NO_FOLDER: Final = error("CL031", "there is no folder `{folder}`", "make it, or name another one")
NO_ASKING: Final = error(
    "CL032", "the program itself is read from standard input", "name its file, or leave --ask out"
)


def check_disk(folder: Path | None) -> None:
    if folder is not None and not folder.is_dir():
        raise Refused(NO_FOLDER(folder=folder), exit_status=2)


def hosts_of(given: Sequence[str]) -> dict[str, str]:
    """Hosts by address; raises Refused for what names none."""
    hosts = {}
    for pair in given:
        address, _, host = (part.strip() for part in pair.partition("="))
        if not address or not host:
            raise Refused(NO_HOST(given=pair), exit_status=2)
        hosts[address] = host
    return hosts


def ask_here(kernel: Kernel, flush: Callable[[], None]) -> None:
    """Has what programs ask answered on standard input, as long as there is more of it.

    flush: prints what happened until then.
    """

    def asked(question: str) -> str | None:
        kernel.catch_up()
        flush()
        sys.stderr.write(f"answer to `{question}`: ")
        sys.stderr.flush()
        line = sys.stdin.readline()
        return line.strip() if line else None

    kernel.person.console = asked
