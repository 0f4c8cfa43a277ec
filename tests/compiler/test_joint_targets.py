"""Joint targets belong to an arm: on another one they put the flange where it was, or stop."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import assistant
from assistant import robots
from assistant.base.diagnostics import Severity
from assistant.compiler import Compiled, Translation, compile, load, translate
from assistant.program import pseudo
from assistant.program.geometry import JointTarget
from assistant.program.rewriting import records
from assistant.robots.retargeting import joints_on_other_arm

CELL = Path(__file__).parents[2] / "samples" / "melfa" / "cell.process.toml"
ABB, MITSUBISHI = robots.get("irb1200-7-0.7"), robots.get("rv-4frl")
SAMPLES = Path(__file__).parents[2] / "samples"
SAME = 0.03
"""mm: joints are printed with two decimals of a degree, about a metre from the tip."""

RAPID = """MODULE cell
    CONST jointtarget jSafe:=[[0,-20,20,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    VAR jointtarget jTwo{2}:=[[[10,-10,20,0,60,5],[9E9,9E9,9E9,9E9,9E9,9E9]],[[-10,-15,25,0,70,0],[9E9,9E9,9E9,9E9,9E9,9E9]]];
    VAR jointtarget jHere;
    PROC main()
        MoveAbsJ jSafe,v1000,fine,tool0;
        MoveAbsJ jTwo{2},v1000,fine,tool0;
        MoveAbsJ [[20,-10,20,0,60,5],[9E9,9E9,9E9,9E9,9E9,9E9]],v1000,fine,tool0;
        jHere:=CJointT();
        MoveAbsJ jHere,v1000,fine,tool0;
    ENDPROC
ENDMODULE
"""  # noqa: E501
MELFA = """1 Mov J1
2 J2=J1
3 Mov J2
4 J3=J_Curr
5 Mov J3
6 End
J1=(+0.00,-20.00,+100.00,+0.00,+90.00,+10.00)
"""


def written(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text, encoding="ascii")
    return folder / name


def kept(result: Translation | Compiled, folder: Path) -> Path:
    assert result.files, result.findings
    ((name, data),) = result.files.items()
    (folder / name).write_bytes(data)
    return folder / name


def flanges(file: Path, arm: robots.Robot) -> np.ndarray:
    """Where the joint targets of a file put the flange of an arm: (n, 7) in order of their x, y."""
    program = load(file).program
    joints = {
        arm.own_joints(part.joints)
        for part in records((program.joint_targets, program.variables, program.procedures))
        if isinstance(part, JointTarget)
    }
    p, q = arm.fk(sorted(joints))
    q = np.where(q[np.arange(len(q)), np.abs(q).argmax(axis=1)][:, None] < 0.0, -q, q)
    rows = np.hstack([p, q])
    return rows[np.lexsort(np.round(rows[:, 1::-1], 1).T)]


def same(left: np.ndarray, right: np.ndarray) -> bool:
    assert left.shape == right.shape
    return bool(
        np.abs(left[:, :3] - right[:, :3]).max() < 10 * SAME
        and np.abs(left[:, 3:] - right[:, 3:]).max() < 1e-3
    )


@pytest.mark.parametrize("language", ["melfa-basic-4", "melfa-basic-5", "melfa-basic-6"])
def test_the_flange_is_where_it_was(language: str, tmp_path: Path) -> None:
    """In constants, arrays, and as they stand in a move; there and back."""
    source = written(tmp_path, "cell.mod", RAPID)
    there = translate(source, to=language, robot=MITSUBISHI, from_robot=ABB)
    assert there.ok, there.findings
    file = kept(there, tmp_path)
    assert same(flanges(source, ABB), flanges(file, MITSUBISHI))
    told = [f for row in there.rows for f in row.reasons if f.code == "CO501"]
    assert len(told) == 4
    assert "(231.29, 0, 687.99)" in told[0].message
    levels = {row.text[:22]: row.level for row in there.rows}
    assert levels["CONST jointtarget jSaf"] == "partial"
    back = translate(
        file, to="rapid", robot=ABB, from_robot=MITSUBISHI, language=language, process=CELL
    )
    assert back.ok, back.findings
    (tmp_path / "back").mkdir()
    assert same(flanges(source, ABB), flanges(kept(back, tmp_path / "back"), ABB))


def test_from_melfa_to_rapid(tmp_path: Path) -> None:
    source = written(tmp_path, "CELL.prg", MELFA)
    found = translate(
        source, to="rapid", robot=ABB, from_robot=MITSUBISHI, language="melfa-basic-5"
    )
    assert found.ok, found.findings
    file = kept(found, tmp_path)
    assert same(flanges(source, MITSUBISHI), flanges(file, ABB))
    assert "CJointT()" in file.read_text("ascii")  # what is read on an arm is of that arm


@pytest.mark.parametrize(
    ("name", "text", "to", "robot"),
    [
        ("cell.mod", RAPID, "melfa-basic-5", MITSUBISHI),
        ("cell.mod", RAPID, "melfa-basic-5", None),
        ("cell.mod", RAPID, "rapid", ABB),
        ("CELL.mb5", MELFA, "rapid", ABB),
        ("CELL.mb5", MELFA, "rapid", None),
        ("CELL.mb5", MELFA, "melfa-basic-6", MITSUBISHI),
    ],
)
def test_nobody_knows_whose_they_are(
    name: str, text: str, to: str, robot: robots.Robot | None, tmp_path: Path
) -> None:
    source = written(tmp_path, name, text)
    language = None if name.endswith("mod") else "melfa-basic-5"
    found = translate(source, to=to, robot=robot, language=language)
    assert not found.files
    told = [f for f in found.findings if f.code == "CO503"]
    assert told
    assert "--from-robot" in told[0].cure
    draft = translate(source, to=to, robot=robot, language=language, draft=True)
    stop = b"Stop;" if to == "rapid" else b"Hlt"
    assert all(stop in data for data in draft.files.values())
    moves = [r for r in draft.rows if r.text.endswith(("Safe,v1000,fine,tool0", "Mov J1"))]
    assert {row.level for row in moves} == {"not"}
    assert not any(
        b"jTwo{2}" in line and b"|" not in line
        for line in b"".join(draft.files.values()).splitlines()
    )


def test_the_same_arm_on_both_sides_keeps_its_angles(tmp_path: Path) -> None:
    source = written(tmp_path, "CELL.mb5", MELFA)
    for robot, from_robot in ((None, None), (MITSUBISHI, MITSUBISHI)):
        found = translate(
            source, to="melfa-basic-6", robot=robot, from_robot=from_robot, language="melfa-basic-5"
        )
        assert found.ok, found.findings
        (data,) = found.files.values()
        assert b"+0.00,-20.00,+100.00,+0.00,+90.00,+10.00" in data


def test_another_arm_of_the_same_maker_is_solved_anew(tmp_path: Path) -> None:
    source, other = written(tmp_path, "CELL.mb5", MELFA), robots.get("rv-7frl")
    found = translate(
        source, to="melfa-basic-6", robot=other, from_robot=MITSUBISHI, language="melfa-basic-5"
    )
    assert found.ok, found.findings
    assert same(flanges(source, MITSUBISHI), flanges(kept(found, tmp_path), other))


def test_angles_that_are_worked_out_are_refused(tmp_path: Path) -> None:
    text = RAPID.replace("jHere:=CJointT();", "jHere:=CJointT(); jHere.robax.rax_1:=30;")
    found = translate(
        written(tmp_path, "cell.mod", text), to="melfa-basic-5", robot=MITSUBISHI, from_robot=ABB
    )
    assert not found.files
    (told,) = (f for f in found.findings if f.code == "CO505")
    assert "jHere.j1" in told.message
    assert told.severity is Severity.ERROR


def test_out_of_the_other_arms_reach(tmp_path: Path) -> None:
    text = RAPID.replace("[0,-20,20,0,90,0]", "[0,90,-90,0,10,0]")
    found = translate(
        written(tmp_path, "cell.mod", text), to="melfa-basic-5", robot=MITSUBISHI, from_robot=ABB
    )
    assert not found.files
    assert [f.place or "jSafe" for f in found.findings if f.code == "CO502"]


def test_taught_targets_name_their_arm(tmp_path: Path) -> None:
    """Without a robot the program is for the arm that it was taught on."""
    sample = SAMPLES / "taught.toml"
    moved = compile(sample, language="melfa-basic-5", robot=MITSUBISHI)
    assert moved.ok, moved.findings
    (joints,) = moved.program.joint_targets.values()
    there, _ = MITSUBISHI.fk(joints.joints)
    assert np.abs(there - ABB.fk([0, 0, 0, 0, 30, 0])[0]).max() < 10 * SAME
    own = compile(sample, language="rapid")
    assert own.ok, own.findings
    assert own.program.robot == ABB.name
    assert own.program.joint_targets["home"].joints == (0, 0, 0, 0, 30, 0)
    foreign = compile(sample, language="melfa-basic-5")
    assert [f.code for f in foreign.findings if f.severity is Severity.ERROR] == ["CO504"]
    unsaid = sample.read_text("utf-8").replace('robot = "irb1200-7-0.7"', "")
    for robot in (None, ABB):
        refused = compile(written(tmp_path, "x.toml", unsaid), language="rapid", robot=robot)
        assert not refused.files
        (told,) = (f for f in refused.findings if f.code == "CO503")
        assert "`robot`" in told.cure


def test_a_table_of_joints_has_its_arm_in_the_process_file(tmp_path: Path) -> None:
    table = written(tmp_path, "way.csv", "j1_deg,j2_deg,j3_deg,j4_deg,j5_deg,j6_deg\n0,0,10,0,40,0")
    process = written(tmp_path, "p.toml", 'robot = "irb1200-7-0.7"')
    found = compile(table, language="melfa-basic-5", robot=MITSUBISHI, process=process)
    assert found.ok, found.findings
    there = flanges(kept(found, tmp_path), MITSUBISHI)[:, :3]
    assert np.abs(there - ABB.fk([0, 0, 10, 0, 40, 0])[0]).max() < 10 * SAME
    assert not compile(table, language="melfa-basic-5", robot=MITSUBISHI).files


def test_the_text_of_a_program_keeps_the_arm() -> None:
    program = load(SAMPLES / "taught.toml").program
    again = pseudo.parse(pseudo.print_program(program).text)
    assert again == program
    assert again.robot == ABB.name
    found = assistant.compile(again, language="melfa-basic-6", robot="rv-4frl")
    assert "CO501" in {f.code for f in found.findings}


@pytest.mark.parametrize("names", [("irb1200-7-0.7", "rv-7frl"), ("rv-6sl", "irb1600-6-1.2")])
def test_what_is_solved_closes_in_the_branch_of_the_source(names: tuple[str, str]) -> None:
    """10,000 places of one arm on another: the same pose, no axis far from where it was."""
    source, arm = map(robots.get, names)
    low, high = source.limits.T
    joints = np.random.default_rng(5).uniform(low, high, (10_000, len(low)))
    found = joints_on_other_arm(joints, source, arm)
    there = np.isfinite(found).all(axis=1)
    assert there.mean() > 0.3
    assert arm.inside(found[there]).all()
    p, q = source.fk(joints[there])
    p2, q2 = arm.fk(found[there])
    assert np.abs(p - p2).max() < 1e-4
    assert (np.abs(np.einsum("ij,ij->i", q, q2)) > 1.0 - 1e-12).all()
    lost, _ = source.fk(joints[~there])
    assert not arm.ik(lost, source.fk(joints[~there])[1])[1].any()
    back = joints_on_other_arm(found[there], arm, source)
    assert np.isfinite(back).all()


def test_an_arm_crosses_to_itself_as_it_is() -> None:
    low, high = ABB.limits.T
    joints = np.random.default_rng(6).uniform(low, high, (1000, len(low)))
    assert np.abs(joints_on_other_arm(joints, ABB, ABB) - joints).max() < 1e-6
    assert (
        np.abs(
            joints_on_other_arm([[0, 0, 0, 30, 0, -70]], ABB, ABB) - [[0, 0, 0, 30, 0, -70]]
        ).max()
        < 1e-6
    )


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("MOV J1 WTHIF M_IN(8)=1,HLT", ["CO506"]),
        ("MOV P1 WTHIF M_IN(8)=1,HLT", []),
        ("M1=M2 AND M3", []),
    ],
)
def test_kept_text_is_told_of_if_it_speaks_of_joints(line, told, tmp_path):
    source = tmp_path / "A.prg"
    source.write_text(f"10 {line}\n20 END\nJ1=(0,0,90,0,0,0)\nP1=(300,0,300,180,0,180)(7,0)\n")
    done = assistant.translate(
        source,
        to="melfa-basic-5",
        language="melfa-basic-4",
        from_robot="rv-4frl",
        robot="rv-7frl",
    )
    assert [f.code for f in done.findings if f.code == "CO506"] == told


def test_joint_targets_that_nothing_uses_stop_no_program(tmp_path):
    target = "[[300,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    joints = "[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    lines = [
        f"CONST robtarget p:={target};",
        f"CONST jointtarget jIdle:={joints};",
        f"VAR jointtarget jMany{{1}}:=[{joints}];",
        "PROC main()",
        "MoveL p,v100,fine,tool0;",
        "ENDPROC",
    ]
    source = written(tmp_path, "m.mod", "\n".join(["MODULE m", *lines, "ENDMODULE", ""]))
    done = translate(source, to="melfa-basic-5")
    assert done.ok
    assert [f.place for f in done.findings if f.code == "CO510"] == ["jIdle", "variable jMany"]
    ((_, data),) = done.files.items()
    assert b"JIDLE" not in data
    told = {row.place.line: row.level for row in done.rows}
    assert (told[3], told[4], told[6]) == ("partial", "partial", "supported")
    used = source.read_text().replace("ENDPROC", "MoveAbsJ jIdle,v100,fine,tool0;\nENDPROC")
    assert not translate(written(tmp_path, "n.mod", used), to="melfa-basic-5").ok
