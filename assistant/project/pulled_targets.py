"""Targets that were taught anew on a controller, in the source that their program was made of."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText, decode, encode
from assistant.base.toml_text import value_spans
from assistant.compiler.loader import PSEUDO_ENCODINGS, lift_texts, parse_pseudo
from assistant.compiler.taught_targets import branch_words, number_list
from assistant.deploy import PlannedFile
from assistant.languages import Language
from assistant.languages.language_types import Precision
from assistant.program import pseudo
from assistant.program.geometry import JointTarget, Target
from assistant.program.program import Program
from assistant.project import rules
from assistant.robots import Robot
from assistant.sources import process_of
from assistant.sources.process.file import ENCODINGS, read_toml
from assistant.sources.tables.taught import (
    ORIENTATIONS,
    TaughtTarget,
    is_otherwise_equal,
    read_taught,
    with_target,
)

TAUGHT_SUFFIX: Final = ".toml"
SOURCES_WITH_NAMES: Final = (TAUGHT_SUFFIX, pseudo.SUFFIX)
"""Sources in which targets have their names."""
LENGTH_DIGITS: Final = 4
"""Of millimetres and degrees, as many as controllers tell."""
TURN_DIGITS: Final = 9
"""Of the parts of a quaternion."""
AnyTarget = Target | JointTarget


@dataclass(frozen=True, slots=True)
class ChangedTarget:
    """A target. before: as it was deployed. after: as it is on the controller."""

    name: str
    before: AnyTarget
    after: AnyTarget


def changed_targets(
    language: Language[Any],
    base: bytes,
    there: bytes,
    file: PlannedFile,
    source: FilePath,
    robot: Robot | None,
) -> list[ChangedTarget]:
    """The targets that two texts of a program place otherwise.

    Raises Refused if they differ in anything else: a source that is compiled cannot be given that.
    """
    old, new = (
        lift_texts(language, [language.decode(data, file.path)], robot).program
        for data in (base, there)
    )
    moved = replace(new, targets=old.targets, joint_targets=old.joint_targets, origin=None)
    same_names = old.targets.keys() == new.targets.keys()
    same_names &= old.joint_targets.keys() == new.joint_targets.keys()
    found = [
        ChangedTarget(n, old.targets[n], t) for n, t in new.targets.items() if n in old.targets
    ]
    found += [
        ChangedTarget(n, old.joint_targets[n], t)
        for n, t in new.joint_targets.items()
        if n in old.joint_targets
    ]
    found = [one for one in found if one.before != one.after]
    if not same_names or moved != replace(old, origin=None) or not found:
        raise Refused(rules.NOT_ONLY_TARGETS(path=file.path, name=file.name, source=source))
    return found


def with_targets(
    source: FilePath, data: bytes, changes: Sequence[ChangedTarget], name: str, precision: Precision
) -> bytes:
    """The source with the targets as they are now, all else to the letter; raises Refused.

    source: of those in PLACES_OF. name: of the program that they come from. precision: in which
    its language writes them.
    """
    suffix = source.suffix.lower()
    encodings = ENCODINGS if suffix == TAUGHT_SUFFIX else PSEUDO_ENCODINGS
    text = decode(data, str(source), encodings)
    for change in changes:
        program = _read_program(source, text)
        place = _target_of(program, change.name)
        if place is None or not _same_target(place, change.before, precision):
            finding = rules.OTHER_TARGET(
                path=str(source), target=change.name, name=name, source=source
            )
            raise Refused(finding)
        with_it = _with_taught_target if suffix == TAUGHT_SUFFIX else _with_pseudo_target
        text = with_it(source, text, program, change, place)
        now = _target_of(_read_program(source, text), change.name)
        if now is None or not _same_target(now, change.after, precision):
            finding = rules.OTHER_TARGET(
                path=str(source), target=change.name, name=name, source=source
            )
            raise Refused(finding)
    return encode(text)


def _read_program(source: FilePath, text: SourceText) -> Program:
    if source.suffix.lower() == TAUGHT_SUFFIX:
        return read_taught(text, source.stem, process_of(source)).program
    return parse_pseudo(text, source.parent)


def _target_of(program: Program, name: str) -> AnyTarget | None:
    named: dict[str, AnyTarget] = {**program.targets, **program.joint_targets}
    return next((place for key, place in named.items() if key.lower() == name.lower()), None)


def _same_target(one: AnyTarget, other: AnyTarget, precision: Precision) -> bool:
    """Whether two are one place, as exactly as the controller's language writes it."""
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
    source: FilePath, text: SourceText, program: Program, change: ChangedTarget, place: AnyTarget
) -> SourceText:
    del program, place
    entries = read_toml(text).content.get("targets", [])
    number, entry = next(
        (i, one) for i, one in enumerate(entries) if one["name"].lower() == change.name.lower()
    )
    spans = value_spans(text.text)
    as_it_is = {
        key: text.text[span.start : span.end]
        for key in entry
        if (span := spans.get(("targets", str(number), key))) is not None
    }
    target = TaughtTarget(entry["name"], dict(_taught_values(change, as_it_is)), {})
    changed, _ = with_target(text, source.stem, target, process_of(source), again=True)
    if not is_otherwise_equal(text.text, changed.text, entry["name"]):
        raise Refused(
            rules.OTHER_TARGET(path=str(source), target=change.name, name=source, source=source)
        )
    return changed


def _taught_values(change: ChangedTarget, as_it_is: dict[str, str]) -> Iterator[tuple[str, str]]:
    """Keys with TOML; what did not change stays as it is written."""
    before, after = change.before, change.after
    if isinstance(after, JointTarget):
        joints = list(after.joints)
        while joints and joints[-1] != joints[-1]:
            joints.pop()
        yield "joints", number_list(joints, LENGTH_DIGITS)
        return
    assert isinstance(before, Target)
    moved = before.pose.position != after.pose.position
    if moved or "position" not in as_it_is:
        yield "position", number_list(after.pose.position, LENGTH_DIGITS)
    else:
        yield "position", as_it_is["position"]
    turned = before.pose.quaternion != after.pose.quaternion
    kept = next((key for key in ORIENTATIONS if key in as_it_is), None)
    if turned:
        yield "quaternion", number_list(after.pose.quaternion, TURN_DIGITS)
    elif kept is not None:
        yield kept, as_it_is[kept]
    if before.configuration != after.configuration and after.configuration is not None:
        yield "configuration", branch_words(after.configuration)
    elif "configuration" in as_it_is:
        yield "configuration", as_it_is["configuration"]


# ------------------------------------------------------------------------------ pseudo-programs


def _with_pseudo_target(
    source: FilePath, text: SourceText, program: Program, change: ChangedTarget, place: AnyTarget
) -> SourceText:
    """The line of one target is printed anew, with the comment behind it."""
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


def _with_target(program: Program, key: str, place: AnyTarget) -> Program:
    if isinstance(place, Target):
        return replace(program, targets={**program.targets, key: place})
    return replace(program, joint_targets={**program.joint_targets, key: place})


def _keep_open_parts(place: AnyTarget, change: ChangedTarget) -> AnyTarget:
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
