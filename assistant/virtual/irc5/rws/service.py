"""What answers all requests: the resources, subscriptions, and the end of a session."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from assistant.virtual.irc5.cabinet import MASTERSHIP_DOMAINS, Cabinet
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import Answer, Rejected
from assistant.virtual.irc5.rws.paths import find_route, make_route
from assistant.virtual.irc5.rws.request import Request
from assistant.virtual.irc5.rws.routes import serve_resource
from assistant.virtual.irc5.rws.sessions import Session, Sessions
from assistant.virtual.irc5.rws.subscriptions import Subscriptions


class Service:
    """Of one cabinet; both dialects share it."""

    def __init__(self, cabinet: Cabinet, sessions: Sessions) -> None:
        self.cabinet, self.sessions = cabinet, sessions
        self.subscriptions = Subscriptions(cabinet)
        sessions.ended.append(self._ended)

    def __call__(self, request: Request) -> Answer:
        found = find_route(OWN_ROUTES[request.dialect], request)
        try:
            if isinstance(found, Rejected):
                return serve_resource(self.cabinet, request)
            row, captures = found
            return row.handler(self, replace(request, captures=captures))
        except (RuntimeError, TimeoutError):  # It is being switched off, or overwhelmed.
            raise Rejected(reasons.UNSPECIFIED, "the controller has no time") from None

    def _ended(self, session: Session) -> None:
        """What it held is given back."""
        self.cabinet.mastership.give_back(MASTERSHIP_DOMAINS, session.key)
        self.subscriptions.end_session(session.key)


def _log_out(service: Service, request: Request) -> Answer:
    service.sessions.end(request.session)
    return Answer(200 if request.dialect == 1 else 204)


OwnHandler = Callable[[Service, Request], Answer]
_BOTH: Final[tuple[tuple[str, str, OwnHandler], ...]] = (
    ("GET", "/logout", _log_out),
    ("POST", "/subscription", lambda service, request: service.subscriptions.create(request)),
    (
        "DELETE",
        "/subscription/{group}",
        lambda service, request: service.subscriptions.delete(request),
    ),
)
_TWO: Final[tuple[tuple[str, str, OwnHandler], ...]] = (
    ("PUT", "/subscription/{group}", lambda service, request: service.subscriptions.add(request)),
    (
        "DELETE",
        "/subscription/{group}/{resource...}",
        lambda service, request: service.subscriptions.delete(request),
    ),
)
OWN_ROUTES: Final = {
    1: tuple(make_route(*row) for row in _BOTH),
    2: tuple(make_route(*row) for row in (*_BOTH, *_TWO)),
}
