"""What a process file says of frames that are seen: how far sights are trusted, and who is asked.

    [seen]
    ask = "192.168.0.5:10010"     # the program asks there as it runs; or listen:ADDRESS:PORT
    found = "found.toml"          # beside this file: what was found before the program is written
    oldest = 600                  # seconds that a sight counts for
    sigma_mm = 1.0                # that a place may be unsure by, one standard deviation
    sigma_deg = 1.0
    confidence = 0.8              # 0 to 1, that it must at least be the object
    within = 300                  # mm from its usual place that the answer of a question may lie

Each key may be left out.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any, Final, Literal

from assistant.program import settings_tables
from assistant.program.settings_tables import Read, Wrong, shown

NOT_AN_ADDRESS: Final = "is no address at which a program can ask"
ADDRESS_FORMS: Final = (
    "write HOST:PORT of the computer that answers, listen:ADDRESS:PORT for a controller that "
    "waits for it, or line:NUMBER for a communication line of the controller"
)
_ADDRESS: Final = re.compile(
    r"line:(?P<line>[1-8])|(?P<listen>listen:)?(?P<host>[A-Za-z0-9_.\-]+):(?P<port>[0-9]{1,5})"
)
MOST_PORT: Final = 65535


@dataclass(frozen=True, slots=True)
class Trust:
    """How far sights are trusted.

    oldest: seconds that one counts for. sigma_mm, sigma_deg: that it may be unsure by, one standard
    deviation. confidence: 0 to 1, that it must at least have. within: mm from its usual place that
    an answer may lie which a program gets as it runs: farther away nothing was looked at.
    """

    oldest: float = 600.0
    sigma_mm: float = 1.0
    sigma_deg: float = 1.0
    confidence: float = 0.8
    within: float = 300.0


DEFAULT_TRUST: Final = Trust()


@dataclass(frozen=True, slots=True)
class PoseServer:
    """Whom a program asks as it runs.

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
        match = _ADDRESS.fullmatch(text.strip())
        if (
            match is None
            or match["host"] == "line"
            or int(match["port"] or 1) not in range(1, MOST_PORT + 1)
        ):
            raise Wrong(f'is "{shown(text)}", which {NOT_AN_ADDRESS}', ADDRESS_FORMS)
        if match["line"]:
            return PoseServer("line", "", int(match["line"]))
        kind: Literal["client", "server"] = "server" if match["listen"] else "client"
        return PoseServer(kind, match["host"], int(match["port"]))


@dataclass(frozen=True, slots=True)
class SeenSettings:
    """What a process file says under [seen].

    found: path of a file of what was found, empty for none.
    """

    ask: PoseServer | None = None
    trust: Trust = field(default=DEFAULT_TRUST)
    found: str = ""


NO_SEEN_SETTINGS: Final = SeenSettings()


def _read_address(value: Any) -> PoseServer:
    return PoseServer.parse(settings_tables.text(value))


def _read_file_beside(value: Any) -> str:
    """The name of a file, in the same folder."""
    given = settings_tables.text(value)
    if re.search(r"[/\\:\x00-\x1f]", given) or given in (".", ".."):
        raise Wrong(f'is "{shown(given)}"', "write the name of a file beside this one, no folder")
    return given


SEEN_KEYS: Final[Mapping[str, Read]] = {
    "ask": _read_address,
    "found": _read_file_beside,
    "oldest": settings_tables.number("seconds", above=0.0),
    "sigma_mm": settings_tables.number("mm", above=0.0),
    "sigma_deg": settings_tables.number("degrees", above=0.0),
    "confidence": settings_tables.number("", least=0.0, most=1.0),
    "within": settings_tables.number("mm", above=0.0),
}


def seen_of(said: Mapping[str, Any], path: str | None) -> SeenSettings:
    """From the values of KEYS that are there. path: of the file that says them."""
    trust = {key: value for key, value in said.items() if key not in ("ask", "found")}
    found = str(FilePath(path or "").parent / said["found"]) if "found" in said else ""
    return SeenSettings(said.get("ask"), Trust(**trust), found)
