"""Changes on a controller since the last deployment, pulled into the sources.

A program that is here as it is sent gets the change in its own layout. Of a compiled program the
targets that were taught anew go into its source, by their names: a file of taught targets, or a
pseudo-program. Other sources have no names for them, so they go into the compiled program, which
keeps them when it is compiled again. All changes of a plan are pulled, or none.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np

from assistant import languages
from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.file_sets import write_all
from assistant.base.source_text import SourceText, decode, encode, read_bytes
from assistant.base.text_merge import StoredForm, in_layout, merged
from assistant.base.toml_edits import rounded
from assistant.compiler.loader import PSEUDO_ENCODINGS, lift_texts, parse_pseudo
from assistant.compiler.taught_targets import branch_table
from assistant.deploy import Change, Held, Plan, PlannedFile
from assistant.deploy.repository import is_committed
from assistant.deploy.rules import IN_WRITTEN
from assistant.deploy.site import Site
from assistant.languages import Language
from assistant.languages.language_types import Precision
from assistant.program import pseudo
from assistant.program.geometry import JointTarget, Target
from assistant.program.program import Program
from assistant.program.settings_tables import ENCODINGS, read_toml
from assistant.project import rules
from assistant.robots import Robot
from assistant.sources import process_of
from assistant.sources.tables.taught import (
    ORIENTATIONS,
    TaughtTarget,
    read_taught,
    with_target,
)

_TAUGHT_SUFFIX: Final = ".toml"
_SOURCES_WITH_NAMES: Final = (_TAUGHT_SUFFIX, pseudo.SUFFIX)
"""Sources in which targets have their names."""
_LENGTH_DIGITS: Final = 4
"""Digits of millimetres and degrees, as many as controllers report."""
_TURN_DIGITS: Final = 9
"""Digits of the parts of a quaternion."""
_AnyTarget = Target | JointTarget


@dataclass(frozen=True, slots=True)
class _ChangedTarget:
    """A target. before: as it was deployed. after: as it is on the controller."""

    name: str
    before: _AnyTarget
    after: _AnyTarget


def _changed_targets(
    language: Language[Any],
    base: bytes,
    there: bytes,
    file: PlannedFile,
    source: FilePath,
    robot: Robot | None,
) -> list[_ChangedTarget]:
    """The targets that two texts of a program place otherwise.

    Raises Refused if they differ in anything else: a source that is compiled cannot be given that.
    """
    old, new = (
        lift_texts(language, [language.decode(data, file.path)], robot).program
        for data in (base, there)
    )
    # Everything but the targets must be equal.
    moved = replace(new, targets=old.targets, joint_targets=old.joint_targets, origin=None)
    same_names = old.targets.keys() == new.targets.keys()
    same_names &= old.joint_targets.keys() == new.joint_targets.keys()
    found = [
        _ChangedTarget(n, old.targets[n], t) for n, t in new.targets.items() if n in old.targets
    ]
    found += [
        _ChangedTarget(n, old.joint_targets[n], t)
        for n, t in new.joint_targets.items()
        if n in old.joint_targets
    ]
    found = [one for one in found if one.before != one.after]
    if not same_names or moved != replace(old, origin=None) or not found:
        raise Refused(rules.NOT_ONLY_TARGETS(path=file.path, name=file.name, source=source))
    return found


def _with_targets(
    source: FilePath,
    data: bytes,
    changes: Sequence[_ChangedTarget],
    name: str,
    precision: Precision,
) -> bytes:
    """The source with the targets as they are now, all else to the letter; raises Refused.

    source: of those in PLACES_OF. name: of the program that they come from. precision: in which
    its language writes them.
    """
    suffix = source.suffix.lower()
    encodings = ENCODINGS if suffix == _TAUGHT_SUFFIX else PSEUDO_ENCODINGS
    text = decode(data, str(source), encodings)
    for change in changes:
        program = _read_program(source, text)
        place = _target_of(program, change.name)
        # The source must still have the target as it was deployed.
        if place is None or not _same_target(place, change.before, precision):
            finding = rules.OTHER_TARGET(
                path=str(source), target=change.name, name=name, source=source
            )
            raise Refused(finding)
        with_it = _with_taught_target if suffix == _TAUGHT_SUFFIX else _with_pseudo_target
        text = with_it(source, text, program, change, place)
        # Read back: the edit must have led to this place.
        now = _target_of(_read_program(source, text), change.name)
        if now is None or not _same_target(now, change.after, precision):
            finding = rules.OTHER_TARGET(
                path=str(source), target=change.name, name=name, source=source
            )
            raise Refused(finding)
    return encode(text)


def _read_program(source: FilePath, text: SourceText) -> Program:
    if source.suffix.lower() == _TAUGHT_SUFFIX:
        return read_taught(text, source.stem, process_of(source)).program
    return parse_pseudo(text, source.parent)


def _target_of(program: Program, name: str) -> _AnyTarget | None:
    named: dict[str, _AnyTarget] = {**program.targets, **program.joint_targets}
    return next((place for key, place in named.items() if key.lower() == name.lower()), None)


def _same_target(one: _AnyTarget, other: _AnyTarget, precision: Precision) -> bool:
    """True if both are the same position, at the precision of the controller's language."""
    if isinstance(one, Target) and isinstance(other, Target):
        apart = np.abs(np.subtract(one.pose.position, other.pose.position)).max()
        turned = rotations.angle_between(one.pose.quaternion, other.pose.quaternion)
        return bool(apart <= 2 * precision.position and turned <= 2 * precision.angle)
    if isinstance(one, JointTarget) and isinstance(other, JointTarget):
        count = min(len(one.joints), len(other.joints))
        apart = np.subtract(one.joints[:count], other.joints[:count])
        return bool(np.nanmax(np.abs(apart), initial=0.0) <= 2 * precision.angle)
    return False


