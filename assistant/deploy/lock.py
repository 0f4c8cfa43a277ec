"""Lock of a controller: one deployment at a time, from this computer or any other.

A file lock on this computer and, on a controller with a disk, a folder there.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path as FilePath
from typing import Final

from assistant.base import file_access
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.controllers.rules import Lost
from assistant.deploy import rules
from assistant.deploy.history import report_file_errors
from assistant.deploy.record import Record, plain_text
from assistant.deploy.site import BETWEEN, CLAIM, CLAIMANT, Site

_LOCK_FILE: Final = "lock"


@contextmanager
def lock_on_this_computer(place: FilePath) -> Iterator[None]:
    """While no other process of this computer deploys to the controller of a folder.

    The system frees the lock when the process dies. Raises Refused.
    """
    from filelock import FileLock, Timeout

    with report_file_errors(place):
        file_access.make_folders(place)
        lock = FileLock(place / _LOCK_FILE, timeout=0)
        try:
            lock.acquire()
        except Timeout:  # which is an OSError
            raise Refused(rules.BUSY_HERE(place=str(place))) from None
        except NotImplementedError:
            raise ValueError("no file can be locked there") from None
    try:
        yield
    finally:
        lock.release()


@dataclass(frozen=True, slots=True)
class Holder:
    """Who holds a controller. name: of the deployment, "" if that is not known."""

    name: str = ""
    who: str = "somebody"
    time: str = "an unknown time"


def claim(site: Site, record: Record, patience: float) -> None:
    """Keeps other computers off the controller; raises Refused if one is there."""
    if site.disk is None:
        return
    if not site.disk.claim(CLAIM):
        one = holder(site)
        # The claim of this very deployment: `--resume` goes on with it.
        if one.name != record.name:
            there = str(site.address)
            raise Refused(rules.BUSY_THERE(place=there, who=one.who, time=one.time, name=one.name))
    content = {"deployment": record.name, "who": record.who, "time": record.time}
    try:
        site.controller.write(CLAIMANT, json.dumps(content).encode())
    except Refused as refusal:
        with suppress(Refused):  # nobody would know whose it is
            free = partial(unclaim, site, record.name)
            site.insist(free, patience, connected=not isinstance(refusal, Lost))
        raise


def holder(site: Site) -> Holder:
    """Who says that he holds the controller."""
    data = site.controller.read(CLAIMANT)
    try:
        content = json.loads((data or b"")[:10_000])
        return Holder(
            *(plain_text(str(content[key])[:200]) for key in ("deployment", "who", "time"))
        )
    except (ValueError, KeyError, TypeError, RecursionError):
        return Holder()


def check_claim(site: Site, record: Record) -> None:
    """Raise Refused if another user freed the controller, taking this deployment for dead."""
    if site.disk is not None and holder(site).name != record.name:
        raise Refused(rules.CLAIM_GONE(place=str(site.address)))


def unclaim(site: Site, name: str) -> None:
    """Let others deploy again. name: of the deployment that held the controller.

    The folder is removed first, in one step: after an interruption the claim still has a known
    owner, or no longer exists.
    """
    if site.disk is not None:
        site.disk.release(CLAIM)
        # Unless another deployment has written its name in between.
        if holder(site).name in ("", name):
            site.controller.remove(CLAIMANT)


def held_by(site: Site) -> Holder | None:
    """Who holds the controller, None if nobody does.

    Who has just come has a moment to say so.
    """
    if site.disk is None:
        return None
    one = holder(site)
    # The claim is free if it can be taken: then it is given back at once.
    if site.disk.claim(CLAIM):
        unclaim(site, one.name)
        return None
    # The folder comes before the name: its owner may be about to write it.
    if not one.name:
        time.sleep(min(BETWEEN, site.patience))
        one = holder(site)
    return one
