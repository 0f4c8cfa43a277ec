"""Frames that are seen: filled with what was found, asked for as the program runs, or refused."""

from __future__ import annotations

import datetime
from pathlib import Path

import pytest

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.compiler import check_files, compile, translate
from assistant.compiler.compilation import Compiled
from assistant.compiler.simulated_run import programs
from assistant.sources.sights import NOTHING_SEEN, Seeing, seeing

TEXT = """program seam

frame part user [300, 0, 200] seen bracket

target above [0, 0, 60] [0, 0, 1, 0]
target on [0, 0, 10] [0, 0, 1, 0]

procedure main
  move joint above speed 200 mm/s blend fine frame part
  move linear on speed 50 mm/s blend fine frame part
end
"""
SOURCE = """MODULE seam
PERS wobjdata part:=[FALSE,TRUE,"",[[300,0,200],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
CONST robtarget on:=[[0,0,10],[0,0,1,0],[0,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
MoveL on,v50,fine,tool0\\WObj:=part;
ENDPROC
ENDMODULE
"""
CELL = """[robots.arm]
robot = "irb1200-7-0.7"
position = [100, 0, 0]
euler_zyx = [90, 0, 0]
"""
ARMS = [("rapid", "irb1200-7-0.7"), ("melfa-basic-5", "rv-4frl"), ("melfa-basic-6", "rv-4frl")]


def found(folder: Path, age: float = 0.0, **changed: str) -> Path:
    """A file that says where the bracket was found."""
    when = datetime.datetime.now(datetime.UTC) - datetime.timedelta(seconds=age)
    said = {
        "position": "[320, 15, 210]",
        "quaternion": "[0.9659258262890683, 0, 0, 0.25881904510252074]",
        "sigma_mm": "0.2",
        "sigma_deg": "0.1",
        "confidence": "0.97",
        "seen": when.isoformat(timespec="seconds"),
        **changed,
    }
    lines = "\n".join(f"{key} = {value}" for key, value in said.items())
    (folder / "found.toml").write_text(f"[found.Bracket]\n{lines}\n", "ascii")
    return folder / "found.toml"


def program(folder: Path, text: str = TEXT) -> Path:
    (folder / "seam.pseudo").write_text(text, "ascii")
    return folder / "seam.pseudo"


def compiled(
    folder: Path,
    sights: Seeing = NOTHING_SEEN,
    language: str = "rapid",
    robot: str = "irb1200-7-0.7",
    text: str = TEXT,
) -> Compiled:
    return compile(program(folder, text), language=language, robot=robot, seeing=sights)


def refusal(folder: Path, sights: Seeing = NOTHING_SEEN, text: str = TEXT) -> Diagnostic:
    with pytest.raises(Refused) as caught:
        compiled(folder, sights, text=text)
    (finding,) = caught.value.findings
    return finding


# ------------------------------------------------------------------------------- nothing known


def test_no_place_is_guessed_and_both_cures_are_named(tmp_path: Path):
    finding = refusal(tmp_path)
    assert finding.code == "CO350"
    assert "--seen" in (finding.cure or "") and "--ask-at" in (finding.cure or "")


def test_a_check_tells_the_same(tmp_path: Path):
    codes = [one.code for one in check_files([program(tmp_path)], robot="rv-2aj").findings]
    assert codes == ["CO350"]


def test_a_run_does_not_begin_either(tmp_path: Path):
    with pytest.raises(Refused) as caught:
        programs([str(program(tmp_path))])
    assert [one.code for one in caught.value.findings] == ["CO350"]


# ------------------------------------------------------------------------------------- found


@pytest.mark.parametrize(("language", "robot"), [*ARMS, ("melfa-basic-4", "rv-2aj")])
def test_a_program_is_written_with_the_place_where_it_was_found(
    tmp_path: Path, language: str, robot: str
):
    done = compiled(tmp_path, seeing(found(tmp_path)), language, robot)
    assert done.ok and "CO357" in {one.code for one in done.findings}
    if robot != "rv-2aj":  # whose targets are told in the base
        assert done.program.frames["part"].pose.position == pytest.approx((320, 15, 210))
    else:
        place = done.program.targets["above"].pose.position
        assert place == pytest.approx((320, 15, 270), abs=0.01)


