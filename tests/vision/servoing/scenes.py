"""Arms with a camera in the hand or beside them, a marker that they see, and random starts."""

from __future__ import annotations

import socket
import threading
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

import numpy as np

from assistant import robots
from assistant.base import rotations
from assistant.controllers import connect
from assistant.controllers.cyclic import Settings
from assistant.controllers.setpoint_streams import MODES, by_egm
from assistant.controllers.trajectory_execution import LinkOptions
from assistant.program.geometry import Pose
from assistant.virtual.cr import VirtualCr
from assistant.virtual.irc5.egm import Guidance, VirtualEgm
from assistant.vision.cameras.camera import Camera, Lens, looking_at
from assistant.vision.servoing.bounds import Bounds, Guard
from assistant.vision.servoing.control_laws import ImageInHand, ImageToHand, PoseInHand, PoseToHand
from assistant.vision.servoing.interaction import flange_of
from assistant.vision.servoing.simulation import Clock, ProjectedEyes, ServoWorld
from assistant.vision.servoing.visual_targets import Marker

LENS = Lens((640, 480), (800.0, 795.0), (318.0, 242.0), (-0.1, 0.03, 0.001, -0.001, 0.0))
TIP = Pose((0.0, 0.0, 100.0))
MOUNT = looking_at((-60.0, 0.0, 20.0), (0.0, 0.0, 270.0), up=(1.0, 0.0, 0.0))
IN_HAND = Camera("hand", LENS, MOUNT, "arm.flange")
MARKER = Marker(7, 60.0)
ON_TOOL = Pose((30.0, 0.0, 60.0), tuple(rotations.about([0.0, 1.0, 0.0], 180.0)))
"""A marker on the tool, that looks back along the flange."""
PATIENT = Settings(opening=60.0, timeout=20.0, settle=0.1, alive=20.0, lag=2.0)
"""No time-out that a busy computer could reach."""
MARGIN = 25.0
"""Pixels from the edge within which all of the marker is at a start."""


@dataclass
class Scene:
    """An arm whose goal is at joints, and what it sees there. away: degrees of random starts."""

    robot: object
    goal_joints: np.ndarray
    away: np.ndarray
    bounds: Bounds
    cameras: tuple[Camera, ...]

    def __post_init__(self):
        self.flange = flange_of(self.robot, self.goal_joints)
        tilt = Pose.of(np.zeros(3), rotations.about([0.96, 0.28, 0.0], 12.0))
        self.target = self.flange @ Pose((0.0, 0.0, 270.0), (0.0, 1.0, 0.0, 0.0)) @ tilt
        self.goal = self.target.inverse() @ self.flange
        self.guard = Guard(self.robot, self.bounds, TIP)

    def law(self, name):
        """Made anew for each servoing."""
        return {
            "image in hand": lambda: ImageInHand(MARKER, self.goal),
            "pose in hand": lambda: PoseInHand(MARKER, self.goal),
            "image to hand": lambda: ImageToHand(MARKER, ON_TOOL, self.flange),
            "pose to hand": lambda: PoseToHand(MARKER, ON_TOOL, self.flange, tip=TIP),
        }[name]()

    def eyes(self, name, joints, **how):
        cameras = (IN_HAND,) if "in hand" in name else self.cameras
        hand = "in hand" in name
        things = ((MARKER, self.target), None) if hand else (None, (MARKER, ON_TOOL))
        world = ServoWorld(self.robot, joints, *things)
        return ProjectedEyes(cameras, world, how.pop("clock", Clock()), **how)

    def start(self, name, rng):
        """(a,) joints at which all that is led by is in the pictures."""
        low, high = self.robot.limits.T
        while True:
            joints = self.goal_joints + rng.uniform(-1.0, 1.0, len(low)) * self.away
            if not ((joints > low + 3.0) & (joints < high - 3.0)).all():
                continue
            sight = self.eyes(name, lambda at=joints: at, noise=0.0).look(0.0, 1.0)
            seen = {**sight.target, **sight.mark}
            cameras = (IN_HAND,) if "in hand" in name else self.cameras
            if all(camera.within(seen[camera.name], MARGIN).all() for camera in cameras):
                return joints

    def off(self, joints):
        """mm and degrees of the tip from where it should be, by the joints that are."""
        now, wanted = flange_of(self.robot, joints) @ TIP, self.flange @ TIP
        away = np.linalg.norm(np.array(now.position) - np.array(wanted.position))
        turn = rotations.angle_between(np.array(now.quaternion), np.array(wanted.quaternion))
        return float(away), float(turn)


