"""What a deployment would do to one program: what is there, whose it is, and what differs."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path as FilePath
from typing import Final

from assistant import languages
from assistant.base.diagnostics import Diagnostic
from assistant.deploy import rules
from assistant.deploy.comparing import module_difference
from assistant.deploy.differences import difference, difference_since
from assistant.deploy.held import NOTHING_INSTALLED, Held
from assistant.deploy.merging import merged, says_the_same
from assistant.deploy.planned import Change, PlannedFile
from assistant.deploy.record import Record
from assistant.deploy.remembering import what_was_left
from assistant.deploy.site import Site

EVERY: Final = "*"
"""In place of the names of programs: all of them."""


class Classifier:
    """Judges programs by what a controller has of them. notes: whose they were found to be."""

    def __init__(
        self,
        site: Site,
        record: Record | None,
        load: bool,
        replace: Collection[str],
        history: str | FilePath | None,
    ) -> None:
        self.site, self.load, self.history = site, load, history
        self.replace = {name.lower() for name in replace}
        programs = record.programs if record else {}
        self.known = {name.lower(): left for name, left in programs.items()}
        self.record = record
        self.notes: list[Diagnostic] = []

    def at(
        self, path: str, name: str, data: bytes, findings: tuple[Diagnostic, ...]
    ) -> PlannedFile:
        before = self.site.held(name, data)
        loads = self.site.memory is not None and not self.site.is_list(name)
        in_memory = loads and (self.load or before.loaded is not None)
        after = Held(data, data if in_memory else None)
        now, wanted = self.site.forms(before), self.site.forms(after)
        reason = (
            "" if before == NOTHING_INSTALLED or now == wanted else self._not_ours(name, before)
        )
        left = None
        if reason and self.record is not None:
            left = what_was_left(self.site, self.record, name, self.history)
        change = self._change(name, before, after, reason, left)
        diff = taught = ""
        if change is not Change.SAME:
            labels = (f"{name} (on the controller)", f"{name} (to be sent)")
            diff = difference(now.file, wanted.file, *labels)
        if before.loaded is not None:
            labels = (f"{name} (its file)", f"{name} (in memory)")
            file = before.file if before.file is not None else data
            taught = module_difference(file, before.loaded, self.site.language, labels)
        return PlannedFile(
            path,
            name,
            change,
            data,
            before,
            after,
            diff,
            taught,
            findings,
            reason,
            left,
            difference_since(self.site, name, left, before),
        )

    def _change(
        self, name: str, before: Held, after: Held, reason: str, left: Held | None
    ) -> Change:
        if self.site.same(before, after):
            return Change.SAME
        if before == NOTHING_INSTALLED:
            return Change.NEW
        if not reason:
            return Change.CHANGED
        if left is not None and self._brought_home(left, before, after):
            self.notes.append(rules.BROUGHT_HOME(place=name, name=name, reason=reason))
            return Change.CHANGED
        if self.replace & {EVERY, name.lower()}:
            self.notes.append(rules.REPLACED(place=name, name=name, reason=reason))
            return Change.CHANGED
        self.notes.append(rules.CONFLICT(place=name, name=name, reason=reason))
        return Change.CONFLICT

    def _not_ours(self, name: str, before: Held) -> str:
        """Why a program is not what a deployment left there, "" if it is."""
        left = self.known.get(name.lower())
        if left is None or self.record is None:
            return "it was not put there by a deployment that is known here"
        there = self.site.digests(before)
        since = f"since the deployment `{self.record.name}` of {self.record.who}"
        if there.file != left.file:
            return f"its file was changed {since}"
        if there.loaded and left.task and left.task != self.site.task:
            return f"it was last deployed to `{left.task}`, not to the memory of `{self.site.task}`"
        if there.loaded != left.loaded:
            return f"its module in memory was changed {since}"
        return ""

    def _brought_home(self, left: Held, before: Held, after: Held) -> bool:
        """Whether what is sent has all that was changed there since.

        It is so after the change was brought home, whoever did it, on whichever computer.
        """
        forms = [self.site.forms(held) for held in (left, before)]
        files = (left.file, before.file, after.file, self.site.controller.stored, "")
        mark = languages.get(self.site.language).comment_mark  # a memory may not keep comments
        loaded = (left.loaded, before.loaded, after.loaded, self.site.in_memory, mark)
        for same, (base, there, sent, form, comment) in (
            (forms[0].file == forms[1].file, files),
            (forms[0].loaded == forms[1].loaded, loaded),
        ):
            if same:
                continue
            if base is None or there is None or sent is None:
                return False
            both = merged(base, sent, there, form, comment)
            if both is None or not says_the_same(both, sent, form, comment):
                return False
        return True
