"""What is moved in a scene, as one edit of the text that says where it is."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Refused, Span
from assistant.base.toml_text import value_spans
from assistant.compiler.loader import language_of
from assistant.compiler.taught_targets import branch_at
from assistant.editing.excerpts import Excerpt
from assistant.editing.service import Change, Document, Workspace
from assistant.editing.text_lines import Lines
from assistant.editing.workspace import source_of
from assistant.program import pseudo
from assistant.program.comparison import Tolerance, compare
from assistant.program.geometry import Pose, Target, Vector
from assistant.program.program import Program
from assistant.program.pseudo.expressions import target_text
from assistant.robots import Robot
from assistant.sources.process.file import parse_process
from assistant.studio import rules
from assistant.studio.dragging import target_joints, target_pose
from assistant.studio.handles import taught_entries
from assistant.studio.stages import DRAWING_HANDLE, TAUGHT_SUFFIX, Handle, Stage
from assistant.studio.studio import Studio
from assistant.studio.texts import open_text
from assistant.studio.toml_edits import toml_content, toml_value, with_values

WRITTEN_DIGITS: Final = 3
"""Of mm that are written: more than an arm repeats."""
DIGIT_TOLERANCE: Final = Tolerance(position=0.01, angle=0.01, number=1e-6)
"""What digits of a text leave off."""
FINEST_DIGITS: Final = 2
"""Of those that a text states, from where on no more are written."""
NUMBER: Final = r"[-+]?[0-9]+(?:\.[0-9]*)?"
COMMA: Final = r"[ \t]*,[ \t]*"
PATTERN_FLAGS: Final = re.MULTILINE | re.IGNORECASE
EDIT_BY_HAND: Final = "change it in the text"


def move_edit(
    studio: Studio, window: str, stage: Stage, handle: Handle, position: Sequence[float]
) -> tuple[str, Change]:
    """The file that says where something is, and what changes there if it is moved.

    position: (3,) mm in the world. Raises Refused where the text has changed since it was shown,
    and where it cannot say the place. Nothing is written.
    """
    x, y, z = target_pose(handle, position).position
    place = (_rounded_value(x), _rounded_value(y), _rounded_value(z))
    text = open_text(studio, window, handle.path)
    if handle.path == (stage.process or stage.path) and not _rest_unchanged(
        handle, stage.text, text
    ):
        raise _not_moved(handle, "the text has changed since it was shown", "show it again")
    if handle.kind == DRAWING_HANDLE:
        return handle.path, _drawing_change(handle, text, place)
    if handle.path.lower().endswith(TAUGHT_SUFFIX):
        return handle.path, _taught_change(handle, text, place)
    return handle.path, _program_change(studio, stage, handle, text, position, place)


def _rest_unchanged(handle: Handle, before: str, now: str) -> bool:
    """Whether texts are the same but for the line that is moved, which is read anew."""
    if before == now:
        return True
    one, other = Lines(before), Lines(now)
    rows = [i for i in range(len(one)) if i != handle.line - 1]
    return len(one) == len(other) and all(one.line(i) == other.line(i) for i in rows)


def least_change(before: str, after: str) -> Change:
    """The least part of a text that makes it another one."""
    start = _common_prefix(before, after)
    least = min(len(before), len(after)) - start
    end = min(_common_prefix(before[::-1], after[::-1]), least)
    span = Span(start, len(before) - end)
    return Change(Lines(before).range(span), after[start : len(after) - end])


def _common_prefix(one: str, other: str) -> int:
    """How many characters are the same from the begin."""
    low, high = 0, min(len(one), len(other))
    while low < high:
        middle = (low + high + 1) // 2
        if one[:middle] == other[:middle]:
            low = middle
        else:
            high = middle - 1
    return low


def _rounded_value(value: float) -> float:
    return round(float(value), WRITTEN_DIGITS) + 0.0


def _not_moved(handle: Handle, reason: str, cure: str = EDIT_BY_HAND) -> Refused:
    found = rules.NOT_MOVED(path=handle.path, name=handle.name, reason=reason, cure=cure)
    return Refused(replace(found, line=handle.line or None), exit_status=2)


# ---------------------------------------------------------------------------------- drawings


def _drawing_change(handle: Handle, text: str, place: Vector) -> Change:
    content = toml_content(text)
    if content is None:
        raise _not_moved(handle, "its process file cannot be read", "mend that first")
    placement = content.get("placement")
    if isinstance(placement, dict) and "drawing" in placement:
        marks = "the process file places it by marks that were taught"
        raise _not_moved(handle, marks, "teach the marks again, or give `position` instead of them")
    changed = with_values(text, {("placement", "position"): list(place)}, handle.path)
    parse_process(source_of(changed, handle.path))
    return least_change(text, changed)


# ----------------------------------------------------------------------------- taught targets


def _taught_change(handle: Handle, text: str, place: Vector) -> Change:
    number = dict(taught_entries(text)).get(handle.name.lower())
    span = None if number is None else value_spans(text).get(("targets", number, "position"))
    if span is None:
        raise _not_moved(handle, "its place is not stated as a position")
    return Change(Lines(text).range(span), toml_value([*map(_plain_number, place)]))


def _plain_number(value: float) -> float | int:
    return int(value) if value.is_integer() else value


# ----------------------------------------------------------------------------------- programs


def _program_change(
    studio: Studio,
    stage: Stage,
    handle: Handle,
    text: str,
    position: Sequence[float],
    place: Vector,
) -> Change:
    """By the declaration alone: it is read, changed and written again, all else stays."""
    document = Workspace(studio.folder).open(str(studio.place(handle.path)), text)
    speaks = document.spoken
    if speaks is None or speaks.editable is None:
        raise _not_moved(handle, "its text is in no language that is written")
    part = document.declared(frozenset({speaks.editable.folded(handle.name)}))
    before = speaks.program(part.source(document.path), (), stage.robot)
    key = next((name for name in before.targets if name.lower() == handle.name.lower()), None)
    if key is None:
        raise _not_moved(handle, "its declaration states no numbers")
    target = _moved_target(stage, handle, before.targets[key], position, place)
    changed = replace(before, targets={**before.targets, key: target})
    for written in _rewritten_parts(document, part.text, handle, changed, target, stage.robot):
        now = speaks.program(source_of(written, document.path), (), stage.robot)
        if compare(changed, now, DIGIT_TOLERANCE).same:
            return _line_change(handle, part, written, text)
    raise _not_moved(handle, "its text cannot say this place")


def _moved_target(
    stage: Stage, handle: Handle, target: Target, position: Sequence[float], place: Vector
) -> Target:
    """With the configuration of the arm there, where the text states another one."""
    turned = target_pose(handle, position).quaternion if handle.with_arm else target.pose.quaternion
    moved = replace(target, pose=Pose(place, turned))
    if stage.solved is None or target.configuration is None:
        return moved
    joints, other = target_joints(stage, handle, position)
    if joints is None or not other:
        return moved
    return replace(moved, configuration=branch_at(stage.solved.solution.robot, joints.tolist()))


def _rewritten_parts(
    document: Document,
    part: str,
    handle: Handle,
    changed: Program,
    target: Target,
    robot: Robot | None,
) -> Iterator[str]:
    """Texts of a part that may say a program: with other numbers of a place, and written anew."""
    yield _in_place_numbers(part, handle, target.pose.position)
    if document.path.lower().endswith(pseudo.SUFFIX):
        yield _pseudo_text(part, handle, target)
    else:
        yield _with_declaration_head(part, _language_text(document, changed, robot), handle.name)


def _in_place_numbers(part: str, handle: Handle, place: Vector) -> str:
    """With other numbers, each written as the one was that stood there."""
    name = rf"(?<!\w){re.escape(handle.name)}(?!\w)`?"
    head = rf"^([^\r\n]*?{name}[ \t]*(?::?=[ \t]*)?[\[(]+[ \t]*)"
    rest = rf"({NUMBER})({COMMA})({NUMBER})({COMMA})({NUMBER})(?=[ \t]*[,\])])"

    def changed(match: re.Match[str]) -> str:
        head, *before = match.groups()
        numbers, commas = before[::2], before[1::2]
        signed = any(one.startswith("+") for one in numbers)
        stated = [len(one.partition(".")[2]) for one in numbers]
        most = max(stated) if max(stated) >= FINEST_DIGITS else WRITTEN_DIGITS
        said = [
            _number_text(value, least, most, signed)
            for value, least in zip(place, stated, strict=True)
        ]
        return head + "".join(a + b for a, b in zip(said, (*commas, ""), strict=True))

    return re.sub(head + rest, changed, part, count=1, flags=PATTERN_FLAGS)


def _number_text(value: float, least: int, most: int, signed: bool) -> str:
    """A number with so many digits behind its point, and a sign also if it is not negative."""
    whole, _, digits = f"{round(value, most) + 0.0:{'+' if signed else ''}.{most}f}".partition(".")
    kept = digits.rstrip("0").ljust(least, "0")
    return f"{whole}.{kept}" if kept else whole


def _pseudo_text(part: str, handle: Handle, target: Target) -> str:
    name = re.escape(handle.name)
    head, rest = rf"^(\s*target[ \t]+{name}[ \t]+)", r"([^#\r\n]*?)([ \t]*(?:#.*)?\r?)$"
    pattern = re.compile(head + rest, PATTERN_FLAGS)
    return pattern.sub(lambda m: f"{m[1]}{target_text(target)}{m[3]}", part, count=1)


def _language_text(document: Document, program: Program, robot: Robot | None) -> str:
    language: Any = language_of(document.language)
    return str(language.render(language.lower(program, robot)))


def _with_declaration_head(part: str, written: str, name: str) -> str:
    """What stands in front of the name stays: who else knows it, and how it is kept."""
    head = re.compile(rf"^[^\r\n]*?(?<!\w){re.escape(name)}(?!\w)", PATTERN_FLAGS)
    kept = head.search(part)
    return written if kept is None else head.sub(lambda _: kept[0], written, count=1)


def _line_change(handle: Handle, part: Excerpt, written: str, text: str) -> Change:
    """A change of one line of a part is that of the same line of the whole text."""
    if part.text == written:
        raise _not_moved(handle, "its text says this place already")
    old, new, whole = (Lines(one) for one in (part.text, written, text))
    lines = [i for i in range(len(old)) if i >= len(new) or old.line(i) != new.line(i)]
    if len(old) != len(new) or len(lines) != 1:
        raise _not_moved(handle, "its declaration cannot be changed by itself")
    one = least_change(old.line(lines[0]), new.line(lines[0]))
    line = part.line_in_whole(lines[0])
    start, end = (replace(at, line=line) for at in (one.range.start, one.range.end))
    if whole.line(line) != old.line(lines[0]):
        raise _not_moved(handle, "its declaration is not where it was", "show it again")
    return Change(replace(one.range, start=start, end=end), one.text)
