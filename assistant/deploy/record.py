"""Record of a deployment: who installed which programs on which controller, with their digests.

A controller that has a disk keeps the last record beside its programs; every record is in the
history of the computer that deployed. A digest of the record itself reveals one that was changed or
cut. `check_meant` and `check_same` refuse a controller other than that of the project, the plan or
the record.
"""

from __future__ import annotations

import getpass
import hashlib
import json
import re
import secrets
import socket
from collections.abc import Iterable, Mapping
from dataclasses import asdict, field
from datetime import UTC, datetime
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers.states import Identity
from assistant.deploy import rules
from assistant.deploy.repository import commit_of


@dataclass(frozen=True, slots=True)
class Held:
    """A program on a controller.

    file: its bytes, None if it is not there. loaded: the module in memory with what was taught
    since, None if it is not loaded or the controller has no such memory.
    """

    file: bytes | None = field(default=None, repr=False)
    loaded: bytes | None = field(default=None, repr=False)


NOTHING_INSTALLED: Final = Held()


@dataclass(frozen=True, slots=True)
class Digests:
    """SHA-256 of a `Held`, of the forms that are compared; None for what is not there.

    task: in whose memory the module is, "" if it is in none.
    """

    file: str | None = None
    loaded: str | None = None
    task: str = ""


def digest(data: bytes | None) -> str | None:
    return None if data is None else hashlib.sha256(data).hexdigest()


_FORMAT: Final = 1
PROGRAM_NAME: Final = re.compile(r"[A-Za-z0-9_][\w. ~-]{0,70}(?<![ .~])", re.ASCII)
"""Name of a program; also valid for a file of this computer."""
DIGEST: Final = re.compile("[0-9a-f]{64}")
_LONGEST_TEXT: Final = 1000
"""Characters of a text in it."""
LONGEST_RECORD: Final = 1_000_000
"""Bytes of a record that are read at most."""


@dataclass(frozen=True, slots=True)
class Record:
    """Record of the content that a deployment left on a controller.

    name: of the deployment, in the order of time. commit: of the project's repository, "" without
    one. programs: all deployed programs there, including those of earlier deployments. robot,
    controller, serial: as the controller reported, "" if it did not report them.
    """

    name: str
    address: str
    time: str
    who: str
    commit: str = ""
    robot: str = ""
    controller: str = ""
    serial: str = ""
    task: str = ""
    programs: Mapping[str, Digests] = field(default_factory=dict)

    def written(self) -> bytes:
        """Return the record as JSON, with the digest of all the rest."""
        content = {"format": _FORMAT, **asdict(self)}
        return _text({**content, "digest": _digest(content)}).encode()


def new_record(address: str, identity: Identity | None, task: str = "") -> Record:
    """A record that begins now and here; without programs."""
    now = datetime.now(UTC)
    told = identity or Identity()
    return Record(
        f"{now:%Y%m%dT%H%M%SZ}-{secrets.token_hex(3)}",
        address,
        now.isoformat(timespec="seconds"),
        plain_text(f"{_user()}@{socket.gethostname()}"),
        commit_of(FilePath()),
        plain_text(told.robot),
        plain_text(told.controller),
        plain_text(told.serial),
        task,
    )


def plain_text(text: str) -> str:
    """Return external text, shortened and without characters that control a terminal."""
    return "".join(c if c.isprintable() else "?" for c in text[:_LONGEST_TEXT])


def read_record(data: bytes, place: str) -> Record:
    """The record of a file; raises Refused if it is damaged."""
    try:
        if len(data) > LONGEST_RECORD:
            raise ValueError("it is too long")
        content = json.loads(data)
        # Taken out before the comparison: the digest covers all the rest.
        told = content.pop("digest")
        if content.get("format") != _FORMAT:
            raise ValueError("it is of another version of this program")
        if told != _digest(content):
            raise ValueError("it was changed after it was written")
        del content["format"]
        programs = {name: Digests(**two) for name, two in content.pop("programs").items()}
        _check_texts(content.values(), programs)
        return Record(**content, programs=programs)
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        reason = str(error) if isinstance(error, ValueError) else "it is none"
        raise Refused(rules.BAD_RECORD(place=place, name=place, reason=reason)) from None


