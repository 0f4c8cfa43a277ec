"""Laws by themselves: slopes against differences, and against OpenCV."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera, Lens
from assistant.vision.servoing.control_laws import (
    ImageToHand,
    PoseInHand,
    PoseToHand,
    ServoMoment,
    TargetSighting,
)
from assistant.vision.servoing.interaction import flange_of, interaction_matrix, jacobian, turned_by
from assistant.vision.servoing.visual_targets import GivenPoints, Marker, PoseTracker, estimate_pose
from tests.vision.servoing.scenes import IN_HAND, LENS, MARKER, ON_TOOL, five_axes, six_axes

LAWS = ("image in hand", "pose in hand", "image to hand", "pose to hand")


def test_the_interaction_matrix_is_that_of_opencv():
    """`projectPoints` tells the change of pixels by turn and place of points before a camera."""
    rng = np.random.default_rng(3)
    points = rng.uniform((-80.0, -60.0, 250.0), (80.0, 60.0, 600.0), (9, 3))
    _, slopes = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), None)
    found = interaction_matrix(points[:, :2] / points[:, 2:], points[:, 2])
    # What the camera does, the points do the other way.
    assert np.allclose(found[:, :3], -slopes[:, 3:6], atol=1e-12)
    assert np.allclose(found[:, 3:], -slopes[:, :3], atol=1e-12)


@pytest.mark.parametrize("name", ["rv-2aj", "irb1200-7-0.7"])
def test_the_jacobian_of_an_arm_is_how_its_flange_moves(name):
    robot = robots.get(name)
    rng = np.random.default_rng(1)
    for _ in range(5):
        low, high = robot.limits.T
        joints = rng.uniform(low + 1.0, high - 1.0)
        by = rng.uniform(-0.02, 0.02, len(joints))
        before, after = flange_of(robot, joints - by / 2.0), flange_of(robot, joints + by / 2.0)
        twist = jacobian(robot, joints) @ by
        moved = np.array(after.position) - np.array(before.position)
        turn = rotations.multiply(after.quaternion, rotations.conjugate(before.quaternion))
        assert np.allclose(twist[:3], moved, atol=1e-6)
        assert np.allclose(twist[3:], turned_by(np.asarray(turn)), atol=1e-8)


def seen(scene, name, flange):
    """The moment in which the flange is somewhere, whether or not an arm gets there."""
    if "in hand" in name:
        camera = IN_HAND.carried(flange)
        pixels = {camera.name: camera.project(scene.target.moved(MARKER.points))}
        return ServoMoment([camera], TargetSighting(0.0, 0, pixels), flange)
    placed = (flange @ ON_TOOL).moved(MARKER.points)
    pixels = {camera.name: camera.project(placed) for camera in scene.cameras}
    return ServoMoment(scene.cameras, TargetSighting(0.0, 0, {}, pixels), flange)


def moved(flange, twist):
    angle = float(np.linalg.norm(twist[3:]))
    turn = rotations.about(twist[3:] / angle if angle else (1.0, 0.0, 0.0), np.degrees(angle))
    place = np.array(flange.position) + twist[:3]
    return Pose.of(place, rotations.multiply(turn, np.array(flange.quaternion)))


@pytest.mark.parametrize("name", LAWS)
def test_errors_and_their_slopes_are_as_differences_say(name):
    scene = six_axes()
    at_goal = scene.law(name).task(seen(scene, name, scene.flange))
    assert np.abs(at_goal.error).max() < 1e-6
    assert at_goal.rank == 6 and at_goal.condition < 1000.0
    found = np.empty_like(at_goal.slopes)
    for k in range(6):
        step = np.zeros(6)
        step[k] = 1e-3 if k < 3 else 1e-5
        errors = [
            scene.law(name).task(seen(scene, name, moved(scene.flange, sign * step))).error
            for sign in (1.0, -1.0)
        ]
        found[:, k] = (errors[0] - errors[1]) / (2.0 * step[k])
    assert np.allclose(found, at_goal.slopes, atol=1e-4 * np.abs(found).max())


def test_points_in_one_line_tell_no_pose():
    scene = six_axes()
    line = GivenPoints(np.array([[0.0, 0.0, 0.0], [20.0, 0.0, 0.0], [40.0, 0.0, 0.0]]))
    placed = (scene.flange @ ON_TOOL).moved(line.points)
    pixels = {camera.name: camera.project(placed) for camera in scene.cameras}
    law = ImageToHand(line, ON_TOOL, scene.flange)
    task = law.task(ServoMoment(scene.cameras, TargetSighting(0.0, 0, {}, pixels), scene.flange))
    assert task.condition > 1e6


def test_one_ball_in_two_cameras_tells_a_place_and_no_turn():
    scene = six_axes()
    ball = GivenPoints(np.zeros((1, 3)))
    start = moved(scene.flange, np.array([5.0, -4.0, 3.0, 0.0, 0.0, 0.0]))
    placed = (start @ ON_TOOL).moved(ball.points)
    pixels = {camera.name: camera.project(placed) for camera in scene.cameras}
    moment = ServoMoment(scene.cameras, TargetSighting(0.0, 0, {}, pixels), start)
    for law in (PoseToHand(ball, ON_TOOL, scene.flange), ImageToHand(ball, ON_TOOL, scene.flange)):
        task = law.task(moment)
        step = np.linalg.lstsq(task.slopes[:, :3], -task.error, rcond=None)[0]
        assert task.rank == 3 and task.condition < 10.0
        assert np.allclose(step, (-5.0, 4.0, -3.0), atol=0.2)


def test_a_pose_that_two_cameras_see_is_exact():
    scene = five_axes()
    pose = scene.flange @ ON_TOOL
    pixels = {camera.name: camera.project(pose.moved(MARKER.points)) for camera in scene.cameras}
    found = estimate_pose(scene.cameras, pixels, MARKER.points)
    assert np.allclose(found.pose.position, pose.position, atol=1e-6) and found.residual < 1e-6


def test_a_marker_that_fits_two_poses_is_doubtful():
    """Small and far away, its perspective is lost in the noise."""
    lens = Lens.ideal((640, 480), 800.0)
    camera = Camera("one", lens)
    turn = rotations.about([1.0, 0.0, 0.0], 205.0)
    pose, small = Pose((0.0, 0.0, 900.0), tuple(turn)), Marker(1, 25.0)
    rng = np.random.default_rng(5)
    pixels = camera.project(pose.moved(small.points)) + rng.normal(0.0, 0.2, (4, 2))
    said = PoseTracker().pose_of([camera], {"one": pixels}, small.points)
    assert isinstance(said, str) and "two poses" in said
    near = Pose((0.0, 0.0, 200.0), tuple(turn))
    pixels = camera.project(near.moved(small.points)) + rng.normal(0.0, 0.2, (4, 2))
    assert not isinstance(PoseTracker().pose_of([camera], {"one": pixels}, small.points), str)


def test_what_is_not_the_thing_is_doubtful():
    scene = five_axes()
    moment = seen(scene, "pose in hand", scene.flange)
    moment.sight.target["hand"][0] += 25.0
    said = PoseInHand(MARKER, scene.goal).task(moment)
    assert isinstance(said, str) and "pixels beside" in said


def test_a_marker_is_found_where_it_is_projected(tell):
    from assistant.vision.cameras.synthetic_pictures import Card, VisibleBody, draw

    picture = MARKER.picture()
    edge = MARKER.size * picture.shape[0] / 240.0
    pose = Pose((5.0, -8.0, 300.0), tuple(rotations.about([0.96, 0.28, 0.0], 160.0)))
    camera = Camera("one", LENS)
    drawn = draw(camera, [VisibleBody(Card((edge, edge), picture), pose)])
    off = MARKER.find(drawn, camera) - camera.project(pose.moved(MARKER.points))
    worst = float(np.linalg.norm(off, axis=1).max())
    tell(f"corners of a drawn marker: {worst:.3f} px off at most")
    assert worst < 0.35
    assert np.isnan(Marker(8, 60.0).find(drawn, camera)).all()
