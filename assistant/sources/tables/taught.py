"""Files of taught targets, as TOML: read as a move to each in order, or as `moves` say, and edited.

    robot = "irb1200-7-0.7"         # the arm that it was taught on: joints are of this arm only
    joint_percent = 20              # of joint moves, where a controller takes no mm/s

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

    [[moves]]                       # left out: one move to each target, in the order of the file
    to = "above"                    # as often as wanted; kind, speed, blend, comment, set and wait
    set = {glue = 0}                # may follow, and count before those of the target

    moves = ["home", {to = "above", wait = 1}, "home"]    # the same in brackets, before all tables

Only the name and one of `position` and `joints` are required. `with_target` adds a target, or
teaches one again, and changes nothing else of the text.
"""

from __future__ import annotations

import math
import pathlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, Rule, Severity, Span, error, has_errors, info
from assistant.base.near_names import near_name
from assistant.base.source_text import SourceText, decode, read_bytes
from assistant.base.toml_edits import (
    is_alike,
    toml_value,
    with_line,
    with_other_key,
    with_values,
)
from assistant.base.toml_text import key_spans, sections, toml_content
from assistant.program import settings_tables as values
from assistant.program.expressions import Name, Number
from assistant.program.geometry import NO_EXTERNAL, Configuration, JointTarget, Pose, Target
from assistant.program.motion import FINE, Kind
from assistant.program.program import identifier
from assistant.program.settings_tables import ENCODINGS, REPAIRED, Table, Wrong, kind_of, read_toml
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
from assistant.sources.process import NO_PROCESS, Process
from assistant.sources.process.file import process_in
from assistant.sources.reading import Reading
from assistant.sources.tables import rows
from assistant.sources.tables.columns import output_signal
from assistant.sources.tables.headers import MOST_JOINTS
from assistant.sources.tables.headers import shown as marked
from assistant.sources.tables.rows import LARGEST_POSITION

ERROR: Final = Severity.ERROR
_NO_TARGETS = error(
    "TB501", "there are no targets", "write [[targets]] and its keys for each of them"
)
_NOT_A_TABLE = error("TB502", "`targets` {what}", "write [[targets]] above each target")
_POSE_OR_JOINTS = error(
    "TB503", "target {name} has {what}", "give `position` and an orientation, or `joints`"
)
_WRONG_ORIENTATION = error(
    "TB504", "target {name} has {what}", "give one of `quaternion`, `euler_zyx`, …"
)
_JOINTS_BY_LINE = error(
    "TB505", "target {name} has joints, which no {kind} move reaches", 'write kind = "joint"'
)
_NOT_MOVES = error(
    "TB514",
    "`moves` {what}",
    'write the names of targets in brackets, ["home", "above", "home"], or [[moves]] and `to`',
)
_NOT_A_TARGET = error("TB515", "there is no target {name} to move to", "{cure}")
_NOT_VISITED = info(
    "TB516",
    "no move leads to target {name}{more}",
    "name it in `moves`, or delete it",
)
_TWO_TABLES = error(
    "TB506", "{name} is declared here and, differently, in the process file", "keep one of them"
)

ORIENTATIONS: Final = ("quaternion", "euler_zyx", "euler_xyz", "euler_zyz")


def read(path: pathlib.Path, process: Process) -> Reading:
    """The pseudo-program of a TOML list of targets; raises Unreadable or Refused."""
    return read_taught(decode(read_bytes(path), str(path), ENCODINGS), path.stem, process)


def read_taught(source: SourceText, stem: str, process: Process) -> Reading:
    """The pseudo-program of a text, named after a file's stem."""
    top = read_toml(source)
    own = process_in(top, beside=("targets", "moves"))
    cell = _with_own_tables(top, own, process)
    path = source.path or ""
    name, notes = rows.program_name(stem, path)
    taught = _TargetReader(top, cell)
    for number, table in enumerate(_target_tables(top)):
        taught.declare(number, table)
    visits = [*_visits(top, taught.declared)]
    body = [s for visit in visits for s in taught.statements(visit)]
    taught.check_arcs()
    program = rows.program_of(name, body, cell, taught.targets, taught.joint_targets)
    if cornered := rows.set_in_corners(program):
        first = next(
            one
            for one in visits
            if one.target.name == cornered[0] and "set" in one.found
            if one.found.get("blend", cell.defaults.motion.blend) != FINE
        )
        first.at("set").say(rows.SET_IN_CORNER, "set", names=marked(", ".join(cornered), 120))
    if left := rows.left_by_joints(program):
        back = next(
            second
            for first, second in pairwise(visits)
            if left.get(first.target.name) == second.target.name
        )
        names = marked(", ".join(left), 120)
        back.at("kind").say(rows.LEFT_BY_JOINTS, "kind", names=names)
    # What is wrong with a target is found at each move to it.
    findings = (*notes, *dict.fromkeys(top.page.findings), *taught.names.findings)
    if has_errors(findings):
        raise Refused(*sorted(findings, key=lambda f: f.line or 0))
    return Reading(program, findings, cell.joint_percent, cell.seen)


