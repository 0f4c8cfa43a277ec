"""Which row of a table a request fits."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Generic, TypeVar
from urllib.parse import unquote

from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import Rejected
from assistant.virtual.irc5.rws.request import Request

H = TypeVar("H")
KEPT_CHARACTERS: Final = "/fileservice"
"""Where a path is kept as it was sent: what it encodes may matter."""


@dataclass(frozen=True, slots=True)
class Route(Generic[H]):
    """action: that the query has to name, empty for none. needs: see `routes.Row`."""

    method: str
    pattern: re.Pattern[str]
    action: str
    handler: H
    needs: str


def make_route(method: str, stated: str, handler: H, needs: str = "") -> Route[H]:
    """stated: a path with names in braces, and behind `?` the action."""
    path, _, action = stated.partition("?")
    pattern = ""
    for part in re.split(r"(\{\w+(?:\.\.\.)?\})", path):
        if not part.startswith("{"):
            pattern += re.escape(part)
        elif part.endswith("...}"):
            pattern += f"(?P<{part[1:-4]}>.+)"
        else:
            pattern += f"(?P<{part[1:-1]}>[^/]+)"
    return Route(method, re.compile(pattern), action, handler, needs)


def find_route(
    routes: Sequence[Route[H]], request: Request
) -> tuple[Route[H], dict[str, str]] | Rejected:
    """The first that fits, with what its names stand for; else why there is none."""
    raw = request.path.rstrip("/") or "/"
    path = raw if raw.startswith(KEPT_CHARACTERS) else unquote(raw)
    action = request.query.get("action", request.query.get("resource", ""))
    action = "" if action == "show" else action
    there = False
    for one in routes:
        found = one.pattern.fullmatch(path)
        if found is None or one.action != action:
            continue
        if one.method == request.method:
            return one, found.groupdict()
        there = True
    return Rejected(reasons.NO_METHOD if there else reasons.NO_RESOURCE)