def beside(*eyes, at):
    names = ("left", "right")
    return tuple(Camera(n, LENS, looking_at(eye, at)) for n, eye in zip(names, eyes, strict=True))


def five_axes():
    """The RV-2AJ."""
    return Scene(
        robots.get("rv-2aj"),
        np.array([10.0, 25.0, 85.0, 70.0, 15.0]),
        np.array([20.0, 15.0, 15.0, 20.0, 40.0]),
        Bounds(speed=1000.0, turning=360.0, part=0.5),
        beside((700.0, -250.0, 900.0), (700.0, 330.0, 900.0), at=(250.0, 45.0, 330.0)),
    )


def six_axes():
    """The IRB 1200."""
    return Scene(
        robots.get("irb1200-7-0.7"),
        np.array([10.0, 25.0, 15.0, 20.0, 60.0, 15.0]),
        np.array([20.0, 15.0, 15.0, 20.0, 20.0, 40.0]),
        Bounds(speed=500.0, turning=180.0, part=0.5),
        beside((900.0, -300.0, 1300.0), (900.0, 400.0, 1300.0), at=(480.0, 80.0, 480.0)),
    )


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Kept:
    """Where a virtual arm was, looked at by itself again and again, beside the loop."""

    def __init__(self):
        self.rows = []

    def looked(self, joints):
        self.rows.append((*joints,))
        return np.array(joints)

    def joints(self):
        return np.array(self.rows)

    @contextmanager
    def looking(self, joints, each=0.02):
        """Looks all the time in between."""
        over = threading.Event()

        def look():
            while not over.wait(each):
                self.looked(joints())

        thread = threading.Thread(target=look, daemon=True)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()


@contextmanager
def five_axes_controller():
    """A virtual CR controller with its motors on, and a client."""
    virtual = VirtualCr("rv-2aj", servo_time=0.02)
    devices = ", ".join(f"OPT{i}" for i in range(12, 19))
    virtual.state.parameters.write("COMDEV", f"{devices}, ", all_levels=True)
    with virtual, connect(virtual.address, timeout=10) as controller:
        controller.session.pace = 0.02
        controller.motors(True)
        while not controller.state().motors:
            pass
        yield virtual, controller


@contextmanager
def by_controller(scene, name):
    """A carrier of a way to a CR controller, and where its arm is."""
    with five_axes_controller() as (virtual, controller):
        lines = tuple(f"{host}:{port}" for host, port in virtual.data_ports.values())[:2]
        wishes = LinkOptions(port=virtual.mxt_port, lines=lines)
        made = MODES[name].make(controller, scene.guard.arm(), wishes, scene.robot.home)
        kept = Kept()
        with made as carrier, kept.looking(lambda: virtual.state.joints):
            yield carrier, lambda: kept.looked(virtual.state.joints), kept


@contextmanager
def over_egm(scene, begin):
    """A virtual arm under EGM that begins at joints, a carrier, and where its arm is."""
    port = free_port()
    speeds = tuple(scene.robot.speeds)
    arm = Guidance("joints", tuple(begin), speeds, comm_timeout=60.0, cond_time=600.0, waiting=None)
    made = by_egm("127.0.0.1", scene.guard.arm(), port, settings=PATIENT)
    with VirtualEgm(arm, ("127.0.0.1", port)) as virtual, made as carrier:
        kept = Kept()
        kept.rows = virtual.track
        yield carrier, lambda: np.array(arm.values), kept


@contextmanager
def over_exchange(scene, folder):
    """A robot that exchanges poses by files; it tells itself where it stands."""
    from assistant.controllers.abb.exchange import Module, Tool
    from tests.controllers.abb.exchanging import RunningRobot

    tool = Tool(TIP.position, mass=0.9, centre=(0.0, 0.0, 52.0))
    module = Module(tool="GRIPPER", tool_data=tool, longest=60.0)
    with RunningRobot(folder, module) as robot, robot.client() as programs:
        arm = scene.guard.arm()
        with MODES["exchange"].make(programs, arm, LinkOptions(), scene.goal_joints) as carrier:
            kept = Kept()
            yield carrier, lambda: kept.looked(carrier.joints()), kept


MODES_BY_NAME = {
    **{
        name: (five_axes, partial(by_controller, name=name)) for name in ("jog", "data-link", "mxt")
    },
    "egm": (six_axes, lambda scene: over_egm(scene, scene.goal_joints)),
    "exchange": (six_axes, over_exchange),
}