def _with_own_tables(top: Table, own: Process, process: Process) -> Process:
    """The process file with what the list of targets declares itself."""
    for kind in ("tools", "frames", "signals"):
        ours, theirs = getattr(own, kind), getattr(process, kind)
        for name in ours:
            same = next((n for n in theirs if n.lower() == name.lower()), None)
            if same is not None and (same != name or theirs[same] != ours[name]):
                top.table(kind).say(_TWO_TABLES, name, name=marked(name))
    return replace(
        process,
        robot=own.robot or process.robot,
        defaults=own.defaults if "motion" in top.content else process.defaults,
        tools={**process.tools, **own.tools},
        frames={**process.frames, **own.frames},
        signals={**process.signals, **own.signals},
        joint_percent=own.joint_percent or process.joint_percent,
        seen=own.seen if "seen" in top.content else process.seen,
    )


def _target_tables(top: Table) -> Iterator[Table]:
    """Each of the targets as a table."""
    entries = top.content.get("targets", [])
    if not isinstance(entries, list):
        top.say(_NOT_A_TABLE, "targets", what=f"is {kind_of(entries)}")
        return
    if not entries:
        top.say(_NO_TARGETS, "targets")
    for number, entry in enumerate(entries):
        table = Table(top.page, ("targets", str(number)), entry if isinstance(entry, dict) else {})
        if not isinstance(entry, dict):
            table.say(_NOT_A_TABLE, what=f"holds {kind_of(entry)}")
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


VISIT_KEYS: Final[Mapping[str, values.Read]] = {
    "to": values.text,
    **{key: TARGET_KEYS[key] for key in ("kind", "speed", "blend", "comment", "set", "wait")},
}


@dataclass(slots=True)
class _StatedTarget:
    """A target as the file states it; found: its values by key, without the wrong ones.

    given: its name there. tool, frame: names of those that are declared. complete: it has one
    place, which its keys agree about.
    """

    given: str
    name: str
    table: Table
    found: dict[str, Any]
    tool: str
    frame: str
    complete: bool


@dataclass(slots=True)
class _Visit:
    """A move to a target. table: what states it; found: its own values, then the target's."""

    target: _StatedTarget
    table: Table
    found: dict[str, Any]

    def at(self, key: str) -> Table:
        """The table that states a key."""
        return self.table if key in self.table.content else self.target.table


def _visits(top: Table, declared: Sequence[_StatedTarget]) -> Iterator[_Visit]:
    """The moves of the file: those of `moves`, without it one to each target."""
    if "moves" not in top.content:
        yield from (_Visit(one, one.table, one.found) for one in declared)
        return
    entries, there = top.content["moves"], {one.given.strip().lower(): one for one in declared}
    if not isinstance(entries, list) or not entries:
        what = f"is {kind_of(entries)}" if entries != [] else "names no target"
        top.say(_NOT_MOVES, "moves", what=what)
        return
    visited = set[str]()
    for number, entry in enumerate(entries):
        content = {"to": entry} if isinstance(entry, str) else entry
        table = Table(
            top.page, ("moves", str(number)), content if isinstance(content, dict) else {}
        )
        if not isinstance(content, dict):
            table.say(_NOT_MOVES, what=f"holds {kind_of(entry)}")
            continue
        found = table.read(VISIT_KEYS)
        if "to" not in content:
            table.say(_NOT_MOVES, what="has a move that names no target")
        if "to" not in found:
            continue
        name = found.pop("to")
        if (target := there.get(name.strip().lower())) is None:
            near = near_name(name, [one.given for one in declared])
            cure = f"write `{near}`" if near else "add [[targets]] with this name, or change `to`"
            table.say(_NOT_A_TARGET, name=marked(name), cure=cure)
            continue
        visited.add(target.name)
        yield _Visit(target, table, {**target.found, **found})
    if left := [one for one in declared if one.name not in visited]:
        name = marked(left[0].given)
        more = f", nor to {len(left) - 1} more" if len(left) > 1 else ""
        left[0].table.say(_NOT_VISITED, "name", name=name, more=more)


