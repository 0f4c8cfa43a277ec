"""Read a file of the objects that were found, and check how far their poses are trusted.

    [found.bracket]
    position = [312.4, -20.1, 15.0]     # mm
    quaternion = [0.966, 0, 0, 0.259]   # w, x, y, z
    sigma_mm = 0.2                      # one standard deviation
    sigma_deg = 0.1
    confidence = 0.97                   # 0 to 1, that it is this object
    seen = 2026-01-31T13:01:30+01:00    # without an offset: in the time of this computer
    frame = "base"                      # of the robot; or "world", of the cell

Other keys are ignored.
"""

from __future__ import annotations

import datetime
from collections.abc import Iterator, Mapping
from dataclasses import field
from functools import cache
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final, Literal

from assistant.base.budgets import SETTINGS_FILE
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors
from assistant.base.source_text import decode, read_bytes
from assistant.program.geometry import Pose
from assistant.sources.seen_settings import (
    DEFAULT_TRUST,
    NO_SEEN_SETTINGS,
    PoseServer,
    SeenSettings,
    Trust,
)

if TYPE_CHECKING:
    from assistant.program.settings_tables import Read, Table

_NOTHING_FOUND: Final = error(
    "SR010",
    "the file says of nothing where it was found",
    "give the file that `robot-assistant see` writes, with a table [found.NAME] for each object",
)
_NOT_SAID: Final = error(
    "SR011", "of `{name}` the file does not say {keys}", "write them, or look for it anew"
)
_TOO_OLD: Final = error(
    "SR012",
    "`{name}` was seen {age} ago, and counts for {most} only",
    "look anew, or allow more seconds by `oldest` under [seen] in the process file",
)
_FROM_LATER: Final = error(
    "SR013",
    "`{name}` was seen {age} from now, says the file",
    "set the clocks of both computers, and look anew",
)
_UNSURE: Final = error(
    "SR014",
    "where `{name}` is, is known to {sigma:g} {unit} only (one standard deviation), and may be "
    "unsure by {most:g} {unit}",
    "look from nearer or with another camera, or allow more by `{key}` under [seen] in the process "
    "file",
)
_HARDLY_IT: Final = error(
    "SR015",
    "that it is `{name}` is believed with {confidence:g}, and {least:g} is the least",
    "look anew with better light, or allow less by `confidence` under [seen] in the process file",
)
_NO_ADDRESS: Final = error("SR016", "the place where the program asks {what}", "{cure}")
QUESTION: Final = "see"
"""The word before the name of an object, in what a program asks as it runs."""
FOUND: Final = 1
NOT_THERE: Final = 0
DOUBTFUL: Final = 2
"""The first of the seven numbers in the answer; x, y, z and the degrees about x, y and z of R =
Rz·Ry·Rx follow, in the robot's base, each on a separate line.
"""
_CLOCKS: Final = 2.0
"""Seconds by which the clocks of two computers may differ."""


@dataclass(frozen=True, slots=True)
class Sight:
    """An object where it was found.

    pose: in `frame`, mm. sigma_mm, sigma_deg: one standard deviation of its place and turn.
    confidence: 0 to 1, that it is this object. seen: when, with its time zone.
    frame: the robot's base, or the world of the cell.
    """

    name: str
    pose: Pose
    sigma_mm: float
    sigma_deg: float
    confidence: float
    seen: datetime.datetime
    frame: Literal["base", "world"] = "base"


@dataclass(frozen=True, slots=True)
class Seeing:
    """Sources of the poses of frames that are seen.

    found: the objects that were found, by name; None if no file is named. ask: the server that the
    program asks as it runs. trust: limits of trust in sights.
    """

    found: Mapping[str, Sight] | None = field(default=None, hash=False)
    ask: PoseServer | None = None
    trust: Trust = DEFAULT_TRUST

    def beside(self, stated: SeenSettings) -> Seeing:
        """Add the settings of a process file for all values that are not set.

        Raises Unreadable or Refused for the file of found objects that it names.
        """
        if stated == NO_SEEN_SETTINGS:
            return self
        found = read_sights(stated.found) if stated.found and self.found is None else self.found
        return Seeing(found, self.ask or stated.ask, stated.trust)


NOTHING_SEEN: Final = Seeing()


