"""Edits by dragging: what a moved target or drawing would do, and the change of the text.

While something is dragged its reach and contacts are reported. The edit is one change of the text
that declares the target; digits that the arm cannot repeat are left off. Positions are mm in the
world, joints degrees.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats, evenly_spaced
from assistant.base.diagnostics import Refused, Span
from assistant.base.source_text import visible
from assistant.base.toml_text import toml_content
from assistant.cell.collision.model import Model
from assistant.compiler.loader import language_of
from assistant.compiler.taught_targets import branch_at
from assistant.editing.excerpts import Excerpt
from assistant.editing.service import Change, Document, Workspace
from assistant.editing.text_lines import Lines
from assistant.editing.workspace import source_of
from assistant.program import pseudo
from assistant.program.comparison import Tolerance, compare
from assistant.program.geometry import Pose, Target, Vector
from assistant.program.motion import UNSTATED
from assistant.program.program import Program
from assistant.program.pseudo.expressions import target_text
from assistant.robots import Robot
from assistant.robots.arms import closed_form
from assistant.robots.solved_program import Leg
from assistant.sources.process.file import parse_process
from assistant.studio import rules
from assistant.studio.process_files import with_values
from assistant.studio.stages import DRAWING_HANDLE, TAUGHT_SUFFIX, Handle, Stage, taught_entries
from assistant.studio.studio import Studio
from assistant.studio.texts import open_text

_MOST_DRAWING_POSES: Final = 400
"""Most poses on the path along a drawing that are checked while it is dragged."""
_MOST_CONTACT_POSES: Final = 40
"""Most of these poses at which contact is checked."""
_OPEN_CONFIGURATION: Final = np.full(6, UNSTATED, dtype=np.int64)

DragRecord = dict[str, Any]


def drag_record(stage: Stage, handle: Handle, position: Sequence[float]) -> DragRecord:
    """Return the effect of another position (3,) in mm in the world.

    reached: None if the arm is unknown. joints: (a,) of the arm's chain there, as `view` poses it,
    None if out of reach. other: the arm needs another configuration there than the text states.
    touches: names of two bodies, None for no contact. near: the same within the margin. left: how
    many of `looked` poses are out of reach.
    """
    nothing: DragRecord = {
        "reached": None,
        "joints": None,
        "other": False,
        "touches": None,
        "near": None,
        "left": 0,
        "looked": 0,
    }
    if stage.solved is None:
        return nothing
    with stage.lock:
        if handle.kind == DRAWING_HANDLE:
            return nothing | _drawing_record(stage, handle, np.array(position))
        return nothing | _target_record(stage, handle, position)


def _target_joints(
    stage: Stage, handle: Handle, position: Sequence[float]
) -> tuple[Floats | None, bool]:
    """(a,) joints with which a target is reached at a position in the world, None if it is not.

    True for those of another configuration than the text states, on the branch that is nearest.
    """
    assert stage.solved is not None
    solution = stage.solved.solution
    leg = solution.legs[handle.procedure][handle.place - 1]
    if leg.solved_run is None:
        return None, False
    p, q = _flange_poses(leg, handle, position)
    row = leg.rows.start + handle.row
    stated = leg.solved_run.configurations[row : row + 1]
    (joints,) = solution.robot.joints_of(p, q, stated)
    if np.isfinite(joints).all():
        return joints, False
    return _nearest_joints(solution.robot, p, q, leg.joints[handle.row]), True


def _target_pose(handle: Handle, position: Sequence[float]) -> Pose:
    """The pose of a target in its frame at another position (3,) mm in the world."""
    local = handle.frame.inverse() @ handle.pose
    x, y, z = handle.frame.inverse().moved(np.array([position]))[0].tolist()
    if not handle.with_arm:
        return Pose((x, y, z), local.quaternion)
    leans = closed_form.to_ab([local.position], [local.quaternion])
    w, i, j, k = closed_form.from_ab([(x, y, z)], leans)[0].tolist()
    return Pose((x, y, z), (w, i, j, k))


def _flange_poses(leg: Leg, handle: Handle, position: Sequence[float]) -> tuple[Floats, Floats]:
    assert leg.solved_run is not None
    local = _target_pose(handle, position)
    rows = np.array([leg.rows.start + handle.row])
    target = np.array([local.position]), np.array([local.quaternion])
    return leg.solved_run.run.mounting.to_flange(*target, rows)


def _nearest_joints(robot: Robot, p: Floats, q: Floats, before: Floats) -> Floats | None:
    found, valid = robot.ik(p, q)
    if not valid.any():
        return None
    from_where = before if np.isfinite(before).all() else robot.home
    away = np.abs(found[0] - from_where).max(axis=1)
    best: Floats = found[0, int(np.where(valid[0], away, np.inf).argmin())]
    return best


def _target_record(stage: Stage, handle: Handle, position: Sequence[float]) -> DragRecord:
    joints, other = _target_joints(stage, handle, position)
    if joints is None:
        return {"reached": False, "looked": 1, "left": 1}
    robot = stage.robot
    assert robot is not None
    chained = robot.chained(joints[None])[0].tolist()
    told: DragRecord = {"reached": True, "joints": chained, "other": other, "looked": 1}
    return told | _contact_record(stage, joints[None])


def _contact_record(stage: Stage, joints: Floats) -> DragRecord:
    """joints: (n, a) of the arm that moves; the other ones stand at home."""
    model = stage.model()
    if model is None or not len(model):
        return {}
    apart, pair = model.nearest(_all_joints(stage, model, joints))
    worst = int((apart - model.margins[pair]).argmin())
    one, other = (side[pair[worst]] for side in (model.one, model.other))
    names = [visible(model.items[int(item)].body.name) for item in (one, other)]
    if apart[worst] <= 0.0:
        return {"touches": names}
    return {"near": names} if apart[worst] < model.margins[pair[worst]] else {}


def _all_joints(stage: Stage, model: Model, joints: Floats) -> Floats:
    parts = [
        joints if one is stage.shown.placed else np.tile(one.robot.home, (len(joints), 1))
        for one in model.scene.robots
    ]
    return np.concatenate(parts, axis=1)


def _drawing_record(stage: Stage, handle: Handle, position: Floats) -> DragRecord:
    """Return the same record for poses along the complete path, evenly selected."""
    assert stage.solved is not None
    solution, base = stage.solved.solution, stage.shown.base
    by = position - np.array(handle.pose.position)
    turned = np.asarray(base.inverse().moved((by + np.array(base.position))[None]))[0]
    flanges = [solved.run.flange(slice(None)) for solved in solution.solved_runs]
    if not flanges:
        return {}
    p = np.concatenate([one for one, _ in flanges])
    q = np.concatenate([one for _, one in flanges])
    picked = evenly_spaced(len(p), _MOST_DRAWING_POSES)
    p, q = p[picked] + turned, q[picked]
    joints = solution.robot.joints_of(p, q, np.tile(_OPEN_CONFIGURATION, (len(p), 1)))
    there = np.isfinite(joints).all(axis=1)
    left = int((~there).sum())
    told: DragRecord = {"reached": left == 0, "left": left, "looked": len(p)}
    reached = joints[there]
    if not len(reached):
        return told
    few = evenly_spaced(len(reached), _MOST_CONTACT_POSES)
    return told | _contact_record(stage, reached[few])


_WRITTEN_DIGITS: Final = 3
"""Decimals of mm that are written: more than an arm's repeatability."""
_DIGIT_TOLERANCE: Final = Tolerance(position=0.01, angle=0.01, number=1e-6)
"""Tolerance for the digits that a text omits."""
_FINEST_DIGITS: Final = 2
"""Decimals in a text from which no more are written."""
NUMBER: Final = r"[-+]?[0-9]+(?:\.[0-9]*)?"
COMMA: Final = r"[ \t]*,[ \t]*"
_PATTERN_FLAGS: Final = re.MULTILINE | re.IGNORECASE
_EDIT_BY_HAND: Final = "change it in the text"


