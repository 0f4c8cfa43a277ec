"""Taught targets as TOML, and a move to each in the order of the file.

    robot = "irb1200-7-0.7"         # the arm that it was taught on: joints mean it alone

    [motion]                        # as in a process file, and so are [tools], [frames],
    speed = 100                     # [signals]; a process file may hold them as well

    [[targets]]
    name = "home"
    joints = [0, 0, 0, 0, 30, 0]    # degrees; nan for a joint that the arm does not have

    [[targets]]
    name = "above"
    position = [400, 0, 300]        # mm
    euler_zyx = [0, 0, 180]         # degrees, R = Rz·Ry·Rx; or euler_xyz, euler_zyz,
    # quaternion = [0, 1, 0, 0]     # or w, x, y, z
    configuration = {back = false, down = false, flip = true, quadrants = [0, 0, -1]}
    external = [100]                # mm or degrees of the external axes
    kind = "joint"                  # or linear; via, and end in the target after it
    speed = 200                     # mm/s
    blend = 5                       # mm, or "fine"
    tool = "gripper"
    frame = "table"
    comment = "over the first part" # before the move
    set = {glue = 1}                # outputs that are set after the move
    wait = 0.5                      # seconds, after that

Only the name and one of `position` and `joints` have to be there.
"""

from __future__ import annotations

import math
import pathlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.diagnostics import Refused, Severity, error, has_errors
from assistant.base.source_text import SourceText, decode, read_bytes
from assistant.program import settings_tables as values
from assistant.program.expressions import Name, Number
from assistant.program.geometry import NO_EXTERNAL, Configuration, JointTarget, Pose, Target
from assistant.program.motion import Kind
from assistant.program.settings_tables import REPAIRED, Table, Wrong, kind_of
from assistant.program.statements import (
    Comment,
    Motion,
    Move,
    MoveCircular,
    MoveJoints,
    SetSignal,
    Statement,
    Wait,
)
from assistant.sources.process import Process
from assistant.sources.process.file import ENCODINGS, process_in, read_toml
from assistant.sources.reading import Reading
from assistant.sources.tables import rows
from assistant.sources.tables.actions import output_signal
from assistant.sources.tables.headers import MOST_JOINTS
from assistant.sources.tables.headers import shown as marked
from assistant.sources.tables.poses import LARGEST_POSITION

ERROR: Final = Severity.ERROR
NO_TARGETS = error(
    "TB501", "there are no targets", "write [[targets]] and its keys for each of them"
)
NOT_A_TABLE = error("TB502", "`targets` {what}", "write [[targets]] above each target")
POSE_OR_JOINTS = error(
    "TB503", "target {name} has {what}", "give `position` and an orientation, or `joints`"
)
WRONG_ORIENTATION = error(
    "TB504", "target {name} has {what}", "give one of `quaternion`, `euler_zyx`, …"
)
JOINTS_BY_LINE = error(
    "TB505", "target {name} has joints, which no {kind} move reaches", 'write kind = "joint"'
)
TWO_TABLES = error(
    "TB506", "{name} is declared here and, differently, in the process file", "keep one of them"
)

ORIENTATIONS: Final = ("quaternion", "euler_zyx", "euler_xyz", "euler_zyz")


def read(path: pathlib.Path, process: Process) -> Reading:
    """The pseudo-program of a TOML list of targets; raises Unreadable or Refused."""
    return read_taught(decode(read_bytes(path), str(path), ENCODINGS), path.stem, process)


def read_taught(source: SourceText, stem: str, process: Process) -> Reading:
    """The pseudo-program of a text, named after a file's stem."""
    top = read_toml(source)
    own = process_in(top, beside=("targets",))
    cell = _with_own_tables(top, own, process)
    path = source.path or ""
    name, notes = rows.program_name(stem, path)
    taught = _TargetReader(top, cell)
    body = [
        s for number, table in enumerate(_target_tables(top)) for s in taught.moves(number, table)
    ]
    taught.check_arcs()
    findings = (*notes, *top.page.findings, *taught.names.findings)
    if has_errors(findings):
        raise Refused(*sorted(findings, key=lambda f: f.line or 0))
    program = rows.program_of(name, body, cell, taught.targets, taught.joint_targets)
    return Reading(program, findings, seen=cell.seen)


def _with_own_tables(top: Table, own: Process, process: Process) -> Process:
    """The process file with what the list of targets declares itself."""
    for kind in ("tools", "frames", "signals"):
        ours, theirs = getattr(own, kind), getattr(process, kind)
        for name in ours:
            same = next((n for n in theirs if n.lower() == name.lower()), None)
            if same is not None and (same != name or theirs[same] != ours[name]):
                top.table(kind).say(TWO_TABLES, name, name=marked(name))
    return replace(
        process,
        robot=own.robot or process.robot,
        defaults=own.defaults if "motion" in top.content else process.defaults,
        tools={**process.tools, **own.tools},
        frames={**process.frames, **own.frames},
        signals={**process.signals, **own.signals},
        seen=own.seen if "seen" in top.content else process.seen,
    )


