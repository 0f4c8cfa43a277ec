"""Verification: compares the programs on a controller with what the last deployment left there."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import field
from pathlib import Path as FilePath

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, has_errors
from assistant.base.source_text import read_bytes
from assistant.controllers import Address, Programs
from assistant.deploy import rules
from assistant.deploy.history import journals, last_record, place_of, what_was_left
from assistant.deploy.plan import controller_names
from assistant.deploy.record import NOTHING_INSTALLED, Digests, Held, Record, of_another
from assistant.deploy.site import Site, difference_since, of_deployments


class Seen(enum.StrEnum):
    """State of a program on a controller, compared with the last deployment."""

    AS_LEFT = "as deployed"
    CHANGED = "changed"
    GONE = "gone"
    FOREIGN = "not ours"
    """No deployment put it there; this is not a fault."""


@dataclass(frozen=True, slots=True)
class SeenProgram:
    """since: a unified difference from the deployed to the present content, "" if not saved.

    as_built: whether it equals the local file, None without a local file.
    """

    name: str
    seen: Seen
    since: str = field(repr=False, default="")
    as_built: bool | None = None


@dataclass(frozen=True, slots=True)
class Verified:
    """Content of a controller. record: of the last deployment, None if unknown."""

    address: Address
    record: Record | None
    programs: tuple[SeenProgram, ...]
    findings: tuple[Diagnostic, ...] = ()

    @property
    def ok(self) -> bool:
        """True if all deployed programs are unchanged, and equal the local files that were
        given.
        """
        fine = (Seen.AS_LEFT, Seen.FOREIGN)
        same = all(p.seen in fine and p.as_built is not False for p in self.programs)
        return same and self.record is not None and not has_errors(self.findings)


def verify(
    controller: Programs,
    files: Sequence[str | FilePath] = (),
    *,
    history: str | FilePath | None = None,
) -> Verified:
    """Compare the content of a controller with the record of the last deployment; change nothing.

    files: local programs, which are compared as well. history: see `history.place_of`. Raises
    Refused and Unreadable.
    """
    data = {str(file): read_bytes(file) for file in files}
    names = controller_names(list(data), controller)
    built = {names[path].lower(): (names[path], data[path]) for path in data}
    with Site(controller) as site:
        record, told = last_record(site, history)
        stranger = of_another(site.identity(), record)
        # The record came with the disk of another controller: its programs count as foreign.
        if stranger is not None:
            record, told = None, (*told, stranger)
        there = [name for name in site.controller.names() if not of_deployments(name)]
        looking = _Verification(site, record, history, built)
        left = {} if record is None else dict(record.programs)
        ours = [looking.at(name, digests) for name, digests in left.items()]
        known = {name.lower() for name in left}
        others = [looking.other(name) for name in there if name.lower() not in known]
        seen = known | {name.lower() for name in there}
        missing = [name for lower, (name, _) in built.items() if lower not in seen]
        found = [*told]
    found += [
        rules.STILL_OPEN(place=str(one.folder), name=one.record.name)
        for one in journals(place_of(controller.address, history))
        if one.open
    ]
    if record is None:
        found.append(rules.NO_RECORD(place=str(controller.address)))
    gone = [SeenProgram(name, Seen.GONE, as_built=False) for name in missing]
    return Verified(controller.address, record, (*ours, *gone, *others), tuple(found))


@dataclass(frozen=True, slots=True)
class _Verification:
    site: Site
    record: Record | None
    history: str | FilePath | None
    built: dict[str, tuple[str, bytes]]

    def at(self, name: str, digests: Digests) -> SeenProgram:
        """One of ours."""
        assert self.record is not None
        left = what_was_left(self.site, self.record, name, self.history)
        self.site.task = digests.task or self.record.task
        now = self.site.held(name, None if left is None else left.file)
        as_built = self._as_built(name, now)
        if now == NOTHING_INSTALLED:
            return SeenProgram(name, Seen.GONE, as_built=as_built)
        if self.site.digests(now) == digests:
            return SeenProgram(name, Seen.AS_LEFT, as_built=as_built)
        return SeenProgram(
            name, Seen.CHANGED, difference_since(self.site, name, left, now), as_built
        )

    def other(self, name: str) -> SeenProgram:
        given = name.lower() in self.built
        as_built = self._as_built(name, self.site.held(name)) if given else None
        return SeenProgram(name, Seen.FOREIGN, as_built=as_built)

    def _as_built(self, name: str, now: Held) -> bool | None:
        if name.lower() not in self.built:
            return None
        _, data = self.built[name.lower()]
        wanted = Held(data, None if now.loaded is None else data)
        return self.site.same(now, wanted)
