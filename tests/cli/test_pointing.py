"""`teach --point`: places shown to cameras become targets, programs, and where the arm stands."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

import assistant
from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.compiler.simulated_run import programs
from assistant.compiler.taught_targets import TargetOptions, check_reached, target_of_shown
from assistant.controllers import Controller, connect
from assistant.program.geometry import Pose
from assistant.sources import read
from assistant.virtual.cr import VirtualCr
from assistant.virtual.events import Moved
from assistant.virtual.program_run import Settings, prepared
from assistant.vision.cameras.camera import Camera, Lens, looking_at
from assistant.vision.cameras.camera_file import Rig, read_cameras, write_cameras
from assistant.vision.pointing.devices import Device, ball, wand
from tests.cli.tables import each
from tests.cli.test_commands import run
from tests.vision.pointing.scenes import BENT, SMALL, grey, shown, taken

ARM = robots.get("rv-2aj")
MIDDLE = (270.0, 0.0, 260.0)
EYES = {"left": (1140.0, -300.0, 640.0), "right": (1140.0, 300.0, 640.0)}
HOLD = 4


def pointing(x: float, y: float, z: float, tilt: float = 0.0, turn: float = 0.0) -> Pose:
    """A wand that points down, tilted by degrees in the plane in which the arm turns its tool."""
    azimuth = np.degrees(np.arctan2(y, x))
    q = rotations.about(np.array([0.0, 0.0, 1.0]), azimuth)
    q = rotations.multiply(q, rotations.about(np.array([0.0, 1.0, 0.0]), 180.0 + tilt))
    q = rotations.multiply(q, rotations.about(np.array([0.0, 0.0, 1.0]), turn))
    return Pose.of(np.array([x, y, z]), rotations.canonical(q))


PLACES = (
    pointing(300.0, 0.0, 180.0, 5.0, 20.0),
    pointing(250.0, 90.0, 160.0, -8.0),
    pointing(250.0, -80.0, 200.0, 0.0, -35.0),
)


def cameras_with(lens: Lens) -> list[Camera]:
    return [Camera(name, lens, looking_at(eye, MIDDLE)) for name, eye in EYES.items()]


def filmed(
    folder: Path,
    poses: Sequence[Pose | None],
    frames: int = HOLD,
    device: Device | None = None,
    lens: Lens = SMALL,
) -> None:
    """A file of cameras, with a folder of pictures of each: the device held at each pose."""
    rng = np.random.default_rng(7)
    sources, cameras = {}, cameras_with(lens)
    for camera in cameras:
        sources[camera.name] = f"seen/{camera.name}"
        (folder / sources[camera.name]).mkdir(parents=True)
        for k, pose in enumerate(p for p in poses for _ in range(frames)):
            seen = taken(grey(camera), rng) if pose is None else shown(camera, pose, rng, device)
            file = folder / sources[camera.name] / f"{k}.bmp"
            cv2.imwrite(str(file), seen)
    rig = Rig({camera.name: camera for camera in cameras}, {}, sources)
    write_cameras(folder / "cameras.toml", rig)


POINT = ("teach", "--point", "cameras.toml", "--frames", HOLD, "--into", "points.toml")
# Between two places of the tests a hand would take longer than one picture.
FAST = ("--fastest", 20000)


def test_three_places_shown_become_a_program_that_goes_there(
    capsys, here: Path, tell: Callable[[str], None]
) -> None:
    """Nobody's hand, but a wand that is drawn; the program runs on the virtual RV-2AJ."""
    filmed(here, PLACES, frames=3, lens=BENT)
    status, out, said = run(
        *(capsys, *POINT, "above", "left_side", "right_side", "-r", "rv-2aj", *FAST),
        *("--frames", 3),
    )
    assert status == 0, said
    assert out.count("stored in points.toml") == 3
    targets = read(here / "points.toml").program.targets
    assert list(targets) == ["above", "left_side", "right_side"]
    compiled = assistant.compile("points.toml", language="melfa-basic-4", robot="rv-2aj")
    assert compiled.proof.holds
    for name, data in compiled.files.items():
        (here / name).write_bytes(data)
    (program,) = compiled.files
    log = prepared(programs([program], robot=ARM), Settings(robot=ARM)).run().log
    flanges = [row.what.flange for row in log if isinstance(row.what, Moved)]
    off = [
        np.linalg.norm(np.subtract(f.position, p.position))
        for f, p in zip(flanges, PLACES, strict=True)
    ]  # type: ignore[union-attr]
    turned = [
        float(rotations.angle_between(f.quaternion, p.quaternion))  # type: ignore[union-attr]
        for f, p in zip(flanges, PLACES, strict=True)
    ]
    assert max(off) < 0.3 and max(turned) < 0.3
    tell(
        f"three places shown, run on the virtual RV-2AJ: {max(off):.3f} mm and "
        f"{max(turned):.3f} degrees off at worst"
    )