# ------------------------------------------------------------------------------ taught targets


def _with_taught_target(
    source: FilePath, text: SourceText, program: Program, change: _ChangedTarget, place: _AnyTarget
) -> SourceText:
    # Both editors of sources take the same arguments.
    del program, place
    entries = read_toml(text).content.get("targets", [])
    entry = next(one for one in entries if one["name"].lower() == change.name.lower())
    target = TaughtTarget(entry["name"], dict(_taught_values(change, entry)), {})
    changed, _ = with_target(text, source.stem, target, process_of(source), again=True)
    return changed


def _taught_values(change: _ChangedTarget, entry: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Keys with values; what did not change stays as it is written."""
    before, after = change.before, change.after
    if isinstance(after, JointTarget):
        joints = list(after.joints)
        while joints and joints[-1] != joints[-1]:
            joints.pop()
        yield "joints", rounded(joints, _LENGTH_DIGITS)
        return
    assert isinstance(before, Target)
    moved = before.pose.position != after.pose.position
    if moved or "position" not in entry:
        yield "position", rounded(after.pose.position, _LENGTH_DIGITS)
    else:
        yield "position", entry["position"]
    turned = before.pose.quaternion != after.pose.quaternion
    kept = next((key for key in ORIENTATIONS if key in entry), None)
    if turned:
        yield "quaternion", rounded(after.pose.quaternion, _TURN_DIGITS)
    elif kept is not None:
        yield kept, entry[kept]
    if before.configuration != after.configuration and after.configuration is not None:
        yield "configuration", branch_table(after.configuration)
    elif "configuration" in entry:
        yield "configuration", entry["configuration"]


# ------------------------------------------------------------------------------ pseudo-programs


def _with_pseudo_target(
    source: FilePath, text: SourceText, program: Program, change: _ChangedTarget, place: _AnyTarget
) -> SourceText:
    """Return the source with the line of one target reprinted; the comment after it stays."""
    key = next(
        key
        for key in (*program.targets, *program.joint_targets)
        if key.lower() == change.name.lower()
    )
    wanted = _with_target(program, key, _keep_open_parts(place, change))
    old, new = (pseudo.print_program(one).text.split("\n") for one in (program, wanted))
    lines = [line for line, other in zip(new, old, strict=True) if line != other]
    begins = re.compile(rf"^[ \t]*(?:target|joints)[ \t]+{re.escape(key)}\b[^#\r\n]*", re.MULTILINE)
    found = list(begins.finditer(text.text))
    if len(lines) == len(found) == 1:
        start, end = found[0].span()
        end = start + len(found[0][0].rstrip())
        changed = replace(text, text=text.text[:start] + lines[0] + text.text[end:])
        if replace(parse_pseudo(changed, source.parent), origin=None) == wanted:
            return changed
    finding = rules.OTHER_TARGET(path=str(source), target=key, name=source, source=source)
    raise Refused(finding)


def _with_target(program: Program, key: str, place: _AnyTarget) -> Program:
    if isinstance(place, Target):
        return replace(program, targets={**program.targets, key: place})
    return replace(program, joint_targets={**program.joint_targets, key: place})


def _keep_open_parts(place: _AnyTarget, change: _ChangedTarget) -> _AnyTarget:
    """The new place, with what the source leaves open left open."""
    after = change.after
    if not isinstance(place, Target) or not isinstance(after, Target):
        return after
    assert isinstance(change.before, Target)
    stated = place.configuration
    if change.before.configuration != after.configuration:
        stated = after.configuration
    kept = change.before.pose.quaternion == after.pose.quaternion
    turn = place.pose.quaternion if kept else after.pose.quaternion
    pose = replace(after.pose, quaternion=turn)
    return Target(pose, stated, after.external)


_SAVED_SUFFIX: Final = ".orig"
"""Behind the name of a file that no repository keeps: what it said before."""


@dataclass(frozen=True, slots=True)
class Pulled:
    """Result of a pull. sources: changes to each file, in order."""

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
        if source.suffix.lower() not in _SOURCES_WITH_NAMES:
            built = FilePath(file.path)
            now = self.wanted.get(built) or read_bytes(built)
            self.wanted[built] = self._as_text(file, base, now, there, form)
            self.told.setdefault(built, []).append(f"`{file.name}` as it is on the controller")
            path, name = file.path, file.name
            self.findings.append(IN_WRITTEN(path=path, file=path, name=name, source=source))
            return
        changes = _changed_targets(
            spoken, form(file.data if base is None else base), form(there), file, source, self.robot
        )
        self.wanted[source] = _with_targets(source, now, changes, file.name, spoken.precision)
        self.told.setdefault(source, []).extend(f"target `{one.name}`" for one in changes)

    def _sides(self, file: PlannedFile) -> tuple[bytes | None, bytes, StoredForm]:
        """Return the deployed and the present contents, and the form in which they are compared."""
        left, now = file.left, file.before
        stored, in_memory = self.site.controller.stored, self.site.in_memory
        one = None if left is None else self.site.forms(left)
        other = self.site.forms(now)
        in_file = now.file is not None and (one is None or one.file != other.file)
        loaded = now.loaded is not None and (one is None or one.loaded != other.loaded)
        # Changed in the file and in memory: only the same change is clear.
        if in_file and loaded and not self._are_one(now):
            raise Refused(rules.TWO_CHANGES(path=file.path, name=file.name))
        if loaded and now.loaded is not None:
            return (None if left is None else left.loaded or left.file), now.loaded, in_memory
        if now.file is None:
            raise Refused(rules.GONE_THERE(path=file.path, name=file.name))
        return (None if left is None else left.file), now.file, stored

    def _are_one(self, now: Held) -> bool:
        """True if a module in memory matches its file."""
        return self.site.forms(Held(None, now.file)) == self.site.forms(Held(None, now.loaded))

    def _as_text(
        self, file: PlannedFile, base: bytes | None, own: bytes, there: bytes, form: StoredForm
    ) -> bytes:
        """Our text with what was changed there."""
        # Programs in memory may have lost their comments.
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
        """True if the controller would treat two texts as the same, in the place that changed."""
        if other == file.before.loaded:
            return self.site.same(Held(None, one), Held(None, other))
        return self.site.same(Held(one), Held(other))

    def check_committed(self) -> None:
        """Add an error for each file with uncommitted changes, so that nothing is written.

        A file outside of a git repository is copied first, with a note.
        """
        for path in list(self.wanted):
            known = is_committed(path)
            if known is False:
                self.findings.append(rules.NOT_COMMITTED(path=str(path), file=path))
            elif known is None:
                kept = path.with_name(path.name + _SAVED_SUFFIX)
                self.wanted[kept] = read_bytes(path)
                self.findings.append(rules.KEPT_BESIDE(path=str(path), file=path, kept=kept))