def seeing(found: str | FilePath | None = None, ask: str | None = None) -> Seeing:
    """Return the objects found in a file, and the server that a program asks; raises Unreadable or
    Refused.
    """
    asked = None
    if ask is not None:
        from assistant.program.settings_tables import Wrong

        try:
            asked = PoseServer.parse(ask)
        except Wrong as wrong:
            raise Refused(_NO_ADDRESS(what=wrong.what, cure=wrong.cure), exit_status=2) from None
    return Seeing(None if found is None else read_sights(found), asked)


def read_sights(path: str | FilePath) -> Mapping[str, Sight]:
    """Read the objects found in a file, by their names.

    Raises Unreadable if it is not TOML, Refused, with every finding, if the content has errors.
    """
    from assistant.program.settings_tables import ENCODINGS, read_toml

    source = decode(read_bytes(path, most=SETTINGS_FILE), str(path), ENCODINGS)
    top = read_toml(source)
    tables = list(top.table("found").named(identifiers=False))
    if not tables:
        top.say(_NOTHING_FOUND)
    read = [(name, _sight(name, table)) for name, table in tables]
    if has_errors(top.page.findings):
        raise Refused(*top.page.findings, exit_status=2)
    return {name: sight for name, sight in read if sight is not None}


def doubts(
    sight: Sight, trust: Trust = DEFAULT_TRUST, now: datetime.datetime | None = None
) -> Iterator[Diagnostic]:
    """Why a sight is not to be trusted with a robot; nothing for one that is."""
    now = now or datetime.datetime.now(datetime.UTC)
    age = (now - sight.seen).total_seconds()
    if age > trust.oldest:
        yield _TOO_OLD(name=sight.name, age=_spoken(age), most=_spoken(trust.oldest))
    if age < -_CLOCKS:
        yield _FROM_LATER(name=sight.name, age=_spoken(-age))
    for key, unit in (("sigma_mm", "mm"), ("sigma_deg", "degrees")):
        sigma, most = getattr(sight, key), getattr(trust, key)
        if not sigma <= most:
            yield _UNSURE(name=sight.name, sigma=sigma, most=most, unit=unit, key=key)
    if not sight.confidence >= trust.confidence:
        told, least = sight.confidence, trust.confidence
        yield _HARDLY_IT(name=sight.name, confidence=told, least=least)


def _spoken(seconds: float) -> str:
    for unit, length in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2.0 * length:
            return f"{seconds / length:.3g} {unit}"
    return f"{seconds:.3g} seconds"


def _moment(value: Any) -> datetime.datetime:
    """A date with its time, as TOML has it or as ISO 8601 text."""
    from assistant.program.settings_tables import Wrong, kind_of, shown

    if isinstance(value, str):
        try:
            value = datetime.datetime.fromisoformat(value)
        except ValueError:
            raise Wrong(f'is "{shown(value)}"', "write it as 2026-01-31T13:01:30Z") from None
    if not isinstance(value, datetime.datetime):
        raise Wrong(f"is {kind_of(value)}", "write a date with its time, as 2026-01-31T13:01:30Z")
    try:
        return value.astimezone(datetime.UTC)
    except (OverflowError, OSError, ValueError):
        raise Wrong("is out of range", "write it as 2026-01-31T13:01:30Z") from None


_OPEN: Final = ("frame",)


@cache
def _keys() -> Mapping[str, Read]:
    from assistant.program.settings_tables import choice, number, position, quaternion

    return {
        "position": position,
        "quaternion": quaternion,
        "sigma_mm": number("mm", least=0.0),
        "sigma_deg": number("degrees", least=0.0),
        "confidence": number("", least=0.0, most=1.0),
        "seen": _moment,
        "frame": choice("base", "world"),
    }


def _sight(name: str, table: Table) -> Sight | None:
    """None with a finding where the table is wrong."""
    from assistant.program.settings_tables import EXACT_LENGTH, REPAIRED, Table, listed, shown

    keys = _keys()
    known = {key: value for key, value in table.content.items() if key in keys}
    found = Table(table.page, table.path, known).read(keys)
    lacking = [key for key in keys if key not in known and key not in _OPEN]
    if lacking:
        table.say(_NOT_SAID, name=shown(name), keys=listed(lacking))
    if lacking or len(found) < len(known):
        return None
    turn, length = found.pop("quaternion")
    if abs(length - 1.0) > EXACT_LENGTH:
        table.say(REPAIRED, "quaternion", key="quaternion", length=length)
    return Sight(name, Pose(found.pop("position"), turn), **found)
