"""The record of a deployment: who put which programs on which controller, with their digests.

The controller keeps the last one beside its programs if it has a disk; each stands in the history
of the computer that deployed. Its own digest tells a record that was changed or cut.
"""

from __future__ import annotations

import getpass
import hashlib
import json
import re
import secrets
import socket
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.diagnostics import Refused
from assistant.controllers.states import Identity
from assistant.deploy import rules
from assistant.deploy.held import Digests
from assistant.deploy.repository import commit_of

FORMAT: Final = 1
PROGRAM_NAME: Final = re.compile(r"[A-Za-z0-9_][\w. ~-]{0,70}(?<![ .~])", re.ASCII)
"""Of a program; also a file of this computer can have it."""
DIGEST: Final = re.compile("[0-9a-f]{64}")
LONGEST_TEXT: Final = 1000
"""Characters of a text in it."""
LONGEST_RECORD: Final = 1_000_000
"""Bytes of a record that is looked at."""


@dataclass(frozen=True, slots=True)
class Record:
    """What a deployment left on a controller.

    name: of the deployment, in the order of time. commit: of the project's repository, "" where
    there is none. programs: all that are ours there, those of earlier deployments among them.
    robot, controller, serial: as the controller told, "" for what it did not tell.
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
        """As JSON, with the digest of all the rest."""
        content = {"format": FORMAT, **asdict(self)}
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
    """Text from outside without what would steer a terminal, and not too long to be told."""
    return "".join(c if c.isprintable() else "?" for c in text[:LONGEST_TEXT])


def read_record(data: bytes, place: str) -> Record:
    """The record of a file; raises Refused if it is damaged."""
    try:
        if len(data) > LONGEST_RECORD:
            raise ValueError("it is too long")
        content = json.loads(data)
        told = content.pop("digest")
        if content.get("format") != FORMAT:
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
    return json.dumps(content, indent=2, sort_keys=True) + "\n"


def _digest(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(_text(content).encode()).hexdigest()
