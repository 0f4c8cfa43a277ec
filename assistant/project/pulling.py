"""Pulling: what was changed on a controller since the last deployment, brought into the sources.

A program that stands here as it is sent gets the change in its own layout. Of a compiled program
the targets that were taught anew go into its source, by their names: a file of taught targets, or
a pseudo-program. Other sources have no names for them, so they go into what was compiled, which
keeps them when it is compiled again. All changes of a plan are brought home, or none is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Final

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.file_sets import write_all
from assistant.base.source_text import read_bytes
from assistant.deploy import Change, Held, Plan, PlannedFile
from assistant.deploy.repository import is_committed
from assistant.deploy.rules import IN_WRITTEN
from assistant.deploy.site import Site
from assistant.deploy.text_merge import StoredForm, in_layout, merged
from assistant.project import rules
from assistant.project.pulled_targets import SOURCES_WITH_NAMES, changed_targets, with_targets
from assistant.robots import Robot

SAVED_SUFFIX: Final = ".orig"
"""Behind the name of a file that no repository keeps: what it said before."""


@dataclass(frozen=True, slots=True)
class Pulled:
    """What was brought home. sources: what was changed in each file, one after another."""

    sources: Mapping[FilePath, tuple[str, ...]] = field(default_factory=dict)
    findings: tuple[Diagnostic, ...] = ()

    @property
    def ok(self) -> bool:
        return not has_errors(self.findings)


def pull(
    plan: Plan, sources: Mapping[str, FilePath] | None = None, robot: Robot | None = None
) -> Pulled:
    """Brings the conflicts of a plan home; the controller is not touched.

    sources: what each local program was made of, itself where it is missing. robot: of the
    controller. Nothing is raised, and nothing is written if there is an error among the findings.
    """
    run = _Pull(plan.site, robot)
    for file in plan.files:
        if file.change is not Change.CONFLICT:
            continue
        try:
            run.bring(file, (sources or {}).get(file.path, FilePath(file.path)))
        except Refused as refusal:
            run.findings += [finding.within(file.path) for finding in refusal.findings]
    if not run.wanted and not run.findings:
        run.findings.append(rules.NOTHING_THERE(place=str(plan.address)))
    try:
        if not has_errors(run.findings):
            run.check_committed()
        if not has_errors(run.findings):
            write_all(run.wanted)
    except Refused as refusal:
        run.findings += refusal.findings
    done = not has_errors(run.findings)
    told = {path: tuple(run.told[path]) for path in run.told} if done else {}
    return Pulled(told, tuple(run.findings))


@dataclass(slots=True)
class _Pull:
    """wanted: files with what they are to say. told: what is new in each."""

    site: Site
    robot: Robot | None
    wanted: dict[FilePath, bytes] = field(default_factory=dict)
    told: dict[FilePath, list[str]] = field(default_factory=dict)
    findings: list[Diagnostic] = field(default_factory=list)

    def bring(self, file: PlannedFile, source: FilePath) -> None:
        base, there, form = self._sides(file)
        spoken = languages.of_file(file.name, there) or languages.of_file(file.path, file.data)
        if spoken is None or has_errors(spoken.parse(spoken.decode(there)).findings):
            raise Refused(rules.NOT_READ(path=file.path, name=file.name))
        now = self.wanted.get(source) or read_bytes(source)
        if source.suffix.lower() in spoken.suffixes:
            self.wanted[source] = self._as_text(file, base, now, there, form)
            self.told.setdefault(source, []).append(f"`{file.name}` as it is on the controller")
            return
        if source.suffix.lower() not in SOURCES_WITH_NAMES:
            built = FilePath(file.path)
            now = self.wanted.get(built) or read_bytes(built)
            self.wanted[built] = self._as_text(file, base, now, there, form)
            self.told.setdefault(built, []).append(f"`{file.name}` as it is on the controller")
            path, name = file.path, file.name
            self.findings.append(IN_WRITTEN(path=path, file=path, name=name, source=source))
            return
        changes = changed_targets(
            spoken, form(file.data if base is None else base), form(there), file, source, self.robot
        )
        self.wanted[source] = with_targets(source, now, changes, file.name, spoken.precision)
        self.told.setdefault(source, []).extend(f"target `{one.name}`" for one in changes)

    def _sides(self, file: PlannedFile) -> tuple[bytes | None, bytes, StoredForm]:
        """What was left, what is there now, and how the two are compared."""
        left, now = file.left, file.before
        stored, in_memory = self.site.controller.stored, self.site.in_memory
        one = None if left is None else self.site.forms(left)
        other = self.site.forms(now)
        in_file = now.file is not None and (one is None or one.file != other.file)
        loaded = now.loaded is not None and (one is None or one.loaded != other.loaded)
        if in_file and loaded and not self._are_one(now):
            raise Refused(rules.TWO_CHANGES(path=file.path, name=file.name))
        if loaded and now.loaded is not None:
            return (None if left is None else left.loaded or left.file), now.loaded, in_memory
        if now.file is None:
            raise Refused(rules.GONE_THERE(path=file.path, name=file.name))
        return (None if left is None else left.file), now.file, stored

    def _are_one(self, now: Held) -> bool:
        """Whether a module in memory says what its file says."""
        return self.site.forms(Held(None, now.file)) == self.site.forms(Held(None, now.loaded))

    def _as_text(
        self, file: PlannedFile, base: bytes | None, own: bytes, there: bytes, form: StoredForm
    ) -> bytes:
        """Our text with what was changed there."""
        in_memory = there == file.before.loaded and there != file.before.file
        mark = languages.get(self.site.language).comment_mark if in_memory else ""
        if base is not None and form(base) != form(own):
            both = merged(base, own, there, form, mark)
            if both is None:
                raise Refused(rules.BOTH_CHANGED(path=file.path, name=file.name))
            return both
        text = in_layout(own, there, form, mark)
        return text if self._are_same(text, there, file) else there

    def _are_same(self, one: bytes, other: bytes, file: PlannedFile) -> bool:
        """Whether the controller would take two texts for the same, where the change is."""
        if other == file.before.loaded:
            return self.site.same(Held(None, one), Held(None, other))
        return self.site.same(Held(one), Held(other))

    def check_committed(self) -> None:
        """What a repository does not know yet would be lost, so it is said and nothing written."""
        for path in list(self.wanted):
            known = is_committed(path)
            if known is False:
                self.findings.append(rules.NOT_COMMITTED(path=str(path), file=path))
            elif known is None:
                kept = path.with_name(path.name + SAVED_SUFFIX)
                self.wanted[kept] = read_bytes(path)
                self.findings.append(rules.KEPT_BESIDE(path=str(path), file=path, kept=kept))