def test_what_was_found_in_the_world_needs_the_cell(tmp_path: Path):
    file = found(tmp_path, frame='"world"', position="[85, 320, 210]", quaternion="[1, 0, 0, 0]")
    assert refusal(tmp_path, seeing(file)).code == "CO352"
    (tmp_path / "cell.toml").write_text(CELL, "ascii")
    done = compile(
        program(tmp_path), language="rapid", cell=tmp_path / "cell.toml", seeing=seeing(file)
    )
    pose = done.program.frames["part"].pose
    assert pose.position == pytest.approx((320, 15, 210))  # x = y' and y = 100 - x' of the world
    assert abs(pose.quaternion[3]) == pytest.approx(0.5**0.5)


@pytest.mark.parametrize(
    ("age", "changed", "code"),
    [
        (601, {}, "SR012"),
        (-60, {}, "SR013"),
        (0, {"sigma_mm": "1.5"}, "SR014"),
        (0, {"sigma_deg": "1.5"}, "SR014"),
        (0, {"confidence": "0.5"}, "SR015"),
    ],
)
def test_a_doubtful_sight_writes_nothing(
    tmp_path: Path, age: float, changed: dict[str, str], code: str
):
    assert refusal(tmp_path, seeing(found(tmp_path, age, **changed))).code == code


def test_a_process_file_may_trust_it_all_the_same_and_name_it(tmp_path: Path):
    found(tmp_path, 3000, sigma_mm="1.5")
    process = tmp_path / "p.toml"
    process.write_text('[seen]\nfound = "found.toml"\noldest = 4000\nsigma_mm = 2\n', "ascii")
    done = compile(program(tmp_path), language="rapid", robot="irb1200-7-0.7", process=process)
    assert done.ok and done.program.frames["part"].pose.position == pytest.approx((320, 15, 210))


def test_another_object_does_not_stand_for_it(tmp_path: Path):
    text = TEXT.replace("seen bracket", "seen cover")
    finding = refusal(tmp_path, seeing(found(tmp_path)), text)
    assert finding.code == "CO351" and "`Bracket`" in finding.message


def test_what_the_robot_carries_is_not_seen(tmp_path: Path):
    text = TEXT.replace("seen bracket", "held seen bracket")
    assert refusal(tmp_path, seeing(found(tmp_path)), text).code == "CO353"


def test_taught_targets_and_robot_programs_get_it_by_their_process_file(tmp_path: Path):
    frame = '[frames.part]\nposition = [300, 0, 200]\nseen = "bracket"\n'
    (tmp_path / "seam.toml").write_text(
        'robot = "irb1200-7-0.7"\n' + frame + '[motion]\nframe = "part"\n'
        '[[targets]]\nname = "on"\nposition = [0, 0, 10]\nquaternion = [0, 0, 1, 0]\n',
        "ascii",
    )
    with pytest.raises(Refused):
        compile(tmp_path / "seam.toml", language="rapid")
    sights = seeing(found(tmp_path))
    assert compile(tmp_path / "seam.toml", language="rapid", seeing=sights).ok
    (tmp_path / "seam.mod").write_text(SOURCE, "ascii")
    (tmp_path / "p.toml").write_text(frame, "ascii")
    done = translate(
        tmp_path / "seam.mod",
        to="melfa-basic-5",
        robot="rv-4frl",
        from_robot="irb1200-7-0.7",
        process=tmp_path / "p.toml",
        seeing=sights,
    )
    assert done.ok
    place = done.compiled.program.frames["part"].pose.position
    assert place == pytest.approx((320, 15, 210), abs=1e-3)


# ------------------------------------------------------------------------------------- asked


@pytest.mark.parametrize(("language", "robot"), ARMS)
@pytest.mark.parametrize("whom", ["192.168.0.5:10010", "listen:192.168.0.20:10003"])
def test_a_program_that_asks_is_proven_as_others_are(
    tmp_path: Path, language: str, robot: str, whom: str
):
    done = compiled(tmp_path, seeing(ask=whom), language, robot)
    assert done.ok, [f"{one.code} {one.message}" for one in done.findings]
    assert "CO358" in {one.code for one in done.findings}


