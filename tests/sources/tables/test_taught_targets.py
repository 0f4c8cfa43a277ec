"""Taught targets in TOML: targets, and a move to each in the order of the file."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import sources
from assistant.base import rotations
from assistant.base.diagnostics import Refused, Severity
from assistant.base.source_text import SourceText
from assistant.program.expressions import Name, Number
from assistant.program.geometry import Configuration, Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import Signal
from assistant.program.statements import (
    Comment,
    Motion,
    Move,
    MoveCircular,
    MoveJoints,
    SetSignal,
    Wait,
)
from assistant.sources import Reading
from assistant.sources.process import NO_PROCESS, Defaults, Process
from assistant.sources.tables.taught import read_taught
from tests.examples import drawn
from tests.tables import every_row

CELL = Process(
    defaults=Defaults(speed=Speed(70.0), blend=Blend(3.0)),
    tools={"Torch": Tool(Pose((0.0, 0.0, 120.0)))},
    signals={"glue": Signal("digital", "output", 8), "ready": Signal("digital", "input", 1)},
)
POSE = "position = [1, 2.5, -3]\nquaternion = [0, 1, 0, 0]\n"


def read(text: str, process: Process = NO_PROCESS) -> Reading:
    return read_taught(SourceText(text, "part.toml"), "part", process)


def test_targets_moves_and_what_stands_around_them() -> None:
    reading = read(
        """
        [tools.gripper]
        tip = [0, 0, 60]
        [frames.table]
        position = [400, 0, 20]

        [[targets]]
        name = "home"
        joints = [0, 10, nan, -20.5]
        external = [100]
        [[targets]]
        name = "above"
        kind = "joint"
        position = [1, 2, 3]
        euler_zyx = [90, 0, 0]
        speed = 250
        blend = "fine"
        tool = "GRIPPER"
        frame = "table"
        comment = "over\\nthe part"
        set = {glue = true}
        wait = 0.5
        [[targets]]
        name = "on"
        position = [4, 5, 6]
        quaternion = [0, 0, 1, 0]
        tool = "torch"
        [targets.configuration]
        back = false
        down = true
        flip = true
        quadrants = [0, -1, 2]
        """,
        CELL,
    )
    program, half = reading.program, math.sqrt(0.5)
    assert reading.findings == ()
    assert program.tools == {"gripper": Tool(Pose((0.0, 0.0, 60.0))), **CELL.tools}
    assert program.frames == {"table": Frame(Pose((400.0, 0.0, 20.0)))}
    assert program.joint_targets == {
        "home": JointTarget((0.0, 10.0, math.nan, -20.5), (100.0, *[math.nan] * 5))
    }
    turn = program.targets["above"].pose.quaternion
    assert np.allclose(turn, (half, 0, 0, half), atol=1e-15)
    assert program.targets["on"] == Target(
        Pose((4.0, 5.0, 6.0), (0.0, 0.0, 1.0, 0.0)), Configuration(False, True, True, (0, -1, 2))
    )
    assert program.procedures[0].body == (
        MoveJoints(Name("home"), replace(CELL.defaults.motion, blend=FINE)),
        Comment("over the part"),
        Move("joint", Name("above"), Motion(Speed(250.0), FINE, "gripper", "table")),
        SetSignal("glue", Number(1)),
        Wait(Number(0.5)),
        Move("linear", Name("on"), Motion(Speed(70.0), FINE, "Torch")),
    )


def test_its_own_motion_table_comes_before_the_process_file() -> None:
    body = read('[motion]\nspeed = 20\n[[targets]]\nname = "p"\n' + POSE, CELL).program
    assert body.procedures[0].body == (Move("joint", Name("p"), Motion(Speed(20.0), FINE)),)


PLACES = "".join(
    f'[[targets]]\nname = "{name}"\nposition = [400, {y}, 300]\nquaternion = [0, 1, 0, 0]\n{more}\n'
    for name, y, more in (("Home", 0, ""), ("pick", 50, "speed = 30"), ("mid", 90, 'kind = "via"'))
)


def visited(text: str) -> list[tuple[str, float]]:
    """The targets of the moves in their order, each with the speed there."""
    moves = [s for s in read(text, CELL).program.statements() if isinstance(s, Move)]
    return [(m.target.name, m.motion.speed.tcp) for m in moves]  # type: ignore[union-attr]


def test_moves_name_a_target_as_often_as_wanted() -> None:
    text = (
        'moves = ["home", "pick", {to = "HOME", speed = 9}, "mid", {to = "pick", kind = "end"}]\n'
    )
    *_, arc = read(text + PLACES, CELL).program.statements()
    assert visited(text + PLACES) == [("Home", 70.0), ("pick", 30.0), ("Home", 9.0)]
    assert isinstance(arc, MoveCircular) and (arc.via, arc.target) == (Name("mid"), Name("pick"))
    tables = '[[moves]]\nto = "home"\n[[moves]]\nto = "pick"\n[[moves]]\nto = "Home"\nspeed = 9\n'
    assert visited(PLACES + tables) == visited(text + PLACES)


def test_a_move_may_state_what_its_target_does_not() -> None:
    one = POSE + 'comment = "here"\nset = {glue = 1}\nwait = 1\n'
    text = (
        'moves = ["q", {to = "p", comment = "away", set = {glue = 0}, wait = 2, blend = 4}, "p"]\n'
    )
    targets = "".join(f'[[targets]]\nname = "{name}"\n{one}' for name in "pq")
    body = read(text + targets, CELL).program.procedures[0].body
    said = [s.text for s in body if isinstance(s, Comment)]
    assert said == ["here", "away", "here"]
    assert [s.value for s in body if isinstance(s, SetSignal)] == [Number(1), Number(0), Number(1)]
    assert [s.seconds for s in body if isinstance(s, Wait)] == [Number(1), Number(2), Number(1)]
    corners = [s.motion.blend for s in body if isinstance(s, Move)]
    assert corners == [FINE, Blend(4.0), FINE]


def test_a_move_to_where_the_arm_stands_is_left_out() -> None:
    step = '{to = "home", set = {glue = 0}, wait = 2}'
    stop = '{to = "home", blend = "fine"}'
    reading = read(f'moves = ["pick", {stop}, {step}, "home", "pick"]\n{PLACES}', CELL)
    moves = [s.target.name for s in reading.program.statements() if isinstance(s, Move)]
    assert moves == ["pick", "Home", "pick"]
    assert [s.seconds for s in reading.program.statements() if isinstance(s, Wait)] == [Number(2)]
    codes = [f.code for f in reading.findings]
    assert codes.count("TB517") == 2 and "`Home`" in reading.findings[codes.index("TB517")].message


def test_a_target_that_no_move_leads_to_is_told() -> None:
    reading = read('moves = ["home", "pick", "home"]\n' + PLACES, CELL)
    assert [(f.code, f.severity) for f in reading.findings] == [("TB516", Severity.INFO)]
    assert "`mid`" in reading.findings[0].message and "mid" in reading.program.targets


def test_a_program_has_what_it_uses_of_a_cell(tmp_path: Path) -> None:
    cell = "".join(f"[tools.{name}]\ntip = [0, 0, 9]\n" for name in ("spare", "Torch"))
    cell += "[frames.spare_desk]\nposition = [1, 2, 3]\n"
    cell += '[signals.glue]\nnumber = 3\n[signals.ready]\ndirection = "input"\n'
    file = tmp_path / "task.toml"
    file.write_text(f'{cell}[[targets]]\nname = "p"\ntool = "torch"\nset = {{glue = 1}}\n{POSE}')
    program = sources.read(file).program
    assert [*program.tools, *program.frames, *program.signals] == ["Torch", "glue"]


def test_arcs() -> None:
    text = "".join(
        f'[[targets]]\nname = "p{i}"\nkind = "{kind}"\n{POSE}'
        for i, kind in enumerate(("linear", "via", "end"))
    )
    program = read(text).program
    assert list(program.targets) == ["p0", "p1", "p2"]
    assert program.procedures[0].body[1:] == (
        MoveCircular(Name("p1"), Name("p2"), NO_PROCESS.defaults.motion),
    )


def test_inline_tables_and_names_that_are_no_identifiers() -> None:
    reading = read(
        'targets = [{name = "a;b", position = [1, 2, 3], euler_xyz = [0, 0, 0]},\n'
        ' {name = "a b", joints = [1]}]'
    )
    assert list(reading.program.targets) == ["a_b"]
    assert list(reading.program.joint_targets) == ["a_b_2"]
    assert [(f.code, f.line) for f in reading.findings] == [("NM001", 1), ("NM002", 2)]


@pytest.mark.parametrize(
    ("key", "order"), [("euler_zyx", "ZYX"), ("euler_xyz", "XYZ"), ("euler_zyz", "ZYZ")]
)
@given(angles=st.tuples(*[st.floats(-179, 179)] * 3))
@settings(deadline=None, max_examples=drawn(40))
def test_orientations(key: str, order: rotations.EulerOrder, angles: tuple[float, ...]) -> None:
    program = read(
        f'[[targets]]\nname = "p"\nposition = [1, 2, 3]\n{key} = {list(angles)}\n'
    ).program
    found = program.targets["p"].pose.quaternion
    assert rotations.angle_between(found, rotations.from_euler(angles, order)) < 1e-6


def test_a_quaternion_nearly_of_unit_length_is_repaired_with_a_warning() -> None:
    reading = read(
        '[[targets]]\nname = "p"\nposition = [1, 2, 3]\nquaternion = [0, 1.0005, 0, 0]\n'
    )
    assert reading.program.targets["p"].pose.quaternion == (0.0, 1.0, 0.0, 0.0)
    assert [(f.severity, f.line) for f in reading.findings] == [(Severity.WARNING, 4)]


P = '[[targets]]\nname = "p"\n'
BAD = {
    "no toml": ("[[targets]", "CT301", 1),
    "nothing": ("# nothing", "TB501", 1),
    "a single table": ('[targets]\nname = "p"', "TB502", 1),
    "numbers": ("targets = [\n1, 2]", "TB502", 2),
    "unknown key": (P + POSE + "sped = 3", "CT302", 5),
    "unknown top key": ("[defaults]\n" + P + POSE, "CT302", 1),
    "nan": (P + "position = [1, nan, 3]\nquaternion = [1, 0, 0, 0]", "CT303", 3),
    "text": (P + 'position = [1, "2,5", 3]\nquaternion = [1, 0, 0, 0]', "CT303", 3),
    "huge": (P + "position = [1, 2e6, 3]\nquaternion = [1, 0, 0, 0]", "CT303", 3),
    "quaternion": (P + "position = [1, 2, 3]\nquaternion = [1, 0, 0, 1]", "CT303", 4),
    "two numbers": (P + "position = [1, 2]\nquaternion = [1, 0, 0, 0]", "CT303", 3),
    "no orientation": (P + "position = [1, 2, 3]", "TB504", 1),
    "two orientations": (P + POSE + "euler_zyx = [0, 0, 0]", "TB504", 5),
    "no target": (P, "TB503", 1),
    "both": (P + POSE + "joints = [1]", "TB503", 5),
    "no list of moves": ("moves = 3\n" + P + POSE, "TB514", 1),
    "no moves": ("moves = []\n" + P + POSE, "TB514", 1),
    "a number as a move": ("moves = [\n3]\n" + P + POSE, "TB514", 2),
    "a move to nothing": (P + POSE + "[[moves]]\nspeed = 3", "TB514", 5),
    "a move to no target": ('moves = ["q"]\n' + P + POSE, "TB515", 1),
    "a move with a place": (P + POSE + '[[moves]]\nto = "p"\ntool = "t"', "CT302", 7),
    "a move by a line to joints": (
        P + 'joints = [1]\n[[moves]]\nto = "p"\nkind = "linear"',
        "TB505",
        6,
    ),
    "an arc of moves without its end": (
        P + POSE + '[[moves]]\nto = "p"\n[[moves]]\nto = "p"\nkind = "via"',
        "TB308",
        9,
    ),
    "joints by a line": (P + 'joints = [1]\nkind = "linear"', "TB505", 4),
    "half a branch": (P + POSE + "configuration = {back = true}", "CT303", 5),
    "unknown kind": (P + POSE + 'kind = "fast"', "CT303", 5),
    "speed 0": (P + POSE + "speed = 0", "CT303", 5),
    "unknown tool": (P + POSE + 'tool = "drill"', "TB301", 5),
    "unknown frame": (P + POSE + 'frame = "desk"', "TB302", 5),
    "input set": (P + POSE + "set = {ready = 1}", "TB303", 5),
    "half a signal": (P + POSE + "set = {glue = 0.5}", "TB312", 5),
    "tool twice": ("[tools.torch]\n" + P + POSE, "TB506", 1),
    "same name": (P + POSE + P.replace('"p"', '"P"') + POSE, "TB309", 5),
    "no name": ("[[targets]]\n" + POSE, "TB310", 1),
    "via first": (P + POSE + 'kind = "via"', "TB308", 5),
    "end alone": (P + POSE + 'kind = "end"', "TB308", 5),
    "wait at via": (P + POSE + 'kind = "via"\nwait = 1', "TB311", 6),
}


@every_row("case", list(BAD))
def test_bad_input_is_refused_with_its_line_and_a_cure(case: str) -> None:
    text, code, line = BAD[case]
    with pytest.raises(Refused) as refused:
        read(text, CELL)
    found = [f for f in refused.value.findings if f.code == code]
    assert found, refused.value.findings
    assert (found[0].path, found[0].line) == ("part.toml", line)
    assert found[0].cure
    assert "\n" not in found[0].message


GOOD = P + POSE + 'kind = "joint"\n[[targets]]\nname = "q"\njoints = [1, 2]\nset = {glue = 1}\n'


@given(st.lists(st.tuples(st.integers(0, len(GOOD)), st.integers(0, 5), st.text(max_size=3))))
@settings(deadline=None, max_examples=drawn(150))
def test_damaged_lists_are_read_or_refused_never_crash(edits: list[tuple[int, int, str]]) -> None:
    text = GOOD
    for at, gone, put in edits:
        text = text[:at] + put + text[at + gone :]
    try:
        read(text, CELL)
    except Refused as refused:
        assert all(f.path == "part.toml" and f.code for f in refused.findings)