class _TargetReader:
    """Targets and moves, one target after the other."""

    def __init__(self, top: Table, process: Process) -> None:
        self.top, self.process = top, process
        self.names = rows.RowNames()
        self.targets: dict[str, Target] = {}
        self.joint_targets: dict[str, JointTarget] = {}
        self.declared: list[_StatedTarget] = []
        self._visited: list[tuple[_Visit, Kind]] = []

    def declare(self, number: int, table: Table) -> None:
        """Take in a target, whether or not a move leads to it."""
        found = table.read(TARGET_KEYS)
        label = f"target {number + 1}"
        span = table.page.spans.get(table.path)
        line = table.page.source.line_column(span.start)[0] if span else None
        where = {"path": table.page.source.path, "line": line, "place": label}
        given = found.get("name", "")
        name = self.names.of(given, where, label)
        tool, frame = (self._declared(table, found, kind) for kind in ("tool", "frame"))
        one = _StatedTarget(given, name, table, found, tool, frame, complete=False)
        one.complete = self._is_complete(one)
        self.declared.append(one)
        # External axes that are not stated do not exist.
        external = (*found.get("external", ()), *NO_EXTERNAL)[:6]
        if not one.complete:
            return
        if "joints" in table.content:
            self.joint_targets[name] = JointTarget(found.get("joints", ()), external)
        else:
            pose = Pose(found.get("position", (0.0, 0.0, 0.0)), self._orientation(one))
            self.targets[name] = Target(pose, found.get("configuration"), external)

    def statements(self, visit: _Visit) -> Iterator[Statement]:
        """The statements of one move: comment, move, signals, wait."""
        target, found = visit.target, visit.found
        # The first move comes from anywhere: it is a joint move, and there is no corner to round.
        usual = rows.default_kind(self.process) if self._visited else Kind.JOINT
        kind = rows.KIND_WORDS.get(found.get("kind", ""), usual)
        if not self._visited and "kind" not in found:
            visit.found = found = {**found, "blend": FINE}
        if "joints" in target.table.content:
            # Joints are reached by a joint move whatever the defaults say.
            kind = Kind.JOINT
            stated = visit.at("kind").content.get("kind", "joint")
            if target.complete and stated != "joint":
                visit.at("kind").say(_JOINTS_BY_LINE, "kind", name=marked(target.name), kind=stated)
        via = self._visited[-1][0].target.name if self._visited else ""
        stands = self._stands_at(visit, kind)
        if stands:
            visit.table.say(_STANDS_THERE, "to", name=marked(target.name))
        else:
            self._visited.append((visit, kind))
        if comment := " ".join(found.get("comment", "").split()):
            # A comment is one line of a program: control characters would end it.
            yield Comment("".join(c for c in comment if c.isprintable()))
        if target.complete and not stands:
            yield from self._move(visit, kind, via)
        yield from self._after(visit, kind)

    def _stands_at(self, visit: _Visit, kind: Kind) -> bool:
        """True if the move before has ended at the target, in a stop."""
        if not self._visited:
            return False
        before, came = self._visited[-1]
        blend = before.found.get("blend", self.process.defaults.motion.blend)
        arcs = (Kind.VIA, Kind.END)
        return before.target is visit.target and blend == FINE and not {kind, came} & {*arcs}

    def _move(self, visit: _Visit, kind: Kind, via: str) -> Iterator[Statement]:
        name, defaults = Name(visit.target.name), self.process.defaults
        speed = visit.found.get("speed", defaults.speed)
        blend = visit.found.get("blend", defaults.motion.blend)
        motion = Motion(speed, blend, visit.target.tool, visit.target.frame)
        if name.name in self.joint_targets:
            yield MoveJoints(name, motion)
        elif kind is Kind.END:
            yield MoveCircular(Name(via), name, motion)
        elif kind in (Kind.JOINT, Kind.LINEAR):
            yield Move("joint" if kind is Kind.JOINT else "linear", name, motion)

    def _is_complete(self, one: _StatedTarget) -> bool:
        """True if the target is a pose or joints, and states only the keys of that form."""
        there, table, name = one.table.content, one.table, marked(one.name)
        turns = [key for key in ORIENTATIONS if key in there]
        if "joints" in there:
            if "position" in there or turns:
                table.say(_POSE_OR_JOINTS, "joints", name=name, what="a pose and joints")
                return False
            return True
        if "position" not in there:
            table.say(_POSE_OR_JOINTS, name=name, what="neither a position nor joints")
            return False
        if len(turns) != 1:
            what = "two orientations" if turns else "no orientation"
            table.say(_WRONG_ORIENTATION, turns[-1] if turns else None, name=name, what=what)
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

    def _declared(self, table: Table, found: Mapping[str, Any], kind: str) -> str:
        """The tool or the frame of a target; what it leaves out is as the defaults say."""
        rule, find = _KNOWN[kind]
        given: str = found.get(kind) or getattr(self.process.defaults, kind)
        name = find(given, self.process)
        if name is None:
            cure = rows.cure_for(kind, given, getattr(self.process, kind + "s"))
            table.say(rule, kind, name=marked(given), more="", cure=cure)
        return name or given

    def _after(self, visit: _Visit, kind: Kind) -> Iterator[Statement]:
        for key in ("set", "wait"):
            if key in visit.found and kind is Kind.VIA:
                visit.at(key).say(rows.VIA_ACTION, key, what=f"`{key}`")
        table = visit.at("set")
        for given, value in visit.found.get("set", {}).items():
            signal = output_signal(given, self.process)
            if signal is None:
                cure = rows.cure_for("signal", given, self.process.signals)
                table.say(rows.UNKNOWN_SIGNAL, "set", name=marked(given), cure=cure)
                continue
            declared = self.process.signals[signal]
            most = rows.most_value(declared)
            # A digital signal takes the whole numbers that its bits can express.
            if most < np.inf and not (value == int(value) and 0 <= value <= most):
                fields = {"kind": declared.kind, "name": marked(signal), "value": value}
                table.say(rows.NOT_ITS_VALUE, "set", **fields, most=most)
            yield SetSignal(signal, _number_expression(value))
        if "wait" in visit.found:
            yield Wait(_number_expression(visit.found["wait"]))

    def check_arcs(self) -> None:
        """A `via` target is followed by its `end` and comes after one to start from."""
        kinds = np.array([kind for _, kind in self._visited], dtype=np.uint8)
        for row, what in rows.broken_arcs(kinds):
            self._visited[row][0].at("kind").say(rows.BROKEN_ARC, "kind", what=what)