def test_without_names_and_without_an_arm(capsys, here: Path) -> None:
    filmed(here, PLACES[:2], device=ball())
    status, out, said = run(capsys, *POINT, "--device", "ball", "--format", "json", *FAST)
    assert status == 0, said
    stored = json.loads(out)["stored"]
    assert [one["name"] for one in stored] == ["p1", "p2"]
    assert np.shape(stored[0]["covariance"]) == (6, 6) and stored[0]["spread_mm"] < 0.5
    program = read(here / "points.toml").program
    assert program.robot is None and program.targets["p1"].configuration is None
    assert np.allclose(program.targets["p1"].pose.position, PLACES[0].position, atol=0.3)


def test_a_place_that_is_not_shown_is_not_stored(capsys, here: Path) -> None:
    filmed(here, (PLACES[0], None))
    status, _, said = run(capsys, *POINT, "a", "b", "-r", "rv-2aj", *FAST)
    assert status == 1 and "VS104" in said and "VS114" in said and "`b`" in said
    assert list(read(here / "points.toml").program.targets) == ["a"]
    status, _, said = run(capsys, *POINT, "a", "-r", "rv-2aj", *FAST)
    assert status == 1 and "TB509" in said  # before anybody shows anything
    assert run(capsys, *POINT, "a", "-r", "rv-2aj", "--replace", *FAST)[0] == 0


def test_places_that_the_arm_does_not_take(capsys, here: Path) -> None:
    far = Pose((270.0, 200.0, 420.0), PLACES[0].quaternion)
    sideways = rotations.multiply(rotations.about(np.array([1.0, 0.0, 0.0]), 25.0), (0, 1.0, 0, 0))
    filmed(here, (far, Pose.of(np.array([300.0, 0.0, 180.0]), sideways)))
    status, _, said = run(capsys, *POINT, "a", "-r", "rv-2aj", *FAST)
    assert status == 1 and "CO732" in said and "VS114" in said
    assert not (here / "points.toml").exists()


def test_what_an_arm_of_five_axes_turns_and_where_it_must_come_to_rest(here: Path) -> None:
    x, y, z = PLACES[0].position
    aside = rotations.about(np.array([1.0, 0.0, 0.0]), 4.0)
    tilted = Pose.of(np.array([x, y, z]), rotations.multiply(aside, PLACES[0].quaternion))
    place = target_of_shown(here / "points.toml", "a", tilted, ARM, TargetOptions())
    assert [finding.code for finding in place.findings] == ["CO733"]
    assert place.joints is not None
    positions, quaternions = ARM.fk([place.joints])
    assert positions[0] == pytest.approx((x, y, z), abs=1e-6)
    assert rotations.angle_between(quaternions[0], tilted.quaternion) == pytest.approx(4.0, abs=0.2)
    assert not target_of_shown(here / "points.toml", "a", PLACES[0], ARM, TargetOptions()).findings
    assert check_reached(place, place.tip) == pytest.approx((0.0, 0.0), abs=1e-9)
    for off in (Pose((0.0, 0.0, 2.0)), Pose((0.0, 0.0, 0.0), (0.99995, 0.01, 0.0, 0.0))):
        with pytest.raises(Refused) as refused:
            check_reached(place, place.tip @ off)
        assert refused.value.findings[0].code == "CO735"


def test_a_place_out_of_reach_is_told(capsys, here: Path) -> None:
    text = "[tools.long]\ntip = [0, 0, 400]\n"
    (here / "points.toml").write_text(text, encoding="utf-8")
    filmed(here, PLACES[:1])
    status, _, said = run(capsys, *POINT, "a", "-r", "rv-2aj", "--tool", "long", *FAST)
    assert status == 1 and "CO731" in said
    assert (here / "points.toml").read_text(encoding="utf-8") == text


def test_cameras_that_stand_in_a_frame_of_the_file(capsys, here: Path) -> None:
    room = "[frames.room]\nposition = [10, 20, 0]\neuler_zyx = [90, 0, 0]\n"
    (here / "points.toml").write_text(room, encoding="utf-8")
    filmed(here, PLACES[:1])
    assert run(capsys, *POINT, "a", "--world", "room", *FAST)[0] == 0
    x, y, z = read(here / "points.toml").program.targets["a"].pose.position
    px, py, pz = PLACES[0].position
    assert (x, y, z) == pytest.approx((10.0 - py, 20.0 + px, pz), abs=0.3)
    assert run(capsys, *POINT, "b", "--frame", "room", "--world", "room", *FAST)[0] == 0
    assert read(here / "points.toml").program.targets["b"].pose.position == pytest.approx(
        PLACES[0].position, abs=0.3
    )
    status, _, said = run(capsys, *POINT, "c", "--world", "hall", *FAST)
    assert status == 2 and "CO734" in said


