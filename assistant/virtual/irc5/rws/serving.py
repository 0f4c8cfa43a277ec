"""The servers of both dialects, put together."""

from __future__ import annotations

from pathlib import Path as FilePath

from assistant.virtual.irc5.cabinet import Cabinet
from assistant.virtual.irc5.rws.certificate import certify
from assistant.virtual.irc5.rws.faults import Faults
from assistant.virtual.irc5.rws.http import Server, Site
from assistant.virtual.irc5.rws.service import Service
from assistant.virtual.irc5.rws.sessions import Sessions


def make_service(cabinet: Cabinet, user: str, password: str) -> Service:
    """What both servers share."""
    return Service(cabinet, Sessions(user, password))


def make_server(
    dialect: int,
    place: tuple[str, int],
    service: Service,
    faults: Faults,
    certificate: FilePath | None,
) -> Server:
    """Not started yet. certificate: the file that is made for an encrypted one, None for plain.

    Raises OSError for the port.
    """
    secure = None if certificate is None else certify(place[0], certificate)
    site = Site(dialect, service.sessions, service, service.subscriptions.open, faults, secure)
    return Server(place, site)