def test_it_asks_over_a_line_of_the_controller_too(tmp_path: Path):
    assert compiled(tmp_path, seeing(ask="line:2"), "melfa-basic-5", "rv-4frl").ok
    assert not compiled(tmp_path, seeing(ask="line:2")).ok  # nothing says what the line is there


def test_where_it_was_found_once_is_the_place_that_is_looked_at(tmp_path: Path):
    text = TEXT.replace("user [300, 0, 200] ", "")
    assert refusal(tmp_path, seeing(ask="pc:1"), text).code == "CO354"
    done = compiled(tmp_path, seeing(found(tmp_path), "pc:1"), text=text)
    assert done.ok and "[320, 15, 210]" in "".join(one.message for one in done.findings)


def test_a_program_without_beginning_cannot_ask(tmp_path: Path):
    text = TEXT.replace("program seam", "program seam without entry")
    assert refusal(tmp_path, seeing(ask="pc:1"), text).code == "CO355"


@pytest.mark.parametrize("name", ['`a "b"`', "`a,b`", "`Gehäuse`", "`" + "x" * 41 + "`"])
def test_a_name_that_no_line_takes_is_refused(tmp_path: Path, name: str):
    text = TEXT.replace("seen bracket", f"seen {name}")
    (tmp_path / "seam.pseudo").write_text(text, "utf-8")
    with pytest.raises(Refused) as caught:
        compile(
            tmp_path / "seam.pseudo",
            language="rapid",
            robot="irb1200-7-0.7",
            seeing=seeing(ask="pc:1"),
        )
    assert [one.code for one in caught.value.findings] == ["CO356"]


def test_names_of_the_program_stay_its_own(tmp_path: Path):
    text = TEXT.replace("procedure main\n", "procedure look_for_frames\nend\n\nprocedure main\n")
    text = text.replace("\nprocedure main", "\nvariable seen_x number = 3\n\nprocedure main")
    assert compiled(tmp_path, seeing(ask="pc:1"), text=text.replace("program", "program", 1)).ok


def test_five_axes_take_no_frame_that_the_program_sets(tmp_path: Path):
    done = compiled(tmp_path, seeing(ask="pc:1"), "melfa-basic-4", "rv-2aj")
    assert not done.ok
    assert any("which the program sets" in one.message for one in done.findings)


# -------------------------------------------------------------- frames that a program sets


def set_by_program(value: str, declared: str = "", *, frame: str = "") -> str:
    text = TEXT.replace(" seen bracket", frame).replace("procedure main\n", "procedure main\n  X\n")
    text = text.replace("\nprocedure", f"\n{declared}\nprocedure", 1)
    return text.replace("  X\n", f"  part = {value}\n")


@pytest.mark.parametrize(("language", "robot"), ARMS)
@pytest.mark.parametrize(
    ("value", "declared", "frame"),
    [
        ("pose [310, 5, 200]", "", ""),
        ("pose [310, 5, 200]", "", " object [1, 2, 3]"),
        ("target [310, 5, 200] [1, 0, 0, 0]", "", ""),
        ("place", "variable place position = target [310, 5, 200] [1, 0, 0, 0]", ""),
        ("place", "variable place pose = pose [310, 5, 200]", ""),
    ],
)
def test_a_program_sets_a_frame_to_a_pose_in_each_language(
    tmp_path: Path, language: str, robot: str, value: str, declared: str, frame: str
):
    done = compiled(
        tmp_path, NOTHING_SEEN, language, robot, set_by_program(value, declared, frame=frame)
    )
    assert done.ok, [f"{one.code} {one.message}" for one in done.findings]


def test_five_axes_do_not_go_on_to_the_place_before(tmp_path: Path):
    text = set_by_program("pose [310, 5, 200]")
    done = compiled(tmp_path, NOTHING_SEEN, "melfa-basic-4", "rv-2aj", text)
    assert [one.code for one in done.findings if one.severity == "error"] == ["MB209"]
