"""One deployment at a time: a lock on this computer and, on a disk, one for all computers."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path as FilePath
from typing import Final

from assistant.deploy import rules
from assistant.deploy.record import Record
from assistant.deploy.site import CLAIM, CLAIMANT, Site
from assistant.program.diagnostics import Refused

LOCK: Final = "lock"


@contextmanager
def alone_here(place: FilePath) -> Iterator[None]:
    """While no other process of this computer deploys to the controller of a folder.

    The system frees the lock when the process dies. Raises Refused.
    """
    from filelock import FileLock, Timeout

    try:
        place.mkdir(parents=True, exist_ok=True)
        lock = FileLock(place / LOCK, timeout=0)
        lock.acquire()
    except Timeout:
        raise Refused(rules.BUSY_HERE(place=str(place))) from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise Refused(rules.NO_HISTORY(folder=place, reason=reason, path=str(place))) from None
    try:
        yield
    finally:
        lock.release()


def claim(site: Site, record: Record, *, anyway: bool = False) -> None:
    """Keeps other computers off the controller; raises Refused if one is there.

    anyway: whether a claim that is there is taken over, which a dead process may have left.
    """
    if site.disk is None:
        return
    if not site.disk.claim(CLAIM):
        name, who, time = claimant(site)
        if not anyway and name != record.name:
            raise Refused(rules.BUSY_THERE(place=str(site.address), who=who, time=time, name=name))
    content = {"deployment": record.name, "who": record.who, "time": record.time}
    site.controller.write(CLAIMANT, json.dumps(content).encode())


def claimant(site: Site) -> tuple[str, str, str]:
    """Name of the deployment that holds the controller, who began it, and when."""
    data = site.controller.read(CLAIMANT)
    with suppress(ValueError, KeyError, TypeError):
        content = json.loads((data or b"")[:10_000])
        return tuple(str(content[key])[:200] for key in ("deployment", "who", "time"))  # type: ignore[return-value]
    return "", "somebody", "an unknown time"


def unclaim(site: Site) -> None:
    """Lets others deploy again."""
    if site.disk is not None:
        site.controller.remove(CLAIMANT)
        site.disk.release(CLAIM)
