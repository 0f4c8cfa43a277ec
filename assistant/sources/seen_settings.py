"""Settings of frames that cameras locate: whom a program asks, and how far a sight is trusted."""

from __future__ import annotations

import re
from typing import Final, Literal

from assistant.base.data_classes import dataclass

_NOT_AN_ADDRESS: Final = "is no address at which a program can ask"
_ADDRESS_FORMS: Final = (
    "write HOST:PORT of the computer that answers, listen:ADDRESS:PORT for a controller that "
    "waits for it, or line:NUMBER for a communication line of the controller"
)
_ADDRESS: Final = re.compile(
    r"line:(?P<line>[1-8])|(?P<listen>listen:)?(?P<host>[A-Za-z0-9_.\-]+):(?P<port>[0-9]{1,5})"
)
_MOST_PORT: Final = 65535


@dataclass(frozen=True, slots=True)
class Trust:
    """Limits of trust in sights.

    oldest: seconds for which a sight is valid. sigma_mm, sigma_deg: largest uncertainty, one
    standard deviation. confidence: 0 to 1, the least that is accepted. within: mm from its usual
    position within which an answer to a running program may be: nothing farther away was checked.
    """

    oldest: float = 600.0
    sigma_mm: float = 1.0
    sigma_deg: float = 1.0
    confidence: float = 0.8
    within: float = 300.0


DEFAULT_TRUST: Final = Trust()


@dataclass(frozen=True, slots=True)
class PoseServer:
    """Server that a program asks as it runs.

    kind: `client` connects to another computer, `server` waits for it at its own address, `line` is
    a communication line of the controller, whatever it is. number: of the port, or of the line.
    """

    kind: Literal["client", "server", "line"]
    address: str
    number: int

    @property
    def spoken(self) -> str:
        """In a sentence: whom a program asks."""
        if self.kind == "line":
            return f"over line {self.number}"
        who = "whoever connects to" if self.kind == "server" else "at"
        return f"{who} {self.address}:{self.number}"

    @staticmethod
    def parse(text: str) -> PoseServer:
        """From `HOST:PORT`, `listen:ADDRESS:PORT` or `line:NUMBER`; raises Wrong."""
        from assistant.program.settings_tables import Wrong, shown

        match = _ADDRESS.fullmatch(text.strip())
        if (
            match is None
            or match["host"] == "line"
            or int(match["port"] or 1) not in range(1, _MOST_PORT + 1)
        ):
            raise Wrong(f'is "{shown(text)}", which {_NOT_AN_ADDRESS}', _ADDRESS_FORMS)
        if match["line"]:
            return PoseServer("line", "", int(match["line"]))
        kind: Literal["client", "server"] = "server" if match["listen"] else "client"
        return PoseServer(kind, match["host"], int(match["port"]))


@dataclass(frozen=True, slots=True)
class SeenSettings:
    """Settings of a process file under [seen].

    found: path of a file of objects that were found, empty if the file names none.
    """

    ask: PoseServer | None = None
    trust: Trust = DEFAULT_TRUST
    found: str = ""


NO_SEEN_SETTINGS: Final = SeenSettings()
