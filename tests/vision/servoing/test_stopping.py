"""What stops servoing: each a finding, with an arm that is where it is told to be."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from assistant.base.diagnostics import Refused
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera_file import read_cameras
from assistant.vision.servoing.control_laws import ImageToHand
from assistant.vision.servoing.interaction import flange_of
from assistant.vision.servoing.live_cameras import LiveEyes, SoughtTargets
from assistant.vision.servoing.servo_loop import ServoSettings, ServoStopped, servo
from assistant.vision.servoing.servo_task import open_eyes, read_servo, set_up_servo
from assistant.vision.servoing.simulation import (
    DrawnEyes,
    IdealArm,
    ProjectedEyes,
    ServoWorld,
    SteppedClock,
)
from assistant.vision.servoing.visual_targets import GivenPoints
from tests.vision.servoing.scenes import IN_HAND, MARKER, ON_TOOL, TIP, five_axes

AWAY = np.array([6.0, -5.0, 4.0, -6.0, 10.0])


def led(name="image in hand", *, scene=None, settings=None, eyes=None, away=AWAY, law=None, **how):
    """Servoing of an ideal arm, and that arm."""
    scene, clock = scene or five_axes(), SteppedClock()
    arm = IdealArm(scene.goal_joints + away, scene.guard.speeds)
    made = eyes(arm, clock) if eyes else scene.eyes(name, arm.joints, clock=clock, **how)
    rules = settings or ServoSettings()
    return arm, lambda: servo(made, law or scene.law(name), arm, scene.guard, rules, clock=clock)


def refused(run):
    with pytest.raises(ServoStopped) as broken:
        run()
    return [finding.code for finding in broken.value.findings], broken.value.served


def test_lost_sight_stops_it_at_the_second_picture():
    arm, run = led(hidden=lambda number: number >= 9)
    codes, served = refused(run)
    seen = served.columns["seen"]
    assert codes == ["VS202"] and (seen[:9] == 1.0).all() and (seen[9:] == 0.0).all()
    assert len(seen) == 11 and len(arm.rows[1:]) == 9 - 3
    assert np.allclose(served.joints, arm.rows[1:][-1])


def test_one_picture_without_a_sight_only_brings_it_to_rest():
    arm, run = led(hidden=lambda number: number % 5 == 4)
    served = run()
    lost = served.columns["seen"] == 0.0
    assert lost.sum() >= 3 and arm.rested >= lost.sum()
    assert (served.columns["velocity.J1"][lost] == 0.0).all()


def test_pictures_that_come_late_count_as_lost():
    _, run = led(delay=lambda number: 0.5 if number >= 6 else 0.0)
    codes, served = refused(run)
    assert codes == ["VS203"] and (served.columns["seen"] == 0.0).sum() == 2


def test_a_camera_that_gives_no_more_pictures_counts_as_lost():
    @dataclass
    class Ending:
        eyes: ProjectedEyes

        @property
        def cameras(self):
            return self.eyes.cameras

        def look(self, after, patience):
            return self.eyes.look(after, patience) if self.eyes._number < 8 else None

    scene = five_axes()
    codes, served = refused(
        led(eyes=lambda arm, clock: Ending(scene.eyes("image in hand", arm.joints, clock=clock)))[1]
    )
    assert codes == ["VS202"] and (served.columns["seen"] == 0.0).sum() == 2


def test_nothing_moves_before_it_is_seen_for_sure():
    for hidden in (lambda _: True, lambda number: number % 3 == 2):
        arm, run = led(hidden=hidden)
        codes, _ = refused(run)
        assert codes == ["VS201"] and len(arm.rows) == 1


def test_points_in_one_line_stop_it():
    line = GivenPoints(np.array([[-20.0, 0.0, 0.0], [0.0, 0.0, 0.0], [20.0, 0.0, 0.0]]))
    scene = five_axes()

    def eyes(arm, clock):
        world = ServoWorld(scene.robot, arm.joints, None, (line, ON_TOOL))
        return ProjectedEyes(scene.cameras, world, clock, noise=0.0)

    codes, _ = refused(led(eyes=eyes, law=ImageToHand(line, ON_TOOL, scene.flange))[1])
    assert codes == ["VS204"]


def test_a_camera_that_is_not_where_its_file_says_stops_it():
    scene = five_axes()
    over = Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    turned = tuple(replace(camera, pose=camera.pose @ over) for camera in scene.cameras)

    @dataclass
    class Wrong:
        eyes: ProjectedEyes
        cameras: tuple = turned

        def look(self, after, patience):
            return self.eyes.look(after, patience)

    codes, _ = refused(
        led(
            "image to hand",
            eyes=lambda arm, clock: Wrong(scene.eyes("image to hand", arm.joints, clock=clock)),
        )[1]
    )
    assert codes[0] in ("VS205", "VS207")


def test_the_time_is_kept():
    codes, served = refused(led(settings=ServoSettings(timeout=0.5))[1])
    assert codes == ["VS206"] and served.seconds < 0.7


def boxed(least, most):
    scene = five_axes()
    tip = np.array((scene.flange @ TIP).position)
    box = tuple(tuple((tip + corner).tolist()) for corner in (least, most))
    return replace(scene, bounds=replace(scene.bounds, box=box))


def test_a_box_before_the_goal_bars_the_way():
    scene = five_axes()
    start = np.array((flange_of(scene.robot, scene.goal_joints + AWAY) @ TIP).position)
    goal = np.array((scene.flange @ TIP).position)
    between = (start + goal) / 2.0 - goal
    axis = int(np.argmax(np.abs(between)))
    least, most = np.full(3, -300.0), np.full(3, 300.0)
    (least if between[axis] > 0.0 else most)[axis] = between[axis]
    arm, run = led("pose in hand", scene=boxed(least, most))
    codes, _ = refused(run)
    tips = np.array([(flange_of(scene.robot, row) @ TIP).position for row in arm.rows[1:]]) - goal
    assert codes == ["VS207"]
    assert (tips >= least - 1e-6).all() and (tips <= most + 1e-6).all()


def test_an_arm_outside_of_the_box_is_not_moved():
    arm, run = led(scene=boxed((50.0, 50.0, 50.0), (90.0, 90.0, 90.0)))
    codes, _ = refused(run)
    assert codes == ["VS208"] and len(arm.rows) == 1


# ------------------------------------------------------------------------- files, cameras

FILE = """
law = "image"
[target]
marker = 7
size = 60
[goal]
position = [0, 0, 150]
quaternion = [0, 1, 0, 0]
"""
PLACE = FILE.replace("marker = 7\nsize = 60", "position = [1, 2, 3]")
CAMERA = """
[cameras.{name}]
size = [640, 480]
focal = [800, 800]
centre = [319.5, 239.5]
parent = "{parent}"
"""


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("marker = 7", "marker = 70", "VS210"),
        ("size = 60", "", "VS210"),
        ("size = 60", 'size = 60\ndevice = "wand"', "VS210"),
        ("[goal]", "[tool]", "VS210"),
        ("[target]", "[mark]", "VS210"),
        ('law = "image"', 'law = "best"', "CT303"),
        ("[goal]", "[servo]\ngain = 1000\n[goal]", "VS209"),
        ("[goal]", "[limits]\nspeed = -1\n[goal]", "CT303"),
        ("[goal]", "[limits]\nbox = [[0, 0, 0], [1, -1, 1]]\n[goal]", "VS209"),
        ("[goal]", "[limits]\nfast = 1\n[goal]", "CT302"),
    ],
)
def test_files_that_are_wrong(tmp_path, old, new, code):
    file = tmp_path / "servo.toml"
    file.write_text(FILE, encoding="utf-8")
    assert read_servo(file).goal.position == (0.0, 0.0, 150.0)
    file.write_text(FILE.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(Refused) as wrong:
        read_servo(file)
    assert code in [finding.code for finding in wrong.value.findings]
    assert wrong.value.exit_status == 2


@pytest.mark.parametrize(
    ("cameras", "file", "code"),
    [
        ([("a", "arm.flange"), ("b", "world")], FILE, "VS212"),
        ([("a", "arm.J3")], FILE, "VS212"),
        ([("a", "world")], FILE, "VS210"),
        (
            [("a", "arm.flange")],
            FILE.replace("marker = 7\nsize = 60", "position = [1, 2, 3]"),
            "VS210",
        ),
        ([("a", "world")], FILE + '[mark]\ndevice = "ball"\n', "VS210"),
        ([("a", "arm.flange")], "cameras = ['b']\n" + FILE, "VS013"),
    ],
)
def test_cameras_that_do_not_fit(tmp_path, cameras, file, code):
    text = "".join(CAMERA.format(name=name, parent=parent) for name, parent in cameras)
    (tmp_path / "cameras.toml").write_text(text, encoding="utf-8")
    (tmp_path / "servo.toml").write_text(file, encoding="utf-8")
    rig = read_cameras(tmp_path / "cameras.toml")
    with pytest.raises(Refused) as wrong:
        set_up_servo(read_servo(tmp_path / "servo.toml"), rig, five_axes().robot)
    assert [finding.code for finding in wrong.value.findings] == [code]
    assert wrong.value.exit_status == 2


def test_a_camera_without_a_source_and_one_that_ends(tmp_path):
    import cv2

    with pytest.raises(Refused) as none:
        LiveEyes([IN_HAND], {}, SoughtTargets(MARKER))
    assert [finding.code for finding in none.value.findings] == ["VS211"]
    cv2.imwrite(str(tmp_path / "1.png"), np.full((480, 640, 3), 90, np.uint8))
    with LiveEyes([IN_HAND], {"hand": "."}, SoughtTargets(MARKER), tmp_path) as live:
        sight = live.look(-np.inf, 5.0)
        assert np.isnan(sight.target["hand"]).all() and sight.number == 0
        with pytest.raises(Refused) as ended:
            live.look(sight.seconds, 5.0)
    assert [finding.code for finding in ended.value.findings] == ["VS213"]


def test_the_pictures_of_a_cell_follow_the_arm():
    """Drawn and looked for: the marker of the samples lies where it is said to lie."""
    robot = five_axes().robot
    file = read_servo("samples/servoing/marker.toml")
    setting = set_up_servo(file, read_cameras("samples/servoing/cameras.toml"), robot)
    at = {"joints": robot.home}
    with open_eyes(setting, lambda: at["joints"]) as eyes:
        for joints in (robot.home, robot.home + np.array([4.0, 6.0, 5.0, -8.0, 10.0])):
            at["joints"] = joints
            camera = eyes.cameras[0].carried(flange_of(robot, joints))
            found = eyes.look(-np.inf, 1.0).target["hand"]
            wanted = camera.project(file.drawn.moved(file.target.points))
            assert np.abs(found - wanted).max() < 0.6


def test_an_ideal_arm_is_led_by_drawn_pictures(tell):
    from assistant.vision.cameras.synthetic_pictures import Card, VisibleBody

    scene = five_axes()
    edge = MARKER.edge
    card = VisibleBody(Card((edge, edge), MARKER.picture()))

    def eyes(arm, clock):
        world = ServoWorld(scene.robot, arm.joints, (MARKER, scene.target))
        return DrawnEyes((IN_HAND,), world, (card,), clock=clock, rate=5.0)

    arm, run = led(
        "pose in hand", eyes=eyes, settings=ServoSettings(gain=4.0, share=0.7, distance=1.0)
    )
    served = run()
    away, turn = scene.off(arm.at)
    tell(f"drawn pictures: {served.pictures} of them, {away:.2f} mm and {turn:.2f} degrees left")
    assert away < 2.0 and turn < 0.5