def move_edit(
    studio: Studio, window: str, stage: Stage, handle: Handle, position: Sequence[float]
) -> tuple[str, Change]:
    """Return the file that states a position, and the change there if it is moved.

    position: (3,) mm in the world. Raises Refused if the text has changed since it was shown, and
    if it cannot express the position. Nothing is written.
    """
    x, y, z = _target_pose(handle, position).position
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
    """True if the texts are the same except for the moved line, which is parsed again."""
    if before == now:
        return True
    one, other = Lines(before), Lines(now)
    rows = [i for i in range(len(one)) if i != handle.line - 1]
    return len(one) == len(other) and all(one.line(i) == other.line(i) for i in rows)


def _least_change(before: str, after: str) -> Change:
    """The least part of a text that makes it another one."""
    start = _common_prefix(before, after)
    least = min(len(before), len(after)) - start
    end = min(_common_prefix(before[::-1], after[::-1]), least)
    span = Span(start, len(before) - end)
    return Change(Lines(before).range(span), after[start : len(after) - end])


def _common_prefix(one: str, other: str) -> int:
    """Return the length of the common prefix."""
    low, high = 0, min(len(one), len(other))
    while low < high:
        middle = (low + high + 1) // 2
        if one[:middle] == other[:middle]:
            low = middle
        else:
            high = middle - 1
    return low