_STANDS_THERE: Final = info(
    "TB517",
    "the arm stands at {name} already: the move there is left out, and what it sets and waits for"
    " follows",
    "",
)
_KNOWN: Final[Mapping[str, tuple[Rule, Callable[[str, Process], str | None]]]] = {
    "tool": (rows.UNKNOWN_TOOL, rows.known_tool),
    "frame": (rows.UNKNOWN_FRAME, rows.known_frame),
}


def _number_expression(value: float) -> Number:
    return Number(int(value) if float(value).is_integer() else value)


_NO_NAME: Final = error(
    "TB507",
    "`{name}` cannot name a target",
    "write {known}, or another name of letters and digits with `_` between them, a letter first",
)
_TARGETS_IN_BRACKETS: Final = error(
    "TB508",
    "the targets stand in brackets, where none can be added",
    "write [[targets]] above each of them",
)
TARGET_EXISTS: Final = error(
    "TB509", "there is a target `{name}` already", "choose another name, or ask to teach it anew"
)
_OTHER_ROBOT: Final = error(
    "TB510",
    "the targets were taught on `{there}`, and this one is of `{given}`",
    "name another file: joints and branches of one arm mean nothing to another one",
)
_EXTERNAL_AXES: Final = error(
    "TB511",
    "`{name}` has external axes, and the controller tells no position of them",
    "give it another name, or take `external` out",
)
_NO_ROBOT: Final = error(
    "TB512",
    "joints mean a place of one arm, and the file names none",
    'write robot = "{robot}" as its first line',
)

_NOT_KEPT: Final = error(
    "TB513",
    "`{name}` cannot be written into {file} without changing the rest of it; it was not touched",
    "name another file",
)

_PLACE_KEYS: Final = ("position", "quaternion", "configuration", "joints", *ORIENTATIONS)
"""Keys of a target that change when it is taught anew."""


@dataclass(frozen=True, slots=True)
class TaughtTarget:
    """A target from a file of targets.

    values: of a pose or of joints, by key, in their order. more: tool and frame, which only a new
    target gets. robot: the robot that it was taught on, None if unknown.
    """

    name: str
    values: Mapping[str, Any]
    more: Mapping[str, str]
    robot: str | None = None


def new_file_text(robot: str | None) -> str:
    """The text of a file before its first target."""
    return "" if robot is None else f"robot = {toml_value(robot)}\n"