def _target_tables(top: Table) -> Iterator[Table]:
    """Each of the targets as a table."""
    entries = top.content.get("targets", [])
    if not isinstance(entries, list):
        top.say(NOT_A_TABLE, "targets", what=f"is {kind_of(entries)}")
        return
    if not entries:
        top.say(NO_TARGETS, "targets")
    for number, entry in enumerate(entries):
        table = Table(top.page, ("targets", str(number)), entry if isinstance(entry, dict) else {})
        if not isinstance(entry, dict):
            table.say(NOT_A_TABLE, what=f"holds {kind_of(entry)}")
        else:
            yield table


def _number_list_reader(least: int, most: int, unit: str, *, gaps: bool = False) -> values.Read:
    """Numbers in brackets, between `least` and `most` of them; gaps: nan for none."""
    cure = f"write {least}{f' to {most}' if most > least else ''} numbers of {unit} in brackets"
    one = values.number(unit, least=-LARGEST_POSITION, most=LARGEST_POSITION)

    def read(value: Any) -> tuple[float, ...]:
        if not isinstance(value, list):
            raise Wrong(f"is {kind_of(value)}", cure)
        if not least <= len(value) <= most:
            raise Wrong(f"has {len(value)} entries", cure)
        return tuple(
            math.nan if gaps and isinstance(v, float) and math.isnan(v) else one(v) for v in value
        )

    return read


def _euler_reader(order: rotations.EulerOrder) -> values.Read:
    angles = _number_list_reader(3, 3, "degrees")

    def read(value: Any) -> Any:
        return tuple(rotations.from_euler(angles(value), order).tolist())

    return read


def _read_configuration(value: Any) -> Configuration:
    form = "{back = false, down = false, flip = false, quadrants = [0, 0, 0]}"
    if not isinstance(value, dict) or value.keys() != {"back", "down", "flip", "quadrants"}:
        raise Wrong("does not state the whole arm branch", f"write {form}")
    quadrants = value["quadrants"]
    if not isinstance(quadrants, list) or len(quadrants) != 3:
        raise Wrong("has no three quadrants", f"write {form}")
    quadrant = values.whole(-127, 127)
    one, four, six = (quadrant(q) for q in quadrants)
    back, down, flip = (values.truth(value[key]) for key in ("back", "down", "flip"))
    return Configuration(back, down, flip, (one, four, six))


TARGET_KEYS: Final[Mapping[str, values.Read]] = {
    "name": values.text,
    "position": _number_list_reader(3, 3, "mm"),
    "quaternion": values.quaternion,
    "euler_zyx": _euler_reader("ZYX"),
    "euler_xyz": _euler_reader("XYZ"),
    "euler_zyz": _euler_reader("ZYZ"),
    "joints": _number_list_reader(1, MOST_JOINTS, "degrees", gaps=True),
    "configuration": _read_configuration,
    "external": _number_list_reader(1, 6, "mm or degrees", gaps=True),
    "kind": values.choice(*rows.KIND_WORDS),
    "speed": values.speed,
    "blend": values.blend,
    "tool": values.text,
    "frame": values.text,
    "comment": values.text,
    "set": values.switches,
    "wait": values.number("seconds", least=0.0),
}


@dataclass(slots=True)
class _StatedTarget:
    """A target as the file states it; found: its values by key, without the wrong ones."""

    name: str
    table: Table
    found: dict[str, Any]
    kind: Kind