def _rounded_value(value: float) -> float:
    return round(float(value), _WRITTEN_DIGITS) + 0.0


def _not_moved(handle: Handle, reason: str, cure: str = _EDIT_BY_HAND) -> Refused:
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
    return _least_change(text, changed)


# ----------------------------------------------------------------------------- taught targets


def _taught_change(handle: Handle, text: str, place: Vector) -> Change:
    number = dict(taught_entries(text)).get(handle.name.lower())
    entries = (toml_content(text) or {}).get("targets", [])
    if number is None or "position" not in entries[int(number)]:
        raise _not_moved(handle, "its place is not stated as a position")
    changed = with_values(text, {("targets", number, "position"): place}, handle.path)
    return _least_change(text, changed)


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
        if compare(changed, now, _DIGIT_TOLERANCE).same:
            return _line_change(handle, part, written, text)
    raise _not_moved(handle, "its text cannot say this place")


def _moved_target(
    stage: Stage, handle: Handle, target: Target, position: Sequence[float], place: Vector
) -> Target:
    """With the configuration of the arm there, where the text states another one."""
    turned = (
        _target_pose(handle, position).quaternion if handle.with_arm else target.pose.quaternion
    )
    moved = replace(target, pose=Pose(place, turned))
    if stage.solved is None or target.configuration is None:
        return moved
    joints, other = _target_joints(stage, handle, position)
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
        most = max(stated) if max(stated) >= _FINEST_DIGITS else _WRITTEN_DIGITS
        said = [
            _number_text(value, least, most, signed)
            for value, least in zip(place, stated, strict=True)
        ]
        return head + "".join(a + b for a, b in zip(said, (*commas, ""), strict=True))

    return re.sub(head + rest, changed, part, count=1, flags=_PATTERN_FLAGS)


def _number_text(value: float, least: int, most: int, signed: bool) -> str:
    """A number with so many digits behind its point, and a sign also if it is not negative."""
    whole, _, digits = f"{round(value, most) + 0.0:{'+' if signed else ''}.{most}f}".partition(".")
    kept = digits.rstrip("0").ljust(least, "0")
    return f"{whole}.{kept}" if kept else whole


def _pseudo_text(part: str, handle: Handle, target: Target) -> str:
    name = re.escape(handle.name)
    head, rest = rf"^(\s*target[ \t]+{name}[ \t]+)", r"([^#\r\n]*?)([ \t]*(?:#.*)?\r?)$"
    pattern = re.compile(head + rest, _PATTERN_FLAGS)
    return pattern.sub(lambda m: f"{m[1]}{target_text(target)}{m[3]}", part, count=1)


def _language_text(document: Document, program: Program, robot: Robot | None) -> str:
    language: Any = language_of(document.language)
    return str(language.render(language.lower(program, robot)))


def _with_declaration_head(part: str, written: str, name: str) -> str:
    """Return the declaration with the original text before the name: its scope and storage."""
    head = re.compile(rf"^[^\r\n]*?(?<!\w){re.escape(name)}(?!\w)", _PATTERN_FLAGS)
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
    one = _least_change(old.line(lines[0]), new.line(lines[0]))
    line = part.line_in_whole(lines[0])
    start, end = (replace(at, line=line) for at in (one.range.start, one.range.end))
    if whole.line(line) != old.line(lines[0]):
        raise _not_moved(handle, "its declaration is not where it was", "show it again")
    return Change(replace(one.range, start=start, end=end), one.text)
