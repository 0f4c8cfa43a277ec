"""A plan: what a deployment would do to each program, with the differences."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field

from assistant.base.diagnostics import Diagnostic
from assistant.controllers import Address
from assistant.controllers.states import Identity
from assistant.deploy import rules
from assistant.deploy.held import Held
from assistant.deploy.journal import Entry
from assistant.deploy.record import Record
from assistant.deploy.site import Site


class Change(enum.StrEnum):
    """What a deployment does to one program on the controller."""

    NEW = "create"
    CHANGED = "replace"
    SAME = "unchanged"
    CONFLICT = "conflict"
    """It is not what a deployment left there: nothing is done before somebody decides."""


@dataclass(frozen=True, slots=True)
class PlannedFile:
    """A program to install.

    path: the local file. name: on the controller. data: what is sent. before: what the
    controller has. after: what it is to have. reason: why it is a conflict, or was one. left:
    what the last deployment left there, None if nobody knows; looked for only then. Unified
    differences: diff from its file to what is sent, taught from what was loaded to what is in
    memory now, since from what the last deployment left to what is there now, "" each if there is
    none. findings: of the language's parser, no errors among them.
    """

    path: str
    name: str
    change: Change
    data: bytes = field(repr=False)
    before: Held
    after: Held
    diff: str = field(repr=False, default="")
    taught: str = field(repr=False, default="")
    findings: tuple[Diagnostic, ...] = ()
    reason: str = ""
    left: Held | None = None
    since: str = field(repr=False, default="")

    @property
    def entry(self) -> Entry:
        return Entry(self.name, self.before, self.after)


@dataclass(frozen=True, slots=True)
class Plan:
    """What a deployment would do; nothing has been changed yet.

    identity: of the controller, None where the session cannot tell. record: of the last
    deployment, None if none is known. foreign: what is there and not ours; never touched. left:
    ours of an earlier deployment, and not planned any more; not touched either.
    """

    address: Address
    files: tuple[PlannedFile, ...]
    site: Site = field(repr=False, compare=False)
    identity: Identity | None = None
    record: Record | None = None
    foreign: tuple[str, ...] = ()
    left: tuple[str, ...] = ()
    notes: tuple[Diagnostic, ...] = ()

    @property
    def changes(self) -> tuple[PlannedFile, ...]:
        """The files that would be written."""
        return tuple(f for f in self.files if f.change in (Change.NEW, Change.CHANGED))

    @property
    def conflicts(self) -> tuple[PlannedFile, ...]:
        return tuple(file for file in self.files if file.change is Change.CONFLICT)

    @property
    def unrecorded(self) -> bool:
        """Whether programs are there as they are sent, but the last record does not say so.

        Somebody put them there by hand, or what was changed there was brought home. Of a controller
        that keeps no record it counts only once it has been deployed to from here.
        """
        if self.record is None and self.site.disk is None:
            return False
        known = {} if self.record is None else self.record.programs
        left = {name.lower(): digests for name, digests in known.items()}
        return any(
            file.change is Change.SAME
            and left.get(file.name.lower()) != self.site.digests(file.after)
            for file in self.files
        )

    @property
    def unseen(self) -> tuple[Diagnostic, ...]:
        """A warning for each program that may have been taught something which is not seen."""
        if not self.site.blind:
            return ()
        there = [f for f in self.files if f.change in (Change.CHANGED, Change.CONFLICT)]
        return tuple(rules.UNSEEN(place=file.name, name=file.name) for file in there)

    @property
    def findings(self) -> tuple[Diagnostic, ...]:
        return (*self.notes, *(finding for file in self.files for finding in file.findings))
