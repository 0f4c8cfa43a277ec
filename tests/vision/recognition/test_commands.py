"""`see` and `objects` on the command line: from a drawing and a picture to a program."""

from __future__ import annotations

import json
import re
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import LineString, Point

import assistant
from assistant.base.rotations import from_euler
from assistant.program.geometry import Pose
from assistant.sources.sights import doubts, read_sights
from assistant.vision.cameras.camera import Camera, looking_at
from assistant.vision.cameras.camera_file import Rig, read_cameras, write_cameras
from assistant.vision.opencv import opencv
from tests.cli.test_commands import run
from tests.vision.recognition.scenes import face_picture

SAMPLES = Path(__file__).parents[3] / "samples" / "objects"
TRUTH = Pose.of(np.array([398.0, 22.0, 203.0]), from_euler((-28.0, 0.0, 0.0)))
"""Of the bracket, as table.toml has it."""
ARC = [(27.5 - 10.0 * np.sin(t), 25.0 - 10.0 * np.cos(t)) for t in np.linspace(0, np.pi / 2, 60)]
GLUE = LineString([(80.0, 15.0), *ARC, (17.5, 55.0)])
"""As bracket.dxf has it."""
SEE = ("see", "--cameras", "cameras.toml", "--objects", "lib", "--plane", "200")


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """The samples with a picture of the table, and a library with the bracket."""
    folder = tmp_path_factory.mktemp("objects")
    shutil.copytree(SAMPLES, folder, dirs_exist_ok=True)
    return folder


@pytest.fixture
def here(made, monkeypatch, capsys) -> Path:
    monkeypatch.chdir(made)
    if not Path("shown").exists():
        draw = ("camera", "draw", "cameras.toml", "--cell", "table.toml", "-o", "shown")
        assert run(capsys, *draw)[0] == 0
        add = ("objects", "add", "lib", "bracket", "bracket.dxf", "--line", "GLUE", "--height", 3)
        assert run(capsys, *add)[0] == 0
    for name in ("targets.toml", "found.toml"):
        Path(name).unlink(missing_ok=True)
    return made