@pytest.mark.slow
def test_a_stroke_becomes_waypoints(capsys, here: Path) -> None:
    first, last = (270.0, -40.0, 200.0), (270.0, 40.0, 200.0)
    middle = [(270.0, y, 200.0) for y in np.linspace(-30.0, 30.0, 7)]
    down = PLACES[0].quaternion
    poses = [Pose(p, down) for p in (*[first] * HOLD, *middle, *[last] * HOLD)]
    filmed(here, poses, frames=1, device=ball())
    stroke = ("teach", "--point", "cameras.toml", "--frames", HOLD, "--device", "ball", "--stroke")
    status, out, said = run(capsys, *stroke, "--into", "way.csv")
    assert status == 0, said
    assert "waypoints along" in out
    (path,) = (s.path for s in read(here / "way.csv").program.statements() if hasattr(s, "path"))
    assert np.abs(path.positions[:, [0, 2]] - (270.0, 200.0)).max() < 0.5
    assert path.positions[[0, -1], 1] == pytest.approx((-40.0, 40.0), abs=0.5)
    for more, code in ((("--into", "way.csv"), "CL514"), (("--into", "way.toml"), "CL513")):
        assert code in run(capsys, *stroke, *more)[2]


# -------------------------------------------------------------------------------- with an arm


def test_nobody_is_led_anywhere_without_being_asked(capsys, cr, here: Path) -> None:
    filmed(here, PLACES[:1])
    lines = ("--line", "192.0.2.1:1", "--line", "192.0.2.1:2")
    status, _, said = run(capsys, "teach", "cell1", "above", *POINT[1:], "--go", *lines)
    assert status == 2 and "CL203" in said and "`above`" in said
    assert not (here / "points.toml").exists()
    with connect("cell1") as session:
        assert isinstance(session, Controller)
        assert session.position().position[0] == pytest.approx(160.0)


@pytest.mark.slow
def test_the_arm_is_led_to_a_place_and_what_it_reached_is_stored(
    capsys, tmp_path: Path, here: Path, tell: Callable[[str], None]
) -> None:
    filmed(here, PLACES[:1])
    virtual = VirtualCr()
    devices = ", ".join(f"OPT{i}" for i in range(12, 19))
    virtual.state.parameters.write("COMDEV", f"{devices}, ", all_levels=True)
    with virtual:
        table = f'address = "{virtual.address}"\nrobot = "rv-2aj"\ntimeout = 5\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        lines = [f"{host}:{port}" for host, port in virtual.data_ports.values()][:2]
        go: list[object] = ["teach", "cell1", "above", *POINT[1:], "--go", "--speed", 100, "--yes"]
        assert run(capsys, "motors", "cell1", "on", "--yes")[0] == 0
        status, out, said = run(capsys, *go, "--line", lines[0], "--line", lines[1])
        assert status == 0, said
        assert "from what was shown" in out
        with connect("cell1") as session:
            assert isinstance(session, Controller)
            there = session.position()
    target = read(here / "points.toml").program.targets["above"]
    assert target.pose.position == pytest.approx(there.position, abs=1e-6)
    assert target.configuration is not None
    off = np.linalg.norm(np.subtract(target.pose.position, PLACES[0].position))
    assert off < 0.3
    tell(f"virtual RV-2AJ led to a shown place, and what it reached stored: {off:.3f} mm off")


SEEN = """law = "pose"
cameras = ["watch_left", "watch_right"]
[mark]
device = "wand"
position = [0, 0, 150]
[limits]
speed = 400
turning = 180
part = 0.9
[servo]
share = 0.8
stale = 2
distance = 0.3
turn = 0.3
"""
CELL = '[robots.arm]\nrobot = "rv-2aj"\n'