class _TargetReader:
    """Targets and moves, one target after the other."""

    def __init__(self, top: Table, process: Process) -> None:
        self.top, self.process = top, process
        self.names = rows.RowNames()
        self.targets: dict[str, Target] = {}
        self.joint_targets: dict[str, JointTarget] = {}
        self._all: list[_StatedTarget] = []

    def moves(self, number: int, table: Table) -> Iterator[Statement]:
        """The statements of one target: comment, move, signals, wait."""
        found = table.read(TARGET_KEYS)
        label = f"target {number + 1}"
        span = table.page.spans.get(table.path)
        line = table.page.source.line_column(span.start)[0] if span else None
        where = {"path": table.page.source.path, "line": line, "place": label}
        name = self.names.of(found.get("name", ""), where, label)
        usual = rows.default_kind(self.process) if self._all else Kind.JOINT
        known = rows.KIND_WORDS.get(found.get("kind", ""), usual)
        one = _StatedTarget(name, table, found, known)
        if "joints" in table.content:
            one.kind = Kind.JOINT
        via = self._all[-1].name if self._all else ""
        self._all.append(one)
        if comment := " ".join(found.get("comment", "").split()):
            yield Comment("".join(c for c in comment if c.isprintable()))
        yield from self._move(one, via)
        yield from self._after(one)

    def _move(self, one: _StatedTarget, via: str) -> Iterator[Statement]:
        motion = self._motion(one)
        external = (*one.found.get("external", ()), *NO_EXTERNAL)[:6]
        if not self._is_complete(one):
            return
        if "joints" in one.table.content:
            self.joint_targets[one.name] = JointTarget(one.found.get("joints", ()), external)
            yield MoveJoints(Name(one.name), motion)
            return
        pose = Pose(one.found.get("position", (0.0, 0.0, 0.0)), self._orientation(one))
        self.targets[one.name] = Target(pose, one.found.get("configuration"), external)
        if one.kind is Kind.END:
            yield MoveCircular(Name(via), Name(one.name), motion)
        elif one.kind in (Kind.JOINT, Kind.LINEAR):
            yield Move("joint" if one.kind is Kind.JOINT else "linear", Name(one.name), motion)

    def _is_complete(self, one: _StatedTarget) -> bool:
        """Whether the target is a pose or joints, and says what belongs to that alone."""
        there, table, name = one.table.content, one.table, marked(one.name)
        turns = [key for key in ORIENTATIONS if key in there]
        if "joints" in there:
            if "position" in there or turns:
                table.say(POSE_OR_JOINTS, "joints", name=name, what="a pose and joints")
                return False
            if there.get("kind", "joint") != "joint":
                table.say(JOINTS_BY_LINE, "kind", name=name, kind=there["kind"])
                return False
            return True
        if "position" not in there:
            table.say(POSE_OR_JOINTS, name=name, what="neither a position nor joints")
            return False
        if len(turns) != 1:
            what = "two orientations" if turns else "no orientation"
            table.say(WRONG_ORIENTATION, turns[-1] if turns else None, name=name, what=what)
            return False
        return True

    def _orientation(self, one: _StatedTarget) -> Any:
        if "quaternion" in one.found:
            turn, length = one.found["quaternion"]
            if abs(length - 1.0) > values.EXACT_LENGTH:
                one.table.say(REPAIRED, "quaternion", key="quaternion", length=length)
            return turn
        angles = (one.found[key] for key in ORIENTATIONS if key in one.found)
        return next(angles, Pose().quaternion)

    def _motion(self, one: _StatedTarget) -> Motion:
        """The motion of a target; what it leaves out is as the defaults say."""
        found, defaults = one.found, self.process.defaults
        names = {}
        for kind, rule, find in (
            ("tool", rows.UNKNOWN_TOOL, rows.known_tool),
            ("frame", rows.UNKNOWN_FRAME, rows.known_frame),
        ):
            given = found.get(kind) or getattr(defaults, kind)
            names[kind] = find(given, self.process) or given
            if find(given, self.process) is None:
                declared = getattr(self.process, kind + "s")
                cure = rows.cure_for(kind, given, declared)
                one.table.say(rule, kind, name=marked(given), more="", cure=cure)
        speed, blend = found.get("speed", defaults.speed), found.get("blend", defaults.motion.blend)
        return Motion(speed, blend, names["tool"], names["frame"])

    def _after(self, one: _StatedTarget) -> Iterator[Statement]:
        for key in ("set", "wait"):
            if key in one.found and one.kind is Kind.VIA:
                one.table.say(rows.VIA_ACTION, key, what=f"`{key}`")
        for given, value in one.found.get("set", {}).items():
            signal = output_signal(given, self.process)
            if signal is None:
                cure = rows.cure_for("signal", given, self.process.signals)
                one.table.say(rows.UNKNOWN_SIGNAL, "set", name=marked(given), cure=cure)
                continue
            declared = self.process.signals[signal]
            most = rows.most_value(declared)
            if most < np.inf and not (value == int(value) and 0 <= value <= most):
                fields = {"kind": declared.kind, "name": marked(signal), "value": value}
                one.table.say(rows.NOT_ITS_VALUE, "set", **fields, most=most)
            yield SetSignal(signal, _number_expression(value))
        if "wait" in one.found:
            yield Wait(_number_expression(one.found["wait"]))

    def check_arcs(self) -> None:
        """A `via` target is followed by its `end` and comes after one to start from."""
        kinds = np.array([one.kind for one in self._all], dtype=np.uint8)
        for row, what in rows.broken_arcs(kinds):
            self._all[row].table.say(rows.BROKEN_ARC, "kind", what=what)


def _number_expression(value: float) -> Number:
    return Number(int(value) if float(value).is_integer() else value)