def numbers(text: str) -> list[float]:
    return [float(one) for one in re.findall(r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?", text)]


def turned(quaternion: list[float], vector: np.ndarray) -> np.ndarray:
    """By the matrix of a quaternion, written out here."""
    w, x, y, z = quaternion
    matrix = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return matrix @ vector


def test_a_part_is_seen_and_its_glue_line_lands_on_it(here, capsys, tell):
    """A drawing, a picture, taught targets, RAPID, whose targets are read by other means."""
    wanted = ("--to", "targets.toml", "--found", "found.toml", "--expect", "bracket")
    status, said, _ = run(capsys, *SEE, "shown/above/0000.png", *wanted)
    assert status == 0
    assert "wrote targets.toml" in said
    found = tomllib.loads(Path("found.toml").read_text())["found"]["bracket"]
    compiled = assistant.compile("targets.toml", language="rapid", robot="irb1200-7-0.7")
    assert compiled.ok
    assert compiled.proof.holds
    (text,) = (data.decode() for name, data in compiled.files.items() if name.endswith(".mod"))
    frame = numbers(re.search(r"wobjdata bracket:=\[FALSE,TRUE,\"\",(.*)\];", text)[1])
    glued = re.findall(r"robtarget bracket_glue_(\d+):=\[\[([^]]*)\]", text)
    assert len(glued) == 5
    assert "MoveC bracket_glue_3,bracket_glue_4" in text
    off = []
    for _, place in glued:
        world = np.array(frame[:3]) + turned(frame[3:7], np.array(numbers(place)))
        w, x, y, z = TRUTH.quaternion
        on = turned([w, -x, -y, -z], world - TRUTH.position)
        off.append(np.hypot(GLUE.distance(Point(on[:2])), on[2]))
    reach = 90.0  # mm that the turn's error acts over
    told = np.hypot(found["sigma_mm"], np.radians(found["sigma_deg"]) * reach)
    tell(f"glue targets are {max(off):.3f} mm off the line at most, told {told:.3f} mm (one sigma)")
    assert max(off) < 3.0 * told
    assert max(off) < 0.3


@pytest.mark.slow
def test_what_is_found_fills_frames_that_are_seen(here, capsys):
    assert run(capsys, *SEE, "above=shown/above/0000.png", "--found", "found.toml")[0] == 0
    sight = read_sights("found.toml")["bracket"]
    assert not list(doubts(sight))
    assert sight.frame == "base"
    program = (
        "program seam\nframe part user [380, 10, 200] seen bracket\n"
        "target start [45, 15, 0] [0, 0, 1, 0]\n"
        "procedure main\nmove joint start speed 200 mm/s blend fine frame part\nend\n"
    )
    Path("seam.pseudo").write_text(program)
    compile_it = ("compile", "seam.pseudo", "--seen", "found.toml", "-l", "rapid", "-o", "out")
    assert run(capsys, *compile_it, "--robot", "irb1200-7-0.7")[0] == 0
    (module,) = Path("out").glob("*.mod")
    frame = numbers(re.search(r"wobjdata part:=\[FALSE,TRUE,\"\",(.*)\];", module.read_text())[1])
    assert np.linalg.norm(np.array(frame[:3]) - TRUTH.position) < 0.5


@pytest.mark.slow
def test_poses_are_told_in_the_base_of_a_robot(here, capsys):
    """The robot stands elsewhere in the world, and is turned."""
    cell = '[robots.arm]\nrobot = "rv-2aj"\nposition = [100, -50, 180]\neuler_zyx = [90, 0, 0]\n'
    Path("cell.toml").write_text(cell)
    status, said, _ = run(
        capsys, *SEE, "shown/above/0000.png", "--cell", "cell.toml", "--format", "json"
    )
    assert status == 0
    (found,) = json.loads(said)["found"]
    # Turned by 90 degrees: x of the base is y of the world, y is -x.
    wanted = [22.0 + 50.0, -(398.0 - 100.0), 23.0]
    np.testing.assert_allclose(found["position"], wanted, atol=0.3)


@pytest.mark.slow
def test_a_camera_on_a_flange_sees_where_its_arm_is(here, capsys):
    """The same camera, hung on an arm; its picture is only understood with the joints."""
    cell = '[robots.arm]\nrobot = "irb1200-7-0.7"\n'
    Path("arm.toml").write_text(cell)
    robot = assistant.robots.get("irb1200-7-0.7")
    joints = [10.0, -20.0, 30.0, 5.0, 40.0, -15.0]
    position, quaternion = robot.fk(np.array([joints]))
    flange = Pose.of(position[0], quaternion[0])
    stands = read_cameras("cameras.toml")["above"]
    hung = Camera("above", stands.lens, flange.inverse() @ stands.pose, "arm.flange")
    write_cameras("hung.toml", Rig({"above": hung}))
    words = ("see", "shown/above/0000.png", "--cameras", "hung.toml", "--objects", "lib")
    at = ("--plane", "200", "--cell", "arm.toml")
    status, _, err = run(capsys, *words, *at)
    assert (status, "VS337" in err) == (2, True)
    assert "CL552" in run(capsys, *words, *at, "--joints", "1,2,x")[2]
    given = ",".join(map(str, joints))
    status, said, _ = run(capsys, *words, *at, "--joints", given, "--format", "json")
    assert status == 0
    np.testing.assert_allclose(json.loads(said)["found"][0]["position"], TRUTH.position, atol=0.3)


def test_doubtful_sights_write_nothing(here, capsys):
    wanted = ("--to", "targets.toml", "--found", "found.toml")
    picture = "shown/above/0000.png"
    for more, code in (
        (("--expect", "cover"), "VS341"),
        (("--most-mm", "0.002"), "VS346"),
        (("--plane", "188"), "VS348"),
    ):
        status, _, err = run(capsys, *SEE, picture, *wanted, *more)
        assert (status, code in err) == (1, True), err
        assert not Path("targets.toml").exists()
        assert not Path("found.toml").exists()


def test_files_of_others_are_not_replaced(here, capsys):
    Path("targets.toml").write_text("[[targets]]\n")
    status, _, err = run(capsys, *SEE, "shown/above/0000.png", "--to", "targets.toml")
    assert (status, "VS351" in err) == (2, True)
    assert Path("targets.toml").read_text() == "[[targets]]\n"


def picture(name: str, data: np.ndarray) -> str:
    opencv().imwrite(name, data)
    return name


def test_bad_pictures_and_words_are_told(here, capsys):
    whole = opencv().imread("shown/above/0000.png")
    Path("text.png").write_text("no picture")
    Path("empty.toml").write_text("[bodies.block]\nbox = [10, 10, 10]\n")
    for words, code, wanted in (
        ((picture("small.png", whole[:300]),), "VS021", 2),
        ((picture("dark.png", whole // 12),), "VS022", 1),
        ((picture("bright.png", np.full_like(whole, 255)),), "VS023", 1),
        ((picture("plain.png", np.full_like(whole, 90)),), "VS340", 1),
        (("text.png",), "VS025", 2),
        (("none.png",), "IN001", 2),
        (("above=dark.png", "above=dark.png"), "VS335", 2),
        (("a.png", "b.png"), "VS334", 2),
        ((), "CL554", 2),
        (("plain.png", "--to", "targets.csv"), "CL550", 2),
        (("plain.png", "--draw", "seen.txt"), "CL551", 2),
        (("plain.png", "--cell", "empty.toml"), "CL553", 2),
    ):
        status, _, err = run(capsys, *SEE, *words)
        assert (status, code in err) == (wanted, True), (words, err)


def test_objects_are_learnt_by_showing_them(here, capsys):
    """A card by a picture of its face, which --width says the size of."""
    face = face_picture("astronaut.png")
    picture("face.png", opencv().resize(face, (160, 160)))
    shown = ("objects", "add", "cards", "card", "face.png")
    assert "VS323" in run(capsys, *shown)[2]
    status, said, _ = run(capsys, *shown, "--width", "100")
    assert (status, "marks" in said) == (0, True)
    assert "VS305" in run(capsys, *shown, "--width", "100")[2]
    status, _, err = run(capsys, *shown, "face.png", "--width", "100", "--again")
    assert (status, "VS322" in err) == (0, True)
    picture("cat.png", face_picture("chelsea.png", 160))
    assert "VS321" in run(capsys, *shown, "cat.png", "--width", "100", "--again")[2]
    assert "VS324" in run(capsys, "objects", "add", "cards", "x", "bracket.dxf", "face.png")[2]
    assert "VS324" in run(capsys, *shown, "--contour", "A", "--again")[2]
    assert "VS306" in run(capsys, "objects", "add", "cards", "../x", "bracket.dxf")[2]
    status, said, _ = run(capsys, "objects", "list", "cards", "--format", "json")
    assert [one["name"] for one in json.loads(said)["objects"]] == ["card"]


@pytest.mark.slow
def test_the_height_of_what_lies_before_two_cameras_is_seen(here, capsys, tell):
    from assistant.cell.scene import Box
    from assistant.vision.cameras.synthetic_pictures import Card, VisibleBody
    from tests.vision.recognition.scenes import LENS, taken

    cameras = {
        name: Camera(name, LENS, looking_at((x, -170.0, 600.0), (0.0, 0.0, 0.0)))
        for name, x in (("left", -50.0), ("right", 50.0))
    }
    write_cameras("pair.toml", Rig(cameras))
    face = face_picture("astronaut.png")
    things = [
        VisibleBody(Box((100.0, 100.0, 20.0)), Pose((10.0, 5.0, 9.9)), (160, 160, 150)),
        VisibleBody(Card((100.0, 100.0), face), Pose((10.0, 5.0, 20.0))),
    ]
    for seed, (name, camera) in enumerate(cameras.items()):
        picture(f"{name}.png", taken(camera, things, seed))
    add = ("objects", "add", "boxes", "box", "left.png", "right.png", "--cameras", "pair.toml")
    status, said, _ = run(capsys, *add, "--format", "json")
    assert status == 0
    learnt = json.loads(said)
    tell(f"a face 20 mm above the plane is measured {learnt['height']:.2f} mm high")
    assert learnt["height"] == pytest.approx(20.0, abs=1.0)
    see = ("see", "left.png", "right.png", "--cameras", "pair.toml", "--objects", "boxes")
    status, said, _ = run(capsys, *see, "--format", "json")
    assert status == 0
    (found,) = json.loads(said)["found"]
    assert found["cameras"] == ["left", "right"] or found["cameras"] == ["right", "left"]
    np.testing.assert_allclose(found["position"], [10.0, 5.0, 20.0], atol=2.5)


@pytest.mark.slow
def test_the_picture_shows_what_was_found(here, capsys):
    assert run(capsys, *SEE, "shown/above/0000.png", "--draw", "seen.png")[0] == 0
    drawn, whole = (opencv().imread(name) for name in ("seen.png", "shown/above/0000.png"))
    assert drawn.shape == whole.shape
    assert 500 < (drawn != whole).any(axis=2).sum() < 30_000


def test_what_shows_nothing_or_tells_no_height_or_is_not_worked_on_is_told(here, capsys):
    """A plain part has no depth that two pictures tell; it is learnt by its outline alone."""
    whole = opencv().imread("shown/above/0000.png")
    bare = np.full_like(whole, 90)
    add = ("objects", "add", "plain", "part", "--cameras", "cameras.toml", "--plane", 200)
    assert "VS325" in run(capsys, *add, picture("above.png", bare))[2]
    shown = bare.copy()
    opencv().fillPoly(
        shown, [np.array([[300, 250], [420, 230], [450, 330], [330, 340]])], (200,) * 3
    )
    rig = read_cameras("cameras.toml").cameras["above"]
    moved = Camera("beside", rig.lens, rig.pose @ Pose((60.0, 0.0, 0.0)))
    write_cameras("two.toml", Rig({"above": rig, "beside": moved}))
    two = ("--cameras", "two.toml", "--plane", 200)
    files = (picture("above.png", shown), picture("beside.png", np.roll(shown, -90, axis=1)))
    status, _, err = run(capsys, "objects", "add", "plain", "part", *files, *two)
    assert (status, "VS326" in err) == (0, True), err
    status, _, err = run(
        capsys, "objects", "add", "plain", "part", *files, *two, "--height", 2, "--again"
    )
    assert (status, "VS326" in err) == (0, False)
    see = ("see", "above.png", *two, "--objects", "plain", "--to", "targets.toml")
    status, _, err = run(capsys, *see)
    assert (status, "VS350" in err) == (0, True), err
    assert not Path("targets.toml").exists()