@pytest.mark.slow
def test_the_last_of_the_way_is_led_by_what_is_seen_of_the_tool(
    capsys, tmp_path: Path, here: Path, tell: Callable[[str], None]
) -> None:
    filmed(here, PLACES[:1], lens=BENT)
    rig = read_cameras(here / "cameras.toml")
    watch = {f"watch_{n}": replace(c, name=f"watch_{n}") for n, c in rig.cameras.items()}
    sources = {**rig.sources, **dict.fromkeys(watch, "cell.toml")}
    write_cameras(here / "cameras.toml", Rig({**rig.cameras, **watch}, {}, sources))
    (here / "cell.toml").write_text(CELL, encoding="utf-8")
    (here / "seen.toml").write_text(SEEN, encoding="utf-8")
    virtual = VirtualCr()
    devices = ", ".join(f"OPT{i}" for i in range(12, 19))
    virtual.state.parameters.write("COMDEV", f"{devices}, ", all_levels=True)
    with virtual:
        table = f'address = "{virtual.address}"\nrobot = "rv-2aj"\ntimeout = 5\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        lines = [f"{host}:{port}" for host, port in virtual.data_ports.values()][:2]
        go: list[object] = ["teach", "cell1", "above", *POINT[1:], "--go", "--speed", 100, "--yes"]
        assert run(capsys, "motors", "cell1", "on", "--yes")[0] == 0
        more = ("--camera", "left", "--camera", "right", "--servo", "seen.toml")
        status, _, said = run(capsys, *go, "--line", lines[0], "--line", lines[1], *more)
        assert status == 0, said
    target = read(here / "points.toml").program.targets["above"]
    off = np.linalg.norm(np.subtract(target.pose.position, PLACES[0].position))
    assert off < 0.8
    tell(f"virtual RV-2AJ led to a shown place by what is seen of its tool: {off:.3f} mm off")


WRONG = (
    (("--servo", "seen.toml"), 2, "CL519"),
    (("--device", "stick"), 2, "VS117"),
    (("--camera", "left"), 2, "VS115"),
    (("--camera", "top"), 2, "VS013"),
    (("--go",), 2, "CL510"),
    (("--now",), 2, "CL512"),
    (("--stroke", "--go"), 2, "CL512"),
    (("--frames", 1), 2, "CL515"),
    (("--above", 1000), 2, "CL515"),
    (("-r", "r2d2"), 2, "r2d2"),
)


def test_wrong_usage(capsys, here: Path) -> None:
    rig = Rig(
        {camera.name: camera for camera in cameras_with(SMALL)},
        {},
        {"left": "seen", "right": "seen"},
    )
    write_cameras(here / "cameras.toml", rig)

    def check(more: tuple[object, ...], status: int, code: str) -> None:
        found, _, said = run(capsys, *POINT, *more)
        assert (found, code in said) == (status, True), said

    each(WRONG, check)


def test_what_else_is_refused(capsys, cr, here: Path, tmp_path: Path) -> None:
    assert "CL518" in run(capsys, "teach", "--now")[2]
    assert "CL516" in run(capsys, "teach", "cell1", "--go")[2]
    rig = Rig({camera.name: camera for camera in cameras_with(SMALL)})
    write_cameras(here / "cameras.toml", rig)
    assert "VS120" in run(capsys, *POINT)[2]
    assert "CL517" in run(capsys, "teach", "cell1", *POINT[1:], "--go", "--by", "foot")[2]
    project = tmp_path / "assistant.toml"
    project.write_text(project.read_text().replace("robot =", "#"))
    assert "CL511" in run(capsys, "teach", "cell1", *POINT[1:], "--go")[2]


@pytest.mark.slow
def test_wands_of_ones_own(capsys, here: Path) -> None:
    """The same three balls by a file, which tells hues; wrong files are told."""
    filmed(here, PLACES[:1])
    balls = "".join(
        f"[[balls]]\n{colour}\nradius = 15\nposition = {list(mark.position)}\n"
        for colour, mark in zip(
            ('colour = "red"', "hue = 120", 'colour = "blue"'), wand().marks, strict=True
        )
    )
    (here / "own.toml").write_text('kind = "wand"\n' + balls, encoding="utf-8")
    own = ("--device", "own.toml", *FAST)
    assert run(capsys, *POINT, "a", *own)[0] == 0
    target = read(here / "points.toml").program.targets["a"]
    assert np.linalg.norm(np.subtract(target.pose.position, PLACES[0].position)) < 0.3
    for old, new in (
        ("hue = 120", "hue = 5"),
        ("radius = 15", ""),
        ('colour = "red"', ""),
        ('colour = "red"', 'colour = "grey"'),
        ("90.0, 0.0, -140.0", "20.0, 0.0, -40.0"),
        ("hue = 120", "hue = nan"),
        ('kind = "wand"', 'kind = "ball"'),
    ):
        (here / "wrong.toml").write_text(('kind = "wand"\n' + balls).replace(old, new))
        status, _, said = run(capsys, *POINT, "b", "--device", "wrong.toml")
        assert status == 2 and "wrong.toml" in said, (new, said)