def with_target(
    source: SourceText,
    stem: str,
    target: TaughtTarget,
    process: Process = NO_PROCESS,
    *,
    again: bool = False,
) -> tuple[SourceText, Reading]:
    """The text with the target, and what it reads as. again: one of its name is taught anew.

    Raises Refused and Unreadable; what the text says of all else stays to the letter.
    """
    if (known := identifier(target.name)) != target.name:
        raise Refused(_NO_NAME(path=source.path, name=target.name, known=known))
    content = read_toml(source).content
    # The list's own robot comes before that of the process file.
    there = content.get("robot", process.robot)
    if target.robot is not None and there not in (None, target.robot):
        raise Refused(_OTHER_ROBOT(path=source.path, there=there, given=target.robot))
    if "joints" in target.values and there is None:
        named = target.robot or "NAME"
        raise Refused(_NO_ROBOT(path=source.path, robot=named))
    entries = content.get("targets", [])
    number = _entry_number(entries, target.name)
    if number is None:
        text = _with_added_target(source, target)
    elif again:
        text = _with_new_place(source, number, entries[number], target)
    else:
        span = key_spans(source.text).get(("targets", str(number)), Span(0, 0))
        raise Refused(source.finding(TARGET_EXISTS, span, name=target.name))
    # The text is read back: edits of lines must not change anything else.
    if not is_alike(toml_content(text), _content_with(content, number, target)):
        raise Refused(_NOT_KEPT(path=source.path, name=target.name, file=source.path or stem))
    changed = replace(source, text=text)
    return changed, read_taught(changed, stem, process)


def _entry_number(entries: Any, name: str) -> int | None:
    """Number of the target of a name, compared without case."""
    if not isinstance(entries, list):
        return None
    named = (e.get("name") if isinstance(e, dict) else None for e in entries)
    same = (i for i, n in enumerate(named) if isinstance(n, str) and n.lower() == name.lower())
    return next(same, None)


def _is_in_brackets(source: SourceText) -> bool:
    span = key_spans(source.text).get(("targets",))
    return span is not None and not source.text[: span.start].rstrip(" \t").endswith("[[")


def _with_added_target(source: SourceText, target: TaughtTarget) -> str:
    if _is_in_brackets(source):
        raise Refused(
            source.finding(
                _TARGETS_IN_BRACKETS, key_spans(source.text)[("targets",)], name=target.name
            )
        )
    end, text = source.newline, source.text
    before = "" if not text else end if text.endswith(end) else end + end
    values = {"name": target.name, **target.values, **target.more}
    lines = ["[[targets]]", *(f"{key} = {toml_value(value)}" for key, value in values.items())]
    return text + before + "".join(line + end for line in lines)


def _with_new_place(
    source: SourceText, number: int, entry: Mapping[str, Any], target: TaughtTarget
) -> str:
    """Change the place of one entry and leave what else it says: its speed, its comments.

    A new value is where the old one of the same meaning was.
    """
    path = ("targets", str(number))
    if _is_in_brackets(source):
        span = key_spans(source.text)[path]
        raise Refused(source.finding(_TARGETS_IN_BRACKETS, span, name=target.name))
    if "external" in entry:
        span = key_spans(source.text)[*path, "external"]
        raise Refused(source.finding(_EXTERNAL_AXES, span, name=target.name))
    section = sections(source.text)[path]
    # Only the lines of this table: its keys are looked up without a path.
    text = source.text[section.start : section.stop]
    rest, last = dict(target.values), "name"
    for old in dict.fromkeys(key[2] for key, _ in section.pairs):
        if old not in _PLACE_KEYS:
            continue
        new = _successor(old, entry, rest)
        if new is None:
            text = with_values(text, {(old,): None}) or text
            continue
        value, last = rest.pop(new), new
        if new != old:
            # A comment after the value tells of it, and may be wrong for another kind of value.
            text = with_other_key(text, old, new, value)
        elif value != entry[old]:
            text = with_values(text, {(old,): value}) or text
    for new, value in rest.items():
        text = with_line(text, new, value, after=last)
        last = new
    return source.text[: section.start] + text + source.text[section.stop :]


def _successor(key: str, entry: Mapping[str, Any], rest: Mapping[str, Any]) -> str | None:
    """Return the key that replaces a key: the same, or one with the same meaning."""
    if key in rest:
        return key
    if key in ORIENTATIONS and "quaternion" in rest and "quaternion" not in entry:
        return "quaternion"
    places = ("position", "joints")
    return next((p for p in places if key in places and p in rest), None)


def _content_with(
    content: Mapping[str, Any], number: int | None, target: TaughtTarget
) -> dict[str, Any]:
    """Intended content of a file with a new target, or with one that is taught again."""
    entries = list(content.get("targets", []))
    if number is None:
        entries.append({"name": target.name, **target.values, **target.more})
    else:
        rest = {key: one for key, one in entries[number].items() if key not in _PLACE_KEYS}
        entries[number] = {**rest, **target.values}
    return {**content, "targets": entries}