def _check_texts(texts: Iterable[str], programs: Mapping[str, Digests]) -> None:
    """Raises ValueError for what no deployment writes: anybody can work out a digest that fits."""
    if not all(isinstance(text, str) and plain_text(text) == text for text in texts):
        raise ValueError("it holds characters that no deployment writes")
    for name, two in programs.items():
        digests = [one for one in (two.file, two.loaded) if one is not None]
        named = PROGRAM_NAME.fullmatch(name) is not None and plain_text(two.task) == two.task
        if not named or not all(map(DIGEST.fullmatch, digests)):
            raise ValueError("it names programs as no deployment does")


def _user() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError):  # a container may have no name for its user
        return "somebody"


def _text(content: Mapping[str, Any]) -> str:
    # Sorted and indented: the digest is of this very text.
    return json.dumps(content, indent=2, sort_keys=True) + "\n"


def _digest(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(_text(content).encode()).hexdigest()


_NAME_WORD: Final = re.compile(r"\d+(?:\.\d+)?|[a-z]+")
_CLOSE_FIGURES: Final = 0.05
"""Greatest difference between two figures of a robot's name: a reach of 0.58 m is also written as
0.6.
"""


def check_meant(identity: Identity | None, meant: Identity, place: str) -> tuple[Diagnostic, ...]:
    """Refuse a controller other than the one of the project, by serial number and robot.

    Returns a warning if the controller does not report its serial number. Many projects name the
    robot only to compile for it: an unreported one is ignored.
    """
    told = identity or Identity()
    refused: list[Diagnostic] = []
    if _is_model(told.robot) and meant.robot and not _same_robot(meant.robot, told.robot):
        refused.append(
            rules.NOT_MEANT(place=place, what="the robot", wanted=meant.robot, told=told.robot)
        )
    what, wanted, there = "the serial number", meant.serial.strip(), told.serial.strip()
    # Serial numbers are written in either case.
    if wanted and there and wanted.casefold() != there.casefold():
        refused.append(rules.NOT_MEANT(place=place, what=what, wanted=wanted, told=there))
    if refused:
        raise Refused(*refused)
    return (rules.UNTOLD(place=place, what=what, wanted=wanted),) if wanted and not there else ()


def check_same(identity: Identity | None, record: Record, place: str) -> None:
    """Refuse a controller other than that of a deployment, as far as both identities are known."""
    if _other(identity, record) is not None:
        raise Refused(rules.ANOTHER(place=place))


def of_another(identity: Identity | None, record: Record | None) -> Diagnostic | None:
    """Return the warning that a record came to this controller from another one, with its files."""
    other = None if record is None else _other(identity, record)
    if record is None or other is None:
        return None
    now, then = other
    return rules.OF_ANOTHER(place=record.name, name=record.name, now=now, then=then)


def _other(identity: Identity | None, record: Record) -> tuple[str, str] | None:
    """Return the first identity field that differs from a record, as (now, then); skip empty
    ones.
    """
    told = identity or Identity()
    pairs = (
        (plain_text(told.robot), record.robot),
        (plain_text(told.controller), record.controller),
        (plain_text(told.serial), record.serial),
    )
    return next(((now, then) for now, then in pairs if now and then and now != then), None)


def _same_robot(one: str, other: str) -> bool:
    """True if two names denote the same robot: `irb1200-7-0.7` is `IRB 1200-7/0.7`.

    The shorter name may lack additions of the other: the maker, a cable or a colour.
    """
    shorter, longer = sorted((_name_words(one), _name_words(other)), key=len)
    left = list(longer)
    for word in shorter:
        found = next((there for there in left if _similar_words(word, there)), None)
        if found is None:
            return False
        # Each word counts once: `6-6` needs two sixes.
        left.remove(found)
    return True


def _is_model(name: str) -> bool:
    """True if the name is a maker's model, with letters and figures."""
    words = _name_words(name)
    return any(map(str.isalpha, words)) and not all(map(str.isalpha, words))


def _name_words(name: str) -> list[str]:
    return _NAME_WORD.findall(name.lower())


def _similar_words(one: str, other: str) -> bool:
    if "." in one and "." in other:
        return abs(float(one) - float(other)) < _CLOSE_FIGURES
    return one == other
