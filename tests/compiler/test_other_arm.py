"""Programs of an IRB 120 on an RV-4FRL, and back: configurations that are true on each arm."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from assistant import robots
from assistant.checks.clearances import clearances
from assistant.compiler import Translation, compile, load, translate
from assistant.program.expressions import Name
from assistant.program.geometry import Frame, Pose, Target, Tool
from assistant.program.motion import FINE, Speed, configuration_of, configuration_row
from assistant.program.program import Procedure, Program
from assistant.program.statements import Motion, Move
from assistant.robots import Robot, solve_program

CELL = Path(__file__).parents[2] / "samples" / "melfa" / "cell.process.toml"
ABB, MITSUBISHI = robots.get("irb120-3-0.58"), robots.get("rv-4frl")
MELFA = ("melfa-basic-4", "melfa-basic-5", "melfa-basic-6")
TOOL = Tool(Pose((12.0, 0.0, 118.0), (0.9659258262890683, 0.0, 0.25881904510252074, 0.0)))
TABLE = Frame(Pose((20.0, -15.0, 30.0), (0.9914448613738104, 0.0, 0.0, 0.13052619222005157)))
MOTION = Motion(Speed(200.0, joint=20.0), FINE, "gripper", "table")
CLEAR = 5.0
"""Degrees and, of the wrist, distance from its singularity that the joints keep."""
ROUNDING = 0.1
"""mm that a target keeps from the end of the reach: MELFA-BASIC is printed with two decimals."""


def tips(arm: Robot, joints: np.ndarray) -> list[Pose]:
    """Where the tool is on the table for joints (n, a)."""
    return [
        TABLE.pose.inverse() @ Pose.of(p, q) @ TOOL.tip
        for p, q in zip(*arm.fk(joints), strict=True)
    ]


def flange(target: Target, program: Program) -> tuple[np.ndarray, np.ndarray]:
    tool, frame = program.tools["gripper"].tip, program.frames["table"].pose
    pose = frame @ target.pose @ tool.inverse()
    return np.array([pose.position]), np.array([pose.quaternion])


def program(arm: Robot, targets: dict[str, Target]) -> Program:
    moves = tuple(Move("joint", Name(name), MOTION) for name in targets)
    return Program(
        "cell", (Procedure("main", moves),), entry="main", targets=targets,
        tools={"gripper": TOOL}, frames={"table": TABLE}, robot=arm.name,
    )  # fmt: skip


def taught(arm: Robot, other: Robot, seed: int, count: int) -> dict[str, Target]:
    """Targets all over the range of an arm, in every branch of it, that another one reaches."""
    low, high = arm.limits.T
    joints = np.random.default_rng(seed).uniform(low + CLEAR, high - CLEAR, (3000, len(low)))
    joints = joints[np.abs(joints[:, 4]) > CLEAR]
    positions, quaternions = arm.fk(joints)
    both = np.ones(len(joints), dtype=bool)
    for shift in np.vstack([ROUNDING * np.eye(3), -ROUNDING * np.eye(3)]):
        for each in (arm, other):
            both &= each.ik(positions + shift, quaternions)[1].any(axis=1)
    joints = joints[both][: 2 * count]
    configurations = arm.configuration(joints)
    targets = {
        f"P{k}": Target(pose, configuration_of(row))
        for k, (pose, row) in enumerate(zip(tips(arm, joints), configurations, strict=True), 1)
    }
    while touched := in_itself(arm, targets) | in_itself(other, targets):
        targets = {name: target for name, target in targets.items() if name not in touched}
    assert len(targets) >= count
    return dict(list(targets.items())[:count])


def in_itself(arm: Robot, targets: dict[str, Target]) -> set[str]:
    """Names of targets at or before which an arm touches itself."""
    own = {name: Target(target.pose) for name, target in targets.items()}
    if arm is ABB:
        own = targets
    found = clearances(solve_program(program(arm, own), arm))
    return {name for one in found for name in re.findall(r"to `(P\d+)`", one.message)}


def kept(translation: Translation, folder: Path) -> Path:
    """The one file of a translation, in a folder."""
    ((name, data),) = translation.files.items()
    (folder / name).write_bytes(data)
    return folder / name


def said(arm: Robot, row: np.ndarray) -> list[int]:
    """What its controller reads of a configuration: of some makers only whole turns."""
    shape, quadrants = row[0, :3].tolist(), row[0, 3:].tolist()
    return shape + (quadrants if arm.counts == "quadrants" else [(q + 2) // 4 for q in quadrants])


def holds(file: Path, arm: Robot, language: str, count: int) -> None:
    """Every target of a file states a configuration that the arm can take there."""
    read = load(file, language=language, robot=arm).program
    assert len(read.targets) == count
    for name, target in read.targets.items():
        assert target.configuration is not None, name
        row = np.array([configuration_row(target.configuration)])
        joints = arm.joints_of(*flange(target, read), row)
        assert np.isfinite(joints).all(), (name, target)
        assert arm.inside(joints).all()
        assert said(arm, arm.configuration(joints)) == said(arm, row), name


@pytest.mark.slow
@pytest.mark.parametrize("language", MELFA)
@pytest.mark.parametrize("seed", range(3))
def test_configurations_are_right_on_either_arm(seed: int, language: str, tmp_path: Path) -> None:
    """RAPID for the IRB 120 → MELFA-BASIC for the RV-4FRL → RAPID for the IRB 120."""
    targets = taught(ABB, MITSUBISHI, seed, 40)
    written = compile(program(ABB, targets), language="rapid", robot=ABB)
    assert written.ok, written.findings
    source = kept(written, tmp_path)
    holds(source, ABB, "rapid", len(targets))
    there = translate(source, to=language, robot=MITSUBISHI, from_robot=ABB)
    assert there.ok, there.findings
    file = kept(there, tmp_path)
    holds(file, MITSUBISHI, language, len(targets))
    back = translate(
        file, to="rapid", robot=ABB, from_robot=MITSUBISHI, language=language, process=CELL
    )
    assert back.ok, back.findings
    holds(kept(back, tmp_path), ABB, "rapid", len(targets))


def test_what_the_smaller_arm_cannot_reach_is_named(tmp_path: Path) -> None:
    """An RV-4FRL reaches further than an IRB 120: which targets, is told."""
    near = taught(ABB, MITSUBISHI, 7, 4)
    far = Target(TABLE.pose.inverse() @ Pose((560.0, 40.0, 400.0), (0.0, 0.0, 1.0, 0.0)) @ TOOL.tip)
    cell = program(MITSUBISHI, {n: Target(t.pose) for n, t in near.items()} | {"PFAR": far})
    written = compile(cell, language="melfa-basic-5", robot=MITSUBISHI)
    assert written.ok, written.findings
    file = kept(written, tmp_path)
    back = translate(file, to="rapid", robot=ABB, from_robot=MITSUBISHI, language="melfa-basic-5")
    assert not back.files
    (finding,) = (f for f in back.findings if f.code == "RB102")
    assert finding.place == "main: 1 of 5 targets (PFAR)"


UNREAD = r"""MODULE M
  PERS tooldata tS:=[TRUE,[[40,0,155],[0.92388,0,0.382683,0]],[2.8,[15,0,70],[1,0,0,0],0,0,0]];
  PERS wobjdata wF:=[FALSE,TRUE,"",[[300,-40,120],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  CONST robtarget p10:=[[0,0,0],[0,1,0,0],[-1,-1,1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    down v100;{also}
  ENDPROC
  PROC down(speeddata v)
    MoveL p10,v,fine,tS\WObj:=wF;
  ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("also", ["", r"MoveJ p10,v100,fine,tS\WObj:=wF;"])
def test_what_only_vendor_text_goes_to_gets_no_configuration_of_the_flange(
    tmp_path: Path, also: str
) -> None:
    """Of the two branches that reach it on the IRB 120, [-1,-1,1,0] is one."""
    file = tmp_path / "M.mod"
    file.write_text(UNREAD.replace("{also}", also), "ascii")
    done = translate(file, to="rapid", from_robot="irb1200-7-0.7", robot="irb120-3-0.58")
    (text,) = done.files.values()
    (found,) = re.findall(r"p10:=\[\[0,0,0\],\[0,1,0,0\],\[([-0-9,]+)\]", text.decode("ascii"))
    assert found == "-1,-1,1,0"
    codes = {finding.code for finding in done.findings}
    assert ("CO513" in codes) == (not also)
