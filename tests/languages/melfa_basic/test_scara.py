"""Programs for a SCARA: four joints, one of them in mm, and flags that tell its side only."""

from __future__ import annotations

import pytest

from assistant import compile, languages, robots
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Configuration, JointTarget, Pose, Target
from assistant.program.motion import FINE, Speed
from assistant.program.program import Procedure, Program, Variable

ARM = robots.get("rh-6frh5520")
MOTION = p.Motion(Speed(100.0, joint=20.0), FINE)


def program(*body: p.Statement, **more) -> Program:
    procedures = (Procedure("main", body),)
    return Program("part", procedures, entry="main", robot=ARM.name, **more)


def written(source: Program) -> str:
    done = compile(source, language="melfa-basic-6", robot=ARM)
    assert done.ok, [f.message for f in done.findings]
    (data,) = done.files.values()
    return data.decode()


def read(text: str, language: str = "melfa-basic-6") -> Program:
    spoken = languages.get(language)
    return spoken.lift(spoken.parse(text), ARM)


def test_joints_are_four_the_third_in_mm() -> None:
    text = written(
        program(
            p.MoveJoints(e.Name("start"), MOTION),
            p.MoveJoints(e.JointValue(JointTarget((10.0, -20.0, 150.5, 30.0))), MOTION),
            joint_targets={"start": JointTarget((0.0, -90.0, 333.0, 0.0))},
        )
    )
    assert "Jstart=(+0.00,-90.00,+333.00,+0.00)\r\n" in text
    assert "=(+10.00,-20.00,+150.50,+30.00)\r\n" in text
    back = read(text)
    assert back.joint_targets["start"].joints == (0.0, -90.0, 333.0, 0.0)


@pytest.mark.parametrize("others", [(0.0, 0.0), (float("nan"), float("nan"))])
def test_joints_of_axes_that_it_lacks_are_left_out(others: tuple[float, float]) -> None:
    target = JointTarget((10.0, -20.0, 150.5, 30.0, *others))
    text = written(program(p.MoveJoints(e.JointValue(target), MOTION)))
    assert "=(+10.00,-20.00,+150.50,+30.00)\r\n" in text


def test_a_fifth_joint_that_says_something_is_refused() -> None:
    target = JointTarget((10.0, -20.0, 150.5, 30.0, 45.0, 0.0))
    done = compile(
        program(p.MoveJoints(e.JointValue(target), MOTION)), language="melfa-basic-6", robot=ARM
    )
    assert not done.files
    assert "RB110" in {finding.code for finding in done.findings}


def test_an_external_axis_keeps_its_place() -> None:
    target = JointTarget((10.0, -20.0, 150.5, 30.0), (55.0, *[float("nan")] * 5))
    text = written(program(p.MoveJoints(e.Name("far"), MOTION), joint_targets={"far": target}))
    assert "Jfar=(+10.00,-20.00,+150.50,+30.00,+0.00,+0.00,+55.00)\r\n" in text
    back = read(text).joint_targets["far"]
    assert back.joints == (10.0, -20.0, 150.5, 30.0)
    assert back.external[0] == 55.0


def test_a_constant_of_six_says_four_joints() -> None:
    back = read("1 Mov J1\r\n2 End\r\nJ1=(10,20,150,30,0,0)\r\n")
    assert [t.joints for t in back.joint_targets.values()] == [(10.0, 20.0, 150.0, 30.0)]


@pytest.mark.parametrize(
    ("stated", "flags"),
    [
        (None, "(4,0)"),
        (Configuration(back=True, down=True, flip=True), "(0,0)"),
        (Configuration(back=False, down=False, flip=False), "(4,0)"),
    ],
)
def test_flag_one_tells_the_side_only(stated: Configuration | None, flags: str) -> None:
    y = 100.0 if stated is None or not stated.back else -100.0
    target = Target(Pose((400.0, y, 250.0)), stated)
    text = written(program(p.Move("joint", e.Name("p1"), MOTION), targets={"p1": target}))
    assert f"p1=(+400.00,{y:+.2f},+250.00,+0.00,+0.00,+0.00){flags}\r\n" in text
    (back,) = read(text).targets.values()
    assert back.configuration is not None
    assert back.configuration.back == (flags == "(0,0)")


def test_the_height_of_the_slide_is_no_angle() -> None:
    body = (
        p.Assign(e.Member(e.Name("here"), "j3"), e.Number(200.0)),
        p.Assign(e.Member(e.Name("here"), "j4"), e.Number(90.0)),
        p.Assign(e.Name("height"), e.Member(e.Name("here"), "j3")),
    )
    variables = {
        "here": Variable("joints", initial=e.JointValue(JointTarget((0.0, 0.0, 150.0, 0.0)))),
        "height": Variable("number", initial=e.Number(0.0)),
    }
    text = written(program(*body, variables=variables))
    (slide,) = [line for line in text.splitlines() if ".J3=" in line]
    (turn,) = [line for line in text.splitlines() if ".J4=" in line]
    assert slide.endswith(".J3=200") and "Rad(90)" in turn
    (read_,) = [line for line in text.splitlines() if line.endswith(".J3")]
    assert "Deg" not in read_
    assert read(text).procedures[1].body == body
